//! Whether the mass interval of an extended model holds the mass, in unseen runs with the effect.

use indicatif::ProgressBar;
use logs::robot::Robot;
use logs::runs::{RawRun, Runs};
use model::effects::written::{self, Written};
use model_core::coefficients::Coefficients;
use model_core::effects::live::{Live, Outside};
use model_core::estimator::{Estimator, Timing};
use model_core::model::Model;
use model_core::payload::Noise;
use model_core::payload::schedule::Schedule;
use model_core::payload::window::Window;
use support::error::{Error, Result};

use super::sets;
use super::{Case, columns};
use crate::extension;
use crate::likelihood::LEVEL;
use crate::weighed;
use residuals::types::Options;

/// Windows of this length, one after the other, s: those of the paper.
const WINDOW_S: f64 = 25.0;

/// Buckets are this long, s.
const BUCKET_S: f64 = 1.0;

/// Buckets that the estimator keeps.
const BUCKETS: usize = 32;

/// Unseen runs have seeds this much above the set's.
const UNSEEN: u64 = 500_000;

/// Windows of unseen runs, by an extended model.
#[derive(Debug, Clone, PartialEq)]
pub struct Covered {
    /// The case, its effect scaled.
    pub case: Case,
    /// What was named, and is in the model.
    pub named: Vec<String>,
    /// Whether the hidden effects are among them.
    pub right: bool,
    /// Of each window whose mass was known: whether the interval holds the mass, and its half
    /// width, kg.
    pub windows: Vec<(bool, f64)>,
    /// The same with the noise of the base alone.
    pub by_base: Vec<(bool, f64)>,
}

/// Runs the cases on all cores; one entry for each whose effects were named and can be added.
///
/// # Errors
/// What plant, fit and workflow refuse.
pub fn run(robot: &Robot, cases: &[Case], bar: &ProgressBar) -> Result<Vec<Covered>> {
    Ok(super::all(cases, bar, |case| one(robot, case))?.into_iter().flatten().collect())
}

fn one(robot: &Robot, case: &Case) -> Result<Option<Covered>> {
    let columns = columns(case);
    let clean = sets::clean(robot, case.seed, case.noise.noise, columns)?;
    let effects = case.scaled()?;
    let field = sets::field(&effects, case.noise.noise);
    let raw = sets::record(&field.field(case.seed), columns)?;
    let runs = clean.runs.condition_alike(&clean.runs.robot, raw.clone())?;
    let report = weighed::investigate(&runs, Some(&clean.runs), &clean.base, &Options::default(), LEVEL)?;
    let (written, kept) = extension::written(&report);
    let as_on_board = Runs::condition(&clean.runs.robot, raw)?;
    let Some(worth) = extension::of(&as_on_board, &report, &kept, &clean.noise) else { return Ok(None) };
    let written: Vec<Written> = written.into_iter().flatten().collect();
    if written.is_empty() {
        return Ok(None);
    }
    let added = written::columns(&written, 2).map_err(|wrong| Error::failed(wrong.message))?;
    let model = Model::Signed { torque: report.state.torque, drive: clean.base.drive };
    let unseen = sets::record(&field.field(case.seed + UNSEEN), columns)?;
    let masses = |noise: Noise<f64>| -> Result<Vec<(bool, f64)>> {
        let coefficients = Coefficients {
            robot: *clean.runs.robot.core(),
            model,
            noise,
            columns: added,
            identifies_mass: true,
            ground_adapts: false,
        };
        let all: Result<Vec<_>> = unseen.iter().map(|run| windows(&coefficients, run)).collect();
        Ok(all?.into_iter().flatten().collect())
    };
    let named: Vec<String> = report.effects.iter().map(|named| named.candidate.id.clone()).collect();
    Ok(Some(Covered {
        right: case.effects.iter().all(|effect| named.iter().any(|id| id == effect.id())),
        case: Case { effects, ..case.clone() },
        named,
        windows: masses(worth.noise)?,
        by_base: masses(clean.noise)?,
    }))
}

/// The windows of a run whose mass is known: whether the interval holds the mass, and its half
/// width, kg.
fn windows(coefficients: &Coefficients<f64, 2>, run: &RawRun) -> Result<Vec<(bool, f64)>> {
    let method = coefficients.window(run.period_s);
    let window = (WINDOW_S / BUCKET_S) as usize;
    let timing = Timing {
        period_s: run.period_s,
        bucket_s: BUCKET_S,
        schedule: Schedule::Moving { window },
        detect_changes: false,
    };
    let unfit = |why: &str| Error::failed(why.to_owned()).in_file(&run.name);
    let mut live = Live::new(coefficients, run.period_s).map_err(|_| unfit("effects that do not fit"))?;
    let mut estimator: Estimator<f64, Window<f64>, 2, BUCKETS> =
        Estimator::new(coefficients, method, &timing).map_err(|_| unfit("too slow for the filter"))?;
    let processor = run.columns.iter().position(|column| column == model::effects::PROCESSOR);
    let (mut intervals, mut closed, mut last) = (Vec::new(), 0_usize, f64::NAN);
    for (time, sample, mass, extras) in &run.rows {
        let mut outside = Outside::UNKNOWN;
        if let Some(place) = processor {
            outside.driver = extras[place];
        }
        let elapsed = if last.is_nan() { 0.0 } else { time - last };
        last = *time;
        let estimate = estimator.push_with(&mut live, &sample.core(), &outside, elapsed);
        closed += usize::from(estimate.closed);
        if estimate.closed
            && closed.is_multiple_of(window)
            && let Some(known) = estimator.over_latest(window).and_then(|mass| mass.known())
        {
            let holds = known.low <= *mass && *mass <= known.high;
            intervals.push((holds, 0.5 * (known.high - known.low)));
        }
    }
    Ok(intervals)
}
