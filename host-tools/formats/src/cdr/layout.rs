//! From a definition to what stands where in a message.

use re_ros_msg::MessageSchema;
use re_ros_msg::message_spec::{ArraySize, BuiltInType, ComplexType, MessageSpecification, Type};

use super::{Primitive, Serialization};
use crate::error::{Error, Result};

/// Messages within messages: ROS's own go to six.
const DEEPEST: usize = 24;
/// Members of a message, those of its members included: the largest of PX4 has some 300.
const MOST_MEMBERS: usize = 20_000;
/// Bytes of the longest definition.
const LONGEST: usize = 1 << 20;

/// What stands at one place of a message.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Layout {
    Number(Primitive),
    Text,
    WideText,
    Struct(Vec<(String, Layout)>),
    /// With its length, if that is fixed.
    Array(Box<Layout>, Option<usize>),
}

impl Layout {
    /// Of the messages of this type.
    ///
    /// # Errors
    /// A definition that is none, lacks a type that it uses, or holds itself.
    pub(crate) fn of(kind: &str, definition: &str, serialization: Serialization) -> Result<Self> {
        let absurd = |why: String| Error::Damaged(format!("the definition of {kind} {why}"));
        if definition.len() > LONGEST {
            return Err(absurd(format!("has {} bytes; expected {LONGEST} at most", definition.len())));
        }
        let schema = MessageSchema::parse(kind, definition).map_err(|error| {
            let why: Vec<String> = error.chain().skip(1).map(ToString::to_string).collect();
            absurd(format!("cannot be read: {}", why.join(": ").replace('\n', " ")))
        })?;
        let mut expander = Expander { schema: &schema, serialization, members: 0 };
        expander.message(&schema.spec, 0).map_err(absurd)
    }

    /// Paths of all numbers; `[]` for those of arrays of any length.
    pub(crate) fn paths(&self) -> Vec<String> {
        let mut paths = Vec::new();
        self.add_paths("", &mut paths);
        paths
    }

    fn add_paths(&self, prefix: &str, paths: &mut Vec<String>) {
        match self {
            Self::Number(_) => paths.push(prefix.to_owned()),
            Self::Text | Self::WideText => {}
            Self::Struct(members) => {
                for (name, layout) in members {
                    let dot = if prefix.is_empty() { "" } else { "." };
                    layout.add_paths(&format!("{prefix}{dot}{name}"), paths);
                }
            }
            Self::Array(element, length) => {
                let length = length.map_or(String::new(), |length| length.to_string());
                element.add_paths(&format!("{prefix}[{length}]"), paths);
            }
        }
    }
}

struct Expander<'a> {
    schema: &'a MessageSchema,
    serialization: Serialization,
    members: usize,
}

impl Expander<'_> {
    fn message(&mut self, spec: &MessageSpecification, depth: usize) -> Result<Layout, String> {
        if depth > DEEPEST {
            return Err(format!("holds messages {DEEPEST} deep, or itself"));
        }
        let mut members = Vec::with_capacity(spec.fields.len());
        for field in &spec.fields {
            self.members += 1;
            if self.members > MOST_MEMBERS {
                return Err(format!("has more than {MOST_MEMBERS} members"));
            }
            members.push((field.name.clone(), self.layout(&field.ty, &spec.name, depth)?));
        }
        if members.is_empty() && self.serialization == Serialization::Cdr {
            // One that only lists constants is sent as one byte (rosidl).
            members.push((String::new(), Layout::Number(Primitive::U8)));
        }
        Ok(Layout::Struct(members))
    }

    fn layout(&mut self, kind: &Type, within: &str, depth: usize) -> Result<Layout, String> {
        Ok(match kind {
            Type::BuiltIn(BuiltInType::String(_)) => Layout::Text,
            Type::BuiltIn(BuiltInType::WString(_)) => Layout::WideText,
            Type::BuiltIn(BuiltInType::Byte) if self.serialization == Serialization::Ros1 => {
                Layout::Number(Primitive::I8)
            }
            Type::BuiltIn(kind) => Layout::Number(primitive(kind)),
            Type::Array { ty, size } => {
                let length = match size {
                    // ROS has none; of such elements there could be any number in no bytes.
                    ArraySize::Fixed(0) => return Err("has an array of no elements".to_owned()),
                    ArraySize::Fixed(length) => Some(*length),
                    ArraySize::Bounded(_) | ArraySize::Unbounded => None,
                };
                Layout::Array(Box::new(self.layout(ty, within, depth)?), length)
            }
            Type::Complex(ComplexType::Relative { name })
                if self.serialization == Serialization::Ros1 && matches!(&name[..], "time" | "duration") =>
            {
                // Types of the language there; their parts are called as in ROS 2.
                let kind = if name == "time" { Primitive::U32 } else { Primitive::I32 };
                let number = |name: &str| (name.to_owned(), Layout::Number(kind));
                Layout::Struct(vec![number("sec"), number("nanosec")])
            }
            Type::Complex(kind) => {
                let schema = self.schema;
                let spec = find(schema, kind, within)
                    .ok_or_else(|| format!("uses {}, which is not with it", type_name(kind)))?;
                self.message(spec, depth + 1)?
            }
        })
    }
}

