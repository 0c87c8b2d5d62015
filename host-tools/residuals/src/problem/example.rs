//! A small problem for tests.

use logs::robot::Robot;
use logs::runs::{RawRun, Runs};
use model::effects::{Candidate, Detail, Regressor};
use model_core::estimator::Sample;
use model_core::torque::{Drive, TorqueModel};
use nalgebra::DMatrix;

use super::Problem;
use super::panel::Fixed;
use crate::late::with_power;
use crate::noise::Noise;
use crate::noise::whiten::Whitener;
use crate::predictor::{Predictor, State};

/// Standard deviation of the noise, W.
pub(crate) const STD_W: f64 = 0.07;

/// Two runs of different masses at two paces, rad/s; no model has their power.
pub(crate) fn runs(paces: [f64; 2]) -> Runs {
    runs_of(paces, 500)
}

/// The same with so many rows each before the filter has settled.
pub(crate) fn runs_of(paces: [f64; 2], rows: u32) -> Runs {
    let burger = Robot::named("burger").unwrap().chassis(2.0).unwrap();
    let raw = [(1.0, paces[0]), (4.0, paces[1])].map(|(mass, pace)| {
        let rows = (0..rows).map(|i| {
            let time = 0.05 * f64::from(i);
            let speed = [5.0 * (pace * time).sin(), 4.0 * (0.7 * pace * time).cos()];
            let power = 0.5 + 0.2 * mass * (1.3 * time).sin() + 0.1 * (11.0 * time * time).sin();
            (time, Sample { wheel_speed: speed, wheel_acceleration: None, power }.into(), mass, Vec::new())
        });
        RawRun { name: "run".to_owned(), rows: rows.collect(), columns: Vec::new(), period_s: 0.05 }
    });
    Runs::condition(&burger, raw.into()).unwrap()
}

/// Runs whose power is that of a state each.
pub(crate) fn simulated(runs: &Runs, drive: Drive, truth: impl Fn(usize) -> State) -> Runs {
    let predictor = Predictor::new(runs, drive);
    with_power(runs, (0..runs.runs.len()).map(|run| predictor.predict(run, &truth(run))).collect())
}

/// A plain candidate with a coefficient within `range`.
pub(crate) fn candidate(id: &str, regressors: Vec<Regressor>, range: (f64, f64)) -> Candidate {
    let (id, unit, detail) = (id.to_owned(), String::new(), Detail::Plain);
    Candidate { id, regressors, unit, range, least: Vec::new(), detail, search: 0.0 }
}

/// White noise of a known standard deviation, with no greater scatter along any column.
fn white(runs: &Runs) -> Noise {
    let all = |value: f64| runs.runs.iter().map(|run| vec![value; run.rows.len()]).collect();
    Noise {
        whitener: Whitener { coefficients: Vec::new() },
        std_w: STD_W,
        weights: all(1.0),
        residual: all(0.0),
        residual_w: all(0.0),
        floor_w2: 0.0,
    }
}

/// A problem without clean runs, prior and discrepancy.
pub(crate) fn bare<'a>(predictor: Predictor<'a>, centre: TorqueModel<f64>, base: usize) -> Problem<'a> {
    Problem {
        predictor,
        centre,
        base,
        precision: DMatrix::zeros(base, base),
        noise: white(predictor.runs),
        discrepancy: Fixed::default(),
        factor: None,
        still: Vec::new(),
        smooth: Vec::new(),
        misfit: 1.0,
    }
}
