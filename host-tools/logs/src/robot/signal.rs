//! Numbers of messages, and the power that they add up to, as `[topics]` of robot.toml names them.

use std::fmt;

use serde::Deserialize;
use toml::Value;

/// What a number in a unit is multiplied by to be W, V, A, rad/s or 1.
const UNITS: [(&str, Quantity, f64); 13] = [
    ("W", Quantity::Power, 1.0),
    ("mW", Quantity::Power, 1e-3),
    ("kW", Quantity::Power, 1e3),
    ("V", Quantity::Voltage, 1.0),
    ("mV", Quantity::Voltage, 1e-3),
    ("A", Quantity::Current, 1.0),
    ("mA", Quantity::Current, 1e-3),
    ("1", Quantity::Share, 1.0),
    ("%", Quantity::Share, 1e-2),
    ("rad/s", Quantity::Speed, 1.0),
    ("deg/s", Quantity::Speed, std::f64::consts::PI / 180.0),
    ("rev/s", Quantity::Speed, std::f64::consts::TAU),
    ("rpm", Quantity::Speed, std::f64::consts::TAU / 60.0),
];

/// What a unit measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    Power,
    Voltage,
    Current,
    /// A share of the voltage: a bridge's duty.
    Share,
    /// Of a wheel.
    Speed,
}

impl Quantity {
    fn units(self) -> String {
        let names = UNITS.iter().filter(|(_, quantity, _)| *quantity == self).map(|(name, ..)| *name);
        names.collect::<Vec<_>>().join(", ")
    }
}

/// A number in the messages of a topic: `"/power:data"`, or with a factor or unit
/// `{ field = "/power:data", scale = -1, unit = "mW" }`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "Value")]
pub struct Signal {
    /// `topic:field`.
    pub field: String,
    /// What the number is multiplied by, its unit included.
    pub scale: f64,
    quantity: Option<Quantity>,
}

/// A part of the power: a number in W, or voltage times current, with a duty if the current is the
/// motor's.
#[derive(Debug, Clone, PartialEq)]
pub struct Term {
    /// A number without a field, and the scales of those with one, multiplied.
    pub scale: f64,
    /// Whose numbers are multiplied.
    pub factors: Vec<Signal>,
}

/// Power as a sum: one source, or several in a list.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(try_from = "Value")]
pub struct Sum(pub Vec<Term>);

impl Signal {
    /// A number as it is.
    pub fn plain(field: String) -> Self {
        Self { field, scale: 1.0, quantity: None }
    }

    /// Refuses a unit of something else.
    pub(super) fn must_be(self, quantity: Quantity, key: &str) -> Result<Self, String> {
        match self.quantity {
            Some(given) if given != quantity => Err(format!(
                "{key} {} has a unit of something else; expected of {}",
                self.field,
                quantity.units()
            )),
            _ => Ok(Self { quantity: Some(quantity), ..self }),
        }
    }

    /// Whether it stands for a voltage.
    pub fn is_voltage(&self) -> bool {
        self.quantity == Some(Quantity::Voltage)
    }
}

const SIGNAL: &str = "\"topic:field\" or { field = \"topic:field\", scale = 1.0, unit = \"…\" }";
const PRODUCT: &str = "\"topic:field\" in W, or { voltage = \"topic:field\" or volts, current = \"topic:field\" or a list, scale = 1.0 }, or a list of these";

impl TryFrom<Value> for Signal {
    type Error = String;

    fn try_from(value: Value) -> Result<Self, String> {
        let table = match value {
            Value::String(field) => return Ok(Self::plain(field)),
            Value::Table(table) => table,
            other => return Err(format!("found {other}; expected {SIGNAL}")),
        };
        let mut signal = Self::plain(String::new());
        for (key, value) in table {
            match (key.as_str(), value) {
                ("field", Value::String(field)) => signal.field = field,
                ("scale", value) => signal.scale *= number(&value).ok_or("scale is no finite number")?,
                ("unit", Value::String(unit)) => {
                    let known = UNITS.iter().find(|(name, ..)| *name == unit);
                    let (_, quantity, size) = known.ok_or_else(|| {
                        let all = UNITS.map(|(name, ..)| name).join(", ");
                        format!("unit = {unit:?}; expected of {all}")
                    })?;
                    signal.scale *= size;
                    signal.quantity = Some(*quantity);
                }
                (key, _) => return Err(format!("{key} is no key or value of a field; expected {SIGNAL}")),
            }
        }
        if signal.field.is_empty() {
            return Err(format!("a field is missing; expected {SIGNAL}"));
        }
        Ok(signal)
    }
}

impl TryFrom<Value> for Sum {
    type Error = String;

    fn try_from(value: Value) -> Result<Self, String> {
        let parts = match value {
            Value::Array(parts) if parts.is_empty() => {
                return Err(format!("power is an empty list; expected {PRODUCT}"));
            }
            Value::Array(parts) => parts,
            one => vec![one],
        };
        let mut terms = Vec::new();
        for value in parts {
            match value {
                Value::Table(table) if table.contains_key("voltage") || table.contains_key("current") => {
                    product(table, &mut terms)?;
                }
                value => {
                    let signal = Signal::try_from(value)?.must_be(Quantity::Power, "power")?;
                    terms.push(Term { scale: signal.scale, factors: vec![signal] });
                }
            }
        }
        Ok(Self(terms))
    }
}

