//! Bags of ROS 1, version 2.0 (wiki.ros.org/Bags/Format/2.0).
//!
//! Read here, not by the crate `rosbag` 0.6.3: it maps the file into memory, panics where the place
//! of the index is wrong, which a recording that was killed always has, and takes as much memory as
//! a chunk says that it needs.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use crate::ending::{Each, Ending};
use crate::error::{Error, Result};
use crate::topic::{Encoding, Serialization, Topic};

const VERSION: &[u8] = b"#ROSBAG V2.0\n";

/// Bytes of a record's header: a few fields of some ten bytes, and a topic's name.
const LONGEST_HEADER: usize = 1 << 20;
/// Bytes of a chunk: recorders close it at 768 kB, or behind the message that is longer.
const LONGEST: usize = 128 << 20;

/// Kinds of records.
const MESSAGE: u8 = 2;
const FILE: u8 = 3;
const CHUNK: u8 = 5;
const CHUNK_INFO: u8 = 6;
const CONNECTION: u8 = 7;

/// The fields of a header: `name=value`, each with its length.
#[derive(Debug)]
struct Header<'a>(&'a [u8]);

impl<'a> Header<'a> {
    fn get(&self, wanted: &[u8]) -> Option<&'a [u8]> {
        let mut rest = self.0;
        while let Some((length, after)) = rest.split_first_chunk::<4>() {
            let (field, after) = after.split_at_checked(u32::from_le_bytes(*length) as usize)?;
            let equals = field.iter().position(|byte| *byte == b'=')?;
            if &field[..equals] == wanted {
                return Some(&field[equals + 1..]);
            }
            rest = after;
        }
        None
    }

    fn number(&self, name: &[u8]) -> Option<u32> {
        self.get(name)?.try_into().ok().map(u32::from_le_bytes)
    }

    fn kind(&self) -> Option<u8> {
        self.get(b"op")?.first().copied()
    }

    fn text(&self, name: &[u8]) -> Option<String> {
        Some(String::from_utf8_lossy(self.get(name)?).into_owned())
    }

    /// When a message was received, ns.
    fn time(&self) -> Option<i64> {
        let (seconds, nanoseconds) = self.get(b"time")?.split_first_chunk::<4>()?;
        let nanoseconds: [u8; 4] = nanoseconds.try_into().ok()?;
        Some(
            i64::from(u32::from_le_bytes(*seconds)) * 1_000_000_000
                + i64::from(u32::from_le_bytes(nanoseconds)),
        )
    }
}

/// Why reading stops before the end.
fn cut(why: &str) -> Ending {
    Ending::Cut(format!("breaks off ({why}); --allow-truncated reads what comes before"))
}

/// A record of the file, in buffers that are used again.
#[derive(Default)]
struct Record {
    header: Vec<u8>,
    data: Vec<u8>,
}

impl Record {
    /// Reads the next one; `None` at the end of the file, and why not where there is none.
    fn read(&mut self, from: &mut impl Read) -> Result<Option<()>, Ending> {
        // Nothing of the last one is left in one that is cut off.
        self.header.clear();
        self.data.clear();
        let mut length = [0; 4];
        let failed = |error: std::io::Error| cut(&error.to_string());
        let got = from.by_ref().take(4).read(&mut length).map_err(failed)?;
        if got == 0 {
            return Ok(None);
        }
        from.read_exact(&mut length[got..]).map_err(failed)?;
        for (bytes, longest, what) in
            [(&mut self.header, LONGEST_HEADER, "a header"), (&mut self.data, LONGEST, "a record")]
        {
            if what == "a record" {
                from.read_exact(&mut length).map_err(failed)?;
            }
            let wanted = u32::from_le_bytes(length) as usize;
            if wanted > longest {
                return Err(cut(&format!("{what} of {wanted} bytes; expected {longest} at most")));
            }
            // Grows as bytes arrive: a length alone takes no memory.
            let got = from.by_ref().take(wanted as u64).read_to_end(bytes).map_err(failed)?;
            if got < wanted {
                return Err(cut(&format!("{what} of {wanted} bytes has {got}")));
            }
        }
        Ok(Some(()))
    }

    fn header(&self) -> Header<'_> {
        Header(&self.header)
    }
}

