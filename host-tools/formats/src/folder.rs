//! A bag of ROS 2 as its recorder leaves it: a folder with `metadata.yaml` and one file or several,
//! split by size or time.

use std::path::{Component, Path, PathBuf};

use crate::error::{Error, Result};

/// What the recorder writes beside the files (rosbag2_storage, `BagMetadata`).
const METADATA: &str = "metadata.yaml";

/// Metadata are a few kilobytes, and one line a topic; more is another file.
const MOST_BYTES: u64 = 16 << 20;

/// Whether a folder is a bag.
pub fn is_bag(folder: &Path) -> bool {
    folder.join(METADATA).is_file()
}

/// The files of a bag, in the order of their messages.
pub(crate) fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    let metadata = folder.join(METADATA);
    let length = std::fs::metadata(&metadata).map_err(|_| {
        Error::Unsupported(format!(
            "is a folder without {METADATA}; expected a bag's (ros2 bag reindex FOLDER writes one)"
        ))
    })?;
    if length.len() > MOST_BYTES {
        return Err(Error::Unsupported(format!(
            "has a {METADATA} of {} bytes; expected a bag's",
            length.len()
        )));
    }
    let text = String::from_utf8_lossy(&std::fs::read(&metadata)?).into_owned();
    let names = listed(&text);
    if names.is_empty() {
        let message = format!("has no relative_file_paths in its {METADATA}; expected the files of a bag");
        return Err(Error::Unsupported(message));
    }
    names.into_iter().map(|name| inside(folder, &name)).collect()
}

/// A file of the folder; old recorders wrote the folder's own name before it.
fn inside(folder: &Path, name: &str) -> Result<PathBuf> {
    let is_plain = Path::new(name).components().all(|component| matches!(component, Component::Normal(_)));
    let file = Path::new(name).file_name().map(|file| folder.join(file));
    match file.filter(|_| is_plain) {
        Some(file) if file.is_file() => Ok(file),
        Some(file) => Err(Error::Unsupported(format!(
            "has no {}, which its {METADATA} names; expected all files of the bag",
            file.file_name().unwrap_or_default().to_string_lossy()
        ))),
        None => Err(Error::Unsupported(format!(
            "names {name:?} in its {METADATA}; expected a file of this folder"
        ))),
    }
}

/// The items of `relative_file_paths`: a YAML list of plain or quoted names, a line each, or in
/// brackets.
fn listed(text: &str) -> Vec<String> {
    let mut lines = text.lines().map(str::trim).skip_while(|line| !line.starts_with("relative_file_paths:"));
    let first = lines.next().and_then(|line| line.strip_prefix("relative_file_paths:")).unwrap_or("").trim();
    let name = |item: &str| item.trim().trim_matches(['"', '\'']).to_owned();
    let names: Vec<String> = match first.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
        Some(items) => items.split(',').map(name).collect(),
        None => lines.map_while(|line| line.strip_prefix("- ")).map(name).collect(),
    };
    names.into_iter().filter(|name| !name.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ways_to_write_a_list() {
        let block = "rosbag2_bagfile_information:\n  version: 5\n  relative_file_paths:\n    - a_0.db3\n    - \"a_1.db3\"\n  duration:\n    nanoseconds: 1\n";
        assert_eq!(listed(block), ["a_0.db3", "a_1.db3"]);
        assert_eq!(listed("x:\n  relative_file_paths: [a_0.mcap, 'a_1.mcap']\n"), ["a_0.mcap", "a_1.mcap"]);
        assert!(listed("relative_file_paths:\nversion: 5\n").is_empty() && listed("").is_empty());
    }
}
