//! Runs in memory: conditioned as the board does it, thinned to some twenty rows a second, with
//! every further column. Which of them are looked at (open, locked, clean) is a view: rows and
//! columns are shared, never copied.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use model_core::filter::{Channel, LowPass};
use support::context::Context;
use support::error::{Error, Result};

use super::conditioned;
use super::conditioner::Conditioner;
use super::motions::Step;
use super::raw;
pub use super::raw::RawRun;
pub use super::row::{Row, Run};
use super::shared::Shared;
use crate::robot::Robot;
use crate::robot::chassis::Chassis;

/// Rows a second that are kept, at most about.
const ROWS_PER_S: f64 = 20.0;

/// Rows that are kept per period of the filter's cutoff: more of them repeat each other, and the
/// band above the cutoff holds nothing but what the model of filtered signals gets wrong.
pub const ROWS_PER_CUTOFF: f64 = 3.0;

/// Rows a second that are kept at least, where the log has them: interpolating a delay needs them.
const LEAST_ROWS_PER_S: f64 = 8.0;

/// Sample periods of two runs that differ by more than this share are different.
const SAME_PERIOD: f64 = 0.1;

/// Most cutoff of the filter that speeds pass where the model is asked [before](Rows::Before) the
/// filter of the power, as a share of the rows a second. Chosen: below the 0.45 that a filter takes.
const CUTOFF_PER_ROW: f64 = 0.35;

/// By how much that filter is faster than that of the power: what it gets wrong of a product of
/// signals goes with the square of this, a fifth. Tuned on verdicts: of 48 sets of the second
/// simulator at 20 Hz, 2.3, 2.8 and 3.5 name 40, 41 and 41 rightly, at 10 Hz 2.3 and 3.5 name 32 and
/// 31; a Husky's logs of 6.5 Hz tell two floors apart up to 2.3, and not at 3.5.
const FASTER: f64 = 2.25;

/// Where in the filter the rows are that are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rows {
    /// Behind it, as a board has them: the model is asked of filtered speeds.
    Behind,
    /// Before it: speeds pass a filter that is several times as fast, and what the model makes of
    /// them passes the power's own filter, as the power itself does ([`Runs::smoothed`]). Where a
    /// wheel starts within a fraction of a second, the model of filtered speeds is off by more than
    /// the noise, and by another amount in each run.
    Before,
}

/// Cutoffs, Hz.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cutoffs {
    /// Of the filter that the speeds pass before the model.
    pub speed: f64,
    /// Of the filter that the power has passed.
    pub power: f64,
}

impl Rows {
    /// Of a robot whose filter has this cutoff, Hz.
    fn cutoffs(self, period_s: f64, cutoff_hz: f64) -> Cutoffs {
        match self {
            Self::Behind => Cutoffs { speed: cutoff_hz, power: cutoff_hz },
            Self::Before => {
                let fastest = CUTOFF_PER_ROW * period_s.recip().min(ROWS_PER_S);
                let power = cutoff_hz.min(fastest / FASTER);
                Cutoffs { speed: FASTER * power, power }
            }
        }
    }

    /// Rows of a log of which one is kept; periods of logs differ by [`SAME_PERIOD`].
    fn stride(self, period_s: f64, cutoff_hz: f64) -> usize {
        let rate = (ROWS_PER_CUTOFF * cutoff_hz).clamp(LEAST_ROWS_PER_S, ROWS_PER_S);
        let stride = 1.0 / (period_s * rate);
        let whole = match self {
            Self::Behind => stride.round(),
            Self::Before => (stride + SAME_PERIOD).floor(),
        };
        whole.max(1.0) as usize
    }
}

/// All runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Runs {
    /// The robot, with the filter's cutoff.
    pub robot: Chassis,
    /// Names of further columns.
    pub columns: Vec<String>,
    /// The runs.
    pub runs: Vec<Run>,
    /// Time between rows, s.
    pub period_s: f64,
    /// How the filter of the speeds shows what is switched.
    pub step: Step,
    /// What speeds and power have passed.
    pub cutoffs: Cutoffs,
    /// The filter that power passes after the model, where rows are [before](Rows::Before) it.
    pub smoothing: Option<LowPass<f64>>,
}

