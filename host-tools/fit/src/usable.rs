//! Whether a fit can be used, and the one thing to do where it cannot.

use super::physical::AtBound;
use super::verdict::PAYLOADS;
use model::coefficients::{Usability, of_r2};
use numerics::robust::NORMAL_95;
use support::figure::figure;
use support::metrics::Quality;

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
/// With an R² below 0 the mean of the power predicts these rows better. What else the data leave
/// open matters where payloads are to be found: a parameter at its bound takes the place of what
/// depends on the mass, and an effect of the mass that may as well be 0 gives any payload. A fit at
/// one payload finds none, and says so: there, neither is a defect.
pub(super) fn defect(
    quality: &Quality,
    at_bounds: &[AtBound],
    effect: Option<&MassEffect>,
) -> Option<Defect> {
    if let Some(r2) = quality.r2.filter(|r2| *r2 < 0.0) {
        let remedy = "check the unit, sign and clock of power and speeds with gmr inspect; where power_w is the total, let the robot stand \
                      for ten seconds in each log, which shows its static power"
            .to_owned();
        return Some(Defect { why: of_r2(r2), remedy });
    }
    let effect = effect?;
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
