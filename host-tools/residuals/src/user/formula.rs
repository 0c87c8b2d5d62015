//! A formula, and what its variables may be.

use exmex::prelude::*;
use exmex::{FloatOpsFactory, MatchLiteral, literal_matcher_from_pattern};
use logs::robot::chassis::Together;
use logs::runs::{Row, Run};
use logs::{MASS, TIME, acceleration_column, speed_column};

// Unlike exmex' own numbers these may have an exponent.
literal_matcher_from_pattern!(Number, r"^([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?");

/// Longest formula, bytes.
const LONGEST: usize = 500;

/// What a formula is made of, for messages.
const ALLOWED: &str = "expected numbers, columns of the logs, + - * / ^ ( ), abs, signum, min, max, sqrt, exp, ln, sin, cos, \
                       tanh, floor and the like";

/// Forward speed, m/s.
const SPEED: &str = "speed_m_s";
/// Turn rate, rad/s.
const TURN_RATE: &str = "turn_rate_rad_s";
/// Heading since the start of the run, −π to π, rad.
const HEADING: &str = "heading_rad";
/// 1 while a wheel turns, 0 else.
const MOVING: &str = "moving";

/// A formula.
#[derive(Debug, Clone)]
pub struct Formula {
    text: String,
    expression: FlatEx<f64, FloatOpsFactory<f64>, Number>,
}

impl PartialEq for Formula {
    fn eq(&self, other: &Self) -> bool {
        self.text == other.text
    }
}

impl Formula {
    /// Reads a formula.
    ///
    /// # Errors
    /// Says what is wrong, and what was expected.
    pub fn parse(text: &str) -> Result<Self, String> {
        if text.trim().is_empty() {
            return Err(format!("the formula is empty; {ALLOWED}"));
        }
        if text.len() > LONGEST {
            return Err(format!("the formula has {} characters; expected at most {LONGEST}", text.len()));
        }
        if let Some(odd) = text.chars().find(|c| !matches!(c, ' '..='~') || matches!(c, '{' | '}')) {
            return Err(format!("{odd:?} in a formula; {ALLOWED}"));
        }
        if let Some(power) = negated_power(text) {
            return Err(format!(
                "{power:?} can be read in two ways; expected parentheses about the power or about what is negated"
            ));
        }
        let expression = FlatEx::parse(text)
            .map_err(|error| format!("{:?}: {}; {ALLOWED}", text, error.msg().replace('\n', " ")))?;
        Ok(Self { text: text.to_owned(), expression })
    }

    /// As it was written.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Its variables, in the order in which [`value`](Self::value) takes them.
    pub fn variables(&self) -> &[String] {
        self.expression.var_names()
    }

    /// Its value; NaN where it has none.
    pub fn value(&self, variables: &[f64]) -> f64 {
        self.expression.eval(variables).unwrap_or(f64::NAN)
    }
}

/// The text from a sign up to a `^` that the sign's operand is the base of: a square below zero in
/// mathematics, above it in exmex.
fn negated_power(text: &str) -> Option<&str> {
    let bytes = text.as_bytes();
    let blank = |at: &usize| bytes[*at] == b' ';
    for sign in (0..bytes.len()).filter(|&at| bytes[at] == b'-') {
        let before = (0..sign).rev().find(|at| !blank(at)).map(|at| bytes[at]);
        if !matches!(before, None | Some(b'(' | b',' | b'+' | b'-' | b'*' | b'/' | b'^')) {
            continue;
        }
        let mut at = (sign + 1..bytes.len()).find(|at| !blank(at))?;
        while at < bytes.len() && matches!(bytes[at], b'0'..=b'9' | b'a'..=b'z' | b'A'..=b'Z' | b'_' | b'.') {
            at += 1;
        }
        if bytes.get(at) == Some(&b'(') {
            let mut depth = 0_usize;
            while at < bytes.len() {
                match bytes[at] {
                    b'(' => depth += 1,
                    b')' => depth -= 1,
                    _ => {}
                }
                at += 1;
                if depth == 0 {
                    break;
                }
            }
        }
        let next = (at..bytes.len()).find(|at| !blank(at))?;
        if bytes[next] == b'^' {
            return Some(&text[sign..=next]);
        }
    }
    None
}

/// Where a variable comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Signals {
    /// Time since the start of the run, s.
    Time,
    /// Total mass, kg.
    Mass,
    /// Forward speed, m/s.
    Speed,
    /// Turn rate, rad/s.
    TurnRate,
    /// Heading since the start of the run, rad.
    Heading,
    /// 1 while a wheel turns.
    Moving,
    /// Speed of a wheel, rad/s.
    Wheel(usize),
    /// Acceleration of a wheel, rad/s².
    Acceleration(usize),
    /// A further column of the logs, by its place.
    Column(usize),
}

