//! A log of the fleet, and what its path says of it.

use std::collections::BTreeMap;
use std::path::PathBuf;

use model::coefficients::FittedLog;

/// A log of the fleet.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Log {
    /// Where it is.
    pub place: Place,
    /// Its path within the source, with `/` between folders: what it is called everywhere.
    pub name: String,
    /// What its path says: robot, day …
    pub keys: BTreeMap<String, String>,
}

/// Where a log is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Place {
    /// On this machine.
    File(PathBuf),
    /// In a bucket, which has to be asked for it.
    #[cfg(feature = "bucket")]
    Object {
        /// Its whole path there.
        location: String,
        /// How long it is.
        bytes: u64,
        /// What the bucket calls this version of it (RFC 9110, ETag), or when it was written.
        version: String,
    },
}

/// Endings of logs: what else lies between them is left alone. What a file is, its first bytes say.
pub(super) const ENDINGS: [&str; 7] = ["csv", "parquet", "mcap", "db3", "ulg", "bag", "bin"];

impl Log {
    /// The log at these folders and file below the source, where its name ends as a log's.
    /// `robot=7/day=2026-11-02/a.csv` says its keys itself; of `7/2026-11-02/a.csv` the folders are
    /// the keys of `group` in their order, and where folders are one fewer, the file's name is the
    /// last.
    pub(super) fn at(parts: &[String], group: &[String], place: impl FnOnce() -> Place) -> Option<Self> {
        let ending = parts.last()?.rsplit_once('.')?.1;
        if !ENDINGS.iter().any(|known| ending.eq_ignore_ascii_case(known)) {
            return None;
        }
        Some(Self { place: place(), name: parts.join("/"), keys: keys(parts, group) })
    }

    /// The day of its path, where that is written as a date (YYYY-MM-DD) that does not exist.
    pub(super) fn wrong_day(&self) -> Option<&str> {
        let day = self.keys.get(super::keys::DAY)?;
        let numbers: Vec<u32> = day.split('-').map(|number| number.parse().ok()).collect::<Option<_>>()?;
        let is_written = day.split('-').map(str::len).eq([4, 2, 2]);
        let &[year, month, of_month] = &numbers[..] else { return None };
        let is_leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
        let length = match month {
            2 if is_leap => 29,
            2 => 28,
            4 | 6 | 9 | 11 => 30,
            1..=12 => 31,
            _ => 0,
        };
        (is_written && !(1..=length).contains(&of_month)).then_some(day)
    }

    /// By what it is known whether it has changed; `None` of what cannot be read now.
    pub(super) fn fingerprint(&self) -> Option<String> {
        match &self.place {
            Place::File(path) => FittedLog::now(path).ok().and_then(|log| log.fingerprint),
            #[cfg(feature = "bucket")]
            Place::Object { bytes, version, .. } => Some(format!("{bytes:x}-{version}")),
        }
    }
}

fn keys(parts: &[String], group: &[String]) -> BTreeMap<String, String> {
    let Some((file, folders)) = parts.split_last() else { return BTreeMap::new() };
    let stem = file.rsplit_once('.').map_or(file.as_str(), |(stem, _)| stem);
    let pairs = folders.iter().filter_map(|folder| folder.split_once('='));
    let mut keys: BTreeMap<String, String> =
        pairs.map(|(key, value)| (key.to_owned(), value.to_owned())).collect();
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
        let of = |path: &str| {
            let parts: Vec<_> = path.split('/').map(str::to_owned).collect();
            Log::at(&parts, &group, || Place::File(path.into())).map(|log| log.keys)
        };
        let expected = BTreeMap::from(
            [("day", "2026-11-02"), ("robot", "7")].map(|(k, v)| (k.to_owned(), v.to_owned())),
        );
        for path in [
            "7/2026-11-02/a.csv",
            "robot=7/day=2026-11-02/a.csv",
            "day=2026-11-02/robot=7/a.csv",
            "7/2026-11-02.csv",
        ] {
            assert_eq!(of(path).as_ref(), Some(&expected), "{path}");
        }
        assert_eq!(of("a.CSV"), Some(BTreeMap::new()), "a file alone says nothing");
        assert_eq!(of("7/2026-11-02/notes.txt"), None);
    }
}
