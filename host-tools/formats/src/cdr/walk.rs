//! Walks a message and picks the numbers asked for.

use super::{Layout, Primitive, Serialization};
use crate::error::{Error, Result};
use crate::field::Step;

/// What is taken at one place of a message.
#[derive(Debug)]
enum Node {
    /// It goes to each of these places: two columns may be made of one number.
    Number(Primitive, Vec<usize>),
    Text,
    WideText,
    /// Members; that called `name` tells the names of the arrays behind it.
    Struct(Vec<Node>),
    Names(Option<usize>),
    Array {
        element: Box<Node>,
        length: Option<usize>,
        picks: Vec<(Pick, Node)>,
    },
}

#[derive(Debug, PartialEq, Eq)]
enum Pick {
    Index(usize),
    Named(String),
}

/// Picks numbers out of messages of one type.
#[derive(Debug)]
pub(crate) struct Walker {
    node: Node,
    serialization: Serialization,
    names: Vec<String>,
    named: usize,
    /// Names of elements that are structs, where they are asked for.
    elements: Option<Vec<String>>,
}

/// A number asked for: where it goes, and where it is.
type Want<'a> = (usize, &'a [Step]);

impl Walker {
    /// For these paths; the number of the n-th goes to the n-th place.
    ///
    /// # Errors
    /// Gives the first path that messages of this layout do not have.
    pub(crate) fn new(
        layout: &Layout,
        serialization: Serialization,
        paths: &[&[Step]],
    ) -> Result<Self, usize> {
        let wants: Vec<Want<'_>> = paths.iter().copied().enumerate().collect();
        let node = compile(layout, &wants)?;
        Ok(Self { node, serialization, names: Vec::new(), named: 0, elements: None })
    }

    /// The numbers of a message, NaN for elements that its arrays do not have.
    ///
    /// # Errors
    /// The message ends too early, or is in a form of CDR that is not read here.
    pub(crate) fn numbers(&mut self, message: &[u8], numbers: &mut [f64]) -> Result<()> {
        numbers.fill(f64::NAN);
        self.named = 0;
        let mut cursor = Cursor::new(message, self.serialization)?;
        let (names, named) = (&mut self.names, &mut self.named);
        let mut taking = Taking { numbers, names, named, text: None, elements: self.elements.as_mut() };
        taking.walk(&self.node, &mut cursor).ok_or_else(|| {
            Error::Damaged(format!("a message of {} bytes ends before its definition does", message.len()))
        })
    }
}

/// What the `name` array of a message says, and what the elements of its other arrays are called;
/// empty where it has none.
pub(crate) fn names(layout: &Layout, serialization: Serialization, message: &[u8]) -> Result<Vec<String>> {
    let Ok(mut walker) = Walker::new(layout, serialization, &[]) else { return Ok(Vec::new()) };
    walker.elements = Some(Vec::new());
    walker.numbers(message, &mut [])?;
    walker.names.truncate(walker.named);
    walker.names.extend(walker.elements.into_iter().flatten());
    Ok(walker.names)
}

