//! What VESC Tool and its apps log: a line a sample, its fields behind each other with semicolons,
//! their names in the first line.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use crate::cdr::Primitive;
use crate::ending::{Each, Ending};
use crate::error::{Error, Result};
use crate::topic::{Encoding, PackedField, Topic};

/// The topic's name and the kind of its messages.
const NAME: &str = "vesc";
const KIND: &str = "vesc_tool/log";
/// Milliseconds since midnight.
const TIME: &str = "ms_today";
const DAY_MS: f64 = 86_400_000.0;

/// Bytes of a line: VESC Tool's has some 500, sixty numbers.
const LONGEST: u64 = 1 << 16;

const SIZE: usize = Primitive::F64.size();

fn line(file: &mut impl BufRead, line: &mut String) -> Result<bool> {
    line.clear();
    let mut bytes = Vec::new();
    file.take(LONGEST).read_until(b'\n', &mut bytes)?;
    if bytes.len() as u64 == LONGEST {
        return Err(Error::damaged("VESC Tool", format!("a line has more than {LONGEST} bytes")));
    }
    line.push_str(&String::from_utf8_lossy(&bytes));
    Ok(!bytes.is_empty())
}

fn open(path: &Path) -> Result<(BufReader<File>, Vec<String>)> {
    let mut file = BufReader::with_capacity(1 << 20, File::open(path)?);
    let mut header = String::new();
    line(&mut file, &mut header)?;
    Ok((
        file,
        header.trim_end().trim_end_matches(';').split(';').map(|name| name.trim().to_owned()).collect(),
    ))
}

/// Its only topic.
pub(crate) fn topics(path: &Path) -> Result<Vec<Topic>> {
    let (_, columns) = open(path)?;
    let fields = columns.into_iter().enumerate().map(|(place, name)| PackedField {
        name,
        kind: Primitive::F64,
        offset: place * SIZE,
        scale: 1.0,
    });
    let encoding = Encoding::Packed { fields: fields.collect() };
    Ok(vec![Topic { name: NAME.to_owned(), kind: KIND.to_owned(), encoding, messages: None }])
}

/// Hands out the lines as messages of numbers with eight bytes each.
pub(crate) fn read(path: &Path, topics: &[Topic], wanted: &[usize], each: &mut Each<'_>) -> Result<Ending> {
    let (mut file, columns) = open(path)?;
    let Some(place) =
        topics.iter().position(|topic| topic.name == NAME).filter(|place| wanted.contains(place))
    else {
        return Ok(Ending::Whole);
    };
    let time = columns.iter().position(|name| name == TIME).unwrap_or(0);
    let (mut text, mut message, mut number) = (String::new(), Vec::new(), 1_u64);
    let (mut days, mut last) = (0.0, f64::NEG_INFINITY);
    while line(&mut file, &mut text)? {
        number += 1;
        let fields = text.trim_end().trim_end_matches(';');
        if fields.is_empty() {
            continue;
        }
        message.clear();
        let mut milliseconds = f64::NAN;
        for (at, field) in fields.split(';').enumerate() {
            let value: f64 = field.trim().parse().map_err(|_| {
                Error::Damaged(format!(
                    "line {number}: {:?} of {} is no number",
                    field,
                    columns.get(at).map_or("a further column", |name| name)
                ))
            })?;
            if at == time {
                milliseconds = value;
            }
            message.extend(value.to_le_bytes());
        }
        if message.len() != columns.len() * SIZE {
            let message = format!(
                "line {number} has {} fields, the first line {}",
                message.len() / SIZE,
                columns.len()
            );
            if !text.ends_with('\n') {
                return Ok(Ending::Cut(format!(
                    "breaks off ({message}); --allow-truncated reads what comes before"
                )));
            }
            return Err(Error::Damaged(format!("{message}; expected as many")));
        }
        // Over midnight.
        if milliseconds < last - DAY_MS / 2.0 {
            days += 1.0;
        }
        last = milliseconds;
        if !each(place, ((days * DAY_MS + milliseconds) * 1e6) as i64, &message)? {
            break;
        }
    }
    Ok(Ending::Whole)
}
