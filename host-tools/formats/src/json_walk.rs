//! Numbers on their ways through a JSON message. A tree of every message would take longer than all
//! that follows.

use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, Error as _, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde_json::value::RawValue;

use crate::error::Result;
use crate::field::Step;
use crate::json::{Name, finite, no_json};

/// Where an object has the names of its arrays' elements (`sensor_msgs/JointState`).
const NAMES: &str = "name";

/// The ways to some numbers, common parts once.
#[derive(Debug, Default)]
pub(crate) struct JsonWalk {
    /// Which of the numbers this is, where the ways end here.
    numbers: Vec<usize>,
    next: Vec<(Step, JsonWalk)>,
}

impl JsonWalk {
    /// To one number a path.
    pub(crate) fn new(paths: &[&[Step]]) -> Self {
        let mut root = Self::default();
        for (number, path) in paths.iter().enumerate() {
            let mut at = &mut root;
            for step in *path {
                let place = at.next.iter().position(|(known, _)| known == step).unwrap_or_else(|| {
                    at.next.push((step.clone(), Self::default()));
                    at.next.len() - 1
                });
                at = &mut at.next[place].1;
            }
            at.numbers.push(number);
        }
        root
    }

    /// The numbers of a message; NaN where it has none.
    ///
    /// # Errors
    /// It is no JSON.
    pub(crate) fn numbers(&self, message: &[u8], numbers: &mut [f64]) -> Result<()> {
        numbers.fill(f64::NAN);
        let mut reader = serde_json::Deserializer::from_slice(message);
        let walk = Walking { walk: self, names: None, numbers };
        walk.deserialize(&mut reader).and_then(|()| reader.end()).map_err(no_json)
    }

    /// Whether elements of this array are asked for by their names.
    fn by_name(&self) -> bool {
        self.next.iter().any(|(step, _)| matches!(step, Step::Named(_)))
    }

    fn set(&self, numbers: &mut [f64], value: f64) {
        for &number in &self.numbers {
            numbers[number] = value;
        }
    }

    /// A member that comes again counts for all that it has, and lacks.
    fn forget(&self, numbers: &mut [f64]) {
        self.set(numbers, f64::NAN);
        self.next.iter().for_each(|(_, next)| next.forget(numbers));
    }

    /// Through a value that has been read over.
    fn through(
        &self,
        value: &RawValue,
        names: Option<&RawValue>,
        numbers: &mut [f64],
    ) -> serde_json::Result<()> {
        if self.next.is_empty() {
            let number = match value.get().as_bytes().first() {
                Some(b'-' | b'0'..=b'9') => finite(value.get()).map_err(serde_json::Error::custom)?,
                Some(b't') => 1.0,
                Some(b'f') => 0.0,
                _ => f64::NAN,
            };
            self.set(numbers, number);
            return Ok(());
        }
        let mut reader = serde_json::Deserializer::from_str(value.get());
        Walking { walk: self, names, numbers }.deserialize(&mut reader)
    }
}

/// At a value.
struct Walking<'a> {
    walk: &'a JsonWalk,
    /// Names of the elements, of an array that has some.
    names: Option<&'a RawValue>,
    numbers: &'a mut [f64],
}

