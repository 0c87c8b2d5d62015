//! ULog, by PX4's own crate. The format has no mark at its end: one that was cut off between two
//! messages cannot be told from a whole one.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use px4_ulog::stream_parser::LogParser;
use px4_ulog::stream_parser::model::{DataMessage, FlattenedFieldType};

use crate::cdr::Primitive;
use crate::ending::{Each, Ending};
use crate::error::{Error, Result};
use crate::guarded::guarded;
use crate::topic::{Encoding, PackedField, Topic};

/// Bytes handed to the parser at once.
const PIECE: usize = 1 << 16;

/// The topics: all that have a message, in the order of their first.
pub(crate) fn topics(path: &Path, allow_cut: bool) -> Result<Vec<Topic>> {
    let mut topics: Vec<Topic> = Vec::new();
    let mut places: HashMap<u16, usize> = HashMap::new();
    let ending = messages(path, &mut |message| {
        if let Some(place) = places.get(&message.msg_id) {
            topics[*place].messages = topics[*place].messages.map(|count| count + 1);
            return Ok(true);
        }
        let format = message.flattened_format;
        // Padding is for alignment only.
        let fields = format.fields.iter().filter(|field| !field.flattened_field_name.contains("_padding"));
        let fields = fields.map(|field| PackedField {
            name: field.flattened_field_name.clone(),
            kind: primitive(&field.field_type),
            offset: usize::from(field.offset),
            scale: 1.0,
        });
        let encoding = Encoding::Packed { fields: fields.collect() };
        places.insert(message.msg_id, topics.len());
        topics.push(Topic {
            name: name(message),
            kind: format.message_name.clone(),
            encoding,
            messages: Some(1),
        });
        Ok(true)
    })?;
    match ending {
        Ending::Cut(why) if !allow_cut => Err(Error::Truncated(why)),
        _ => Ok(topics),
    }
}

fn name(message: &DataMessage<'_>) -> String {
    match message.multi_id.value() {
        0 => message.flattened_format.message_name.clone(),
        instance => format!("{}.{instance}", message.flattened_format.message_name),
    }
}

fn primitive(kind: &FlattenedFieldType) -> Primitive {
    match kind {
        FlattenedFieldType::Int8 => Primitive::I8,
        FlattenedFieldType::UInt8 | FlattenedFieldType::Char => Primitive::U8,
        FlattenedFieldType::Int16 => Primitive::I16,
        FlattenedFieldType::UInt16 => Primitive::U16,
        FlattenedFieldType::Int32 => Primitive::I32,
        FlattenedFieldType::UInt32 => Primitive::U32,
        FlattenedFieldType::Int64 => Primitive::I64,
        FlattenedFieldType::UInt64 => Primitive::U64,
        FlattenedFieldType::Float => Primitive::F32,
        FlattenedFieldType::Double => Primitive::F64,
        FlattenedFieldType::Bool => Primitive::Bool,
    }
}

/// Hands out the messages of some topics. They have one time only, that of the board, in µs.
pub(crate) fn read(path: &Path, topics: &[Topic], wanted: &[usize], each: &mut Each<'_>) -> Result<Ending> {
    let mut places: HashMap<u16, Option<usize>> = HashMap::new();
    messages(path, &mut |message| {
        let place = *places.entry(message.msg_id).or_insert_with(|| {
            let name = name(message);
            topics.iter().position(|topic| topic.name == name).filter(|place| wanted.contains(place))
        });
        let Some(place) = place else { return Ok(true) };
        let Some(stamp) = &message.flattened_format.timestamp_field else { return Ok(true) };
        let at = usize::from(stamp.offset);
        let Some(bytes) = message.data.get(at..at + 8).and_then(|bytes| bytes.try_into().ok()) else {
            return Ok(true);
        };
        let microseconds = u64::from_le_bytes(bytes);
        each(place, i64::try_from(microseconds.saturating_mul(1000)).unwrap_or(i64::MAX), message.data)
    })
}

/// Hands out all messages.
fn messages(path: &Path, each: &mut dyn FnMut(&DataMessage<'_>) -> Result<bool>) -> Result<Ending> {
    let mut outcome: Result<bool> = Ok(true);
    let mut file = BufReader::with_capacity(1 << 20, File::open(path)?);
    let mut give = |message: &DataMessage<'_>| {
        if let Ok(true) = outcome {
            outcome = each(message);
        }
    };
    let mut parser = LogParser::default();
    parser.set_data_message_callback(&mut give);
    let mut piece = vec![0; PIECE];
    let mut place = 0_u64;
    let mut appended: Option<Vec<u64>> = None;
    let mut ending = Ending::Whole;
    loop {
        // A log that was written to after a crash has further data behind this place, and nothing
        // that counts between.
        let limit = appended.as_ref().and_then(|places| places.first()).map_or(u64::MAX, |&next| next);
        let most = usize::try_from(limit.saturating_sub(place)).unwrap_or(usize::MAX).min(PIECE);
        let count = file.read(&mut piece[..most])?;
        if count == 0 {
            let next = appended.as_mut().filter(|places| !places.is_empty()).map(|places| places.remove(0));
            if let Some(next) = next.filter(|next| *next == place) {
                parser.clear_leftover();
                file.seek(SeekFrom::Start(next))?;
                continue;
            }
            if parser.has_leftover() {
                ending = Ending::Cut(
                    "ends within a message: the recording was cut off; --allow-truncated reads what is there"
                        .to_owned(),
                );
            }
            break;
        }
        place += count as u64;
        // The crate trusts some lengths within messages and panics where they are wrong.
        let Some(consumed) = guarded(|| parser.consume_bytes(&piece[..count])) else {
            return Err(Error::damaged("ULog", "a length within a message is wrong"));
        };
        if let Err(error) = consumed {
            if !parser.in_data() {
                return Err(Error::damaged("ULog", error));
            }
            ending = Ending::Cut(format!("breaks off ({error}); --allow-truncated reads what comes before"));
            break;
        }
        if appended.is_none() && parser.header_complete() {
            let mut places: Vec<u64> =
                parser.appended_offsets().iter().copied().filter(|at| *at >= place).collect();
            places.sort_unstable();
            appended = Some(places);
        }
    }
    drop(parser);
    outcome.map(|_| ending)
}
