//! MCAP, by the crate of its makers.

use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use mcap::records::{Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{MAGIC, McapError};

use crate::ending::{Each, Ending};
use crate::error::{Error, Result};
use crate::topic::{Encoding, Serialization, Topic};

/// Bytes of the longest record: a point cloud or picture has some ten million.
const LONGEST: usize = 128 << 20;

/// Bytes of the footer: opcode, length, two places and a checksum.
const FOOTER: i64 = 1 + 8 + 20;

/// The topics, from the summary at its end, or from all of the file where it has none.
pub(crate) fn topics(path: &Path, allow_cut: bool) -> Result<Vec<Topic>> {
    if !ends_whole(path)? {
        if !allow_cut {
            let message = "ends before its format does (no MCAP mark at its end): the recording was cut off; \
                           --allow-truncated reads what is there";
            return Err(Error::Truncated(message.to_owned()));
        }
        return scanned(path);
    }
    match summary(path) {
        Ok(Some(topics)) if !topics.is_empty() => Ok(topics),
        _ => scanned(path),
    }
}

/// Whether the format's mark is at its end.
fn ends_whole(path: &Path) -> Result<bool> {
    let mut file = File::open(path)?;
    if file.metadata()?.len() < 2 * MAGIC.len() as u64 {
        return Ok(false);
    }
    file.seek(SeekFrom::End(-(MAGIC.len() as i64)))?;
    let mut end = [0; MAGIC.len()];
    file.read_exact(&mut end)?;
    Ok(end == MAGIC)
}

/// The topics that the summary tells; `None` where there is none, or one that is damaged: then the
/// data tell.
fn summary(path: &Path) -> Result<Option<Vec<Topic>>> {
    let mut file = BufReader::new(File::open(path)?);
    let length = file.get_ref().metadata()?.len();
    file.seek(SeekFrom::End(-(FOOTER + MAGIC.len() as i64)))?;
    let Some((op::FOOTER, footer)) = next_record(&mut file, length)? else { return Ok(None) };
    let Ok(Record::Footer(footer)) = mcap::parse_record(op::FOOTER, &footer) else { return Ok(None) };
    if footer.summary_start == 0 || footer.summary_start >= length {
        return Ok(None);
    }
    file.seek(SeekFrom::Start(footer.summary_start))?;
    let (mut schemas, mut channels, mut counts) = (HashMap::new(), BTreeMap::new(), None);
    loop {
        let Some((opcode, body)) = next_record(&mut file, length)? else { return Ok(None) };
        match parsed(opcode, &body) {
            Some(Ok(Record::Schema { header, data })) => {
                schemas.insert(header.id, (header.name, header.encoding, data.into_owned()));
            }
            Some(Ok(Record::Channel(channel))) => _ = channels.insert(channel.id, channel),
            Some(Ok(Record::Statistics(statistics))) => counts = Some(statistics.channel_message_counts),
            Some(Err(_)) => return Ok(None),
            _ if opcode == op::FOOTER => break,
            _ => {}
        }
    }
    let mut topics: Vec<Topic> = Vec::new();
    for channel in channels.values() {
        let schema = schemas.get(&channel.schema_id);
        let schema = schema.map(|(name, encoding, data)| (&name[..], &encoding[..], &data[..]));
        let messages = counts.as_ref().map(|counts| counts.get(&channel.id).copied().unwrap_or(0));
        add(&mut topics, &channel.topic, &channel.message_encoding, schema, messages);
    }
    Ok(Some(topics))
}

/// The record at this place of a file that is so long; `None` where there is none that fits.
fn next_record(file: &mut BufReader<File>, length: u64) -> Result<Option<(u8, Vec<u8>)>> {
    let (mut opcode, mut size) = ([0], [0; 8]);
    if file.read_exact(&mut opcode).and_then(|()| file.read_exact(&mut size)).is_err() {
        return Ok(None);
    }
    let remaining = length.saturating_sub(file.stream_position()?);
    let Some(size) = usize::try_from(u64::from_le_bytes(size)).ok().filter(|size| *size as u64 <= remaining)
    else {
        return Ok(None);
    };
    if size > LONGEST {
        return Ok(None);
    }
    let mut body = vec![0; size];
    file.read_exact(&mut body)?;
    let [opcode] = opcode;
    Ok(Some((opcode, body)))
}

/// A record of those that are looked at; `None` of any other. The crate takes a length within a
/// record for true, and memory for it: up to 4 GB for a text of which there are ten bytes.
fn parsed(opcode: u8, body: &[u8]) -> Option<Result<Record<'_>, McapError>> {
    let fields = match opcode {
        op::SCHEMA => "2ttt",
        op::CHANNEL => "22ttm",
        op::MESSAGE => "2488",
        op::STATISTICS => "82444488",
        op::DATA_END => "4",
        _ => return None,
    };
    if fit(fields, body) {
        Some(mcap::parse_record(opcode, body))
    } else {
        Some(Err(McapError::UnexpectedEof))
    }
}