impl<'de> DeserializeSeed<'de> for Walking<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, from: D) -> std::result::Result<(), D::Error> {
        from.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Walking<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("JSON")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> std::result::Result<(), A::Error> {
        let next = &self.walk.next;
        let has_names = next.iter().any(|(_, next)| next.by_name());
        // Their names may come behind them.
        let (mut names, mut named) = (None::<&RawValue>, Vec::new());
        let place = |name: &str| {
            let is_it = |(step, _): &(Step, JsonWalk)| matches!(step, Step::Member(member) if member == name);
            (next.iter().position(is_it), name == NAMES)
        };
        while let Some((place, is_names)) = map.next_key_seed(Name(place))? {
            let wanted = place.map(|place| (place, &next[place].1));
            if let Some((_, next)) = wanted {
                next.forget(self.numbers);
            }
            match wanted {
                None if !(is_names && has_names) => {
                    map.next_value::<IgnoredAny>()?;
                }
                Some((_, next)) if !is_names && !next.next.is_empty() && !next.by_name() => {
                    map.next_value_seed(Walking { walk: next, names: None, numbers: self.numbers })?;
                }
                _ => {
                    let value: &RawValue = map.next_value()?;
                    if is_names {
                        names = Some(value);
                    }
                    match wanted {
                        Some((place, next)) if next.by_name() => {
                            named.retain(|(known, _)| *known != place);
                            named.push((place, value));
                        }
                        Some((_, next)) => {
                            next.through(value, None, self.numbers).map_err(A::Error::custom)?;
                        }
                        None => {}
                    }
                }
            }
        }
        for (place, value) in named {
            next[place].1.through(value, names, self.numbers).map_err(A::Error::custom)?;
        }
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> std::result::Result<(), A::Error> {
        let names: Vec<&RawValue> = match self.names {
            // What is no array names nothing.
            Some(names) if self.walk.by_name() => serde_json::from_str(names.get()).unwrap_or_default(),
            _ => Vec::new(),
        };
        let place_of = |step: &Step| match step {
            Step::Index(place) => Some(*place),
            Step::Named(name) => names.iter().position(|here| is_text(here, name)),
            Step::Member(_) => None,
        };
        let next: Vec<(usize, &JsonWalk)> =
            self.walk.next.iter().filter_map(|(step, next)| Some((place_of(step)?, next))).collect();
        let mut place = 0;
        loop {
            let mut wanted = next.iter().filter(|(wanted, _)| *wanted == place).peekable();
            if wanted.peek().is_none() {
                if elements.next_element::<IgnoredAny>()?.is_none() {
                    return Ok(());
                }
            } else {
                let Some(value) = elements.next_element::<&RawValue>()? else { return Ok(()) };
                for (_, next) in wanted {
                    next.through(value, None, self.numbers).map_err(A::Error::custom)?;
                }
            }
            place += 1;
        }
    }

    fn visit_bool<E>(self, is: bool) -> std::result::Result<(), E> {
        self.walk.set(self.numbers, f64::from(u8::from(is)));
        Ok(())
    }

    fn visit_f64<E>(self, value: f64) -> std::result::Result<(), E> {
        self.walk.set(self.numbers, value);
        Ok(())
    }

    fn visit_u64<E>(self, value: u64) -> std::result::Result<(), E> {
        self.walk.set(self.numbers, value as f64);
        Ok(())
    }

    fn visit_i64<E>(self, value: i64) -> std::result::Result<(), E> {
        self.walk.set(self.numbers, value as f64);
        Ok(())
    }

    fn visit_str<E>(self, _: &str) -> std::result::Result<(), E> {
        Ok(())
    }

    fn visit_unit<E>(self) -> std::result::Result<(), E> {
        Ok(())
    }
}

/// Whether a value is this text.
fn is_text(value: &RawValue, text: &str) -> bool {
    let written = value.get();
    match written.strip_prefix('"').and_then(|rest| rest.strip_suffix('"')) {
        Some(plain) if !plain.contains('\\') => plain == text,
        Some(_) => serde_json::from_str::<String>(written).is_ok_and(|unescaped| unescaped == text),
        None => false,
    }
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use super::*;
    use crate::field::Field;
    use crate::json::parse;

    const PATHS: [&str; 9] = [
        "a",
        "b.c",
        "b.d[1]",
        "b.d[0].e",
        "velocity[left]",
        "velocity[right]",
        "velocity[0]",
        "deep.position[le\"ft]",
        "a",
    ];

    fn walked(message: &str) -> Result<Vec<f64>> {
        let fields = PATHS.map(|path| Field::new("/t", path).unwrap());
        let mut numbers = vec![7.0; PATHS.len()];
        JsonWalk::new(&fields.each_ref().map(|field| &field.steps[..]))
            .numbers(message.as_bytes(), &mut numbers)?;
        Ok(numbers)
    }

    /// By a tree of the message.
    fn by_tree(message: &Value, steps: &[Step]) -> f64 {
        let mut at = message;
        let mut above = message;
        for step in steps {
            let next = match step {
                Step::Member(name) => at.get(name),
                Step::Index(index) => at.get(index),
                Step::Named(name) => {
                    let names = above.get("name").and_then(Value::as_array);
                    let place =
                        names.and_then(|names| names.iter().position(|here| here.as_str() == Some(name)));
                    place.and_then(|place| at.get(place))
                }
            };
            let Some(next) = next else { return f64::NAN };
            above = at;
            at = next;
        }
        match at {
            Value::Bool(is) => f64::from(u8::from(*is)),
            other => other.as_f64().unwrap_or(f64::NAN),
        }
    }

    /// Bit for bit: members in any order, twice, missing, of other kinds; elements by number and by
    /// names that stand before or behind them.
    #[test]
    fn numbers_are_those_of_a_tree() {
        let messages = [
            r#"{"a":0.1,"b":{"c":-2.2250738585072014e-308,"d":[{"e":3},4]},"x":[{"a":1}]}"#,
            r#"{"name":["left","right"],"velocity":[1.5,-2.5],"position":[3]}"#,
            r#"{"velocity":[1.5,-2.5,3],"name":["x","right","left","left"],"a":true}"#,
            r#"{"velocity":[1],"velocity":[2,3],"name":["left"],"name":["right","left"]}"#,
            r#"{"deep":{"position":[8,9],"name":["le","le\"ft"]},"name":3,"velocity":[5]}"#,
            r#"{"a":7,"a":null,"b":{"c":1},"b":{"d":[0,{"e":1}]}}"#,
            r#"{"a":{"c":1},"b":[1,2],"velocity":{"left":1},"name":{"left":0}}"#,
            r#"{"\u0061":false,"b":3,"velocity":[[1],2],"name":[["left"],"left"]}"#,
            r#" { "a" : 123456789012345678901234567890 , "b" : { "c" : 9007199254740993 } } "#,
            r#"{"a":1e-400,"b":{"c":-0,"d":[]}}"#,
            "{}",
            "[1,2]",
            "3",
            "true",
            "null",
            r#""a""#,
        ];
        for message in messages {
            let tree = parse(message.as_bytes()).unwrap();
            let numbers = walked(message).unwrap();
            for (path, number) in PATHS.iter().zip(numbers) {
                let expected = by_tree(&tree, &Field::new("/t", path).unwrap().steps);
                let is_same = number.to_bits() == expected.to_bits();
                assert!(
                    is_same || number.is_nan() && expected.is_nan(),
                    "{message} {path} {number} {expected}"
                );
            }
        }
    }

    #[test]
    fn what_is_no_json_is_refused() {
        for message in [
            r#"{"a":1"#,
            r#"{"a":1}}"#,
            r#"{"a":01}"#,
            r#"{"a":1e999}"#,
            r#"{"b":{"c":1e999}}"#,
            r#"{"b":{"c":1}"#,
            r#"{"velocity":[1,}"#,
            r#"{"x":{a:1}}"#,
            "",
            "{,}",
            "[1",
        ] {
            assert!(walked(message).is_err(), "{message}");
            assert!(parse(message.as_bytes()).is_err(), "{message}");
        }
    }
}