/// Opens a bag behind its first record, and gives the place of its index, 0 where the recording was
/// cut off.
fn open(path: &Path) -> Result<(BufReader<File>, u64)> {
    let mut file = BufReader::with_capacity(1 << 20, File::open(path)?);
    let mut version = [0; VERSION.len()];
    file.read_exact(&mut version).map_err(|_| Error::damaged("ROS 1", "it ends within its first line"))?;
    if version != VERSION {
        let other = String::from_utf8_lossy(&version).trim_end().to_owned();
        return Err(Error::Unsupported(format!(
            "is a bag of ROS 1 of another version, {other}; expected 2.0 (rosbag migrate)"
        )));
    }
    let mut record = Record::default();
    let read = record.read(&mut file).ok().flatten();
    let header = record.header();
    let index = header.get(b"index_pos").and_then(|place| place.try_into().ok()).map(u64::from_le_bytes);
    match (read, header.kind(), index) {
        (Some(()), Some(FILE), Some(index)) => Ok((file, index)),
        _ => Err(Error::damaged("ROS 1", "its first record is no file header")),
    }
}

/// The topics: from the index at its end, or from all of the file where it has none.
pub(crate) fn topics(path: &Path, allow_cut: bool) -> Result<Vec<Topic>> {
    let (mut file, index) = open(path)?;
    let length = file.get_ref().metadata()?.len();
    let mut connections = Connections::default();
    if index > 0 && index < length {
        file.seek(SeekFrom::Start(index))?;
        let mut record = Record::default();
        while let Ok(Some(())) = record.read(&mut file) {
            match record.header().kind() {
                Some(CONNECTION) => connections.add(record.header(), &record.data),
                Some(CHUNK_INFO) => connections.count(&record.data),
                _ => {}
            }
        }
        connections.are_counted = true;
    } else if allow_cut {
        records(path, &mut |kind, header, data| {
            if kind == CONNECTION {
                connections.add(header, data);
            }
            Ok(true)
        })?;
    } else {
        let message = "ends before its format does (no index at its end): the recording was cut off; --allow-truncated reads what is there, \
                       and so does rosbag reindex";
        return Err(Error::Truncated(message.to_owned()));
    }
    Ok(connections.topics())
}

/// Connections, of which a topic has one a publisher.
#[derive(Default)]
struct Connections {
    all: Vec<(u32, String, String, String)>,
    messages: HashMap<u32, u64>,
    are_counted: bool,
}

impl Connections {
    fn add(&mut self, header: Header<'_>, data: &[u8]) {
        let described = Header(data);
        let all = (
            header.number(b"conn"),
            header.text(b"topic"),
            described.text(b"type"),
            described.text(b"message_definition"),
        );
        let (Some(connection), Some(topic), Some(kind), Some(definition)) = all else { return };
        if !self.all.iter().any(|(known, ..)| *known == connection) {
            self.all.push((connection, topic, kind, definition));
        }
    }

    /// Messages of each connection in a chunk, in pairs.
    fn count(&mut self, data: &[u8]) {
        let (pairs, _) = data.as_chunks::<8>();
        for pair in pairs {
            let number = |at: usize| u32::from_le_bytes([pair[at], pair[at + 1], pair[at + 2], pair[at + 3]]);
            *self.messages.entry(number(0)).or_default() += u64::from(number(4));
        }
    }

    fn topics(self) -> Vec<Topic> {
        let mut topics: Vec<Topic> = Vec::new();
        for (connection, name, kind, definition) in self.all {
            let messages = self.are_counted.then(|| self.messages.get(&connection).copied().unwrap_or(0));
            match topics.iter_mut().find(|known| known.name == name) {
                Some(known) => known.messages = known.messages.zip(messages).map(|(a, b)| a + b),
                None => {
                    let encoding = Encoding::Ros { definition, serialization: Serialization::Ros1 };
                    topics.push(Topic { name, kind, encoding, messages });
                }
            }
        }
        topics
    }
}

/// Hands out the messages of some topics.
pub(crate) fn read(path: &Path, topics: &[Topic], wanted: &[usize], each: &mut Each<'_>) -> Result<Ending> {
    let mut places: HashMap<u32, Option<usize>> = HashMap::new();
    records(path, &mut |kind, header, data| {
        let Some(connection) = header.number(b"conn") else { return Ok(true) };
        if kind == CONNECTION {
            let name = header.text(b"topic").unwrap_or_default();
            let place = topics.iter().position(|topic| topic.name == name);
            places.insert(connection, place.filter(|place| wanted.contains(place)));
            return Ok(true);
        }
        match (places.get(&connection).copied().flatten(), header.time()) {
            (Some(place), Some(time)) => each(place, time, data),
            _ => Ok(true),
        }
    })
}