fn compile(layout: &Layout, wants: &[Want<'_>]) -> Result<Node, usize> {
    let first = wants.first().map(|want| want.0);
    match layout {
        Layout::Number(kind) => match wants.iter().find(|(_, steps)| !steps.is_empty()) {
            Some((slot, _)) => Err(*slot),
            None => Ok(Node::Number(*kind, wants.iter().map(|want| want.0).collect())),
        },
        Layout::Text => first.map_or(Ok(Node::Text), Err),
        Layout::WideText => first.map_or(Ok(Node::WideText), Err),
        Layout::Struct(members) => {
            let known = |step: Option<&Step>| matches!(step, Some(Step::Member(name)) if members.iter().any(|(member, _)| member == name));
            if let Some((slot, _)) = wants.iter().find(|(_, steps)| !known(steps.first())) {
                return Err(*slot);
            }
            let nodes = members.iter().map(|(name, layout)| {
                if name == "name"
                    && let Layout::Array(element, length) = layout
                    && **element == Layout::Text
                {
                    return Ok(Node::Names(*length));
                }
                let inner: Vec<Want<'_>> = wants
                    .iter()
                    .filter(|(_, steps)| matches!(&steps[0], Step::Member(wanted) if wanted == name))
                    .map(|(slot, steps)| (*slot, &steps[1..]))
                    .collect();
                compile(layout, &inner)
            });
            Ok(Node::Struct(nodes.collect::<Result<_, usize>>()?))
        }
        Layout::Array(element, length) => {
            let mut picks: Vec<(Pick, Vec<Want<'_>>)> = Vec::new();
            for (slot, steps) in wants {
                let pick = match steps.first() {
                    Some(Step::Index(index)) if length.is_none_or(|length| *index < length) => {
                        Pick::Index(*index)
                    }
                    Some(Step::Named(name)) => Pick::Named(name.clone()),
                    _ => return Err(*slot),
                };
                let want = (*slot, &steps[1..]);
                match picks.iter_mut().find(|(known, _)| *known == pick) {
                    Some((_, inner)) => inner.push(want),
                    None => picks.push((pick, vec![want])),
                }
            }
            let picks = picks.into_iter().map(|(pick, inner)| Ok((pick, compile(element, &inner)?)));
            let picks = picks.collect::<Result<_, usize>>()?;
            Ok(Node::Array { element: Box::new(compile(element, &[])?), length: *length, picks })
        }
    }
}

struct Taking<'a> {
    numbers: &'a mut [f64],
    names: &'a mut Vec<String>,
    named: &'a mut usize,
    /// Texts passed, where they are the name of what they are in.
    text: Option<String>,
    elements: Option<&'a mut Vec<String>>,
}

impl Taking<'_> {
    /// What an element is called that is a struct: the texts in it, `odom>base_link`.
    fn called(&mut self, element: &Node, mut ahead: Cursor<'_>) -> Option<String> {
        let outer = self.text.replace(String::new());
        self.walk(element, &mut ahead)?;
        std::mem::replace(&mut self.text, outer)
    }

    /// `None` where the message ends too early.
    fn walk(&mut self, node: &Node, cursor: &mut Cursor<'_>) -> Option<()> {
        match node {
            Node::Number(kind, slots) => {
                let number = cursor.number(*kind)?;
                for slot in slots {
                    self.numbers[*slot] = number;
                }
            }
            Node::Text => {
                let text = cursor.text()?;
                if let Some(passed) = &mut self.text {
                    *passed += if passed.is_empty() { "" } else { ">" };
                    *passed += &String::from_utf8_lossy(text);
                }
            }
            Node::WideText => {
                // Units of two bytes, without an end mark (rmw_fastrtps).
                let units = cursor.count()?;
                cursor.skip(units.checked_mul(2)?)?;
            }
            Node::Struct(members) => {
                for member in members {
                    self.walk(member, cursor)?;
                }
            }
            Node::Names(length) => {
                let count = cursor.length(*length)?;
                for place in 0..count {
                    let text = String::from_utf8_lossy(cursor.text()?);
                    match self.names.get_mut(place) {
                        Some(name) if *name == text => {}
                        Some(name) => text.clone_into_string(name),
                        None => self.names.push(text.into_owned()),
                    }
                }
                *self.named = count;
            }
            Node::Array { element, length, picks } => {
                let count = cursor.length(*length)?;
                if picks.is_empty()
                    && let Node::Number(kind, _) = **element
                {
                    if count > 0 {
                        cursor.align(kind.size())?;
                        cursor.skip(count.checked_mul(kind.size())?)?;
                    }
                    return Some(());
                }
                let is_named = picks.iter().any(|(pick, _)| matches!(pick, Pick::Named(_)));
                let is_called = matches!(**element, Node::Struct(_)) && (is_named || self.elements.is_some());
                for place in 0..count {
                    let called = if is_called { Some(self.called(element, cursor.clone())?) } else { None };
                    if let (Some(elements), Some(called)) = (&mut self.elements, &called) {
                        elements.push(called.clone());
                    }
                    let picked = picks.iter().find(|(pick, _)| match pick {
                        Pick::Index(index) => *index == place,
                        Pick::Named(name) => {
                            let listed = self.names[..*self.named].get(place);
                            listed.is_some_and(|here| here == name) || called.as_ref() == Some(name)
                        }
                    });
                    self.walk(picked.map_or(element, |(_, node)| node), cursor)?;
                }
            }
        }
        Some(())
    }
}

/// Replaces a text without a new allocation.
trait CloneInto {
    fn clone_into_string(&self, place: &mut String);
}