impl Runs {
    /// Reads the logs of a robot; each value of a `run` column is a run.
    ///
    /// # Errors
    /// A log that cannot be read or is not one of this robot; runs of different sample rates; a run
    /// too short for the filter.
    pub fn read(
        context: &Context,
        robot: &Robot,
        chassis: &Chassis,
        files: &[PathBuf],
        mass_kg: f64,
    ) -> Result<Self> {
        Self::read_with(context, robot, chassis, files, mass_kg, &[])
    }

    /// As [`read`](Self::read), with further columns that are powers (`…_w`), where a log has them.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn read_with(
        context: &Context,
        robot: &Robot,
        chassis: &Chassis,
        files: &[PathBuf],
        mass_kg: f64,
        powers: &[String],
    ) -> Result<Self> {
        Self::condition(chassis, Self::raw(context, robot, files, mass_kg, powers)?)
    }

    /// The logs as recorded, before any filter.
    ///
    /// # Errors
    /// A log that cannot be read or is not one of this robot.
    pub fn raw(
        context: &Context,
        robot: &Robot,
        files: &[PathBuf],
        mass_kg: f64,
        powers: &[String],
    ) -> Result<Vec<RawRun>> {
        raw::read(context, robot, files, mass_kg, powers)
    }

    /// Conditions runs as recorded, with the rows [behind](Rows::Behind) the filter.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn condition(chassis: &Chassis, raw: Vec<RawRun>) -> Result<Self> {
        Self::condition_to(chassis, raw, Rows::Behind)
    }

    /// Conditions runs as recorded.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn condition_to(chassis: &Chassis, raw: Vec<RawRun>, rows: Rows) -> Result<Self> {
        let first = first(&raw)?;
        // A log that is too slow for the robot's filter is refused, whichever filter it passes here.
        Conditioner::of_log(chassis, Path::new(&first.name), first.period_s)?;
        let cutoffs = rows.cutoffs(first.period_s, chassis.cutoff_hz());
        let stride = rows.stride(first.period_s, cutoffs.speed);
        Self::conditioned(chassis, raw, cutoffs, stride)
    }

    /// Conditions further runs as these are, with rows as far apart.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn condition_alike(&self, chassis: &Chassis, raw: Vec<RawRun>) -> Result<Self> {
        let first = first(&raw)?;
        let stride = (self.period_s / first.period_s).round().max(1.0) as usize;
        Self::conditioned(chassis, raw, self.cutoffs, stride)
    }

    fn conditioned(chassis: &Chassis, raw: Vec<RawRun>, cutoffs: Cutoffs, stride: usize) -> Result<Self> {
        let mut columns: Vec<String> = Vec::new();
        let mut seen: HashSet<&str> = HashSet::new();
        for name in raw.iter().flat_map(|run| &run.columns) {
            if seen.insert(name) {
                columns.push(name.clone());
            }
        }
        let first = first(&raw)?;
        let (first_name, period) = (first.name.clone(), first.period_s);
        let Cutoffs { speed, power } = cutoffs;
        let fast = chassis.with_cutoff(speed);
        let row_period = period * stride as f64;
        let smoothing = (power < speed).then(|| conditioned::filter(power, row_period, &first_name));
        let smoothing = smoothing.transpose()?;
        let mut runs = Vec::new();
        for run in raw {
            if (run.period_s / period - 1.0).abs() > SAME_PERIOD {
                return Err(Error::failed(format!(
                    "sampled at {:.2} Hz, but {first_name} at {:.2} Hz; expected runs of one sample rate",
                    1.0 / run.period_s,
                    1.0 / period
                ))
                .in_file(&run.name));
            }
            let run = conditioned::condition(&fast, run, &columns, stride)?;
            runs.push(match &smoothing {
                Some(filter) => with_smooth_power(filter, run),
                None => run,
            });
        }
        Ok(Self {
            robot: chassis.clone(),
            columns,
            runs,
            period_s: row_period,
            step: Step::new(&conditioned::filter(speed, period, &first_name)?, period),
            cutoffs,
            smoothing,
        })
    }

    /// What the filter of the power makes of values of one run, a row each.
    pub fn smoothed(&self, run: &Run, values: Vec<f64>) -> Vec<f64> {
        match &self.smoothing {
            Some(filter) => smooth(filter, run, values),
            None => values,
        }
    }

    /// Whether rows are as far apart as those of others, nearly.
    pub fn is_as_fast_as(&self, others: &Self) -> bool {
        (self.period_s / others.period_s - 1.0).abs() <= SAME_PERIOD
    }

    /// A view of the runs at these places.
    #[must_use]
    pub fn subset(&self, places: &[usize]) -> Self {
        let runs = places.iter().map(|&place| self.runs[place].clone()).collect();
        Self {
            robot: self.robot.clone(),
            columns: self.columns.clone(),
            runs,
            period_s: self.period_s,
            step: self.step.clone(),
            cutoffs: self.cutoffs,
            smoothing: self.smoothing,
        }
    }

    /// A view of these runs, and behind them the clean ones of the base.
    #[must_use]
    pub fn with_clean(&self, clean: Option<&Self>) -> Self {
        let Some(clean) = clean else { return self.clone() };
        let mut all = self.followed_by(clean);
        for run in &mut all.runs[self.runs.len()..] {
            run.clean = true;
        }
        all
    }

    /// A view of these runs, and behind them others with the same columns: empty where those lack
    /// one.
    #[must_use]
    pub fn followed_by(&self, others: &Self) -> Self {
        let mut all = self.clone();
        let of_others: HashMap<&str, usize> = others.columns.iter().map(String::as_str).zip(0..).collect();
        let places: Vec<Option<usize>> =
            self.columns.iter().map(|name| of_others.get(name.as_str()).copied()).collect();
        for run in &others.runs {
            let extras = places
                .iter()
                .map(|place| place.map_or_else(Shared::default, |place| run.extras[place].clone()));
            all.runs.push(Run { extras: extras.collect(), ..run.clone() });
        }
        all
    }

    /// Place of a further column that every run has.
    pub fn column(&self, name: &str) -> Option<usize> {
        let place = self.columns.iter().position(|column| column == name)?;
        self.runs.iter().all(|run| !run.extras[place].is_empty()).then_some(place)
    }
}