/// Whether these fields are within a record: numbers of so many bytes, texts (`t`) and maps of
/// texts (`m`) with their lengths before them (MCAP's specification, Records).
fn fit(fields: &str, mut body: &[u8]) -> bool {
    fields.bytes().all(|field| match field {
        b't' => text(&mut body).is_some(),
        b'm' => text(&mut body).is_some_and(|mut texts| {
            // A key and its value, until there is no more.
            while !texts.is_empty() {
                if text(&mut texts).is_none() {
                    return false;
                }
            }
            true
        }),
        size => body.split_off(..usize::from(size - b'0')).is_some(),
    })
}

/// The bytes of a text at the start of `body`, which then begins behind it.
fn text<'a>(body: &mut &'a [u8]) -> Option<&'a [u8]> {
    let (length, rest) = body.split_first_chunk()?;
    let (text, rest) = rest.split_at_checked(u32::from_le_bytes(*length) as usize)?;
    *body = rest;
    Some(text)
}

/// Adds a topic, or the messages of another publisher of one that is there.
fn add(
    topics: &mut Vec<Topic>,
    name: &str,
    messages_as: &str,
    schema: Option<(&str, &str, &[u8])>,
    messages: Option<u64>,
) {
    if let Some(known) = topics.iter_mut().find(|known| known.name == name) {
        known.messages = known.messages.zip(messages).map(|(a, b)| a + b);
        return;
    }
    let (kind, schema_as, data) = schema.unwrap_or(("no schema", "", b""));
    let text = || String::from_utf8_lossy(data).into_owned();
    let ros = |definition, serialization| Encoding::Ros { definition, serialization };
    let encoding = match (messages_as, schema_as) {
        ("cdr", "ros2msg") => ros(text(), Serialization::Cdr),
        ("ros1", "ros1msg") => ros(text(), Serialization::Ros1),
        ("cdr", _) => match crate::cdr::known_definition(kind) {
            Some(definition) => ros(definition, Serialization::Cdr),
            None => Encoding::Other(format!("cdr with a schema in {schema_as:?}")),
        },
        ("json", "jsonschema" | "") => Encoding::Json { schema: text() },
        _ => Encoding::Other(format!("{messages_as} with a schema in {schema_as:?}")),
    };
    topics.push(Topic { name: name.to_owned(), kind: kind.to_owned(), encoding, messages });
}

fn scanned(path: &Path) -> Result<Vec<Topic>> {
    let mut topics = Vec::new();
    let mut schemas: HashMap<u16, (String, String, Vec<u8>)> = HashMap::new();
    records(path, &mut |record| {
        match record {
            Record::Schema { header, data } => {
                schemas.insert(header.id, (header.name, header.encoding, data.into_owned()));
            }
            Record::Channel(channel) => {
                let schema = schemas.get(&channel.schema_id);
                let schema = schema.map(|(name, encoding, data)| (&name[..], &encoding[..], &data[..]));
                add(&mut topics, &channel.topic, &channel.message_encoding, schema, None);
            }
            _ => {}
        }
        Ok(true)
    })?;
    Ok(topics)
}