impl Signals {
    /// Those that every run has, without the columns of the logs.
    pub fn known(wheels: usize) -> Vec<(String, Self)> {
        let common = [
            (TIME, Self::Time),
            (MASS, Self::Mass),
            (SPEED, Self::Speed),
            (TURN_RATE, Self::TurnRate),
            (HEADING, Self::Heading),
            (MOVING, Self::Moving),
        ];
        let wheels = (0..wheels).flat_map(|wheel| {
            [
                (speed_column(wheel), Self::Wheel(wheel)),
                (acceleration_column(wheel), Self::Acceleration(wheel)),
            ]
        });
        common.into_iter().map(|(name, signal)| (name.to_owned(), signal)).chain(wheels).collect()
    }

    /// Its value in a row of a run.
    pub fn value(self, run: &Run, index: usize, row: &Row) -> f64 {
        match self {
            Self::Time => row.time,
            Self::Mass => row.mass,
            Self::Speed => row.speed,
            Self::TurnRate => row.turn_rate,
            Self::Heading => row.heading[1].atan2(row.heading[0]),
            Self::Moving => f64::from(u8::from(row.wheels.is_moving())),
            Self::Wheel(wheel) => row.wheels[wheel].speed,
            Self::Acceleration(wheel) => row.wheels[wheel].acceleration,
            Self::Column(place) => run.extra(place)[index],
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::{ProptestConfig, prop_assert_eq, proptest};

    use super::Formula;

    fn value(text: &str, variables: &[f64]) -> f64 {
        Formula::parse(text).unwrap().value(variables)
    }

    /// Worked out by hand.
    #[test]
    fn formulas_mean_what_is_written() {
        for (text, expected) in [
            ("2 + 3 * 4", 14.0),
            ("10 - 4 - 3", 3.0),
            ("12 / 4 / 3", 1.0),
            ("12 / 4 * 3", 9.0),
            ("2 * 12 / 4", 6.0),
            ("1 - 2 + 3", 2.0),
            ("1.5e-1 * 2E2", 30.0),
            (".5 + 2.", 2.5),
            ("-(3 ^ 2)", -9.0),
            ("(-3) ^ 2", 9.0),
            ("5 - 3 ^ 2", -4.0),
            ("2 ^ -1", 0.5),
            ("-2 * 3", -6.0),
            ("max(2, 3) + min(1, 4)", 4.0),
            ("abs(-2.5)", 2.5),
        ] {
            assert!((value(text, &[]) - expected).abs() < 1e-12, "{text}");
        }
        let formula = Formula::parse("0.5 * abs(wheel1_rad_s) * door_open").unwrap();
        assert_eq!(formula.variables(), ["door_open", "wheel1_rad_s"]);
        assert!((formula.value(&[2.0, -3.0]) - 3.0).abs() < 1e-12);
    }

    #[test]
    fn what_is_no_formula_is_refused() {
        for text in [
            "",
            " ",
            "1 +",
            "(1",
            "1)",
            "2 x",
            "x y",
            "2x",
            "x(2)",
            "foo(x)",
            "a b c",
            "()",
            "*",
            "x **",
            "x = 2",
            "a > b",
            "x, y",
            "abs",
            "abs()",
            "{x",
            "{x}",
            "π",
            "x\ny",
            "x;",
            "1..2",
            "\"x\"",
            "min(1)",
            "-x^2",
            "3 * -x ^ 2",
            "2 ^ -x ^ 2",
            "-(x + 1)^2",
            "-abs(x)^2",
        ] {
            assert!(
                Formula::parse(text).is_err(),
                "{text}: {:?}",
                Formula::parse(text).map(|f| f.value(&[1.0, 2.0, 3.0]))
            );
        }
        assert!(Formula::parse(&"(".repeat(1000)).is_err());
        assert!(Formula::parse(&format!("{}1{}", "(".repeat(240), ")".repeat(240))).is_ok());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]

        /// Whatever is typed: a formula or a refusal, and a value where it is one.
        #[test]
        fn nothing_typed_panics(
            parts in proptest::collection::vec(
                proptest::sample::select(&[
                    "x", "wheel1_rad_s", "1", "2.5", "1e", "e", "E", "PI", "+", "-", "*", "/", "^", "(", ")", ",", " ", ".", "abs",
                    "min", "max(", "atan2", "log", "log2", "sin(", "{", "}", "_", "signum", "$", "<",
                ][..]),
                0..14,
            )
        ) {
            let text = parts.concat();
            if let Ok(formula) = Formula::parse(&text) {
                let values = vec![1.5; formula.variables().len()];
                let first = formula.value(&values);
                prop_assert_eq!(first.to_bits(), formula.value(&values).to_bits());
            }
        }

        #[test]
        fn no_text_panics(text in "[ -~]{0,40}") {
            if let Ok(formula) = Formula::parse(&text) {
                formula.value(&vec![1.0; formula.variables().len()]);
            }
        }
    }
}
