//! What the board estimated while it was recorded, beside the replay of the same samples and beside
//! the truth.

use std::path::Path;

use logs::{ColumnRequest, Header, LogReader, Role, TIME};
use serde::Serialize;
use support::context::Context;
use support::error::Result;
use support::metrics::{Metrics, Quality};

use super::{Change, Instant};

/// The board's columns of a recorded log.
const COLUMNS: [&str; 4] = ["board_power_w", "board_mass_kg", "board_mass_low_kg", "board_mass_high_kg"];

/// A mass counts as settled so long after it changed, s: the window that the board estimates over.
const SETTLED_S: f64 = 25.0;

/// Times this close are the same: logs have microseconds.
const SAME_S: f64 = 1e-7;

/// How far the board's numbers stray from the replay's, and how good they are.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub struct BoardReport {
    /// Samples for which the board gave a power.
    pub samples: u64,
    /// Samples for which one of the two knew the mass and the other did not.
    pub disagreements: u64,
    /// Largest difference of the masses, relative to the replay's.
    pub mass_difference: f64,
    /// Largest difference of the predicted powers, W.
    pub power_difference_w: f64,
    /// Largest predicted power of the replay, W: what the difference is to be held against.
    pub largest_power_w: f64,
    /// The board's power against the measured one, both behind the filter.
    pub quality: Option<Quality>,
    /// The board's mass against the true one.
    pub mass: Option<MassAgainstTruth>,
}

/// Errors of the board's mass, from a window after each change of the true one.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub struct MassAgainstTruth {
    /// Samples.
    pub samples: u64,
    /// Mean |m̂ − m| / m, %.
    pub mean_percent: f64,
    /// Its largest, %.
    pub worst_percent: f64,
    /// Share of the samples whose interval holds the true mass.
    pub interval_contains_truth: f64,
}

/// Reads the board's columns, and the truth, in step with the replay.
pub struct BoardTrack {
    log: Option<Columns<4>>,
    truth: Option<Columns<1>>,
    report: BoardReport,
    metrics: Metrics,
    mass_since: Option<(f64, f64)>,
    errors: f64,
    inside: u64,
}

impl BoardTrack {
    /// For a log, with the truth of a virtual robot where there is one.
    ///
    /// # Errors
    /// A file cannot be read, or the truth has no mass.
    pub fn open(context: &Context, log: &Path, truth: Option<&Path>, mape_floor_w: f64) -> Result<Self> {
        let is_recorded = Header::open(context, log)?.has(COLUMNS[0]);
        let log = is_recorded.then(|| Columns::open(context, log, COLUMNS, false)).transpose()?;
        let truth = truth.map(|truth| Columns::open(context, truth, [logs::MASS], true)).transpose()?;
        Ok(Self {
            log,
            truth,
            report: BoardReport::default(),
            metrics: Metrics::new(mape_floor_w),
            mass_since: None,
            errors: 0.0,
            inside: 0,
        })
    }

    /// One instant of the replay, in order of time; gives it back with the true mass, where that is
    /// known.
    ///
    /// # Errors
    /// A file cannot be read on.
    pub fn add(&mut self, instant: &Instant) -> Result<Instant> {
        let mut instant = *instant;
        if let Some(truth) = &mut self.truth
            && let Some([mass]) = truth.as_of(instant.time_s)?
        {
            instant.truth_kg = Some(mass);
            if self.mass_since.is_none_or(|(before, _)| before != mass) {
                self.mass_since = Some((mass, instant.time_s));
            }
        }
        if let Some(log) = &mut self.log
            && let Some(board) = log.at(instant.time_s)?
        {
            self.compare(&instant, board);
        }
        Ok(instant)
    }

