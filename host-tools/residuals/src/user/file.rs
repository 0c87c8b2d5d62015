//! The file with a user's effects.

use std::ops::Range;
use std::path::Path;

use logs::POWER;
use logs::robot::position;
use model::effects::{ENTRIES, Sign, find};
use serde::Deserialize;
use support::error::{Error, Result};
use support::input::{MOST_DESCRIPTION, read_text};
use toml::Spanned;

use super::Formula;

/// Effects in a file, at most: three times the dictionary's. Each is tried on every run.
const MOST_EFFECTS: usize = 64;

/// An effect of the user's own.
#[derive(Debug, Clone, PartialEq)]
pub struct UserEffect {
    /// Its name in JSON and summary; none of the dictionary's.
    pub id: String,
    /// What it is, one sentence.
    pub meaning: String,
    /// What its coefficient multiplies, W per the coefficient's unit.
    pub formula: Formula,
    /// Unit of its coefficient.
    pub unit: String,
    /// The signs that its coefficient can have.
    pub sign: Sign,
    /// Least and greatest coefficient, the sign allowed for.
    pub range: (f64, f64),
    /// Line of the file on which its formula stands.
    pub line: u64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    #[serde(alias = "effects")]
    effect: Vec<Raw>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    #[serde(alias = "name")]
    id: Spanned<String>,
    #[serde(default)]
    meaning: String,
    formula: Spanned<String>,
    unit: String,
    sign: Sign,
    range: Spanned<[f64; 2]>,
}

/// Reads a file of effects.
///
/// # Errors
/// The file cannot be read or is no such file; an id that is the dictionary's, or there twice; a
/// formula that is none; a range that holds no number of the sign. With line and column, and what
/// was allowed.
pub fn read(file: &Path) -> Result<Vec<UserEffect>> {
    let text = read_text(file, MOST_DESCRIPTION)?;
    parse(&text).map_err(|error| error.in_file(file))
}

fn parse(text: &str) -> Result<Vec<UserEffect>> {
    let document: Document = toml::from_str(text).map_err(|error| {
        let message = format!(
            "{}; expected [[effect]] entries with id, formula, unit, sign (positive, negative, either), range = [least, greatest] \
             and, if wanted, meaning",
            error.message().replace('\n', " ")
        );
        match error.span() {
            Some(span) => at(text, &span, message),
            None => Error::failed(message),
        }
    })?;
    let count = document.effect.len();
    if count > MOST_EFFECTS {
        return Err(Error::failed(format!("{count} effects; expected at most {MOST_EFFECTS}")));
    }
    let mut effects: Vec<UserEffect> = Vec::new();
    for raw in document.effect {
        let effect = effect(text, raw)?;
        effects.push(effect);
        let (last, earlier) = (&effects[effects.len() - 1], &effects[..effects.len() - 1]);
        if earlier.iter().any(|other| other.id == last.id) {
            let message = format!("the id {:?} is there twice; expected every id once", last.id);
            return Err(Error::failed(message).at_line(last.line));
        }
    }
    if effects.is_empty() {
        return Err(Error::failed("no effect; expected at least one [[effect]]"));
    }
    Ok(effects)
}

