//! What the model's form may get wrong: smooth functions of the drive, and the effects' own
//! columns, each in a group whose variance clean runs tell.

use logs::runs::Runs;
use model::effects::{Candidate, Regressor};
use model_core::effects::Term;
use rayon::prelude::*;

use super::predicted::Predicted;
use residuals::noise::whiten::Signal;
use residuals::predictor::State;
use residuals::smooth;

/// Functions that vary together: in size, not in sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Group {
    /// Power that is there or not.
    Level,
    /// With the speed.
    Speed,
    /// With acceleration.
    Acceleration,
    /// With the power's own changes.
    Edge,
    /// In turns, and by side and heading.
    Turn,
    /// With the mass.
    Mass,
    /// With time.
    Time,
    /// With a further column.
    Column,
}

use Group::{Acceleration, Column, Edge, Level, Mass, Speed, Time, Turn};

/// Groups of [`smooth::functions`], in their order.
const OF_SMOOTH: [Group; 40] = [
    Level,
    Level,
    Level,
    Speed,
    Speed,
    Speed,
    Speed,
    Speed,
    Speed,
    Turn,
    Turn,
    Turn,
    Turn,
    Turn,
    Turn,
    Turn,
    Turn,
    Turn,
    Turn,
    Turn,
    Turn,
    Acceleration,
    Acceleration,
    Acceleration,
    Acceleration,
    Acceleration,
    Mass,
    Mass,
    Mass,
    Mass,
    Time,
    Time,
    Time,
    Time,
    Time,
    Time,
    Time,
    Time,
    Turn,
    Acceleration,
];

/// The functions with the group of each; `power` is what the base predicts. In `anywhere` every run
/// may have effects, the clean ones too.
pub fn functions<'a>(
    runs: &Runs,
    anywhere: &Predicted<'_>,
    start_of: impl Fn(usize) -> &'a State + Sync,
    power: &Signal,
    list: &[Candidate],
) -> Vec<(Signal, Group)> {
    let smooth = smooth::functions(runs);
    let (of_motion, further) = smooth.split_at(smooth::count_of_motion(runs, &smooth));
    let mut functions: Vec<(Signal, Group)> = of_motion.iter().cloned().zip(OF_SMOOTH).collect();
    let shown = |signals: Vec<Signal>| smooth::shown_by_clean(runs, signals);
    functions.extend(shown(further.to_vec()).into_iter().map(|signal| (signal, Column)));
    functions.extend(edges(runs, power).into_iter().map(|signal| (signal, Edge)));
    let is_column =
        |regressor: &Regressor| matches!(regressor, Regressor::Column(_) | Regressor::Temperature(..));
    let all = list.iter().flat_map(|candidate| &candidate.regressors);
    let regressors: Vec<Regressor> = all.filter(|regressor| !is_column(regressor)).cloned().collect();
    let mut slopes: Vec<Vec<Vec<f64>>> = (0..power.len())
        .into_par_iter()
        .map(|run| anywhere.slopes(run, start_of(run), &regressors))
        .collect();
    let of_drive = functions.len();
    for (place, regressor) in regressors.iter().enumerate() {
        let signal: Signal = slopes.iter_mut().map(|run| std::mem::take(&mut run[place])).collect();
        match regressor {
            Regressor::Term(Term::GradeByPitch) => {
                functions.extend(shown(vec![signal]).into_iter().map(|signal| (signal, Column)));
            }
            _ => {
                let group = most_like(&signal, &functions[..of_drive]);
                functions.push((signal, group));
            }
        }
    }
    functions
}

/// The group of the function to which a signal is most in proportion: it varies like that one.
fn most_like(signal: &Signal, functions: &[(Signal, Group)]) -> Group {
    let product = |a: &Signal, b: &Signal| -> f64 {
        a.iter().zip(b).flat_map(|(a, b)| a.iter().zip(b)).map(|(a, b)| a * b).sum()
    };
    let likeness = |function: &Signal| {
        product(signal, function).abs() / product(function, function).sqrt().max(f64::MIN_POSITIVE)
    };
    let each = functions.iter().map(|(function, group)| (likeness(function), *group));
    each.max_by(|a, b| a.0.total_cmp(&b.0)).map_or(Level, |best| best.1)
}

/// Changes of the predicted power: what filters, and rates of the sensors, get wrong.
fn edges(runs: &Runs, power: &Signal) -> Vec<Signal> {
    let mean = |run: usize| {
        let rows = &runs.runs[run].rows;
        rows.iter().map(|row| row.mass).sum::<f64>() / rows.len().max(1) as f64
    };
    let slope = |at: &dyn Fn(isize) -> f64, t: isize| 0.5 * (at(t + 1) - at(t - 1));
    let bend = |at: &dyn Fn(isize) -> f64, t: isize| at(t + 1) - 2.0 * at(t) + at(t - 1);
    let mut signals: Vec<Signal> = vec![Vec::new(); 5];
    for (run, power) in power.iter().enumerate() {
        let last = power.len() as isize - 1;
        let at = |t: isize| power[t.clamp(0, last) as usize];
        let mass = mean(run);
        let of = |make: &dyn Fn(isize) -> f64| (0..=last).map(make).collect::<Vec<f64>>();
        let of_run = [
            of(&|t| bend(&at, t)),
            of(&|t| bend(&at, t) * mass),
            of(&|t| slope(&at, t).abs()),
            of(&|t| slope(&at, t) * mass),
            of(&|t| 0.5 * (bend(&at, t + 1) - bend(&at, t - 1))),
        ];
        for (signal, values) in signals.iter_mut().zip(of_run) {
            signal.push(values);
        }
    }
    signals
}
