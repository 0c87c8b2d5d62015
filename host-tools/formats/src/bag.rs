//! A bag: topics, and their messages one after the other.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::ending::{Each, Ending};
use crate::error::{Error, Result};
use crate::format::Format;
use crate::topic::Topic;
use crate::{cdr, mcap_file, sqlite, ulog};

/// Topics and messages of a file.
#[derive(Debug)]
pub struct Bag {
    path: PathBuf,
    format: Format,
    allow_cut: bool,
    topics: Vec<Topic>,
}

impl Bag {
    /// Opens a bag: its topics are read, its messages not yet. What is left of one that was cut off is read only if that is allowed.
    ///
    /// # Errors
    /// Another format; a file that was cut off, or whose bytes are not what its format says.
    pub fn open(path: &Path, allow_cut: bool) -> Result<Self> {
        let mut head = Vec::new();
        File::open(path)?.take(Format::HEAD_BYTES as u64).read_to_end(&mut head)?;
        let format = Format::of(&head).ok_or_else(|| {
            Error::Unsupported("is no MCAP, SQLite or ULog file; expected a bag".to_owned())
        })?;
        format.check()?;
        let topics = match format {
            Format::Mcap => mcap_file::topics(path, allow_cut)?,
            Format::Sqlite => sqlite::topics(path)?,
            Format::Ulog => ulog::topics(path, allow_cut)?,
            _ => return Err(Error::Unsupported(format!("is {}, a table; expected a bag", format.name()))),
        };
        if topics.is_empty() {
            return Err(Error::Choice("has no topics: nothing was recorded".to_owned()));
        }
        Ok(Self { path: path.to_owned(), format, allow_cut, topics })
    }

    /// Its format.
    pub fn format(&self) -> Format {
        self.format
    }

    /// Its topics, by name.
    pub fn topics(&self) -> &[Topic] {
        &self.topics
    }

    /// Hands out the messages of some topics in the order of the file, as long as `each` wants more.
    ///
    /// # Errors
    /// Damage, and what `each` reports.
    pub fn read(&self, wanted: &[usize], each: &mut Each<'_>) -> Result<Ending> {
        let ending = match self.format {
            Format::Mcap => mcap_file::read(&self.path, &self.topics, wanted, each)?,
            Format::Sqlite => sqlite::read(&self.path, &self.topics, wanted, each)?,
            _ => ulog::read(&self.path, &self.topics, wanted, each)?,
        };
        match ending {
            Ending::Cut(why) if !self.allow_cut => Err(Error::Truncated(why)),
            ending => Ok(ending),
        }
    }

    /// Names that the first messages of a topic give to the elements of their arrays (`name` of `sensor_msgs/JointState`).
    ///
    /// # Errors
    /// Damage.
    pub fn names(&self, topic: usize) -> Result<Vec<String>> {
        const LOOKED_AT: usize = 100;
        let crate::Encoding::Cdr { definition } = &self.topics[topic].encoding else { return Ok(Vec::new()) };
        let layout = cdr::Layout::of(&self.topics[topic].kind, definition)?;
        let mut found: Vec<String> = Vec::new();
        let mut left = LOOKED_AT;
        self.read(&[topic], &mut |_, _, message| {
            for name in cdr::names(&layout, message)? {
                if !found.contains(&name) {
                    found.push(name);
                }
            }
            left -= 1;
            Ok(left > 0)
        })?;
        Ok(found)
    }
}
