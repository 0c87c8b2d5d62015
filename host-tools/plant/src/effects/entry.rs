//! An entry of the dictionary of causes, and an effect that a user asks for.

use support::error::{Error, Result};

/// What an option of an effect can be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Values {
    /// A number from the first to the second.
    Number(f64, f64),
    /// One of these words.
    Word(&'static [&'static str]),
}

/// An option of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Choice {
    /// Its name.
    pub name: &'static str,
    /// What it can be.
    pub values: Values,
    /// What it is when not given; for words their place in the list. `None`: its meaning says what
    /// then.
    pub default: Option<f64>,
    /// What it means, with its unit.
    pub meaning: &'static str,
}

/// One effect of the dictionary, as a physical cause in the plant.
#[derive(Debug, Clone, Copy)]
pub struct Entry {
    /// Its name in command lines, JSON and documents.
    pub id: &'static str,
    /// What happens, in one sentence.
    pub meaning: &'static str,
    /// What the size is, with its unit.
    pub unit: &'static str,
    /// The sizes that are physically plausible.
    pub range: (f64, f64),
    /// Options.
    pub options: &'static [Choice],
}

/// An effect with its size.
#[derive(Debug, Clone)]
pub struct Effect {
    entry: &'static Entry,
    size: f64,
    /// Options as given.
    given: Vec<(&'static str, f64)>,
}

/// One of the dictionary is the same as that of its name.
impl PartialEq for Effect {
    fn eq(&self, other: &Self) -> bool {
        (self.id(), self.size, &self.given) == (other.id(), other.size, &other.given)
    }
}

impl Effect {
    /// Of an entry, of size 0 and without options.
    pub(super) fn of(entry: &'static Entry) -> Self {
        Self { entry, size: 0.0, given: Vec::new() }
    }

    /// The same effect with this size.
    ///
    /// # Errors
    /// Usage: the size is out of the plausible range.
    pub fn with_size(mut self, size: f64) -> Result<Self> {
        let (low, high) = self.entry().range;
        if !(low..=high).contains(&size) {
            return Err(self.refuse_size(size));
        }
        self.size = size;
        Ok(self)
    }

    /// The same effect with an option; a word by its place in the list.
    ///
    /// # Errors
    /// Usage: an option that the effect does not have, or a value that the option cannot have.
    pub fn with(mut self, name: &str, value: f64) -> Result<Self> {
        let choice = self.choice(name)?;
        let allowed = match choice.values {
            Values::Number(low, high) => (low..=high).contains(&value),
            Values::Word(words) => value.fract() == 0.0 && (0.0..words.len() as f64).contains(&value),
        };
        if !allowed {
            return Err(self.refuse_option(choice, value));
        }
        self.given.retain(|(given, _)| *given != name);
        self.given.push((choice.name, value));
        Ok(self)
    }

    /// Its entry in the dictionary.
    pub fn entry(&self) -> &'static Entry {
        self.entry
    }

    /// Its name.
    pub fn id(&self) -> &'static str {
        self.entry.id
    }

    /// Its size, in the unit of its entry.
    pub fn size(&self) -> f64 {
        self.size
    }

    /// An option as given, or its default; `None` where it has none.
    pub fn option(&self, name: &str) -> Option<f64> {
        let given = self.given.iter().find(|(given, _)| *given == name).map(|(_, value)| *value);
        given.or_else(|| self.entry().options.iter().find(|choice| choice.name == name)?.default)
    }

    /// An option that has a default.
    pub(super) fn number(&self, name: &str) -> f64 {
        self.option(name).unwrap_or(0.0)
    }

    /// Refuses the effect in a run in which it makes no sense.
    pub(super) fn refuse(&self, why: impl std::fmt::Display) -> Error {
        Error::usage(format!("effect {}={}: {why}", self.id(), self.size))
    }

    pub(super) fn refuse_size(&self, size: impl std::fmt::Display) -> Error {
        let Entry { id, unit, range: (low, high), .. } = self.entry();
        Error::usage(format!("effect {id}={size}; allowed: {low} to {high} ({unit})"))
    }

    pub(super) fn choice(&self, name: &str) -> Result<&'static Choice> {
        self.entry().options.iter().find(|choice| choice.name == name).ok_or_else(|| {
            let names: Vec<&str> = self.entry().options.iter().map(|choice| choice.name).collect();
            let allowed = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
            Error::usage(format!("effect {}: option `{name}`; allowed: {allowed}", self.id()))
        })
    }

    pub(super) fn refuse_option(&self, choice: &Choice, value: impl std::fmt::Display) -> Error {
        let Choice { name, meaning, .. } = choice;
        Error::usage(format!(
            "effect {}: {name}={value}; allowed: {} ({meaning})",
            self.id(),
            choice.allowed()
        ))
    }
}

impl Choice {
    pub(super) fn allowed(&self) -> String {
        match self.values {
            Values::Number(low, high) => format!("{low} to {high}"),
            Values::Word(words) => words.join(", "),
        }
    }

    pub(super) fn default_text(&self) -> String {
        match (self.default, self.values) {
            (None, _) => String::new(),
            (Some(value), Values::Number(..)) => format!(" [default: {value}]"),
            (Some(value), Values::Word(words)) => {
                format!(" [default: {}]", words.get(value as usize).copied().unwrap_or(""))
            }
        }
    }
}
