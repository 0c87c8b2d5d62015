//! Where the logs of a fleet come from: a folder of folders, or a bucket, whose names say whose and
//! when.

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use support::context::Context;
use support::error::{Error, Result};

#[cfg(feature = "bucket")]
use super::bucket::Bucket;
use super::logs::{ENDINGS, Log, Place};

/// Where the logs come from.
#[derive(Debug)]
pub(super) enum Source {
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
    pub(super) fn of(text: &Path) -> Result<Self> {
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
    pub(super) fn find(&self, context: &Context, group: &[String]) -> Result<Vec<Log>> {
        let (mut logs, of) = match self {
            Self::Folder(folder) => (in_folder(context, folder, group)?, folder.as_path()),
            #[cfg(feature = "bucket")]
            Self::Bucket(bucket) => (bucket.find(group)?, Path::new(bucket.url())),
        };
        logs.retain(|log| match log.wrong_day() {
            None => true,
            Some(day) => {
                context.notice(format_args!(
                    "{}: day={day} is no date; expected YYYY-MM-DD; left out",
                    log.name
                ));
                false
            }
        });
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

    /// Gives `work` each of these logs as a file, a log a core. `aside` holds a few logs of a
    /// bucket at a time. An error says why a log cannot be had just now.
    ///
    /// # Errors
    /// The first of `work`; what the operating system refuses.
    pub(super) fn each(
        &self,
        logs: &[&Log],
        aside: &Path,
        work: impl Fn(&Log, Result<&Path>) -> Result<()> + Sync,
    ) -> Result<()> {
        let _ = aside;
        match self {
            Self::Folder(_) => logs.par_iter().try_for_each(|log| match &log.place {
                Place::File(path) => work(log, Ok(path)),
                #[cfg(feature = "bucket")]
                Place::Object { .. } => work(log, Err(Error::failed("is in a bucket; expected a file"))),
            }),
            #[cfg(feature = "bucket")]
            Self::Bucket(bucket) => bucket.each(logs, aside, work),
        }
    }
}

fn in_folder(context: &Context, source: &Path, group: &[String]) -> Result<Vec<Log>> {
    let mut logs = Vec::new();
    walk(context, source, group, &mut Vec::new(), &mut logs)?;
    Ok(logs)
}

fn walk(
    context: &Context,
    folder: &Path,
    group: &[String],
    parts: &mut Vec<String>,
    logs: &mut Vec<Log>,
) -> Result<()> {
    let refused = |error: std::io::Error| Error::io(folder, &error);
    for entry in std::fs::read_dir(folder).map_err(refused)? {
        let entry = entry.map_err(refused)?;
        let path = entry.path();
        parts.push(entry.file_name().to_string_lossy().into_owned());
        let kind = entry.file_type().map_err(refused)?;
        if kind.is_dir() {
            walk(context, &path, group, parts, logs)?;
        } else if let Some(log) = Log::at(parts, group, || Place::File(path.clone())) {
            match std::fs::metadata(&path) {
                Ok(is) if is.is_file() => logs.push(log),
                // Opened, a pipe would wait for its writer, and a device need not end.
                Ok(_) => context.notice(format_args!(
                    "{}: is no file (a pipe, socket, device or folder); left out",
                    path.display()
                )),
                // Gone since, or a link that leads nowhere: reading it says so.
                Err(_) => logs.push(log),
            }
        } else if kind.is_symlink() && path.is_dir() {
            context.notice(format_args!(
                "{}: a link to a folder, which may lead in a circle; not followed",
                path.display()
            ));
        }
        parts.pop();
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Devices, pipes and circles are left out. A link to a log is a log; a dangling link is a log
    /// that cannot be read.
    #[cfg(unix)]
    #[test]
    fn what_is_no_file_is_left_out() {
        use std::os::unix::fs::symlink;
        use std::os::unix::net::UnixListener;
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("robot=1/day=2026-11-02");
        std::fs::create_dir_all(&folder).unwrap();
        let at = |name: &str| folder.join(name);
        std::fs::write(at("good.csv"), "time_s\n").unwrap();
        let (kind, mode) = (rustix::fs::FileType::Fifo, rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR);
        rustix::fs::mknodat(rustix::fs::CWD, at("pipe.csv"), kind, mode, 0).unwrap();
        let _socket = UnixListener::bind(at("socket.csv")).unwrap();
        symlink(at("good.csv"), at("link.csv")).unwrap();
        symlink(at("gone"), at("dangling.csv")).unwrap();
        symlink(at("loop.csv"), at("loop.csv")).unwrap();
        symlink(at("pipe.csv"), at("to_pipe.mcap")).unwrap();
        symlink("/dev/zero", at("device.parquet")).unwrap();
        symlink(place.path(), at("circle")).unwrap();
        symlink(place.path(), at("circle.csv")).unwrap();
        let logs = Source::of(place.path()).unwrap().find(&Context::default(), &[]).unwrap();
        let names: Vec<&str> = logs.iter().filter_map(|log| log.name.rsplit('/').next()).collect();
        assert_eq!(names, ["dangling.csv", "good.csv", "link.csv", "loop.csv"]);
    }

    /// A year has twelve months, and February its own days. What is not written as a date sorts as
    /// text.
    #[test]
    fn a_day_that_there_is_not_is_left_out() {
        let place = tempfile::tempdir().unwrap();
        for day in ["2026-13-45", "2026-02-29", "2026-00-10", "2024-02-29", "2026-11-02", "monday"] {
            let folder = place.path().join(format!("robot=1/day={day}"));
            std::fs::create_dir_all(&folder).unwrap();
            std::fs::write(folder.join("a.csv"), "time_s\n").unwrap();
        }
        let logs = Source::of(place.path()).unwrap().find(&Context::default(), &[]).unwrap();
        let days: Vec<&str> = logs.iter().map(|log| &log.keys["day"][..]).collect();
        assert_eq!(days, ["2024-02-29", "2026-11-02", "monday"]);
    }

    /// Without the feature it is named; with it, what no store is behind is refused as well.
    #[test]
    fn what_is_no_bucket_is_refused_in_one_line() {
        let refused = Source::of(Path::new("gopher://logs/here")).unwrap_err().to_string();
        let expected = if cfg!(feature = "bucket") { "expected s3://" } else { "--features bucket" };
        assert!(refused.starts_with("gopher://logs/here: ") && refused.contains(expected), "{refused}");
        assert!(matches!(Source::of(Path::new("logs")), Ok(Source::Folder(_))));
    }
}