/// Adds voltage times current, one term a current.
fn product(table: toml::Table, terms: &mut Vec<Term>) -> Result<(), String> {
    let (mut scale, mut common, mut currents, mut has_voltage) = (1.0, Vec::new(), Vec::new(), false);
    for (key, value) in table {
        match key.as_str() {
            "voltage" => {
                has_voltage = true;
                match number(&value) {
                    Some(volts) => scale *= volts,
                    None => common.push(Signal::try_from(value)?.must_be(Quantity::Voltage, "voltage")?),
                }
            }
            "duty" => common.push(Signal::try_from(value)?.must_be(Quantity::Share, "duty")?),
            "current" => {
                let all = if let Value::Array(all) = value { all } else { vec![value] };
                for current in all {
                    currents.push(Signal::try_from(current)?.must_be(Quantity::Current, "current")?);
                }
            }
            "scale" => scale *= number(&value).ok_or("scale is no finite number")?,
            key => {
                return Err(format!("{key} is no key of a product; expected voltage, current, duty, scale"));
            }
        }
    }
    if !has_voltage || currents.is_empty() {
        let lacking = if has_voltage { "current" } else { "voltage" };
        return Err(format!("a product lacks its {lacking}; expected {PRODUCT}"));
    }
    for current in currents {
        let factors: Vec<Signal> = common.iter().cloned().chain([current]).collect();
        terms.push(Term { scale: factors.iter().fold(scale, |scale, factor| scale * factor.scale), factors });
    }
    Ok(())
}

fn number(value: &Value) -> Option<f64> {
    let number = match value {
        Value::Float(number) => *number,
        Value::Integer(number) => *number as f64,
        _ => return None,
    };
    number.is_finite().then_some(number)
}

impl fmt::Display for Signal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.scale == 1.0 {
            f.write_str(&self.field)
        } else {
            write!(f, "{} × {}", self.field, self.scale)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sum(text: &str) -> Result<Sum, String> {
        let table: toml::Table = format!("power = {text}").parse().unwrap();
        Sum::try_from(table["power"].clone())
    }

    /// Each term as its scale and fields.
    fn terms(text: &str) -> Vec<(f64, Vec<String>)> {
        let terms = sum(text).unwrap().0.into_iter();
        terms
            .map(|term| (term.scale, term.factors.into_iter().map(|signal| signal.field).collect()))
            .collect()
    }

    #[test]
    fn power_is_a_sum_of_numbers_and_products() {
        let term =
            |scale: f64, fields: &[&str]| (scale, fields.iter().map(|&field| field.to_owned()).collect());
        assert_eq!(terms("\"/p:data\""), [term(1.0, &["/p:data"])]);
        assert_eq!(terms("{ field = \"/p:data\", unit = \"mW\", scale = -2 }"), [term(-2e-3, &["/p:data"])]);
        let both = "[{ voltage = \"/l:v\", current = { field = \"/l:i\", scale = -1 } }, \
                    { voltage = { field = \"/r:v\", unit = \"mV\" }, current = \"/r:i\", scale = 2.0 }, \"/lamp:data\"]";
        assert_eq!(
            terms(both),
            [term(-1.0, &["/l:v", "/l:i"]), term(2e-3, &["/r:v", "/r:i"]), term(1.0, &["/lamp:data"])]
        );
        let one_voltage = "{ voltage = 24, current = [\"/m:i[0]\", \"/m:i[1]\"], duty = \"/m:d\" }";
        assert_eq!(terms(one_voltage), [term(24.0, &["/m:d", "/m:i[0]"]), term(24.0, &["/m:d", "/m:i[1]"])]);
    }

    #[test]
    fn what_is_no_power_is_said_with_the_remedy() {
        for (wrong, said) in [
            ("[]", "empty list"),
            ("3.0", "expected \"topic:field\""),
            ("[{ voltage = \"/l:v\" }]", "lacks its current"),
            ("[{ current = \"/l:i\" }]", "lacks its voltage"),
            ("[{ voltage = \"/l:v\", current = [] }]", "lacks its current"),
            ("[{ voltage = \"/l:v\", current = \"/l:i\", curent = \"/l:i\" }]", "curent is no key"),
            ("{ voltage = { field = \"/l:v\", unit = \"mA\" }, current = \"/l:i\" }", "expected of V, mV"),
            ("{ field = \"/p:data\", unit = \"hp\" }", "expected of W, mW"),
            ("{ field = \"/p:data\", scale = nan }", "scale is no finite number"),
            ("{ scale = 2 }", "a field is missing"),
        ] {
            let error = sum(wrong).unwrap_err();
            assert!(error.contains(said), "{wrong}: {error}");
        }
    }
}