/// Hands out the messages of some topics.
pub(crate) fn read(path: &Path, topics: &[Topic], wanted: &[usize], each: &mut Each<'_>) -> Result<Ending> {
    let mut channels: HashMap<u16, usize> = HashMap::new();
    records(path, &mut |record| {
        match record {
            Record::Channel(channel) => {
                let place = topics.iter().position(|topic| topic.name == channel.topic);
                if let Some(place) = place.filter(|place| wanted.contains(place)) {
                    channels.insert(channel.id, place);
                }
            }
            Record::Message { header, data } => {
                if let Some(place) = channels.get(&header.channel_id) {
                    return each(*place, i64::try_from(header.log_time).unwrap_or(i64::MAX), &data);
                }
            }
            _ => {}
        }
        Ok(true)
    })
}

/// Hands out the records up to the end of the data, those within chunks included.
fn records(path: &Path, each: &mut dyn FnMut(Record<'_>) -> Result<bool>) -> Result<Ending> {
    let cut = |error: McapError| {
        let why = error.to_string().replace('\n', " ");
        format!("breaks off ({why}); --allow-truncated reads what comes before")
    };
    let mut file = BufReader::with_capacity(1 << 20, File::open(path)?);
    let options = LinearReaderOptions::default().with_skip_end_magic(true).with_record_length_limit(LONGEST);
    let mut reader = LinearReader::new_with_options(options);
    while let Some(event) = reader.next_event() {
        match event {
            Ok(LinearReadEvent::ReadRequest(count)) => {
                let read = file.read(reader.insert(count.min(LONGEST)))?;
                reader.notify_read(read);
            }
            Ok(LinearReadEvent::Record { data, opcode }) => {
                let record = match parsed(opcode, data) {
                    Some(Ok(record)) => record,
                    Some(Err(error)) => return Ok(Ending::Cut(cut(error))),
                    None => continue,
                };
                if matches!(record, Record::DataEnd(_)) || !each(record)? {
                    return Ok(Ending::Whole);
                }
            }
            Err(McapError::UnsupportedCompression(name)) => {
                let message = format!("has chunks compressed as {name:?}; expected zstd, lz4 or none");
                return Err(Error::Unsupported(message));
            }
            Err(error) => return Ok(Ending::Cut(cut(error))),
        }
    }
    Ok(Ending::Cut("ends before its data do; --allow-truncated reads what is there".to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text_of(text: &str) -> Vec<u8> {
        [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat()
    }

    /// Every length of a channel and of a schema, as it is and as long as it can say: 4 GB are not
    /// even asked for.
    #[test]
    fn lengths_beyond_the_record_are_refused() {
        let map = [text_of("key"), text_of("value")].concat();
        let map = [&(map.len() as u32).to_le_bytes()[..], &map].concat();
        let channel = [&[1, 0, 2, 0][..], &text_of("/t"), &text_of("cdr"), &map].concat();
        let schema = [&[1, 0][..], &text_of("p/A"), &text_of("ros2msg"), &text_of("int8 a")].concat();
        assert!(matches!(parsed(op::CHANNEL, &channel), Some(Ok(Record::Channel(it))) if it.topic == "/t"));
        assert!(matches!(parsed(op::SCHEMA, &schema), Some(Ok(Record::Schema { .. }))));
        for (opcode, record, lengths) in
            [(op::CHANNEL, channel, &[4, 10, 17, 21, 28][..]), (op::SCHEMA, schema, &[2, 9, 20])]
        {
            for &at in lengths {
                let mut wrong = record.clone();
                wrong[at..at + 4].copy_from_slice(&u32::MAX.to_le_bytes());
                assert!(matches!(parsed(opcode, &wrong), Some(Err(_))), "{opcode} {at}");
            }
            for end in 0..record.len() {
                assert!(matches!(parsed(opcode, &record[..end]), Some(Err(_))), "{opcode} {end}");
            }
        }
    }
}
