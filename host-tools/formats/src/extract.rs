//! Numbers out of the messages of one topic, however they are written.

use crate::cdr::{Layout, Primitive, Walker};
use crate::error::{Error, Result, nearest};
use crate::field::{Field, Step};
use crate::json;
use crate::json_walk::JsonWalk;
use crate::topic::{Encoding, Topic};

/// Takes some numbers, and the time that the message bears, out of each message of a topic.
#[derive(Debug)]
pub struct Extractor {
    how: How,
    numbers: usize,
    /// The message's own time is behind the numbers.
    is_stamped: bool,
    taken: Vec<f64>,
}

#[derive(Debug)]
enum How {
    Ros(Walker),
    Json(JsonWalk),
    /// Kind, place and factor.
    Packed(Vec<(Primitive, usize, f64)>),
}

/// Where ROS's messages bear their time.
const STAMP: [&str; 2] = ["header.stamp.sec", "header.stamp.nanosec"];

impl Extractor {
    /// For some fields of a topic.
    ///
    /// # Errors
    /// A topic whose messages cannot be read, by the name of what they are, or that has no such
    /// field; the nearest are named.
    pub fn new(topic: &Topic, fields: &[&Field]) -> Result<Self> {
        // An element of tf2_msgs/TFMessage bears its own.
        let element =
            fields.first().and_then(|field| field.path.split_once("].")).map(|(element, _)| element);
        let head = element.map_or(String::new(), |element| format!("{element}]."));
        let of_element = STAMP.map(|path| format!("{}[].{path}", head.split('[').next().unwrap_or("")));
        let paths = paths(topic)?;
        let has = |stamp: &str| paths.iter().any(|path| path == stamp);
        let head = if of_element.iter().all(|stamp| has(stamp)) { head } else { String::new() };
        let stamp = STAMP.map(|path| Field::new(&topic.name, &format!("{head}{path}")));
        let has_stamp = !head.is_empty() || STAMP.iter().all(|stamp| has(stamp));
        let [Ok(seconds), Ok(nanoseconds)] = &stamp else { return Err(Error::Choice("no stamp".to_owned())) };
        let mut all: Vec<&Field> = fields.to_vec();
        if has_stamp {
            all.extend([seconds, nanoseconds]);
        }
        let refuse = |place: usize| {
            let path = &all[place].path;
            let has = nearest(path, paths.iter().map(String::as_str));
            let kind = &topic.kind;
            Error::Choice(format!("topic {} ({kind}) has no number {path}; it has: {has}", topic.name))
        };
        let how = match &topic.encoding {
            Encoding::Ros { definition, serialization } => {
                let layout = Layout::of(&topic.kind, definition, *serialization)?;
                let steps: Vec<&[Step]> = all.iter().map(|field| &field.steps[..]).collect();
                How::Ros(Walker::new(&layout, *serialization, &steps).map_err(refuse)?)
            }
            Encoding::Json { .. } => {
                How::Json(JsonWalk::new(&all.iter().map(|field| &field.steps[..]).collect::<Vec<_>>()))
            }
            Encoding::Packed { fields: packed } => {
                let places = all.iter().enumerate().map(|(place, field)| {
                    let packed = packed.iter().find(|packed| packed.name == field.path);
                    packed.map(|it| (it.kind, it.offset, it.scale)).ok_or_else(|| refuse(place))
                });
                How::Packed(places.collect::<Result<_>>()?)
            }
            Encoding::Other(_) => return Err(unreadable(topic)),
        };
        Ok(Self { how, numbers: fields.len(), is_stamped: has_stamp, taken: vec![f64::NAN; all.len()] })
    }

    /// The numbers of a message; NaN where it has none.
    ///
    /// # Errors
    /// The message is not what its topic says.
    pub fn numbers(&mut self, message: &[u8]) -> Result<&[f64]> {
        match &mut self.how {
            How::Ros(walker) => walker.numbers(message, &mut self.taken)?,
            How::Json(walk) => walk.numbers(message, &mut self.taken)?,
            How::Packed(places) => {
                for (taken, (kind, offset, scale)) in self.taken.iter_mut().zip(places) {
                    let number = message.get(*offset..).and_then(|bytes| kind.number(bytes, true));
                    *taken = number.map_or(f64::NAN, |number| number * *scale);
                }
            }
        }
        Ok(&self.taken[..self.numbers])
    }

    /// When the message read last was stamped, ns; `None` where it bears no time, or zero.
    pub fn stamp_ns(&self) -> Option<i64> {
        if !self.is_stamped {
            return None;
        }
        let (seconds, nanoseconds) = (self.taken[self.numbers], self.taken[self.numbers + 1]);
        let is_time = seconds.is_finite() && nanoseconds.is_finite() && (seconds, nanoseconds) != (0.0, 0.0);
        // Seconds are of 32 bits in ROS; JSON may hold anything.
        is_time.then(|| (seconds as i64).saturating_mul(1_000_000_000).saturating_add(nanoseconds as i64))
    }
}

/// Paths of all numbers of a topic's messages; `[]` for those of arrays of any length.
///
/// # Errors
/// A topic whose messages cannot be read.
pub fn paths(topic: &Topic) -> Result<Vec<String>> {
    match &topic.encoding {
        Encoding::Ros { definition, serialization } => {
            Ok(Layout::of(&topic.kind, definition, *serialization)?.paths())
        }
        Encoding::Json { schema } => Ok(json::paths(schema)),
        Encoding::Packed { fields } => Ok(fields.iter().map(|field| field.name.clone()).collect()),
        Encoding::Other(_) => Err(unreadable(topic)),
    }
}

fn unreadable(topic: &Topic) -> Error {
    let how = match &topic.encoding {
        Encoding::Other(how) => how.as_str(),
        _ => "",
    };
    Error::Unsupported(format!(
        "topic {} ({}) is written as {how}; expected CDR with a definition in ros2msg, messages of ROS 1 with one in ros1msg, or JSON with a schema",
        topic.name, topic.kind
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cdr::Serialization;

    #[test]
    fn one_number_of_a_message_serves_two_columns() {
        let topic = Topic {
            name: "/mass".to_owned(),
            kind: "std_msgs/msg/Float64".to_owned(),
            encoding: Encoding::Ros {
                definition: "float64 data\nfloat64 error\n".to_owned(),
                serialization: Serialization::Cdr,
            },
            messages: None,
        };
        let fields = ["data", "error", "data"].map(|path| Field::new("/mass", path).unwrap());
        let fields: Vec<&Field> = fields.iter().collect();
        let mut extractor = Extractor::new(&topic, &fields).unwrap();
        let message = [&[0, 1, 0, 0][..], &1.5_f64.to_le_bytes(), &0.25_f64.to_le_bytes()].concat();
        assert_eq!(extractor.numbers(&message).unwrap(), [1.5, 0.25, 1.5]);
    }

    /// The field that is missing is named, whichever stand before it, and however often.
    #[test]
    fn a_missing_number_is_named_behind_one_that_is_taken_twice() {
        let topic = Topic {
            name: "/mass".to_owned(),
            kind: "std_msgs/msg/Float64".to_owned(),
            encoding: Encoding::Ros {
                definition: "float64 data\n".to_owned(),
                serialization: Serialization::Cdr,
            },
            messages: None,
        };
        let fields = ["data", "data", "weight"].map(|path| Field::new("/mass", path).unwrap());
        let fields: Vec<&Field> = fields.iter().collect();
        let error = Extractor::new(&topic, &fields).unwrap_err().to_string();
        assert!(error.contains("no number weight; it has: data"), "{error}");
    }
}
