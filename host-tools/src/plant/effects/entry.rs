//! An entry of the dictionary of causes, and an effect that somebody asks for.

use std::fmt::Write;

use super::super::scenario::Scenario;
use super::DICTIONARY;
use super::causes::Cause;
use crate::error::{Error, Result};

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
    /// What it is when not given; for words their place in the list. `None`: its meaning says what then.
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
    pub(super) build: fn(&Effect, &Setting<'_>) -> Result<Box<dyn Cause>>,
}

/// The run in which an effect is to act.
pub(in super::super) struct Setting<'a> {
    pub(in super::super) scenario: &'a Scenario,
    /// Place of the effect among those of the run: each draws its own random numbers.
    pub(in super::super) place: u64,
}

/// An effect with its size.
#[derive(Debug, Clone, PartialEq)]
pub struct Effect {
    id: &'static str,
    size: f64,
    /// Options as given.
    given: Vec<(&'static str, f64)>,
}

impl Effect {
    /// The effect `id` of a size in its own unit.
    ///
    /// # Errors
    /// Usage: an unknown id, a size out of the plausible range.
    pub fn new(id: &str, size: f64) -> Result<Self> {
        let entry = DICTIONARY.iter().find(|entry| entry.id == id).ok_or_else(|| {
            let ids: Vec<&str> = DICTIONARY.iter().map(|entry| entry.id).collect();
            Error::usage(format!("effect `{id}`; allowed: {}", ids.join(", ")))
        })?;
        Self { id: entry.id, size: 0.0, given: Vec::new() }.with_size(size)
    }

    /// Reads `id=size` or `id=size:option=value:…`.
    ///
    /// # Errors
    /// Usage, naming the part that cannot be read or is out of range, and what is allowed.
    pub fn parse(text: &str) -> Result<Self> {
        let mut parts = text.split(':');
        let (id, size) = parts.next().and_then(|first| first.split_once('=')).ok_or_else(|| {
            Error::usage(format!("effect `{text}`; allowed: ID=SIZE or ID=SIZE:OPTION=VALUE:…"))
        })?;
        // An unknown id is the first thing to be told, whatever else is wrong.
        let effect = Self::new(id, 0.0)?;
        let size = number(size).ok_or_else(|| effect.refuse_size(size))?;
        let mut effect = effect.with_size(size)?;
        for part in parts {
            let (name, value) = part.split_once('=').unwrap_or((part, ""));
            let choice = effect.choice(name)?;
            let read = match choice.values {
                Values::Number(..) => number(value),
                Values::Word(words) => words.iter().position(|word| *word == value).map(|place| place as f64),
            };
            let read = read.ok_or_else(|| effect.refuse_option(choice, value))?;
            effect = effect.with(name, read)?;
        }
        Ok(effect)
    }

    /// The same effect of another size.
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
        // Every way to make an effect has found its entry.
        DICTIONARY.iter().find(|entry| entry.id == self.id).unwrap_or(&DICTIONARY[0])
    }

    /// Its name.
    pub fn id(&self) -> &'static str {
        self.id
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
        Error::usage(format!("effect {}={}: {why}", self.id, self.size))
    }

    fn refuse_size(&self, size: impl std::fmt::Display) -> Error {
        let Entry { id, unit, range: (low, high), .. } = self.entry();
        Error::usage(format!("effect {id}={size}; allowed: {low} to {high} ({unit})"))
    }

    fn choice(&self, name: &str) -> Result<&'static Choice> {
        self.entry().options.iter().find(|choice| choice.name == name).ok_or_else(|| {
            let names: Vec<&str> = self.entry().options.iter().map(|choice| choice.name).collect();
            let allowed = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
            Error::usage(format!("effect {}: option `{name}`; allowed: {allowed}", self.id))
        })
    }

    fn refuse_option(&self, choice: &Choice, value: impl std::fmt::Display) -> Error {
        let Choice { name, meaning, .. } = choice;
        Error::usage(format!("effect {}: {name}={value}; allowed: {} ({meaning})", self.id, choice.allowed()))
    }
}

impl Choice {
    fn allowed(&self) -> String {
        match self.values {
            Values::Number(low, high) => format!("{low} to {high}"),
            Values::Word(words) => words.join(", "),
        }
    }

    fn default_text(&self) -> String {
        match (self.default, self.values) {
            (None, _) => String::new(),
            (Some(value), Values::Number(..)) => format!(" [default: {value}]"),
            (Some(value), Values::Word(words)) => {
                format!(" [default: {}]", words.get(value as usize).copied().unwrap_or(""))
            }
        }
    }
}

fn number(text: &str) -> Option<f64> {
    text.trim().parse::<f64>().ok().filter(|x| x.is_finite())
}

/// The dictionary of causes as text: ids, meanings, units, ranges, options.
pub fn list() -> String {
    let mut text = String::new();
    for Entry { id, meaning, unit, range: (low, high), options, .. } in DICTIONARY {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{id}\n    {meaning}\n    size: {unit}, {low} to {high}");
        for choice in options.iter() {
            let Choice { name, meaning, .. } = choice;
            let (allowed, default) = (choice.allowed(), choice.default_text());
            let _ = writeln!(text, "    :{name}=  {meaning}, {allowed}{default}");
        }
    }
    text
}
