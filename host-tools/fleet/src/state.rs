//! What has been read already: one small file a log, whole or absent, so that a killed run resumes
//! where it was.

use std::path::PathBuf;

use crc::{CRC_64_XZ, Crc};
use fit::run_gram::RunGram;
use serde::{Deserialize, Serialize};
use support::error::{Error, Result};
use support::output::write_content;

use super::logs::Log;

/// A folder of such files.
#[derive(Debug, Clone)]
pub(super) struct State {
    folder: PathBuf,
    /// Checksum of what they were made with.
    settings: String,
}

/// What came of a log.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Outcome {
    /// The sums of its runs.
    Read(Vec<RunGram>),
    /// Why it cannot be read.
    Refused(String),
}

#[derive(Serialize, Deserialize)]
struct Done {
    log: String,
    fingerprint: Option<String>,
    settings: String,
    outcome: Outcome,
}

impl State {
    /// In this folder, made where it is not there, of logs that are read with these settings.
    ///
    /// # Errors
    /// What the operating system refuses.
    pub(super) fn open(folder: PathBuf, settings: &str) -> Result<Self> {
        std::fs::create_dir_all(&folder).map_err(|error| Error::io(&folder, &error))?;
        let settings = format!("{:016x}", Crc::<u64>::new(&CRC_64_XZ).checksum(settings.as_bytes()));
        Ok(Self { folder, settings })
    }

    fn file(&self, log: &Log) -> PathBuf {
        let name = Crc::<u64>::new(&CRC_64_XZ).checksum(log.name.as_bytes());
        self.folder.join(format!("{name:016x}.json"))
    }

    /// What came of a log, if it was read with these settings and has not changed since. A file of
    /// another form counts as none.
    pub(super) fn done(&self, log: &Log) -> Option<Outcome> {
        let text = std::fs::read_to_string(self.file(log)).ok()?;
        let done: Done = serde_json::from_str(&text).ok()?;
        let same =
            done.log == log.name && done.settings == self.settings && done.fingerprint == log.fingerprint();
        same.then_some(done.outcome)
    }

    /// Keeps what came of a log.
    ///
    /// # Errors
    /// What the operating system refuses.
    pub(super) fn keep(&self, log: &Log, outcome: Outcome) -> Result<()> {
        let file = self.file(log);
        let done = Done {
            log: log.name.clone(),
            fingerprint: log.fingerprint(),
            settings: self.settings.clone(),
            outcome,
        };
        let text =
            serde_json::to_string(&done).map_err(|error| Error::failed(error.to_string()).in_file(&file))?;
        write_content(&file, text)
    }
}
