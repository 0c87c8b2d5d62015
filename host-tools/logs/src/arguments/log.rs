//! Logs on the command line, each with the total mass that was weighed with it where somebody says
//! so.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// A log: `FILE`, or `FILE=KG` with the robot's total mass in it. A file of that very name wins.
#[derive(Debug, Clone, PartialEq)]
pub struct Log {
    /// Where it is.
    pub path: PathBuf,
    /// Total mass, kg.
    pub mass_kg: Option<f64>,
}

impl From<OsString> for Log {
    fn from(argument: OsString) -> Self {
        let whole = |argument: OsString| Self { path: argument.into(), mass_kg: None };
        if Path::new(&argument).exists() {
            return whole(argument);
        }
        let weighed = argument.to_str().and_then(|text| text.rsplit_once('=')).and_then(|(path, mass)| {
            let mass = mass.trim().trim_end_matches("kg").trim_end();
            Some(Self { path: path.into(), mass_kg: Some(mass.parse().ok()?) })
        });
        weighed.unwrap_or_else(|| whole(argument))
    }
}

impl AsRef<Path> for Log {
    fn as_ref(&self) -> &Path {
        &self.path
    }
}

/// Their files.
#[must_use]
pub fn paths<'a>(logs: impl IntoIterator<Item = &'a Log>) -> Vec<PathBuf> {
    logs.into_iter().map(|log| log.path.clone()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mass_follows_the_name_and_a_file_of_that_name_wins() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("odd=3"), "").unwrap();
        let log = |name: &str| Log::from(at(name).into_os_string());
        let of = |name: &str, mass_kg| Log { path: at(name), mass_kg };
        assert_eq!(log("empty.mcap=1.0"), of("empty.mcap", Some(1.0)));
        assert_eq!(log("full.csv=6kg"), of("full.csv", Some(6.0)));
        assert_eq!(log("odd=3"), of("odd=3", None));
        assert_eq!(log("odd=3=2.5"), of("odd=3", Some(2.5)));
        assert_eq!(log("run=two.csv"), of("run=two.csv", None));
    }
}
