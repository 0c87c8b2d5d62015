//! From starts to the lowest of their ends.

use model_core::torque::Drive;
use nalgebra::Const;
use numerics::levenberg_marquardt::{self, Ending, Patience, Tolerances};

use super::super::dataset::Stretch;
use super::bounds::Bounds;
use super::cost::{Cost, Loss, PARAMETERS, Parameters};
use super::starts;

/// Where a search ended.
pub(crate) type Descent = levenberg_marquardt::Descent<Const<PARAMETERS>>;

/// Trials need not end where the last digit stays. Where twenty steps gain less than two ends that
/// count as one may differ by, the search has ended.
pub(super) const TRIAL: Tolerances = Tolerances {
    steps: 200,
    cost_share: 1e-9,
    cost: 0.0,
    step: 1e-8,
    gradient: 1e-8,
    patience: Patience { steps: 20, share: starts::SAME },
};

/// On a robot's data the last steps gain by squares of what is left: forty that gain a part in a
/// million find no minimum.
pub(super) const FINAL: Tolerances = Tolerances {
    steps: 500,
    cost_share: 1e-13,
    cost: 0.0,
    step: 1e-12,
    gradient: 1e-10,
    patience: Patience { steps: 40, share: 1e-6 },
};

/// Steps beyond which a search is cut short, over all starts and losses: all that the trials of its
/// starts may take. Logs of robots took 250 to 1,300, those of a skid-steered one 3,200 where
/// its slip was left out. Data that no robot makes have valleys without an end, and every descent
/// uses up what it is given.
pub(crate) const MOST_STEPS: u32 = starts::STARTS * TRIAL.steps;

/// A descent has at least so many steps, so that the rest of the fit has a result.
const LEAST_STEPS: u32 = TRIAL.steps;

/// The lowest cost of any rows, from one start, or from all starts where none is given, with the
/// steps of all.
pub(crate) fn search(
    rows: Stretch<'_>,
    drive: Drive,
    loss: Loss,
    bounds: &Bounds,
    near: Option<&Parameters>,
) -> Descent {
    let all = Cost { rows, drive, loss, free: bounds.free() };
    let mut steps = 0;
    let starts = match near {
        Some(near) => vec![*near],
        None => starts::finalists(&all, bounds, &TRIAL, 1, &mut steps),
    };
    let best = best_of(&all, &starts, bounds, &TRIAL, &mut steps);
    Descent { steps, ..best }
}

/// The lowest of the ends that these starts lead to. `steps` counts on; the starts may use what
/// remains of [`MOST_STEPS`].
pub(super) fn best_of(
    cost: &Cost<'_>,
    starts: &[Parameters],
    bounds: &Bounds,
    tolerances: &Tolerances,
    steps: &mut u32,
) -> Descent {
    let ends: Vec<Descent> = starts
        .iter()
        .map(|start| {
            let most = MOST_STEPS.saturating_sub(*steps).max(LEAST_STEPS).min(tolerances.steps);
            let tolerances = Tolerances { steps: most, ..*tolerances };
            let end = levenberg_marquardt::descend(cost, start, bounds.as_box(), &tolerances);
            *steps += end.steps;
            end
        })
        .collect();
    let best = ends.iter().filter(|end| !end.cost.is_nan()).min_by(|a, b| a.cost.total_cmp(&b.cost));
    best.or(ends.first()).cloned().unwrap_or_else(|| Descent {
        parameters: Parameters::zeros(),
        cost: f64::NAN,
        steps: 0,
        ending: Ending::NotFinite,
    })
}
