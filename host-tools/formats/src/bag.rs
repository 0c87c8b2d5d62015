//! A bag: topics, and their messages one after the other.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::ending::{Each, Ending};
use crate::error::{Error, Result};
use crate::format::Format;
use crate::topic::{Encoding, Topic};
use crate::{cdr, folder, readers};

/// Topics and messages of a file, or of the files of a folder.
#[derive(Debug)]
pub struct Bag {
    /// In the order of their messages.
    parts: Vec<Part>,
    allow_cut: bool,
    topics: Vec<Topic>,
}

/// A file of a bag.
#[derive(Debug)]
struct Part {
    path: PathBuf,
    format: Format,
}

impl Bag {
    /// Opens a bag, a file or a folder of ROS 2: its topics are read, its messages not yet. What is
    /// left of one that was cut off is read only if that is allowed.
    ///
    /// # Errors
    /// Another format; a file that was cut off, or whose bytes are not what its format says; a
    /// folder without what its metadata name.
    pub fn open(path: &Path, allow_cut: bool) -> Result<Self> {
        let files = if path.is_dir() { folder::files(path)? } else { vec![path.to_owned()] };
        let several = path.is_dir();
        let mut parts = Vec::new();
        let mut topics: Vec<Topic> = Vec::new();
        for file in files {
            let opened = Part::open(&file, allow_cut)
                .map_err(|error| if several { error.of_part(&file) } else { error });
            let (part, its_topics) = opened?;
            for topic in its_topics {
                match topics.iter_mut().find(|known| known.name == topic.name) {
                    None => topics.push(topic),
                    Some(known) if known.kind == topic.kind => {
                        known.messages = known.messages.zip(topic.messages).map(|(a, b)| a + b);
                    }
                    Some(known) => {
                        return Err(Error::Unsupported(format!(
                            "{} has {} as {}, a file before it as {}; expected one type a topic",
                            file.display(),
                            topic.name,
                            topic.kind,
                            known.kind
                        )));
                    }
                }
            }
            parts.push(part);
        }
        if topics.is_empty() {
            return Err(Error::Choice("has no topics: nothing was recorded".to_owned()));
        }
        Ok(Self { parts, allow_cut, topics })
    }

    /// Its format; a folder's files have one.
    pub fn format(&self) -> Format {
        self.parts.first().map_or(Format::Mcap, |part| part.format)
    }

    /// Its topics, by name.
    pub fn topics(&self) -> &[Topic] {
        &self.topics
    }

    /// Hands out the messages of some topics in the order of the file, as long as `each` wants
    /// more.
    ///
    /// # Errors
    /// Damage, and what `each` reports.
    pub fn read(&self, wanted: &[usize], each: &mut Each<'_>) -> Result<Ending> {
        let mut goes_on = true;
        let mut cut = None;
        for part in &self.parts {
            let ending = part.read(&self.topics, wanted, &mut |topic, time, message| {
                goes_on = each(topic, time, message)?;
                Ok(goes_on)
            });
            match ending? {
                Ending::Cut(why) if !self.allow_cut => return Err(Error::Truncated(why)),
                Ending::Cut(why) => cut = cut.or(Some(why)),
                Ending::Whole => {}
            }
            if !goes_on {
                break;
            }
        }
        Ok(cut.map_or(Ending::Whole, Ending::Cut))
    }

    /// Names that the first messages of a topic give to the elements of their arrays (`name` of
    /// `sensor_msgs/JointState`).
    ///
    /// # Errors
    /// Damage.
    pub fn names(&self, topic: usize) -> Result<Vec<String>> {
        const LOOKED_AT: usize = 100;
        let Encoding::Ros { definition, serialization } = &self.topics[topic].encoding else {
            return Ok(Vec::new());
        };
        let layout = cdr::Layout::of(&self.topics[topic].kind, definition, *serialization)?;
        let mut names: Vec<String> = Vec::new();
        let mut remaining = LOOKED_AT;
        self.read(&[topic], &mut |_, _, message| {
            for name in cdr::names(&layout, *serialization, message)? {
                if !names.contains(&name) {
                    names.push(name);
                }
            }
            remaining -= 1;
            Ok(remaining > 0)
        })?;
        Ok(names)
    }
}

impl Part {
    fn open(path: &Path, allow_cut: bool) -> Result<(Self, Vec<Topic>)> {
        let mut head = Vec::new();
        File::open(path)?.take(Format::HEAD_BYTES as u64).read_to_end(&mut head)?;
        let format = Format::of(&head).ok_or_else(|| {
            Error::Unsupported("is no MCAP, SQLite, ULog, DataFlash or ROS 1 file; expected a bag".to_owned())
        })?;
        format.check()?;
        let topics = readers::topics(path, format, allow_cut)?;
        Ok((Self { path: path.to_owned(), format }, topics))
    }

    fn read(&self, topics: &[Topic], wanted: &[usize], each: &mut Each<'_>) -> Result<Ending> {
        readers::messages(&self.path, self.format, topics, wanted, each)
    }
}
