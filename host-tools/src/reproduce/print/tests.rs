//! Logs that Eq. 18 itself has made, as derived or as printed.

use model_core::eq18::{self, Gate, REGRESSORS};
use model_core::motion::Motion;

use super::{Cost, Pair, list, measure};
use crate::fit::dataset::{Dataset, Row};
use crate::robot::Robot;

/// Positive, and of a size that every product shows: a few tenths of a watt each at 3 kg and 3 rad/s.
const BETA: [f64; REGRESSORS] =
    [0.2, 0.03, 0.01, 0.01, 0.02, 900.0, 0.03, 0.02, 0.02, 0.01, 5.0, 2.0, 0.02, 8.0, 9.0];

/// Ninety seconds at 20 Hz of two wheels that speed up and brake at their own rhythms, without noise.
fn log(gate: Gate, masses: &[f64], phase: f64) -> Dataset<2> {
    let core = Robot::load("burger").unwrap().core::<2>(2.0).unwrap();
    let mut dataset = Dataset::empty(core, gate);
    for k in 0..1800_usize {
        let time = k as f64 / 20.0;
        let (a, b) = (0.9 * time + phase, 0.31 * time + 2.0 * phase);
        let speed = [3.5 + 2.0 * a.sin() + 0.5 * b.sin(), 3.5 + 1.5 * a.cos() - 0.8 * b.cos()];
        let acceleration = [1.8 * a.cos() + 0.155 * b.cos(), -1.35 * a.sin() + 0.248 * b.sin()];
        let motion = Motion::new(&speed, &acceleration, &core.mass_matrix, core.dead_band);
        let mass = masses[k * masses.len() / 1800];
        let x = eq18::regressors(gate, &eq18::products(gate, &motion), mass);
        let power = x.iter().zip(BETA).map(|(x, beta)| x * beta).sum();
        dataset.keep(Row { motion, power, mass, run: 0, time });
    }
    dataset
}

/// Three masses to learn from: two would leave β0, β1 and β2 open between them.
fn pair(gate: Gate) -> Pair<2> {
    let (training, test) = (log(gate, &[1.0, 3.0, 6.0], 0.0), log(gate, &[2.0, 4.5], 1.0));
    Pair { plant: "made", training, test, floor_w: 0.1 }
}

fn cost<'a>(costs: &'a [Cost], figure: &str) -> &'a Cost {
    costs.iter().find(|cost| cost.figure.starts_with(figure)).unwrap()
}

/// Without noise the derivation is exact but for rounding, some 1e-12 of the power through the normal equations: a thousand times that
/// is allowed. What the print costs here (β5's part of the power is small) is a million times more than what is allowed.
#[test]
fn a_log_of_the_derivation_is_the_derivations() {
    let found = list(&measure(&[pair(Gate::Corrected)]).unwrap());
    for difference in &found[..3] {
        let (r2, mape, mass) = (
            cost(&difference.cost, "R²"),
            cost(&difference.cost, "MAPE"),
            cost(&difference.cost, "mean mass"),
        );
        assert!(r2.derivation.mean > 1.0 - 1e-9 && mape.derivation.mean < 1e-9, "{difference:#?}");
        assert!(mass.derivation.mean < 1e-9, "{difference:#?}");
        assert!(r2.difference.mean < -1e-7 && mape.difference.mean > 1e-3, "{difference:#?}");
        assert!((r2.print.mean - r2.derivation.mean - r2.difference.mean).abs() < 1e-12, "{difference:#?}");
    }
}

#[test]
fn a_log_of_the_print_is_the_prints() {
    let found = list(&measure(&[pair(Gate::Published)]).unwrap());
    let both = &found[2].cost;
    assert!(cost(both, "R²").difference.mean > 0.0 && cost(both, "MAPE").print.mean < 1e-3, "{both:#?}");
}

#[test]
fn nothing_to_judge_is_an_error() {
    let mut empty = pair(Gate::Corrected);
    empty.test.store.clear();
    assert!(measure(&[empty]).unwrap_err().to_string().contains("made: no row"));
}
