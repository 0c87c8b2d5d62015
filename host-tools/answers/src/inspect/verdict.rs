//! What a log is good for, in one line.

use std::fmt;

use serde::Serialize;

use super::finding::{Finding, Severity};
use super::scan::Scan;

/// Less driving than this, s, tells neither parameters nor a payload.
const LEAST_DRIVING_S: f64 = 10.0;

/// Where the 95 % quantile of the speed is above the 5 % one by less than this factor, there is one
/// speed only.
const ONE_SPEED: f64 = 1.25;

/// Which command the log is fit for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Use {
    /// `gmr fit`, and `gmr estimate`.
    Fit,
    /// `gmr estimate`, but not `gmr fit`.
    Estimate,
    /// Neither, as it is.
    Nothing,
}

/// What a log is good for.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Verdict {
    /// Which command.
    pub fit_for: Use,
    /// Why, and what is missing.
    pub verdict: String,
}

impl Verdict {
    pub(super) fn of(scan: &Scan, findings: &[Finding]) -> Self {
        let nothing = |why: String| Self { fit_for: Use::Nothing, verdict: why };
        let Some(drive) = &scan.excitation else {
            return nothing("no wheel speeds, so it tells the power at standstill at most".to_owned());
        };
        if drive.share_moving == 0.0 {
            return nothing(
                "the robot stands all the time, so it tells the power at standstill only".to_owned(),
            );
        }
        if let Some(problem) = findings.iter().find(|finding| finding.severity == Severity::Problem) {
            return nothing(format!("{}. {}", problem.text, sentence(&problem.advice)));
        }
        let driving_s = drive.share_moving * scan.duration_s;
        if driving_s < LEAST_DRIVING_S {
            return nothing(format!("{driving_s:.0} s of driving are too few; drive for two minutes"));
        }
        let estimate = |why: &str| Self { fit_for: Use::Estimate, verdict: why.to_owned() };
        let [slow, _, fast] = drive.speed_quantiles_rad_s;
        if fast < ONE_SPEED * slow {
            return estimate("one speed all the time; a fit needs slow and fast, with ramps");
        }
        match drive.payloads.len() {
            0 => estimate("it does not say what the robot weighed; a fit needs the total mass, as LOG=KG"),
            1 => Self {
                fit_for: Use::Fit,
                verdict: format!(
                    "a drive at {} kg; together with a drive at another payload",
                    drive.payloads[0].mass_kg
                ),
            },
            count => Self { fit_for: Use::Fit, verdict: format!("drives at {count} payloads") },
        }
    }
}

/// As the first line of `gmr inspect` says it.
impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { fit_for, verdict } = self;
        match fit_for {
            Use::Fit => write!(f, "READY for gmr fit ({verdict}) and gmr estimate"),
            Use::Estimate => write!(f, "READY for gmr estimate, not for gmr fit ({verdict})"),
            Use::Nothing => write!(f, "NOT READY: {verdict}"),
        }
    }
}

/// With a capital letter.
fn sentence(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}
