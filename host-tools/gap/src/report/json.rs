//! The answer as JSON: always these keys, in SI units; null for what is unknown or not finite.

use model::effects::{Sign, find};
use serde_json::{Map, Value, json};

use super::advice;
use crate::driven_plant::Simulated;
use crate::manoeuvre::Suggestion;
use crate::report::Report;
use crate::simulator::Told;
use crate::simulator::export::Changes;
use crate::words;
use residuals::types::{Named, Round};

/// What the keys hold: shown by `gmr gap --help`.
pub const KEYS: &str = "\
Keys of --json, always all there; watts and SI units; null where something is not known or does not apply:
  verdict            none, named, ambiguous or unexplained
  effects            what was added: id, coefficient, unit, std_err, physical (its size in the world, the drive's losses taken
                     out: value, unit, std_err), detail, meaning, sign. Of an effect with several
                     columns coefficient is the greatest in size (of a slope in a direction of the world its size), and
                     detail has all as coefficients and std_errs, in the order of detail.runs where they belong to runs
  ambiguous_with     ids of effects that explain as much, or are likelier
  rivals             probability of each effect among those of the list, by its id, from 1 % on; of
                     several names only theirs, the others being known. A name below 5 % is taken
                     back. Null where it is not known
  suggested_profile  file with a drive that parts them, or null
  manoeuvre          what to drive where there is a tie, and what is expected of it; null without one
  gap_before_w       RMS of measured less predicted power over the locked runs, behind the filter
  gap_after_w        the same with the effects added; the same number as before where none stands
  noise_floor_w      the part of the gap that no effect removes; held at gap_after_w
  noise_floor_unclipped_w
                     the same as it was estimated
  gap_closed         (before² - after²) / (before² - floor²); null where nothing was to be closed, or no locked run has the effect
  gain_w2            mean square before less after: mean over the locked runs, and its 95 % interval (Student's t; null for one run)
  confirmed_share    how much of what was added the locked runs show, asked alone: share, and its 95 % interval
  simulation         the same gap of the simulated robot (--plant): before, after, closed, effects and their sizes
  simulator          of --sim, or of sim_ columns: its logs, power_from, model_r2 and model_rmse_w of the model fitted to it, and
                     difference: measured less simulated power on the locked runs, before_w and with the effects added after_w
  changes            of --export: language, and changes of the simulator's model: effect, element, part, change, value, its 95 %
                     interval, unit, note
  confirm_runs       the locked runs
  localisation       cells: axis, from, to, mean_residual_w, band_w (half the 95 % interval over runs), mean_after_w,
                     band_after_w, runs, words
  rounds             structure, allowed, outcome, and candidates with id, status, gain, coefficients, detail
  clean_structure    the most structure, |z|, that clean runs show of each other: it raises what rounds allow where it is
                     beyond noise; null where clean runs are fewer than six
  refit              terms that the clean runs ask for and the coefficients lack: term, gain, std_err; nothing is named before a refit
  relabelled         share: how often as much is seen when other runs are called the field, and the
                     level that is allowed; null where it was not asked
  notes              what is less sure than it might be, and why
  noise_floor_how    how the noise floor was estimated
  base_moves         parameters of the base: before, after
  not_testable       effects that these runs cannot show: id, reason
  next_steps         what to do next, sentences";

/// What goes beside the report.
#[derive(Debug, Clone, Copy, Default)]
pub struct Beside<'a> {
    /// The simulation's side.
    pub simulated: Option<&'a Simulated>,
    /// Somebody's own simulator.
    pub simulator: Option<&'a Told>,
    /// What its model of the robot needs.
    pub changes: Option<&'a Changes>,
    /// What to drive where there is a tie.
    pub suggestion: Option<&'a Suggestion>,
    /// The file that its profile was written to.
    pub profile: Option<&'a str>,
}