    fn compare(&mut self, replay: &Instant, [power, mass, low, high]: [f64; 4]) {
        let report = &mut self.report;
        if replay.mass_kg.is_some() != mass.is_finite() {
            report.disagreements += 1;
        }
        if let Some(expected) = replay.mass_kg
            && mass.is_finite()
        {
            report.mass_difference = report.mass_difference.max((mass / expected - 1.0).abs());
        }
        if power.is_finite() {
            report.samples += 1;
            self.metrics.add(replay.measured_w, power);
            if let Some(expected) = replay.predicted_w {
                report.power_difference_w = report.power_difference_w.max((power - expected).abs());
                report.largest_power_w = report.largest_power_w.max(expected);
            }
        }
        if let (Some((truth, since)), Some(_)) = (self.mass_since, replay.truth_kg)
            && replay.time_s - since >= SETTLED_S
            && mass.is_finite()
        {
            let error = 100.0 * (mass / truth - 1.0).abs();
            let against = report.mass.get_or_insert_default();
            against.samples += 1;
            against.worst_percent = against.worst_percent.max(error);
            self.errors += error;
            self.inside += u64::from(low <= truth && truth <= high);
        }
    }

    /// The figures; `None` for a log that holds no estimate of a board.
    pub fn report(self) -> Option<BoardReport> {
        self.log.as_ref()?;
        let mut report = BoardReport { quality: self.metrics.quality(), ..self.report };
        if let Some(mass) = &mut report.mass {
            let samples = mass.samples as f64;
            mass.mean_percent = self.errors / samples;
            mass.interval_contains_truth = self.inside as f64 / samples;
        }
        Some(report)
    }
}

/// Times at which the true mass changed, s, and how long each took to be noticed, where it was.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Delay {
    /// When the true mass changed, s.
    pub time_s: f64,
    /// From then until the estimator noticed, s.
    pub delay_s: Option<f64>,
}

/// Changes of the true mass within a replay, each with the first notice before the next.
///
/// # Errors
/// The truth cannot be read.
pub fn delays(
    context: &Context,
    truth: &Path,
    from_s: f64,
    to_s: f64,
    noticed: &[Change],
) -> Result<Vec<Delay>> {
    let mut columns = Columns::open(context, truth, [logs::MASS], true)?;
    let mut before = None;
    let mut times = Vec::new();
    while let Some((time, [mass])) = columns.advance()? {
        let changed = before.replace(mass).is_some_and(|before| before != mass);
        if changed && time > from_s && time < to_s {
            times.push(time);
        }
    }
    let ends = times.iter().skip(1).copied().chain([f64::INFINITY]);
    let delay = |(time_s, end): (&f64, f64)| {
        let heard = noticed.iter().map(|change| change.noticed_s).find(|at| at >= time_s && *at < end);
        Delay { time_s: *time_s, delay_s: heard.map(|at| at - time_s) }
    };
    Ok(times.iter().zip(ends).map(delay).collect())
}

/// Some columns of a log by time.
struct Columns<const K: usize> {
    reader: LogReader,
    /// The row reached.
    row: Option<(f64, [f64; K])>,
    /// The one behind it, where it has been read.
    ahead: Option<(f64, [f64; K])>,
}

impl<const K: usize> Columns<K> {
    fn open(context: &Context, path: &Path, names: [&str; K], required: bool) -> Result<Self> {
        let mut requests = vec![ColumnRequest::required(TIME, Role::Time)];
        requests.extend(names.map(|name| {
            if required {
                ColumnRequest::required(name, Role::Number)
            } else {
                ColumnRequest::optional(name, Role::MaybeNumber)
            }
        }));
        let mut columns = Self { reader: LogReader::open(context, path, &requests)?, row: None, ahead: None };
        columns.ahead = columns.read()?;
        Ok(columns)
    }

    /// The next row, in order.
    fn advance(&mut self) -> Result<Option<(f64, [f64; K])>> {
        let row = self.ahead.take();
        if row.is_some() {
            self.ahead = self.read()?;
        }
        Ok(row)
    }

    fn read(&mut self) -> Result<Option<(f64, [f64; K])>> {
        let mut row = vec![0.0; K + 1];
        if self.reader.next_row(&mut row)?.is_none() {
            return Ok(None);
        }
        Ok(Some((row[0], std::array::from_fn(|index| row[index + 1]))))
    }

