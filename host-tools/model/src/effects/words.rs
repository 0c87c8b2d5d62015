//! What is special about an effect, in words.

use std::path::Path;

use serde_json::Value;

use super::detail::{FROM_MOTION, FROM_START};
use super::{Along, Detail, Heated, PITCH, Runs, WheelSide};

impl Detail {
    /// In words; empty where nothing is special.
    pub fn words(&self) -> String {
        match self {
            Self::Plain => String::new(),
            Self::Slope(Along::Pitch) => format!("by {PITCH}"),
            Self::Slope(along) => format!("along {}", along.name()),
            Self::Heated(Heated::FromStart) => format!("from {FROM_START}"),
            Self::Heated(Heated::ByLoss(time)) | Self::TimeConstant { time_s: time } => {
                format!("time constant {} s", number(*time))
            }
            Self::Heated(Heated::WithTime(time)) => format!("with time, time constant {} s", number(*time)),
            Self::Heated(Heated::Measured(cold)) => {
                format!("by motor temperatures, above {} °C", number(*cold))
            }
            Self::Width { speed_rad_s } => format!("width {} rad/s", number(*speed_rad_s)),
            Self::Wheel { wheel, side } => format!("wheel {wheel}, {} side", side.name()),
            Self::Side(WheelSide::Both) => "both sides".to_owned(),
            Self::Side(side) => format!("{} side", side.name()),
            Self::DependsOnMass(true) => "grows with the mass".to_owned(),
            Self::Sliding { half_slip } => {
                format!("grows with the mass, 1/√2 of it at a slip of {}", number(*half_slip))
            }
            Self::DependsOnMass(false) => "whatever the mass".to_owned(),
            Self::WithHalfSlip => "with the slip at which half of the scrub is there".to_owned(),
            Self::OffCentre { empty_kg } => {
                format!("turns scrub less, by the square of what is loaded beyond {} kg", number(*empty_kg))
            }
            Self::InProportion => "in proportion to it".to_owned(),
            Self::WithStatic { power_w } => format!("with {} W of static power", number(*power_w)),
            Self::WithMotion { hold_s } if *hold_s < 0.0 => {
                format!("with motion, until {} s before its end", number(-hold_s))
            }
            Self::WithMotion { hold_s } => format!("with motion, held for {} s after it", number(*hold_s)),
            Self::FromFirstMotion => format!("from {FROM_MOTION}"),
            Self::At { at_s } => format!("at {} s, {}", number(*at_s), Runs::All.words()),
            Self::InRuns { runs, at_s: None } => runs.words(),
            Self::InRuns { runs, at_s: Some(times) } => {
                let times = some_of(times.iter().flatten().map(|time| number(*time)));
                format!("{}, at {times} s", runs.words())
            }
            Self::Formula { formula, meaning, sign, range } => {
                let sign = format!("{sign:?}").to_lowercase();
                let range = some_of([number(range.0), number(range.1)]);
                format!("formula {formula}, meaning {meaning}, sign {sign}, range {range}")
            }
            Self::Levels(figures) => {
                let said = figures.iter().filter_map(|(name, value)| phrase(name, value));
                said.collect::<Vec<_>>().join(", ")
            }
        }
    }
}

impl Runs {
    fn words(&self) -> String {
        match self {
            Self::All => "in all runs".to_owned(),
            Self::Named(names) => format!("in {}", some_of(names.iter().map(|name| file_name(name)))),
        }
    }
}

fn phrase(name: &str, value: &Value) -> Option<String> {
    let text = plain(value)?;
    Some(match name {
        "runs" => format!("in {text}"),
        other => format!("{} {text}", other.replace('_', " ")),
    })
}

fn plain(value: &Value) -> Option<String> {
    match value {
        Value::Null => None,
        Value::String(text) => Some(file_name(text)),
        Value::Number(value) => value.as_f64().map(number),
        Value::Array(entries) => Some(some_of(entries.iter().filter_map(plain))),
        other => Some(other.to_string()),
    }
}

/// Three decimals, without the noughts at the end.
fn number(value: f64) -> String {
    let text = format!("{value:.3}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// Entries of a list that are said one by one.
const SAID: usize = 3;

/// The first few of a list, and how many more there are.
pub fn some_of(entries: impl IntoIterator<Item = String>) -> String {
    let all: Vec<String> = entries.into_iter().collect();
    // One more is as short as its name.
    match all.len() - SAID.min(all.len()) {
        0 | 1 => all.join(", "),
        more => format!("{} and {more} more", all[..SAID].join(", ")),
    }
}

/// A run's log without its folder.
pub fn file_name(run: &str) -> String {
    match Path::new(run).file_name() {
        Some(name) if run.contains(".csv") => name.to_string_lossy().into_owned(),
        _ => run.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn details_are_said_as_one_would() {
        let names = Runs::Named(vec!["a/b.csv".to_owned(), "a/c.csv#2".to_owned()]);
        let times = Some(vec![Some(1.5), None]);
        for (detail, said) in [
            (Detail::Wheel { wheel: 1, side: WheelSide::Left }, "wheel 1, left side"),
            (Detail::TimeConstant { time_s: 9.0 }, "time constant 9 s"),
            (Detail::InRuns { runs: names, at_s: times }, "in b.csv, c.csv#2, at 1.5 s"),
            (Detail::WithMotion { hold_s: -0.3 }, "with motion, until 0.3 s before its end"),
            (Detail::At { at_s: 12.25 }, "at 12.25 s, in all runs"),
            (Detail::Heated(Heated::WithTime(20.0)), "with time, time constant 20 s"),
            (Detail::Heated(Heated::Measured(20.0)), "by motor temperatures, above 20 °C"),
        ] {
            assert_eq!(detail.words(), said);
        }
        assert_eq!(some_of(["a", "b", "c", "d"].map(str::to_owned)), "a, b, c, d");
        assert_eq!(some_of(["a", "b", "c", "d", "e"].map(str::to_owned)), "a, b, c and 2 more");
    }
}
