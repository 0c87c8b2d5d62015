//! The logs of a fleet: a folder of folders, whose names say whose and when.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// A log of the fleet.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Log {
    /// Where it is.
    pub path: PathBuf,
    /// Its path within the source, with `/` between folders: what it is called everywhere.
    pub name: String,
    /// What its path says: robot, day …
    pub keys: BTreeMap<String, String>,
}

/// Endings of logs: what else lies between them is left alone. What a file is, its first bytes say.
const ENDINGS: [&str; 5] = ["csv", "parquet", "mcap", "db3", "ulg"];

/// All logs below a folder, by name. `robot=7/day=2026-11-02/a.csv` says its keys itself; of `7/2026-11-02/a.csv` the folders are the keys of
/// `group` in their order, and where folders are one fewer, the file's name is the last.
///
/// # Errors
/// A folder that cannot be read; none of the files is a log.
pub fn find(source: &Path, group: &[String]) -> Result<Vec<Log>> {
    let mut found = Vec::new();
    walk(source, &mut Vec::new(), &mut found)?;
    let mut logs: Vec<Log> = found
        .into_iter()
        .map(|(path, parts)| Log { path, keys: keys(&parts, group), name: parts.join("/") })
        .collect();
    if logs.is_empty() {
        let message = format!(
            "no logs below it; expected files *.{} in folders such as robot=7/day=2026-11-02",
            ENDINGS.join(", *.")
        );
        return Err(Error::failed(message).in_file(source));
    }
    // Whatever order the file system has.
    logs.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(logs)
}

fn walk(folder: &Path, parts: &mut Vec<String>, found: &mut Vec<(PathBuf, Vec<String>)>) -> Result<()> {
    let refused = |error: std::io::Error| Error::io(folder, &error);
    for entry in std::fs::read_dir(folder).map_err(refused)? {
        let entry = entry.map_err(refused)?;
        let path = entry.path();
        parts.push(entry.file_name().to_string_lossy().into_owned());
        // Links are not followed: they may lead in a circle.
        if entry.file_type().map_err(refused)?.is_dir() {
            walk(&path, parts, found)?;
        } else if path
            .extension()
            .is_some_and(|ending| ENDINGS.iter().any(|known| ending.eq_ignore_ascii_case(known)))
        {
            found.push((path, parts.clone()));
        }
        parts.pop();
    }
    Ok(())
}

fn keys(parts: &[String], group: &[String]) -> BTreeMap<String, String> {
    let Some((file, folders)) = parts.split_last() else { return BTreeMap::new() };
    let stem = file.rsplit_once('.').map_or(file.as_str(), |(stem, _)| stem);
    let own = folders.iter().filter_map(|part| part.split_once('='));
    let mut keys: BTreeMap<String, String> =
        own.map(|(key, value)| (key.to_owned(), value.to_owned())).collect();
    if keys.is_empty() {
        let plain =
            folders.iter().map(String::as_str).chain((folders.len() + 1 == group.len()).then_some(stem));
        keys.extend(group.iter().cloned().zip(plain.map(str::to_owned)));
    }
    keys
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_say_whose_and_when() {
        let group = ["robot".to_owned(), "day".to_owned()];
        let of = |path: &str| keys(&path.split('/').map(str::to_owned).collect::<Vec<_>>(), &group);
        let expected = BTreeMap::from(
            [("day", "2026-11-02"), ("robot", "7")].map(|(k, v)| (k.to_owned(), v.to_owned())),
        );
        for path in [
            "7/2026-11-02/a.csv",
            "robot=7/day=2026-11-02/a.csv",
            "day=2026-11-02/robot=7/a.csv",
            "7/2026-11-02.csv",
        ] {
            assert_eq!(of(path), expected, "{path}");
        }
        assert_eq!(of("a.csv").len(), 0, "a file alone says nothing");
    }
}