    /// The last row not later than this; times have to increase.
    fn as_of(&mut self, time: f64) -> Result<Option<[f64; K]>> {
        while let Some((ahead, _)) = self.ahead
            && ahead <= time + SAME_S
        {
            self.row = self.advance()?;
        }
        Ok(self.row.map(|(_, row)| row))
    }

    /// The row of this very time.
    fn at(&mut self, time: f64) -> Result<Option<[f64; K]>> {
        let row = self.as_of(time)?;
        Ok(row.filter(|_| self.row.is_some_and(|(at, _)| (at - time).abs() <= SAME_S)))
    }
}

#[cfg(test)]
mod tests {
    use std::fs::write;

    use super::*;

    fn instant(time_s: f64, mass_kg: Option<f64>) -> Instant {
        Instant {
            time_s,
            measured_w: 2.0,
            told_w: None,
            predicted_w: Some(2.0),
            mass_kg,
            interval_kg: None,
            truth_kg: None,
        }
    }

    /// By hand: the true mass is 4 kg from 1 s on, so counts from 26 s; there the board says 4.1
    /// kg, 2.5 % too much, and at 27 s 3.9 kg with an interval that begins above.
    #[test]
    fn counts_what_differs_and_what_is_wrong() {
        let folder = tempfile::tempdir().unwrap();
        let (log, truth) = (folder.path().join("run.csv"), folder.path().join("truth.csv"));
        let header = "time_s,board_power_w,board_mass_kg,board_mass_low_kg,board_mass_high_kg";
        let rows = "0.5,,,,\n1,2,3,2,4\n26,2.5,4.1,3.9,4.3\n27,2,3.9,4.05,4.1\n";
        write(&log, format!("{header}\n{rows}")).unwrap();
        write(&truth, "time_s,mass_kg\n0.4,3\n1,4\n2,4\n25.9,4\n").unwrap();
        let mut track = BoardTrack::open(&Context::default(), &log, Some(&truth), 0.1).unwrap();
        // A sample that the replay has and the board has not changes nothing.
        for (time, mass) in
            [(0.5, Some(3.0)), (1.0, Some(3.0)), (1.5, None), (26.0, Some(4.1)), (27.0, Some(3.0))]
        {
            track.add(&instant(time, mass)).unwrap();
        }
        let report = track.report().unwrap();
        assert_eq!((report.samples, report.disagreements), (3, 1));
        assert!((report.mass_difference - 0.3).abs() < 1e-12, "{report:?}");
        assert!((report.power_difference_w - 0.5).abs() < 1e-12, "{report:?}");
        // Mean of 0, 25 and 0 %.
        assert!((report.quality.unwrap().mape_percent.unwrap() - 25.0 / 3.0).abs() < 1e-9);
        let mass = report.mass.unwrap();
        assert_eq!((mass.samples, mass.interval_contains_truth), (2, 0.5));
        assert!(
            (mass.worst_percent - 2.5).abs() < 1e-9 && (mass.mean_percent - 2.5).abs() < 1e-9,
            "{mass:?}"
        );

        let noticed = [Change { time_s: 0.9, noticed_s: 3.5 }];
        let changes = delays(&Context::default(), &truth, 0.5, 27.0, &noticed).unwrap();
        assert_eq!(changes, [Delay { time_s: 1.0, delay_s: Some(2.5) }]);
        assert_eq!(
            delays(&Context::default(), &truth, 0.5, 27.0, &[]).unwrap(),
            [Delay { time_s: 1.0, delay_s: None }]
        );
    }

    #[test]
    fn a_log_of_no_board_has_no_report() {
        let folder = tempfile::tempdir().unwrap();
        let log = folder.path().join("run.csv");
        write(&log, "time_s,wheel1_rad_s,power_w\n0,1,2\n1,1,2\n").unwrap();
        let mut track = BoardTrack::open(&Context::default(), &log, None, 0.1).unwrap();
        track.add(&instant(0.0, None)).unwrap();
        assert!(track.report().is_none());
    }
}