impl CloneInto for std::borrow::Cow<'_, str> {
    fn clone_into_string(&self, place: &mut String) {
        place.clear();
        place.push_str(self);
    }
}

/// Where in a message one is; places are counted from behind its header, as CDR aligns.
#[derive(Clone)]
struct Cursor<'a> {
    bytes: &'a [u8],
    place: usize,
    is_little: bool,
    /// Numbers are aligned to their size, and to no more than this.
    most_aligned: usize,
}

impl<'a> Cursor<'a> {
    /// Behind the four bytes that say how the rest is written (DDSI-RTPS 10.2; XTypes 7.6.3).
    fn new(message: &'a [u8], serialization: Serialization) -> Result<Self> {
        if serialization == Serialization::Ros1 {
            return Ok(Self { bytes: message, place: 0, is_little: true, most_aligned: 1 });
        }
        let Some((header, bytes)) = message.split_at_checked(4) else {
            return Err(Error::Damaged(format!("a message has {} bytes; expected CDR", message.len())));
        };
        if header == [0x28, 0xB5, 0x2F, 0xFD] {
            let message = "its messages are compressed one by one (zstd); expected a bag without, or with \
                           chunks that are (ros2 bag convert)";
            return Err(Error::Unsupported(message.to_owned()));
        }
        let (is_little, most_aligned) = match [header[0], header[1]] {
            [0, 0] => (false, 8),
            [0, 1] => (true, 8),
            [0, 6] => (false, 4),
            [0, 7] => (true, 4),
            [a, b] => {
                let message =
                    format!("a message is in the representation {a:#04x}{b:02x}; expected plain CDR");
                return Err(Error::Unsupported(message));
            }
        };
        Ok(Self { bytes, place: 0, is_little, most_aligned })
    }

    fn align(&mut self, size: usize) -> Option<()> {
        let size = size.min(self.most_aligned);
        self.place = self.place.next_multiple_of(size);
        (self.place <= self.bytes.len()).then_some(())
    }

