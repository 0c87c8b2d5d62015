//! Fleets of sums, made up: what the tests of this room share.

use fit::physical::parameters;
use fit::run_gram::{Local, PARAMETERS, RunGram};
use model_core::torque::TorqueModel;
use nalgebra::{DMatrix, DVector};
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};

use super::drift::Drift;

const ROBOTS: usize = 30;
const DAYS: usize = 5;
const ROWS: usize = 200;

pub(super) const REFERENCE: TorqueModel<f64> = TorqueModel {
    coulomb: 0.04,
    rolling: 0.01,
    viscous: 0.01,
    rotor_inertia: 0.005,
    inertia_gain: 1.5,
    winding_loss: 2.0,
    scrub: 0.0,
    imbalance: 0.0,
    gear_loss: 0.0,
    bridge_drop: 0.0,
    wheel_friction_share: 0.0,
};

pub(super) fn no_change() -> Drift {
    Drift { changes: Vec::new(), asked: 0, threshold: None, silent: Vec::new() }
}

/// A run a robot and day. Robots differ by 1 % of each coefficient, and by the share `of` (robot,
/// day) of viscous friction; rows have noise of 10 mW times `noise`.
pub(super) fn fleet(of: impl Fn(usize, usize) -> f64, noise: impl Fn(usize, usize) -> f64) -> Vec<RunGram> {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut normal = move || -> f64 { StandardNormal.sample(&mut random) };
    let values = parameters(&REFERENCE);
    let mut runs = Vec::new();
    for robot in 0..ROBOTS {
        let off = DVector::from_fn(PARAMETERS, |place, _| 0.01 * values[place] * normal());
        for day in 0..DAYS {
            let mut delta = off.clone();
            delta[2] += of(robot, day) * values[2];
            // A watt or so for each coefficient as it is.
            let slopes = DMatrix::from_fn(ROWS, PARAMETERS, |_, place| {
                if values[place] > 0.0 { normal() / values[place] } else { 0.0 }
            });
            let errors = &slopes * delta + DVector::from_fn(ROWS, |_, _| 0.01 * noise(robot, day) * normal());
            let (products, score) = (slopes.transpose() * &slopes, slopes.transpose() * &errors);
            let pairs = (0..PARAMETERS).flat_map(|i| (0..=i).map(move |j| (i, j)));
            let local = Local {
                rows: ROWS as u64,
                squares: errors.dot(&errors),
                score: score.iter().copied().collect(),
                normal: pairs.map(|pair| products[pair]).collect(),
            };
            let keys = [("robot", format!("{robot:02}")), ("day", format!("{day}"))];
            runs.push(RunGram {
                run: format!("{robot:02}/{day}"),
                keys: keys.map(|(key, value)| (key.to_owned(), value)).into(),
                local: Some(local),
                ..RunGram::blank()
            });
        }
    }
    runs
}