/// Each piece of a run through a filter, as if its first value had been there for ever.
fn smooth(filter: &LowPass<f64>, run: &Run, mut values: Vec<f64>) -> Vec<f64> {
    let mut channel = Channel::default();
    for (row, value) in run.rows.iter().zip(&mut values) {
        if row.starts {
            filter.settle(&mut channel, *value);
        }
        *value = filter.step(&mut channel, *value).value;
    }
    values
}

fn with_smooth_power(filter: &LowPass<f64>, run: Run) -> Run {
    let power = smooth(filter, &run, run.rows.iter().map(|row| row.power).collect());
    let rows = run.rows.iter().zip(power).map(|(row, power)| Row { power, ..*row }).collect();
    Run { rows, ..run }
}

/// The run whose sample rate all others have.
fn first(raw: &[RawRun]) -> Result<&RawRun> {
    raw.first().ok_or_else(|| Error::usage("no log was given"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RawSample;

    fn runs(columns: &[&str]) -> Runs {
        let burger = Robot::named("burger").unwrap().chassis(2.0).unwrap();
        let sample = |i: usize| RawSample {
            wheel_speed: [3.0 + (0.05 * i as f64).sin(), 2.0].into(),
            wheel_acceleration: None,
            power: 1.0,
        };
        let row =
            |i: usize| (0.05 * i as f64, sample(i), 2.0, (1..=columns.len()).map(|k| k as f64).collect());
        let raw = RawRun {
            name: "run".to_owned(),
            rows: (0..400).map(row).collect(),
            columns: columns.iter().map(|name| (*name).to_owned()).collect(),
            period_s: 0.05,
        };
        Runs::condition(&burger, vec![raw]).unwrap()
    }

    #[test]
    fn rows_are_kept_about_or_at_least_as_wanted() {
        let strides = |rows: Rows| [4.0, 2.0, 1.0].map(|cutoff_hz| rows.stride(0.05, cutoff_hz));
        assert_eq!([strides(Rows::Behind), strides(Rows::Before)], [[2, 3, 3], [1, 2, 2]]);
        // A log of 99 samples a second is thinned as one of 100 is.
        assert_eq!([0.01, 1.0 / 99.0].map(|period| Rows::Before.stride(period, 10.0)), [5, 5]);
    }

    /// A filter of the power that a log has rows for, and one of the speeds that is faster.
    #[test]
    fn the_filter_before_the_model_is_the_faster_one() {
        let cutoffs = |rate: f64, cutoff_hz| Rows::Before.cutoffs(rate.recip(), cutoff_hz);
        assert_eq!(cutoffs(50.0, 1.0), Cutoffs { speed: 2.25, power: 1.0 });
        for (rate, cutoff_hz, speed) in [(20.0, 5.0, 7.0), (500.0, 5.0, 7.0), (10.0, 4.0, 3.5)] {
            let cutoffs = cutoffs(rate, cutoff_hz);
            assert!((cutoffs.speed - speed).abs() < 1e-9, "{cutoffs:?}");
            assert!((cutoffs.power - speed / 2.25).abs() < 1e-9, "{cutoffs:?}");
        }
    }

    /// Power and what is asked of the rows pass the same filter.
    #[test]
    fn power_before_the_filter_passes_it_too() {
        let burger = Robot::named("burger").unwrap().chassis(2.0).unwrap();
        let sample = |i: usize| {
            let speed = if i < 200 { 0.0 } else { 3.0 };
            RawSample { wheel_speed: [speed, speed].into(), wheel_acceleration: None, power: 2.0 * speed }
        };
        let raw = RawRun {
            name: "run".to_owned(),
            rows: (0..400).map(|i| (0.05 * i as f64, sample(i), 2.0, Vec::new())).collect(),
            columns: Vec::new(),
            period_s: 0.05,
        };
        let runs = Runs::condition_to(&burger, vec![raw], Rows::Before).unwrap();
        let run = &runs.runs[0];
        let asked: Vec<f64> = run.rows.iter().map(|row| 2.0 * row.wheels[0].speed).collect();
        let first = asked.iter().position(|power| *power > 3.0).unwrap();
        let smooth = runs.smoothed(run, asked.clone());
        assert!(run.rows[first].power < 0.5 * asked[first], "{}", run.rows[first].power);
        for (row, smooth) in run.rows.iter().zip(&smooth) {
            assert!((row.power - smooth).abs() < 1e-9, "{}: {} {smooth}", row.time, row.power);
        }
    }

    /// Runs that follow keep the columns that the first have, at their places, and lack the others;
    /// nothing is copied.
    #[test]
    fn what_follows_has_the_columns_of_what_goes_before() {
        let (field, other) = (runs(&["a", "b"]), runs(&["c", "b"]));
        let all = field.followed_by(&other).followed_by(&runs(&[]));
        assert!(all.runs.iter().all(|run| run.extras.len() == 2));
        assert!(all.runs[1].extra(0).is_empty() && !all.runs[1].clean);
        assert_eq!(all.runs[1].extra(1)[0], 2.0);
        assert!(all.runs[2].extra(0).is_empty() && all.runs[2].extra(1).is_empty());
        assert_eq!(
            (all.column("a"), all.column("b"), all.subset(&[0, 1]).column("b")),
            (None, None, Some(1))
        );
        let view = field.subset(&[0]).with_clean(Some(&other));
        assert!(view.runs[1].clean && !view.runs[0].clean);
        assert!(std::ptr::eq(&raw const view.runs[1].rows[0], &raw const other.runs[0].rows[0]));
    }
}