    fn skip(&mut self, count: usize) -> Option<&'a [u8]> {
        let end = self.place.checked_add(count)?;
        let skipped = self.bytes.get(self.place..end)?;
        self.place = end;
        Some(skipped)
    }

    fn number(&mut self, kind: Primitive) -> Option<f64> {
        self.align(kind.size())?;
        let is_little = self.is_little;
        kind.number(self.skip(kind.size())?, is_little)
    }

    fn count(&mut self) -> Option<usize> {
        Some(self.number(Primitive::U32)? as usize)
    }

    /// Elements of an array; never more than there are bytes left, as each has one at least.
    fn length(&mut self, fixed: Option<usize>) -> Option<usize> {
        let count = match fixed {
            Some(length) => length,
            None => self.count()?,
        };
        (count <= self.bytes.len().saturating_sub(self.place)).then_some(count)
    }

    /// A text, without the zero at its end.
    fn text(&mut self) -> Option<&'a [u8]> {
        let count = self.count()?;
        let text = self.skip(count)?;
        Some(text.strip_suffix(b"\0").unwrap_or(text))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Field;

    fn layout(definition: &str) -> Layout {
        Layout::of("p/msg/A", definition, Serialization::Cdr).unwrap()
    }

    fn message(parts: &[&[u8]]) -> Vec<u8> {
        [&[0, 1, 0, 0][..], &parts.concat()].concat()
    }

    /// Bytes laid out by hand by the rules of CDR: a text has its length and a zero, numbers are
    /// aligned to their size.
    #[test]
    fn numbers_are_found_by_name_and_index() {
        let layout = layout("string[] name\nfloat64[] velocity\nuint8 n\nfloat32[2] pair\n");
        let bytes = message(&[
            &2_u32.to_le_bytes(),
            &2_u32.to_le_bytes(),
            b"a\0",
            &[0; 2],
            &2_u32.to_le_bytes(),
            b"b\0",
            &[0; 2],
            &2_u32.to_le_bytes(),
            &[0; 4],
            &1.5_f64.to_le_bytes(),
            &(-2.5_f64).to_le_bytes(),
            &[7, 0, 0, 0],
            &3.0_f32.to_le_bytes(),
            &4.0_f32.to_le_bytes(),
        ]);
        let fields = ["velocity[b]", "velocity[0]", "n", "pair[1]", "velocity[c]", "velocity[9]"];
        let fields = fields.map(|path| Field::new("/t", path).unwrap());
        let steps: Vec<&[Step]> = fields.iter().map(|field| &field.steps[..]).collect();
        // The last bytes in front of the first double: 4 + 8 + 8 + 4 = 24, a multiple of 8.
        let mut walker = Walker::new(&layout, Serialization::Cdr, &steps).unwrap();
        let mut numbers = [0.0; 6];
        let bytes: Vec<u8> = bytes[..28].iter().chain(&bytes[32..]).copied().collect();
        walker.numbers(&bytes, &mut numbers).unwrap();
        assert_eq!(numbers[..4], [-2.5, 1.5, 7.0, 4.0]);
        assert!(numbers[4].is_nan() && numbers[5].is_nan());
        assert_eq!(names(&layout, Serialization::Cdr, &bytes).unwrap(), ["a", "b"]);
        for end in 0..bytes.len() {
            assert!(walker.numbers(&bytes[..end], &mut numbers).is_err(), "{end}");
        }
    }

    /// Elements that are structs are called by their texts, whatever their place.
    #[test]
    fn elements_are_found_by_their_texts() {
        let layout = layout("Pair[] pairs\n================\nMSG: p/Pair\nstring from\nuint8 n\nstring to\n");
        let element = |n: u8| {
            [&2_u32.to_le_bytes()[..], b"a\0", &[n, 0], &2_u32.to_le_bytes(), &[b'b' + n, 0], &[0; 2]]
                .concat()
        };
        let bytes = message(&[&2_u32.to_le_bytes(), &element(1), &element(0)]);
        let fields =
            ["pairs[a>b].n", "pairs[a>c].n", "pairs[a>d].n"].map(|path| Field::new("/t", path).unwrap());
        let steps: Vec<&[Step]> = fields.iter().map(|field| &field.steps[..]).collect();
        let mut walker = Walker::new(&layout, Serialization::Cdr, &steps).unwrap();
        let mut numbers = [0.0; 3];
        walker.numbers(&bytes, &mut numbers).unwrap();
        assert!(numbers[..2] == [0.0, 1.0] && numbers[2].is_nan(), "{numbers:?}");
        assert_eq!(names(&layout, Serialization::Cdr, &bytes).unwrap(), ["a>c", "a>b"]);
    }

    /// Bytes laid out by hand: nothing in front, no gaps, no zeros; a time is two numbers.
    #[test]
    fn ros_1_leaves_no_gaps() {
        let definition = "uint8 n\ntime at\nstring[] name\nfloat64[] velocity\n";
        let layout = Layout::of("p/A", definition, Serialization::Ros1).unwrap();
        let bytes = [
            &[7_u8][..],
            &12_u32.to_le_bytes(),
            &34_u32.to_le_bytes(),
            &1_u32.to_le_bytes(),
            &3_u32.to_le_bytes(),
            b"abc",
            &1_u32.to_le_bytes(),
            &1.5_f64.to_le_bytes(),
        ]
        .concat();
        let fields = ["n", "at.sec", "at.nanosec", "velocity[abc]"];
        let fields = fields.map(|path| Field::new("/t", path).unwrap());
        let steps: Vec<&[Step]> = fields.iter().map(|field| &field.steps[..]).collect();
        let mut walker = Walker::new(&layout, Serialization::Ros1, &steps).unwrap();
        let mut numbers = [0.0; 4];
        walker.numbers(&bytes, &mut numbers).unwrap();
        assert_eq!(numbers, [7.0, 12.0, 34.0, 1.5]);
        for end in 0..bytes.len() {
            assert!(walker.numbers(&bytes[..end], &mut numbers).is_err(), "{end}");
        }
    }

    #[test]
    fn what_a_message_does_not_have_is_refused_by_its_place() {
        let layout = layout("float64 x\nfloat32[2] pair\nstring s\n");
        for wrong in ["y", "x.y", "pair", "pair[2]", "s", "x[0]"] {
            let field = Field::new("/t", wrong).unwrap();
            let good = Field::new("/t", "x").unwrap();
            assert_eq!(
                Walker::new(&layout, Serialization::Cdr, &[&good.steps, &field.steps]).unwrap_err(),
                1,
                "{wrong}"
            );
        }
    }
}