type EachRecord<'a> = dyn FnMut(u8, Header<'_>, &[u8]) -> Result<bool> + 'a;

/// Hands out the connections and messages of all chunks, up to the index.
fn records(path: &Path, each: &mut EachRecord<'_>) -> Result<Ending> {
    let (mut file, index) = open(path)?;
    let mut record = Record::default();
    let mut chunk = Vec::new();
    loop {
        if index > 0 && file.stream_position()? >= index {
            return Ok(Ending::Whole);
        }
        // What arrived of a record that was cut off is in it.
        let ending = match record.read(&mut file) {
            Ok(Some(())) => None,
            Ok(None) if index > 0 => return Ok(cut("it ends before its index")),
            Ok(None) => return Ok(cut("it has no index")),
            Err(ending) => Some(ending),
        };
        let header = record.header();
        let goes_on = match header.kind() {
            Some(CHUNK) => {
                let (unpacked, is_whole) = unpack(&record, &mut chunk)?;
                match each_within(unpacked, each)? {
                    Within::Whole if is_whole || ending.is_some() => true,
                    Within::Stopped => false,
                    _ if ending.is_some() => true,
                    _ => return Ok(cut("a chunk cannot be unpacked")),
                }
            }
            // Of a chunk that was never closed: its header says that it is empty, and its records
            // follow.
            Some(kind @ (MESSAGE | CONNECTION)) if ending.is_none() => each(kind, header, &record.data)?,
            _ => true,
        };
        match ending {
            _ if !goes_on => return Ok(Ending::Whole),
            Some(ending) => return Ok(ending),
            None => {}
        }
    }
}

/// How the records of a chunk ended.
enum Within {
    Whole,
    /// Within a record.
    Cut,
    /// Nobody wants more.
    Stopped,
}

/// Hands out the connections and messages of a chunk.
fn each_within(mut rest: &[u8], each: &mut EachRecord<'_>) -> Result<Within> {
    while !rest.is_empty() {
        let Some((header, data, after)) = within(rest) else { return Ok(Within::Cut) };
        rest = after;
        if let Some(kind @ (MESSAGE | CONNECTION)) = header.kind()
            && !each(kind, header, data)?
        {
            return Ok(Within::Stopped);
        }
    }
    Ok(Within::Whole)
}

/// The first record of a chunk, and what follows it.
fn within(bytes: &[u8]) -> Option<(Header<'_>, &[u8], &[u8])> {
    let range = |bytes: &'_ [u8]| -> Option<(usize, usize)> {
        let length = u32::from_le_bytes(*bytes.first_chunk::<4>()?) as usize;
        (length <= bytes.len() - 4).then_some((4, 4 + length))
    };
    let (start, end) = range(bytes)?;
    let (header, rest) = (&bytes[start..end], &bytes[end..]);
    let (start, end) = range(rest)?;
    Some((Header(header), &rest[start..end], &rest[end..]))
}

