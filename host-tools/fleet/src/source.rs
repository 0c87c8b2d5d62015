//! Where the logs of a fleet come from: a folder of folders, or a bucket, whose names say whose and when.

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use support::error::{Error, Result};

#[cfg(feature = "bucket")]
use super::bucket::Bucket;
use super::logs::{ENDINGS, Log, Place};

/// Where the logs come from.
#[derive(Debug)]
pub enum Source {
    /// A folder of this machine.
    Folder(PathBuf),
    /// A bucket of S3, Google Cloud Storage, Azure, or what WebDAV lists.
    #[cfg(feature = "bucket")]
    Bucket(Bucket),
}

impl Source {
    /// A folder, or a URL such as `s3://bucket/logs`.
    ///
    /// # Errors
    /// A URL of something else, or in a gmr that was built without the feature `bucket`.
    pub fn of(text: &Path) -> Result<Self> {
        match text.to_str().filter(|text| text.contains("://")) {
            None => Ok(Self::Folder(text.to_owned())),
            #[cfg(feature = "bucket")]
            Some(url) => Bucket::open(url).map(Self::Bucket).map_err(|error| error.in_file(url)),
            #[cfg(not(feature = "bucket"))]
            Some(url) => {
                let message = "is in a bucket, which this gmr was built without; expected a folder, or one that is built with `--features bucket`";
                Err(Error::usage(message).in_file(url))
            }
        }
    }

    /// All logs of it, by name.
    ///
    /// # Errors
    /// What cannot be listed; none of the files is a log.
    pub fn find(&self, group: &[String]) -> Result<Vec<Log>> {
        let (mut logs, of) = match self {
            Self::Folder(folder) => (in_folder(folder, group)?, folder.as_path()),
            #[cfg(feature = "bucket")]
            Self::Bucket(bucket) => (bucket.find(group)?, Path::new(bucket.url())),
        };
        if logs.is_empty() {
            let message = format!(
                "no logs below it; expected files *.{} in folders such as robot=7/day=2026-11-02",
                ENDINGS.join(", *.")
            );
            return Err(Error::failed(message).in_file(of));
        }
        // Whatever order the file system or the bucket has.
        logs.sort_by(|a, b| a.name.cmp(&b.name));
        Ok(logs)
    }

    /// Gives `work` each of these logs as a file, a log a core; what comes from a bucket is in `aside` meanwhile, a few logs at a time. An error is
    /// why it cannot be had just now.
    ///
    /// # Errors
    /// The first of `work`; what the operating system refuses.
    pub fn each(
        &self,
        logs: &[&Log],
        aside: &Path,
        work: impl Fn(&Log, Result<&Path>) -> Result<()> + Sync,
    ) -> Result<()> {
        let _ = aside;
        match self {
            Self::Folder(_) => logs.par_iter().try_for_each(|log| match &log.place {
                Place::File(path) => work(log, Ok(path)),
                Place::Object { .. } => work(log, Err(Error::failed("is in a bucket; expected a file"))),
            }),
            #[cfg(feature = "bucket")]
            Self::Bucket(bucket) => bucket.each(logs, aside, work),
        }
    }
}

fn in_folder(source: &Path, group: &[String]) -> Result<Vec<Log>> {
    let mut found = Vec::new();
    walk(source, group, &mut Vec::new(), &mut found)?;
    Ok(found)
}

fn walk(folder: &Path, group: &[String], parts: &mut Vec<String>, found: &mut Vec<Log>) -> Result<()> {
    let refused = |error: std::io::Error| Error::io(folder, &error);
    for entry in std::fs::read_dir(folder).map_err(refused)? {
        let entry = entry.map_err(refused)?;
        let path = entry.path();
        parts.push(entry.file_name().to_string_lossy().into_owned());
        // Links are not followed: they may lead in a circle.
        if entry.file_type().map_err(refused)?.is_dir() {
            walk(&path, group, parts, found)?;
        } else {
            found.extend(Log::at(parts, group, || Place::File(path)));
        }
        parts.pop();
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Without the feature it is named; with it, what no store is behind is refused as well.
    #[test]
    fn what_is_no_bucket_is_refused_in_one_line() {
        let refused = Source::of(Path::new("gopher://logs/here")).unwrap_err().to_string();
        let expected = if cfg!(feature = "bucket") { "expected s3://" } else { "--features bucket" };
        assert!(refused.starts_with("gopher://logs/here: ") && refused.contains(expected), "{refused}");
        assert!(matches!(Source::of(Path::new("logs")), Ok(Source::Folder(_))));
    }
}
