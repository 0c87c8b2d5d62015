//! What `gmr gap-bench --json` prints.

use gap::bench::count::{Closed, Coverage, Seconds, count, figures};
use gap::bench::coverage::Covered;
use gap::bench::manoeuvre::Parted;
use gap::bench::{Case, Outcome};
use serde_json::{Map, Value, json};

/// Every set with what was made of it, and the figures.
pub(super) fn outcomes(outcomes: &[Outcome]) -> Value {
    let sets = outcomes.iter().map(|outcome| {
        let mut set = of_case(&outcome.case);
        let mut put = |key: &str, value: Value| set.insert(key.to_owned(), value);
        put("removed", json!(outcome.case.removed));
        put("verdict", json!(outcome.verdict));
        put("named", json!(outcome.named));
        put("tie", json!(outcome.ties));
        put("gap_closed", json!(outcome.closed));
        put("seconds", json!(outcome.seconds));
        put("probability", json!(outcome.probability));
        put("counted", json!(count(outcome)));
        Value::Object(set)
    });
    json!({
        "sets": sets.collect::<Vec<_>>(),
        "figures": figures(outcomes),
        "gap_closed": Closed::of(outcomes),
        "seconds": Seconds::of(outcomes),
    })
}

/// Every tie with what was driven, and how it ended.
pub(super) fn parted(parted: &[Parted], sets: usize) -> Value {
    let ties = parted.iter().map(|tie| {
        let mut set = of_case(&tie.case);
        let mut put = |key: &str, value: Value| set.insert(key.to_owned(), value);
        put("tie", json!(tie.tie));
        put("manoeuvre", tie.suggestion.json());
        put("names", json!(tie.names));
        put("ending", json!(tie.ending));
        Value::Object(set)
    });
    json!({ "sets": sets, "ties": ties.collect::<Vec<_>>() })
}

/// Every extended model with its windows, and the figures.
pub(super) fn coverage(covered: &[Covered]) -> Value {
    let sets = covered.iter().map(|model| {
        let mut set = of_case(&model.case);
        let mut put = |key: &str, value: Value| set.insert(key.to_owned(), value);
        let Coverage { holds, windows, half_width_kg, .. } = Coverage::of("", model.windows.iter().copied());
        put("named", json!(model.named));
        put("right", json!(model.right));
        put("holds", json!(holds));
        put("windows", json!(windows));
        put("half_width_kg", json!(half_width_kg));
        Value::Object(set)
    });
    json!({ "sets": sets.collect::<Vec<_>>(), "figures": Coverage::all(covered) })
}

fn of_case(case: &Case) -> Map<String, Value> {
    let hidden = case.effects.iter().map(|effect| json!({"id": effect.id(), "size": effect.size()}));
    let mut set = Map::new();
    set.insert("hidden".to_owned(), hidden.collect());
    set.insert("size".to_owned(), json!(case.size));
    set.insert("seed".to_owned(), json!(case.seed));
    set.insert("noise".to_owned(), json!(case.noise.name));
    set
}
