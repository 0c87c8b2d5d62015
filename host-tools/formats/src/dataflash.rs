//! DataFlash, the logs of ArduPilot
//! (ardupilot.org/dev/docs/code-overview-adding-a-new-log-message.html; AP_Logger/LogStructure.h).
//!
//! Each message is three bytes that say which it is, and numbers in a row as a message `FMT` before
//! it has said. Read here, not by the crate `ardupilot-binlog` 0.2: it panics on a message of fewer
//! than three bytes, and ends in silence where a file is damaged or cut off.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use crate::cdr::Primitive;
use crate::ending::{Each, Ending};
use crate::error::Result;
use crate::topic::{Encoding, PackedField, Topic};

/// What each message begins with.
const HEAD: [u8; 2] = [0xA3, 0x95];
/// The message that says what others are: three bytes, then type, length, name, types of the
/// columns, names of the columns.
const FORMAT: u8 = 128;
const FORMAT_BYTES: usize = 89;

/// Numbers by the letter of their type, with the factor that the letter stands for; `None` of texts
/// and arrays.
fn number(letter: u8) -> Option<(Primitive, f64)> {
    Some(match letter {
        b'b' => (Primitive::I8, 1.0),
        b'B' | b'M' => (Primitive::U8, 1.0),
        b'h' => (Primitive::I16, 1.0),
        b'H' => (Primitive::U16, 1.0),
        b'c' => (Primitive::I16, 1e-2),
        b'C' => (Primitive::U16, 1e-2),
        b'i' => (Primitive::I32, 1.0),
        b'I' => (Primitive::U32, 1.0),
        b'e' => (Primitive::I32, 1e-2),
        b'E' => (Primitive::U32, 1e-2),
        b'L' => (Primitive::I32, 1e-7),
        b'q' => (Primitive::I64, 1.0),
        b'Q' => (Primitive::U64, 1.0),
        b'f' => (Primitive::F32, 1.0),
        b'd' => (Primitive::F64, 1.0),
        _ => return None,
    })
}

/// Bytes of a column.
fn size(letter: u8) -> Option<usize> {
    match letter {
        b'n' => Some(4),
        b'N' => Some(16),
        b'Z' | b'a' => Some(64),
        b'g' => Some(2),
        letter => number(letter).map(|(kind, _)| kind.size()),
    }
}

/// A kind of message.
#[derive(Debug, Clone)]
struct Format {
    length: usize,
    name: String,
    fields: Vec<PackedField>,
    /// Place and size of its time, µs.
    time: Option<PackedField>,
    /// The column that tells one sensor or motor from another.
    instance: Option<usize>,
}

fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).into_owned()
}

impl Format {
    /// Of a message `FMT`; `None` of one that contradicts itself.
    fn of(message: &[u8]) -> Option<(u8, Self)> {
        let (kind, length) = (*message.get(3)?, usize::from(*message.get(4)?));
        let (name, letters, labels) =
            (text(message.get(5..9)?), message.get(9..25)?, text(message.get(25..89)?));
        let mut labels = labels.split(',');
        let mut format = Self { length, name, fields: Vec::new(), time: None, instance: None };
        let mut offset = HEAD.len() + 1;
        for &letter in letters.iter().take_while(|letter| **letter != 0) {
            let label = labels.next().unwrap_or_default().trim();
            if let Some((kind, scale)) = number(letter).filter(|_| !label.is_empty()) {
                if matches!(label, "Instance" | "Inst" | "I") && kind.size() == 1 {
                    format.instance = Some(offset);
                }
                let field = PackedField { name: label.to_owned(), kind, offset, scale };
                match label {
                    "TimeUS" => format.time = Some(field.clone()),
                    // Of logs before 2015.
                    "TimeMS" => format.time = Some(PackedField { scale: 1e3, ..field.clone() }),
                    _ => {}
                }
                format.fields.push(field);
            }
            offset += size(letter)?;
        }
        (offset == length && !format.name.is_empty()).then_some((kind, format))
    }

    /// With the instance, if it is not the first.
    fn topic(&self, message: &[u8]) -> String {
        match self.instance.and_then(|at| message.get(at)) {
            None | Some(0) => self.name.clone(),
            Some(instance) => format!("{}.{instance}", self.name),
        }
    }
}

type EachMessage<'a> = dyn FnMut(&Format, u8, &[u8]) -> Result<bool> + 'a;

