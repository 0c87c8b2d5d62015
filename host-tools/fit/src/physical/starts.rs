//! Where the search begins: shares of the power put down to each parameter, and points drawn within
//! the bounds.

use numerics::levenberg_marquardt::{self, Tolerances};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::bounds::Bounds;
use super::cost::{Cost, PARAMETERS, Parameters, WINDING_LOSS, gradient, torque};

/// Draws of shares. With the ordered starts, so many reached every minimum that fifty reached on
/// the robots of the bench.
pub(super) const DRAWS: u64 = 16;

/// Ends of which the cost differs by less than this share are one and the same.
pub(super) const SAME: f64 = 1e-4;

/// Winding loss per mechanical power.
const LOSSES: [f64; 4] = [0.0, 0.1, 1.0, 10.0];
/// Shares of the inertias.
const INERTIAS: [f64; 2] = [0.05, 0.5];

/// How many starts there are.
pub(super) const STARTS: u32 = (LOSSES.len() * INERTIAS.len()) as u32 + DRAWS as u32;

/// Searches from every start on these rows; the lowest ends, the best first.
pub(super) fn finalists(
    cost: &Cost<'_>,
    bounds: &Bounds,
    tolerances: &Tolerances,
    most: usize,
    steps: &mut u32,
) -> Vec<Parameters> {
    let alone = Alone::of(cost);
    let descend = |start: Parameters| levenberg_marquardt::descend(cost, &start, bounds.as_box(), tolerances);
    let mut ends: Vec<levenberg_marquardt::Descent<_>> =
        alone.starts(bounds).into_par_iter().map(descend).collect();
    *steps += ends.iter().map(|end| end.steps).sum::<u32>();
    ends.retain(|end| end.cost.is_finite());
    ends.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    ends.dedup_by(|later, earlier| later.cost - earlier.cost <= SAME * earlier.cost);
    ends.into_iter().take(most).map(|end| end.parameters).collect()
}

/// How large each parameter is where it alone explains the power.
pub struct Alone {
    /// Each where the others are 0.
    pub parameters: Parameters,
    /// Root mean square of the wheel speed over Coulomb's direction, rad/s.
    pub speed: f64,
}

impl Alone {
    pub(super) fn of(cost: &Cost<'_>) -> Self {
        // At no torque the slope of the power is the regressor w x of each part.
        let none = torque(&Parameters::zeros());
        let (mut xp, mut xx) = (Parameters::zeros(), Parameters::zeros());
        for row in cost.rows.iter() {
            let slope = gradient(&none, &row, model_core::torque::Drive::Regenerative);
            xp.axpy(row.power, &slope, 1.0);
            xx += slope.component_mul(&slope);
        }
        let parameters = xp.zip_map(&xx, |xp, xx| if xx > 0.0 { (xp / xx).max(0.0) } else { 0.0 });
        let speed = (xx[0] / cost.rows.others().len().max(1) as f64).sqrt();
        Self { parameters, speed }
    }

    /// The ordered starts: shares of every friction and inertia, for several winding losses.
    pub fn ordered_starts(&self) -> Vec<Parameters> {
        let mut starts = Vec::new();
        for loss in LOSSES {
            for inertia in INERTIAS {
                let scale = 0.3 / (1.0 + loss);
                starts.push(
                    self.start(&[scale, scale, scale, inertia, inertia, loss, scale, 0.0, 0.0, 0.0, 0.0]),
                );
            }
        }
        starts
    }

    fn starts(&self, bounds: &Bounds) -> Vec<Parameters> {
        let mut starts = self.ordered_starts();
        starts.extend((0..DRAWS).map(|draw| self.drawn(draw, bounds)));
        starts
    }

    /// A start at random; the same for the same draw.
    pub(super) fn drawn(&self, draw: u64, bounds: &Bounds) -> Parameters {
        let random = &mut ChaCha8Rng::seed_from_u64(draw);
        // From a thousandth to all of it, each decade alike.
        let shares: [f64; PARAMETERS] = std::array::from_fn(|_| 10.0_f64.powf(-3.0 * random.random::<f64>()));
        let mut start = self.start(&shares);
        start[WINDING_LOSS] = 10.0_f64.powf(-4.0 * random.random::<f64>()) * bounds.upper()[WINDING_LOSS];
        start
    }

    /// Shares of what each explains alone; that of κ is the loss per mechanical power.
    fn start(&self, shares: &[f64; PARAMETERS]) -> Parameters {
        let mut start = Parameters::from_fn(|i, _| shares[i] * self.parameters[i]);
        // There κ τ² is so many times τ w.
        start[WINDING_LOSS] = shares[WINDING_LOSS] * self.speed.max(1e-9) / self.parameters[0].max(1e-9);
        start
    }
}
