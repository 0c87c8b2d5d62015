//! The answer as JSON: always these keys, watts and SI units.

use serde_json::{Map, Value, json};

use super::investigate::{Report, Verdict};
use super::manoeuvre::Suggestion;
use super::simulation::Simulated;

/// What goes beside the report.
#[derive(Debug, Clone, Copy, Default)]
pub struct Beside<'a> {
    /// The simulation's side.
    pub simulated: Option<&'a Simulated>,
    /// What to drive where there is a tie.
    pub suggestion: Option<&'a Suggestion>,
    /// The file that its profile was written to.
    pub profile: Option<&'a str>,
}

/// The report, for scripts.
pub fn json(report: &Report, beside: Beside<'_>) -> Value {
    let effects: Vec<Value> = report
        .effects
        .iter()
        .map(|effect| {
            let mut detail = effect.candidate.detail.clone();
            if effect.coefficients.len() > 1 {
                detail.insert("coefficients".to_owned(), json!(effect.coefficients));
                detail.insert("std_errs".to_owned(), json!(effect.std_errs));
            }
            json!({
                "id": effect.candidate.id,
                "coefficient": effect.coefficients.first(),
                "unit": effect.candidate.unit,
                "std_err": effect.std_errs.first(),
                "detail": detail,
            })
        })
        .collect();
    let mut rounds: Vec<Value> = report.rounds.iter().map(round).collect();
    if let Some(Value::Object(first)) = rounds.first_mut() {
        first.insert("not_testable".to_owned(), json!(report.not_testable));
    }
    if let Some(Value::Object(last)) = rounds.last_mut() {
        last.insert("base".to_owned(), report.base_moves());
    }
    let confirmed = &report.confirmed;
    let mut out = Map::new();
    out.insert("verdict".to_owned(), json!(report.verdict));
    out.insert("effects".to_owned(), Value::Array(effects));
    out.insert("ambiguous_with".to_owned(), json!(report.ambiguous_with));
    out.insert("suggested_profile".to_owned(), json!(beside.profile));
    out.insert("manoeuvre".to_owned(), beside.suggestion.map_or(Value::Null, Suggestion::json));
    out.insert("gap_before_w".to_owned(), json!(confirmed.before_w));
    let stands = matches!(report.verdict, Verdict::Named | Verdict::Ambiguous);
    out.insert("gap_after_w".to_owned(), json!(if stands { confirmed.after_w } else { confirmed.before_w }));
    out.insert("noise_floor_w".to_owned(), json!(confirmed.floor_w));
    out.insert("gap_closed".to_owned(), json!(confirmed.closed.filter(|_| stands)));
    out.insert("simulation".to_owned(), beside.simulated.map_or(Value::Null, Simulated::json));
    out.insert("confirm_runs".to_owned(), json!(confirmed.runs));
    out.insert("localisation".to_owned(), json!(report.localisation));
    out.insert("rounds".to_owned(), Value::Array(rounds));
    Value::Object(out)
}

fn round(round: &super::investigate::Round) -> Value {
    let candidates: Vec<Value> = round
        .candidates
        .iter()
        .map(|scored| {
            json!({
                "id": scored.id,
                "status": scored.status,
                "gain": scored.gain,
                "coefficients": scored.coefficients,
                "detail": scored.detail,
            })
        })
        .collect();
    json!({
        "structure": round.structure,
        "allowed": round.allowed,
        "outcome": round.outcome,
        "candidates": candidates,
    })
}
