//! Whether a fit can be used, and the one thing to do where it cannot.

use super::physical::AtBound;
use super::verdict::PAYLOADS;
use model::coefficients::{Usability, of_r2};
use numerics::robust::NORMAL_95;
use support::figure::figure;
use support::metrics::Quality;

/// Where the log itself is in doubt.
const LOOK: &str = "check the unit, sign and clock of power and speeds with gmr inspect";

/// Why a fit cannot be used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Defect {
    /// What it is, short: it stands in the file as well.
    pub why: String,
    /// What to do.
    pub remedy: String,
}

/// How much more power the heaviest payload takes than the lightest one by the model, over the rows
/// of a fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MassEffect {
    /// Mean difference, W.
    pub mean_w: f64,
    /// Its standard error, W.
    pub std_err_w: f64,
    /// Lightest and heaviest total mass, kg.
    pub masses_kg: [f64; 2],
}

/// What makes a fit one that nobody can use; `None` where somebody can.
///
/// With an R² below 0 the mean of the power predicts these rows better. `cut_short` are the steps
/// of a search that was cut short and met no minimum. What else the data leave open matters where
/// payloads are estimated: a parameter at its bound replaces what depends on the mass, and a mass
/// effect that may as well be 0 gives any payload. A fit at one payload estimates none and says
/// so: there, none of these is a defect.
pub(super) fn defect(
    quality: &Quality,
    at_bounds: &[AtBound],
    effect: Option<&MassEffect>,
    cut_short: Option<u32>,
) -> Option<Defect> {
    let no_minimum = cut_short
        .map(|steps| format!("no minimum after {steps} steps, where logs of robots take 3,200 at most"));
    if let Some(r2) = quality.r2.filter(|r2| *r2 < 0.0) {
        let remedy = format!(
            "{LOOK}; where power_w is the total, let the robot stand for ten seconds in each log, which shows its static power"
        );
        let mut why = of_r2(r2);
        no_minimum.iter().for_each(|no_minimum| why += &format!("; {no_minimum}"));
        return Some(Defect { why, remedy });
    }
    let effect = effect?;
    // Any other defect follows from it.
    if let Some(why) = no_minimum {
        let remedy = format!("{LOOK}: wheels that turn so draw no such power");
        return Some(Defect { why, remedy });
    }
    if let Some(at) = at_bounds.iter().find(|at| !at.of_motor) {
        return Some(Defect {
            why: format!("{} is at its bound of {}", at.description.name, figure(at.bound)),
            remedy: at.remedy(),
        });
    }
    let MassEffect { mean_w, std_err_w, masses_kg: [light, heavy] } = *effect;
    (mean_w <= NORMAL_95 * std_err_w).then(|| Defect {
        why: format!(
            "at {heavy} kg the robot draws {} ± {} W more than at {light} kg, which may be nothing",
            figure(mean_w),
            figure(std_err_w)
        ),
        remedy: PAYLOADS.to_owned(),
    })
}

/// As files keep it.
pub(super) fn usability(defect: Option<&Defect>) -> Usability {
    defect.map_or(Usability::Usable, |defect| Usability::NotUsable(defect.why.clone()))
}