fn type_name(kind: &ComplexType) -> String {
    match kind {
        ComplexType::Absolute { package, name } => format!("{package}/{name}"),
        ComplexType::Relative { name } => name.clone(),
    }
}

/// `pkg/msg/Name` and `pkg/Name` are one type.
fn short(name: &str) -> (Option<&str>, &str) {
    let mut parts = name.split('/');
    let (first, last) = (parts.next(), parts.next_back());
    match last {
        Some(last) => (first, last),
        None => (None, name),
    }
}

fn find<'a>(schema: &'a MessageSchema, kind: &ComplexType, within: &str) -> Option<&'a MessageSpecification> {
    let (package, name) = match kind {
        ComplexType::Absolute { package, name } => (package.split('/').next(), name.as_str()),
        ComplexType::Relative { name } => (short(within).0, name.as_str()),
    };
    let same = |spec: &&MessageSpecification| short(&spec.name) == (package, name);
    let named = |spec: &&MessageSpecification| short(&spec.name).1 == name;
    let relative = matches!(kind, ComplexType::Relative { .. });
    let exact = schema.dependencies.iter().find(same);
    // `Header` alone means std_msgs/Header.
    exact.or_else(|| schema.dependencies.iter().find(named).filter(|_| relative))
}

fn primitive(kind: &BuiltInType) -> Primitive {
    match kind {
        BuiltInType::Bool => Primitive::Bool,
        BuiltInType::Int8 => Primitive::I8,
        BuiltInType::Int16 => Primitive::I16,
        BuiltInType::UInt16 => Primitive::U16,
        BuiltInType::Int32 => Primitive::I32,
        BuiltInType::UInt32 => Primitive::U32,
        BuiltInType::Int64 => Primitive::I64,
        BuiltInType::UInt64 => Primitive::U64,
        BuiltInType::Float32 => Primitive::F32,
        BuiltInType::Float64 => Primitive::F64,
        // Texts are no numbers; whoever asks has sorted them out.
        BuiltInType::Byte
        | BuiltInType::Char
        | BuiltInType::UInt8
        | BuiltInType::String(_)
        | BuiltInType::WString(_) => Primitive::U8,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_definition_that_holds_itself_is_refused() {
        let itself = "A a\n================\nMSG: p/A\nA a\n";
        let error = Layout::of("p/msg/A", itself, Serialization::Cdr).unwrap_err().to_string();
        assert!(error.contains("or itself"), "{error}");
        let wide = format!("B[2] b\n================\nMSG: p/B\n{}", "float64 x\n".repeat(30_000));
        assert!(
            Layout::of("p/msg/A", &wide, Serialization::Cdr).unwrap_err().to_string().contains("members")
        );
        let lacking = Layout::of("p/msg/A", "q/C c\n", Serialization::Cdr).unwrap_err().to_string();
        assert!(lacking.contains("uses q/C"), "{lacking}");
    }
}