/// Hands out all messages that a `FMT` before them describes.
fn messages(path: &Path, each: &mut EachMessage<'_>) -> Result<Ending> {
    let mut file = BufReader::with_capacity(1 << 20, File::open(path)?);
    let mut formats: HashMap<u8, Format> = HashMap::new();
    // A message has 255 bytes at most.
    let mut message = [0; 256];
    let mut place = 0_u64;
    let cut = |place: u64, why: &str| {
        Ok(Ending::Cut(format!(
            "breaks off at byte {place} ({why}); --allow-truncated reads what comes before"
        )))
    };
    loop {
        let got = fill(&mut file, &mut message[..3])?;
        match got {
            0 => return Ok(Ending::Whole),
            3 if message[..2] == HEAD => {}
            // Files end in zeros or 0xFF up to a block where power was cut.
            _ => return cut(place, "no message begins there"),
        }
        let kind = message[2];
        let length =
            if kind == FORMAT { Some(FORMAT_BYTES) } else { formats.get(&kind).map(|format| format.length) };
        let Some(length) = length else { return cut(place, "no message before it says what it is") };
        if fill(&mut file, &mut message[3..length])? < length - 3 {
            return cut(place, "it ends within a message");
        }
        let message = &message[..length];
        if kind == FORMAT {
            let Some((kind, format)) = Format::of(message) else {
                return cut(place, "a definition contradicts itself");
            };
            formats.insert(kind, format);
        } else if let Some(format) = formats.get(&kind)
            && !each(format, kind, message)?
        {
            return Ok(Ending::Whole);
        }
        place += length as u64;
    }
}

/// Bytes read: fewer than asked for at the end of the file only.
fn fill(from: &mut impl Read, into: &mut [u8]) -> Result<usize> {
    let mut got = 0;
    while got < into.len() {
        match from.read(&mut into[got..]) {
            Ok(0) => break,
            Ok(count) => got += count,
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error.into()),
        }
    }
    Ok(got)
}

/// The topics: all that have a message with a time, in the order of their first.
pub(crate) fn topics(path: &Path, allow_cut: bool) -> Result<Vec<Topic>> {
    let mut topics: Vec<Topic> = Vec::new();
    let mut places: HashMap<(u8, u8), usize> = HashMap::new();
    let ending = messages(path, &mut |format, kind, message| {
        if format.time.is_none() {
            return Ok(true);
        }
        let instance = format.instance.and_then(|at| message.get(at)).copied().unwrap_or(0);
        if let Some(place) = places.get(&(kind, instance)) {
            topics[*place].messages = topics[*place].messages.map(|count| count + 1);
            return Ok(true);
        }
        places.insert((kind, instance), topics.len());
        topics.push(Topic {
            name: format.topic(message),
            kind: format!("ardupilot/{}", format.name),
            encoding: Encoding::Packed { fields: format.fields.clone() },
            messages: Some(1),
        });
        Ok(true)
    })?;
    match ending {
        Ending::Cut(why) if !allow_cut => Err(crate::Error::Truncated(why)),
        _ => Ok(topics),
    }
}

/// Hands out the messages of some topics. They have one time only, that of the board, in µs.
pub(crate) fn read(path: &Path, topics: &[Topic], wanted: &[usize], each: &mut Each<'_>) -> Result<Ending> {
    let mut places: HashMap<(u8, u8), Option<usize>> = HashMap::new();
    messages(path, &mut |format, kind, message| {
        let Some(time) = &format.time else { return Ok(true) };
        let instance = format.instance.and_then(|at| message.get(at)).copied().unwrap_or(0);
        let place = *places.entry((kind, instance)).or_insert_with(|| {
            let name = format.topic(message);
            topics.iter().position(|topic| topic.name == name).filter(|place| wanted.contains(place))
        });
        let Some(place) = place else { return Ok(true) };
        let microseconds = message.get(time.offset..).and_then(|bytes| time.kind.number(bytes, true));
        let nanoseconds = microseconds.map_or(0.0, |time_us| time_us * time.scale * 1e3);
        each(place, nanoseconds as i64, message)
    })
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use super::*;

    fn format(length: u8, letters: &str, labels: &str) -> Vec<u8> {
        let mut message = vec![0; FORMAT_BYTES];
        message[..5].copy_from_slice(&[HEAD[0], HEAD[1], FORMAT, 1, length]);
        message[5..9].copy_from_slice(b"BAT\0");
        message[9..9 + letters.len()].copy_from_slice(letters.as_bytes());
        message[25..25 + labels.len()].copy_from_slice(labels.as_bytes());
        message
    }

    fn ending(bytes: &[u8]) -> String {
        let mut file = tempfile::NamedTempFile::new().unwrap();
        file.write_all(bytes).unwrap();
        match messages(file.path(), &mut |_, _, _| Ok(true)).unwrap() {
            Ending::Cut(why) => why,
            Ending::Whole => "whole".to_owned(),
        }
    }

    #[test]
    fn definitions_that_contradict_themselves_are_refused() {
        assert_eq!(ending(&format(15, "Qf", "TimeUS,Volt")), "whole");
        // Shorter than what each message begins with; not as long as its columns; a column of no
        // known type.
        for wrong in
            [format(2, "Qf", "TimeUS,Volt"), format(16, "Qf", "TimeUS,Volt"), format(12, "Q?", "TimeUS,Volt")]
        {
            assert!(ending(&wrong).contains("breaks off at byte 0 (a definition contradicts itself)"));
        }
        let unknown = [&format(15, "Qf", "TimeUS,Volt")[..], &[HEAD[0], HEAD[1], 9]].concat();
        assert!(ending(&unknown).contains("breaks off at byte 89 (no message before it says what it is)"));
        let cut = [&format(15, "Qf", "TimeUS,Volt")[..], &[HEAD[0], HEAD[1], 1, 0]].concat();
        assert!(ending(&cut).contains("it ends within a message"));
    }
}