/// The report, for scripts; [`KEYS`] says what it holds.
pub fn json(report: &Report, beside: Beside<'_>) -> Value {
    let confirmed = &report.confirmed;
    let stands = report.verdict.stands();
    let mut out = Map::new();
    out.insert("verdict".to_owned(), json!(report.verdict));
    out.insert("effects".to_owned(), report.effects.iter().map(effect).collect());
    out.insert("ambiguous_with".to_owned(), json!(report.ambiguous_with));
    let rivals: Map<String, Value> =
        report.rivals.iter().map(|(id, probability)| (id.clone(), json!(probability))).collect();
    out.insert("rivals".to_owned(), json!((!rivals.is_empty()).then_some(rivals)));
    out.insert("suggested_profile".to_owned(), json!(beside.profile));
    out.insert("manoeuvre".to_owned(), beside.suggestion.map_or(Value::Null, Suggestion::json));
    out.insert("gap_before_w".to_owned(), json!(confirmed.before_w));
    out.insert("gap_after_w".to_owned(), json!(if stands { confirmed.after_w } else { confirmed.before_w }));
    out.insert("noise_floor_w".to_owned(), json!(confirmed.floor_w));
    out.insert("noise_floor_unclipped_w".to_owned(), json!(confirmed.floor_unclipped_w));
    out.insert("gap_closed".to_owned(), json!(confirmed.closed.filter(|_| stands)));
    let gain = confirmed.gain_w2;
    let interval = gain.ends().map(|(low, high)| [low, high]);
    out.insert("gain_w2".to_owned(), json!({"mean": gain.mean, "interval": interval}));
    let share = confirmed.share.map(|shown| json!({"share": shown.share, "interval": shown.interval()}));
    out.insert("confirmed_share".to_owned(), json!(share));
    out.insert("simulation".to_owned(), beside.simulated.map_or(Value::Null, Simulated::json));
    out.insert("simulator".to_owned(), json!(beside.simulator));
    out.insert("changes".to_owned(), json!(beside.changes));
    out.insert("confirm_runs".to_owned(), json!(confirmed.runs));
    out.insert("localisation".to_owned(), json!(report.localisation));
    out.insert("rounds".to_owned(), report.rounds.iter().map(round).collect());
    out.insert("clean_structure".to_owned(), json!(report.clean_structure));
    out.insert("refit".to_owned(), json!(report.refit));
    let relabelled = report.relabelled.map(|gate| json!({"share": gate.share, "level": gate.level}));
    out.insert("relabelled".to_owned(), json!(relabelled));
    out.insert("notes".to_owned(), json!(report.notes));
    out.insert("noise_floor_how".to_owned(), json!(confirmed.floor_how));
    out.insert("base_moves".to_owned(), report.base_moves());
    out.insert("not_testable".to_owned(), json!(report.not_testable));
    out.insert("next_steps".to_owned(), json!(advice::next_steps(report)));
    Value::Object(out)
}

fn effect(named: &Named) -> Value {
    let candidate = &named.candidate;
    let mut detail = candidate.detail.fields();
    if named.coefficients.len() > 1 {
        detail.insert("coefficients".to_owned(), json!(named.coefficients));
        detail.insert("std_errs".to_owned(), json!(named.std_errs));
    }
    if let Some(direction) = words::direction(named) {
        detail.insert("heading_rad".to_owned(), json!(direction));
    }
    let (coefficient, std_err) = words::headline(named);
    json!({
        "id": candidate.id,
        "coefficient": coefficient,
        "unit": candidate.unit,
        "std_err": std_err,
        "physical": named.physical,
        "detail": detail,
        "meaning": words::meaning(candidate),
        "sign": find(&candidate.id).map_or(Sign::Either, |entry| entry.sign),
    })
}

fn round(round: &Round) -> Value {
    let candidates: Value = round
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

#[cfg(test)]
mod tests {
    use super::{Beside, KEYS, json};
    use crate::report::example::report;
    use residuals::types::Verdict;

    #[test]
    fn all_keys_are_there_whatever_the_verdict_and_the_help_names_them() {
        let documented: Vec<&str> = KEYS
            .lines()
            .filter_map(|line| line.strip_prefix("  ").filter(|line| !line.starts_with(' ')))
            .filter_map(|line| line.split(' ').next())
            .collect();
        for verdict in [Verdict::None, Verdict::Named, Verdict::Ambiguous, Verdict::Unexplained] {
            let answer = json(&report(verdict), Beside::default());
            let keys: Vec<&str> = answer.as_object().unwrap().keys().map(String::as_str).collect();
            assert_eq!(keys, documented);
        }
    }

    #[test]
    fn coefficients_are_numbers_and_what_is_not_finite_is_null() {
        let answer = json(&report(Verdict::Named), Beside::default());
        for effect in answer["effects"].as_array().unwrap() {
            assert!(effect["coefficient"].is_f64() && effect["std_err"].is_f64(), "{effect}");
            assert!(effect["meaning"].as_str().unwrap().contains(' '), "{effect}");
        }
        // Four runs with an error of their own: the greatest, and all.
        assert_eq!(answer["effects"][2]["coefficient"], 0.12);
        assert_eq!(answer["effects"][2]["detail"]["coefficients"].as_array().unwrap().len(), 4);
        assert!(answer["rounds"][0]["candidates"][0]["coefficients"][0].is_null());
        assert!(json(&report(Verdict::Unexplained), Beside::default())["gap_closed"].is_null());
    }
}
