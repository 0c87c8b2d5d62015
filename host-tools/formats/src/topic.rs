//! A topic of a bag.

use crate::cdr;
pub use crate::cdr::Serialization;
use crate::error::{Error, Result};

/// How a topic's messages are written.
#[derive(Debug, Clone, PartialEq)]
pub enum Encoding {
    /// As ROS writes messages, by a definition in the language of its `.msg` files.
    Ros {
        /// The definition, with those that it needs behind it.
        definition: String,
        /// Of which ROS.
        serialization: Serialization,
    },
    /// JSON objects, by a JSON schema.
    Json {
        /// The schema.
        schema: String,
    },
    /// Structs, as ULog and DataFlash have them: each field's name, kind and place.
    Packed {
        /// Flattened.
        fields: Vec<PackedField>,
    },
    /// Another one, by its name: its messages cannot be read.
    Other(String),
}

/// A number at a fixed place of a message.
#[derive(Debug, Clone, PartialEq)]
pub struct PackedField {
    /// Path, as in the log's format.
    pub name: String,
    /// Its type.
    pub kind: cdr::Primitive,
    /// Bytes before it.
    pub offset: usize,
    /// What the number is multiplied by.
    pub scale: f64,
}

/// A topic: its name, what its messages are, and how they are written.
#[derive(Debug, Clone, PartialEq)]
pub struct Topic {
    /// With its slash, as ROS writes it; in a ULog or DataFlash the message's name, with `.1`, `.2`
    /// … for further instances.
    pub name: String,
    /// The messages' type, `sensor_msgs/msg/JointState`; of ROS 1 without `msg`.
    pub kind: String,
    /// How they are written.
    pub encoding: Encoding,
    /// Messages, where the file says it.
    pub messages: Option<u64>,
}

impl Topic {
    /// One of ROS 2's messages of a type that is known here, where nothing tells its definition.
    ///
    /// # Errors
    /// Another type; those that are known are named.
    pub fn known(name: &str, kind: &str) -> Result<Self> {
        let definition = cdr::known_definition(kind).ok_or_else(|| {
            let known = cdr::known_kinds().collect::<Vec<_>>().join(", ");
            Error::Choice(format!(
                "topic {name} is of {kind}, whose definition is not known here; expected one of {known}"
            ))
        })?;
        let encoding = Encoding::Ros { definition, serialization: Serialization::Cdr };
        Ok(Self { name: name.to_owned(), kind: kind.to_owned(), encoding, messages: None })
    }
}
