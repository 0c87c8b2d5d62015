//! Numbers out of CDR and of what ROS 1 wrote, by the definition of the message.
//!
//! The definition is parsed by `re_ros_msg`; the messages are walked here: that crate's decoder
//! builds every value of a message, follows a definition that holds itself without end, and we need
//! a few numbers of each.

mod known;
mod layout;
mod walk;

pub(crate) use known::{definition as known_definition, kinds as known_kinds};
pub(crate) use layout::Layout;
pub(crate) use walk::{Walker, names};

/// How the members of a message follow each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Serialization {
    /// CDR, of ROS 2: four bytes in front that say how, numbers aligned to their size, texts with a
    /// zero at their end.
    Cdr,
    /// ROS 1: little-endian, nothing in front and nothing in between (wiki.ros.org/msg; genpy
    /// writes it so).
    Ros1,
}

/// A number's type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Primitive {
    /// One byte, 0 or 1.
    Bool,
    /// Signed byte.
    I8,
    /// Byte.
    U8,
    /// Signed, two bytes.
    I16,
    /// Two bytes.
    U16,
    /// Signed, four bytes.
    I32,
    /// Four bytes.
    U32,
    /// Signed, eight bytes.
    I64,
    /// Eight bytes.
    U64,
    /// IEEE 754, four bytes.
    F32,
    /// IEEE 754, eight bytes.
    F64,
}

impl Primitive {
    /// Bytes.
    pub const fn size(self) -> usize {
        match self {
            Self::Bool | Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// The number in its first bytes; `None` if there are too few.
    pub(crate) fn number(self, bytes: &[u8], is_little: bool) -> Option<f64> {
        macro_rules! read {
            ($type:ty, $size:expr) => {{
                let bytes: [u8; $size] = bytes.get(..$size)?.try_into().ok()?;
                if is_little { <$type>::from_le_bytes(bytes) } else { <$type>::from_be_bytes(bytes) }
            }};
        }
        Some(match self {
            Self::Bool | Self::U8 => f64::from(*bytes.first()?),
            Self::I8 => f64::from(read!(i8, 1)),
            Self::I16 => f64::from(read!(i16, 2)),
            Self::U16 => f64::from(read!(u16, 2)),
            Self::I32 => f64::from(read!(i32, 4)),
            Self::U32 => f64::from(read!(u32, 4)),
            Self::I64 => read!(i64, 8) as f64,
            Self::U64 => read!(u64, 8) as f64,
            Self::F32 => f64::from(read!(f32, 4)),
            Self::F64 => read!(f64, 8),
        })
    }
}