/// The bytes of a chunk, as far as they can be unpacked, and whether they are all that its header
/// says.
fn unpack<'a>(record: &'a Record, chunk: &'a mut Vec<u8>) -> Result<(&'a [u8], bool)> {
    let header = record.header();
    let size = header.number(b"size").map(|size| size as usize).filter(|size| *size <= LONGEST);
    let Some(size) = size else { return Ok((&[], false)) };
    // One byte more than it says: then it is more.
    let most = size as u64 + 1;
    chunk.clear();
    // What cannot be unpacked leaves what came before it, and too few bytes.
    let _ = match header.get(b"compression") {
        Some(b"none") => return Ok((&record.data, record.data.len() == size)),
        Some(b"lz4") => {
            lz4::Decoder::new(&record.data[..]).and_then(|decoder| decoder.take(most).read_to_end(chunk))
        }
        Some(b"bz2") => bzip2::read::BzDecoder::new(&record.data[..]).take(most).read_to_end(chunk),
        other => {
            let name = String::from_utf8_lossy(other.unwrap_or(b"")).into_owned();
            return Err(Error::Unsupported(format!(
                "has chunks compressed as {name:?}; expected none, lz4 or bz2 (rosbag decompress)"
            )));
        }
    };
    Ok((&chunk[..], chunk.len() == size))
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use super::*;

    fn field(name: &str, value: &[u8]) -> Vec<u8> {
        let length = (name.len() + 1 + value.len()) as u32;
        [&length.to_le_bytes()[..], name.as_bytes(), b"=", value].concat()
    }

    fn record(header: &[Vec<u8>], data: &[u8]) -> Vec<u8> {
        let header = header.concat();
        let length = |bytes: &[u8]| (bytes.len() as u32).to_le_bytes();
        [&length(&header)[..], &header, &length(data), data].concat()
    }

    /// A bag that was never closed, with these bytes behind its first record.
    fn bag(rest: &[u8]) -> tempfile::NamedTempFile {
        let mut file = tempfile::NamedTempFile::new().unwrap();
        let first = record(&[field("op", &[FILE]), field("index_pos", &[0; 8])], b"");
        file.write_all(&[VERSION, &first, rest].concat()).unwrap();
        file
    }

    fn ending(rest: &[u8]) -> String {
        match records(bag(rest).path(), &mut |_, _, _| Ok(true)).unwrap() {
            Ending::Cut(why) => why,
            Ending::Whole => "whole".to_owned(),
        }
    }

    /// Neither does a length take memory, nor more than a chunk says come out of it.
    #[test]
    fn lengths_and_sizes_are_not_believed() {
        assert!(ending(&[0xFF; 4]).contains("a header of 4294967295 bytes; expected 1048576 at most"));
        let header = field("op", &[CHUNK]);
        let long = [&(header.len() as u32).to_le_bytes()[..], &header, &[0xFF; 4]].concat();
        assert!(ending(&long).contains("a record of 4294967295 bytes; expected 134217728 at most"));
        let short =
            [&(header.len() as u32).to_le_bytes()[..], &header, &100_u32.to_le_bytes(), b"abc"].concat();
        assert!(ending(&short).contains("a record of 100 bytes has 3"));

        let mut encoder = lz4::EncoderBuilder::new().build(Vec::new()).unwrap();
        encoder.write_all(&vec![0; 10 << 20]).unwrap();
        let header =
            [field("op", &[CHUNK]), field("compression", b"lz4"), field("size", &100_u32.to_le_bytes())];
        let packed = Record { header: header.concat(), data: encoder.finish().0 };
        let mut chunk = Vec::new();
        let (unpacked, is_whole) = unpack(&packed, &mut chunk).unwrap();
        assert_eq!((unpacked.len(), is_whole), (101, false));
        assert!(chunk.capacity() < 1 << 16, "{}", chunk.capacity());
    }

    /// Its header says that a chunk is empty until it is closed; what it holds follows.
    #[test]
    fn a_chunk_that_was_never_closed_is_read() {
        let chunk = [field("op", &[CHUNK]), field("compression", b"none"), field("size", &[0; 4])];
        let described =
            [field("type", b"std_msgs/Float64"), field("message_definition", b"float64 data\n")].concat();
        let number = |kind| [field("op", &[kind]), field("conn", &[7, 0, 0, 0])].concat();
        let connection = record(&[number(CONNECTION), field("topic", b"/power")], &described);
        let message =
            record(&[number(MESSAGE), field("time", &[1, 0, 0, 0, 2, 0, 0, 0])], &2.5_f64.to_le_bytes());
        let file = bag(&[record(&chunk, b""), connection, message].concat());
        let topics = topics(file.path(), true).unwrap();
        assert_eq!(topics.iter().map(|topic| &topic.name[..]).collect::<Vec<_>>(), ["/power"]);
        let mut messages = Vec::new();
        let ending = read(file.path(), &topics, &[0], &mut |topic, time, data| {
            messages.push((topic, time, data.to_vec()));
            Ok(true)
        });
        assert!(matches!(ending.unwrap(), Ending::Cut(_)));
        assert_eq!(messages, [(0, 1_000_000_002, 2.5_f64.to_le_bytes().to_vec())]);
        assert!(matches!(super::topics(file.path(), false), Err(Error::Truncated(_))));
    }
}