fn effect(text: &str, raw: Raw) -> Result<UserEffect> {
    let (span, id) = (raw.id.span(), raw.id.into_inner());
    let is_name = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_');
    if id.is_empty() || id.len() > 40 || !id.chars().all(is_name) {
        let expected = "expected 1 to 40 letters, digits, - and _";
        return Err(at(text, &span, format!("the id {id:?}; {expected}")));
    }
    if find(&id).is_some() {
        let taken: Vec<&str> = ENTRIES.iter().map(|entry| entry.id).collect();
        let message =
            format!("the id {id:?} is in the dictionary; expected another than {}", taken.join(", "));
        return Err(at(text, &span, message));
    }
    let (span, formula) = (raw.formula.span(), raw.formula.into_inner());
    let formula = Formula::parse(&formula).map_err(|message| at(text, &span, message))?;
    if formula.variables().iter().any(|name| name == POWER) {
        let message = format!("{POWER} in a formula; expected other columns: it is what is to be explained");
        return Err(at(text, &span, message));
    }
    let (line, _) = position(text, span.start);
    let (span, [least, most]) = (raw.range.span(), raw.range.into_inner());
    // A range without the numbers of the other sign.
    let (low, high) = match raw.sign {
        Sign::Positive => (least.max(0.0), most),
        Sign::Negative => (least, most.min(0.0)),
        Sign::Either => (least, most),
    };
    if least.is_nan() || most.is_nan() || low >= high {
        let of_sign = match raw.sign {
            Sign::Positive => " above 0",
            Sign::Negative => " below 0",
            Sign::Either => "",
        };
        let message = format!(
            "range = [{least}, {most}]; expected [least, greatest] with numbers{of_sign} between them"
        );
        return Err(at(text, &span, message));
    }
    let meaning = if raw.meaning.is_empty() { formula.text().to_owned() } else { raw.meaning };
    Ok(UserEffect { id, meaning, formula, unit: raw.unit, sign: raw.sign, range: (low, high), line })
}

fn at(text: &str, span: &Range<usize>, message: String) -> Error {
    let (line, column) = position(text, span.start);
    Error::failed(message).at_line(line).in_column(column.to_string())
}

#[cfg(test)]
mod tests {
    use super::parse;

    const GOOD: &str = "[[effect]]\nid = \"arm\"\nformula = \"12 * arm_a\"\nunit = \"V\"\nsign = \"positive\"\nrange = [-1, 50]\n";

    #[test]
    fn a_file_is_read() {
        let effects = parse(GOOD).unwrap();
        assert_eq!(effects[0].id, "arm");
        assert_eq!(effects[0].meaning, "12 * arm_a");
        assert_eq!((effects[0].range, effects[0].line), ((0.0, 50.0), 3));
        let named = GOOD.replace("[[effect]]\nid", "[[effects]]\nname");
        assert_eq!(parse(&named).unwrap(), effects);
    }

    #[test]
    fn a_refusal_says_where_and_what_was_allowed() {
        let twice = format!("{GOOD}{GOOD}");
        for (text, expected) in [
            (
                GOOD.replace("\"arm\"", "\"grade\""),
                "2:6: the id \"grade\" is in the dictionary; expected another than grade, ",
            ),
            (GOOD.replace("\"arm\"", "\"my arm\""), "2:6: the id \"my arm\"; expected 1 to 40 letters"),
            (GOOD.replace("12 *", "12 **"), "3:11: \"12 ** arm_a\": "),
            (GOOD.replace("12 *", "power_w *"), "3:11: power_w in a formula; expected other columns"),
            (
                GOOD.replace("unit", "units"),
                "4:1: unknown field `units`, expected one of `id`, `name`, `meaning`,",
            ),
            (GOOD.replace("unit = \"V\"\n", ""), "1:1: missing field `unit`"),
            (
                GOOD.replace("positive", "up"),
                "5:8: unknown variant `up`, expected one of `positive`, `negative`, `either`",
            ),
            (
                GOOD.replace("[-1, 50]", "[5, 1]"),
                "6:9: range = [5, 1]; expected [least, greatest] with numbers above 0",
            ),
            (
                GOOD.replace("positive", "negative").replace("-1", "1"),
                "6:9: range = [1, 50]; expected [least, greatest] with numbers below 0",
            ),
            (GOOD.replace("[-1, 50]", "[0, nan]"), "6:9: range = [0, NaN]; expected"),
            (GOOD.replace("[-1, 50]", "7"), "6:9: invalid type: integer `7`"),
            (twice, "9: the id \"arm\" is there twice; expected every id once"),
            (String::new(), "1:1: missing field `effect`; expected [[effect]] entries with id"),
            ("effect = []".to_owned(), "no effect; expected at least one [[effect]]"),
            ("[[effect]\n".to_owned(), "1:"),
        ] {
            let message = parse(&text).unwrap_err().in_file("f").to_string();
            let said = message.strip_prefix("f:").unwrap().trim_start();
            assert!(said.starts_with(expected), "{said:?} for {expected:?}");
            assert_eq!(message.lines().count(), 1, "{message}");
        }
    }
}
