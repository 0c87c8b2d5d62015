//! What a run is not good for, said of each; the others go on.

use fit::run_gram::RunGram;
use serde::Serialize;

/// Whether a run takes part.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Judged {
    /// The run.
    pub run: String,
    /// It counts.
    pub is_used: bool,
    /// Why not, or what to know of it.
    pub notes: Vec<String>,
}

/// How far the distance may be from what was commanded. Speed loops follow to a percent or two over
/// a drive; other tyres or another gear are further off.
const MOST_OFF_COMMAND: f64 = 0.05;

/// Judges a run by its sums, `group` being the keys that it must have.
pub(super) fn judge(run: &RunGram, group: &[String]) -> Judged {
    let summary = &run.summary;
    let mut refusals = Vec::new();
    for key in group.iter().filter(|key| !run.keys.contains_key(*key)) {
        refusals.push(format!("its path does not say its {key}; expected folders such as {key}=…"));
    }
    if summary.moving_s == 0.0 {
        refusals.push("the robot does not move: it says nothing of a wheel".to_owned());
    } else if run.local.as_ref().is_none_or(|local| local.rows == 0) {
        refusals.push(
            "no row behind the filter in which a wheel draws power: too short, or in pieces".to_owned(),
        );
    }
    if let Some(share) = summary.way_per_command().filter(|share| (share - 1.0).abs() > MOST_OFF_COMMAND) {
        refusals.push(format!(
            "it goes {share:.3} of the way that it is told: wheels of another radius than the robot's file says, or slip; energy per metre \
             and coefficients would be off by as much"
        ));
    }
    let is_used = refusals.is_empty();
    let mut notes = refusals;
    if summary.exclusions.total() > 0 {
        notes.push(summary.exclusions.to_string());
    }
    if summary.gaps > 0 {
        notes.push(format!(
            "its clock jumps ahead {} times: the filter begins anew, the gaps are not counted",
            summary.gaps
        ));
    }
    Judged { run: run.run.clone(), is_used, notes }
}
