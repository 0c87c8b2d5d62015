//! MCAP, by the crate of its makers.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::sans_io::summary_reader::{SummaryReadEvent, SummaryReader, SummaryReaderOptions};
use mcap::{MAGIC, McapError};

use crate::ending::{Each, Ending};
use crate::error::{Error, Result};
use crate::topic::{Encoding, Serialization, Topic};

/// Bytes of the longest record: a point cloud or picture has some ten million.
const LONGEST: usize = 128 << 20;

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

fn summary(path: &Path) -> Result<Option<Vec<Topic>>> {
    let damaged = |error: McapError| Error::damaged("MCAP", error);
    let mut file = File::open(path)?;
    let options = SummaryReaderOptions::default().with_record_length_limit(LONGEST);
    let mut reader = SummaryReader::new_with_options(options);
    while let Some(event) = reader.next_event() {
        match event.map_err(damaged)? {
            SummaryReadEvent::SeekRequest(to) => {
                let place = file.seek(to)?;
                reader.notify_seeked(place);
            }
            SummaryReadEvent::ReadRequest(count) => {
                let read = file.read(reader.insert(count.min(LONGEST)))?;
                reader.notify_read(read);
            }
        }
    }
    let Some(summary) = reader.finish() else { return Ok(None) };
    let counts = summary.stats.as_ref().map(|stats| &stats.channel_message_counts);
    let mut topics: Vec<Topic> = Vec::new();
    let mut channels: Vec<_> = summary.channels.values().collect();
    channels.sort_by_key(|channel| channel.id);
    for channel in channels {
        let messages = counts.map(|counts| counts.get(&channel.id).copied().unwrap_or(0));
        let schema = channel.schema.as_ref();
        add(
            &mut topics,
            &channel.topic,
            &channel.message_encoding,
            schema.map(|schema| (&schema.name[..], &schema.encoding[..], &schema.data[..])),
            messages,
        );
    }
    Ok(Some(topics))
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
                let record = match mcap::parse_record(opcode, data) {
                    Ok(record) => record,
                    Err(error) => return Ok(Ending::Cut(cut(error))),
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
