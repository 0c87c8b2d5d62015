//! Replays a log through model-core's estimator, as the board would run it.

mod answer;
pub mod board;
mod outside;
pub mod plot;
mod told;

use std::path::Path;

use logs::robot::Robot;
use logs::{Conditioner, Exclusions, Header, NO_GYRO, RawRow, SampleReader, YAW_RATE};
use model::coefficients::{FittedModel, GROUND_NEEDS};
use model::pipeline::{Estimated, adapting, reason_text};
pub use model::pipeline::{GroundAt, Payloads, Pipeline, bucket_length, fitted};
use model_core::adapt::Ground;
use model_core::estimator::{Timing, Unfit};
use model_core::model::Model;
use model_core::payload::schedule::Schedule;
use model_core::payload::{MassEstimate, Place};
use serde::Serialize;
use support::context::Context;
use support::error::{Error, Result};
use support::metrics::{Metrics, Quality};
use support::progress::FileProgress;

pub use answer::{Answer, MassError, Request, estimate};
use outside::Columns;
use told::Telling;
pub use told::Told;

/// When the mass is found (Algorithm 2), lengths in s.
#[derive(Debug, Clone, PartialEq)]
pub struct Policy {
    /// Length of the window, s.
    pub window_s: f64,
    /// Moving, cumulative, periodic or after known changes.
    pub kind: PolicyKind,
    /// Known times of payload changes, s since the first row.
    pub changes_s: Vec<f64>,
    /// Restart when the payload seems to have changed.
    pub detect: bool,
}

/// Which of Algorithm 2's policies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PolicyKind {
    /// The latest window, at every second.
    Moving,
    /// All since the last known change.
    Cumulative,
    /// The first window after a known change.
    Known,
    /// The first window of every round of so many seconds.
    Periodic(f64),
}

/// The mass over one window.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct WindowMass {
    /// Start and end since the log's time 0, s.
    pub t0_s: f64,
    /// Start and end since the log's time 0, s.
    pub t1_s: f64,
    /// Total mass, kg; null where it is unknown.
    pub mass_kg: Option<f64>,
    /// 95 % interval, kg.
    pub low_kg: Option<f64>,
    /// 95 % interval, kg.
    pub high_kg: Option<f64>,
    /// Where the mass lies, seen from the robot's range: within, below or above; beyond it
    /// `mass_kg` is the nearest end.
    pub range: Option<&'static str>,
    /// Why the mass is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unknown: Option<&'static str>,
    /// True mass over the whole window, where the log tells it and it stays the same, kg.
    #[serde(skip)]
    pub truth_kg: Option<f64>,
}

/// A noticed change of payload.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Change {
    /// When it happened, by the estimator, s.
    pub time_s: f64,
    /// When it was noticed, s.
    pub noticed_s: f64,
}

/// What was known after one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instant {
    /// Time, s.
    pub time_s: f64,
    /// Filtered actuation power, W.
    pub measured_w: f64,
    /// P̂_act, W, while the mass is known.
    pub predicted_w: Option<f64>,
    /// The same at the mass that the log tells, or that was given, W.
    pub told_w: Option<f64>,
    /// The estimator's mass, kg.
    pub mass_kg: Option<f64>,
    /// Its interval, kg.
    pub interval_kg: Option<(f64, f64)>,
    /// True mass, where the log tells it, kg.
    pub truth_kg: Option<f64>,
}

/// A replayed log.
#[derive(Debug, Clone)]
pub struct Replay {
    /// One entry a second from the first full window on; where the schedule holds a mass, one a
    /// window.
    pub windows: Vec<WindowMass>,
    /// Payload changes noticed.
    pub changes: Vec<Change>,
    /// The floor, second by second, where it adapts; else empty.
    pub ground: Vec<GroundAt>,
    /// P̂ with the estimator's own mass against the measured power.
    pub quality: Option<Quality>,
    /// P̂ at the mass that the log tells, or that was given; none where neither is.
    pub told: Option<Told>,
    /// Share of the settled samples for which the mass was known.
    pub known_share: f64,
    /// Energy drawn, static power included, J; less what returns where drives return it.
    pub energy_j: f64,
    /// Actuation energy by the model while the mass was known, J.
    pub predicted_j: f64,
    /// Time of the first row, s.
    pub start_s: f64,
    /// Length of the log, s.
    pub duration_s: f64,
    /// Rows read.
    pub rows: u64,
    /// Rows left out.
    pub exclusions: Exclusions,
}

/// A log, and what its robot weighed where that is known beside it.
#[derive(Debug, Clone, Copy)]
pub struct Recorded<'a> {
    /// The log.
    pub file: &'a Path,
    /// Total mass, kg: power and energy at it are given beside, instead of those at the mass that
    /// the log tells.
    pub mass_kg: Option<f64>,
}

/// Replays a log. `watch` sees every settled sample.
///
/// # Errors
/// The log cannot be read or is not one of this robot; the policy's lengths do not fit.
pub fn replay(
    context: &Context,
    robot: &Robot,
    coefficients: &FittedModel,
    file: &Path,
    payloads: Payloads,
    policy: &Policy,
    watch: &mut dyn FnMut(&Instant),
) -> Result<Replay> {
    replay_at(context, robot, coefficients, &Recorded { file, mass_kg: None }, payloads, policy, watch)
}

/// As [`replay`], with power and energy at the mass that is given with the log beside.
///
/// # Errors
/// As [`replay`].
pub fn replay_at(
    context: &Context,
    robot: &Robot,
    coefficients: &FittedModel,
    recorded: &Recorded<'_>,
    payloads: Payloads,
    policy: &Policy,
    watch: &mut dyn FnMut(&Instant),
) -> Result<Replay> {
    let log = Log::open(context, robot, coefficients, recorded)?;
    let timing = log.timing(policy)?;
    let unfit = |why| Error::failed(unfit_text(why, coefficients)).in_file(recorded.file);
    let pipeline = fitted(coefficients, payloads, &timing).map_err(unfit)?;
    Run::new(coefficients, log, pipeline, policy, robot)?.finish(context, robot, watch)
}

/// As [`replay_at`], rolling resistance and scrub adapting (with a memory of a minute) beside the
/// mass, or at the one that is given.
///
/// # Errors
/// As [`replay`]; coefficients of another model than the signed one, or with effects.
pub fn replay_adapting(
    context: &Context,
    robot: &Robot,
    coefficients: &FittedModel,
    recorded: &Recorded<'_>,
    policy: &Policy,
    watch: &mut dyn FnMut(&Instant),
) -> Result<Replay> {
    if !matches!(coefficients.model, Model::Signed { .. }) || !coefficients.columns.is_empty() {
        return Err(Error::failed(GROUND_NEEDS));
    }
    if coefficients.robot.conditioning().true_slip != 0.0 {
        return Err(Error::failed(NO_TRUE_SLIP));
    }
    let log = Log::open(context, robot, coefficients, recorded)?;
    let timing = log.timing(policy)?;
    let ground = Ground { window: policy.window_s, ..Ground::usual() };
    let unfit = |why| Error::failed(unfit_text(why, coefficients)).in_file(recorded.file);
    let pipeline = adapting(coefficients, &ground, &timing, recorded.mass_kg).map_err(unfit)?;
    Run::new(coefficients, log, pipeline, policy, robot)?.finish(context, robot, watch)
}

/// Why ground does not adapt beside a gyro.
const NO_TRUE_SLIP: &str = "true slip beside ground that adapts, which has no gyro; expected coefficients without: gmr fit --no-gyro";

/// Why this log cannot be replayed with these coefficients.
fn unfit_text(why: Unfit, coefficients: &FittedModel) -> String {
    match why {
        Unfit::Cutoff(cutoff) => {
            format!("cutoff {} Hz; expected below {} Hz", cutoff.cutoff_hz, cutoff.below_hz)
        }
        Unfit::Model => "effects beside model eq18; expected model signed".to_owned(),
        Unfit::Sides => "true slip of a robot that has no two sides".to_owned(),
        Unfit::Delay => format!(
            "delay of {} s; expected at most {} sample periods, as many as a board keeps",
            coefficients.robot.conditioning().delay + coefficients.columns.delay(),
            model_core::delay::FRAMES
        ),
    }
}

/// A log that is replayed.
struct Log<'a> {
    file: &'a Path,
    reader: SampleReader,
    columns: Columns,
    /// Given beside it, kg.
    mass_kg: Option<f64>,
}

impl<'a> Log<'a> {
    fn open(
        context: &Context,
        robot: &Robot,
        coefficients: &FittedModel,
        recorded: &Recorded<'a>,
    ) -> Result<Self> {
        let Recorded { file, mass_kg } = *recorded;
        let columns = Columns::of(context, coefficients, file)?;
        if coefficients.robot.conditioning().true_slip != 0.0 && !Header::open(context, file)?.has(YAW_RATE) {
            return Err(Error::failed(NO_GYRO).in_file(file).in_column(YAW_RATE));
        }
        let reader = SampleReader::open_with(context, file, robot, &columns.names())?;
        // The conditioner's message names file and rate better than the estimator's error could.
        Conditioner::of_log(&coefficients.robot, file, reader.period_s())?;
        Ok(Self { file, reader, columns, mass_kg })
    }

    /// How a policy divides its time.
    fn timing(&self, policy: &Policy) -> Result<Timing> {
        let bucket_s = bucket_length(policy.window_s)?;
        let buckets = |seconds: f64| (seconds / bucket_s).round() as usize;
        let window = buckets(policy.window_s);
        let schedule = match policy.kind {
            PolicyKind::Moving => Schedule::Moving { window },
            PolicyKind::Cumulative => Schedule::Cumulative,
            PolicyKind::Known => Schedule::KnownChange { window },
            PolicyKind::Periodic(every) if every >= policy.window_s => {
                Schedule::Periodic { window, every: buckets(every) }
            }
            PolicyKind::Periodic(every) => {
                return Err(Error::usage(format!(
                    "--every {every}: expected at least the window of {} s",
                    policy.window_s
                )));
            }
        };
        Ok(Timing { period_s: self.reader.period_s(), bucket_s, schedule, detect_changes: policy.detect })
    }
}

struct Run<'a> {
    log: Log<'a>,
    pipeline: Box<dyn Pipeline>,
    telling: Telling,
    policy: &'a Policy,
    bucket_s: f64,
    window_buckets: usize,
}

impl<'a> Run<'a> {
    fn new(
        coefficients: &FittedModel,
        log: Log<'a>,
        pipeline: Box<dyn Pipeline>,
        policy: &'a Policy,
        robot: &Robot,
    ) -> Result<Self> {
        let bucket_s = bucket_length(policy.window_s)?;
        let window_buckets = (policy.window_s / bucket_s).round() as usize;
        let telling = Telling::new(coefficients, log.mass_kg, robot.mape_floor_w());
        Ok(Self { log, pipeline, telling, policy, bucket_s, window_buckets })
    }

    fn finish(mut self, context: &Context, robot: &Robot, watch: &mut dyn FnMut(&Instant)) -> Result<Replay> {
        let mut progress = FileProgress::new(context, &[self.log.file.to_owned()]);
        let mut metrics = Metrics::new(robot.mape_floor_w());
        let mut windows = Vec::new();
        let (mut changes, mut ground) = (Vec::new(), Vec::new());
        let mut truth = Truth::default();
        let (mut settled, mut known) = (0_u64, 0_u64);
        let (mut start, mut last, mut clock) = (f64::NAN, f64::NAN, 0.0);
        let mut pending: Vec<f64> = self.policy.changes_s.clone();
        pending.sort_by(f64::total_cmp);
        let mut pending = pending.into_iter().peekable();
        let (mut energy, mut since) = (0.0, 0.0);
        while let Some(row) = self.log.reader.next_row()? {
            if self.log.reader.rows().is_multiple_of(1 << 16) {
                progress.at(self.log.reader.progress());
            }
            if start.is_nan() {
                start = row.time;
            }
            let mut is_another = false;
            if row.elapsed.is_infinite() && row.run > 0 {
                // Another run: nothing is known of its payload.
                self.pipeline.restart();
                is_another = true;
            }
            while pending.peek().is_some_and(|change| row.time - start >= *change) {
                pending.next();
                self.pipeline.payload_changed();
                is_another = true;
            }
            // The first row of a run has no step before it.
            let step = if row.elapsed.is_finite() { row.elapsed } else { 0.0 };
            let elapsed = if row.elapsed.is_finite() || row.run == 0 { step } else { f64::MAX };
            let beside = self.log.columns.beside(self.log.reader.extras());
            self.pipeline.turn(row.yaw_rate);
            let estimate = self.pipeline.push(&row.sample, &beside, elapsed);
            clock += step;
            if is_another {
                since = clock;
            }
            energy += robot.static_power_w().unwrap_or(0.0) * step;
            truth.note(clock, row.mass);
            if let Some(ago) = estimate.changed {
                changes.push(Change {
                    time_s: (row.time - ago as f64 * self.bucket_s).max(start),
                    noticed_s: row.time,
                });
            }
            let told_w = self.telling.add(&*self.pipeline, &row, &estimate, step);
            if let Some(instant) = instant(&row, &estimate) {
                let instant = Instant { told_w, ..instant };
                settled += 1;
                if let Some(predicted) = instant.predicted_w {
                    known += 1;
                    metrics.add(instant.measured_w, predicted);
                }
                watch(&instant);
            }
            last = row.time;
            if estimate.closed && at_second(clock, self.log.reader.period_s()) {
                let window = self.window(clock, since, estimate.mass);
                windows.extend(window.map(|(times, mass)| mass_over(times, start, mass, &truth)));
                ground.extend(self.pipeline.ground(row.time));
            }
        }
        progress.finish();
        let told = self.policy.changes_s.iter().map(|change| start + change);
        let times: Vec<f64> = changes.iter().map(|change| change.time_s).chain(told).collect();
        blank_straddling(&mut windows, &times);
        let (measured, predicted) = self.pipeline.energy();
        Ok(Replay {
            windows,
            changes,
            ground,
            quality: metrics.quality(),
            told: self.telling.finish(),
            known_share: known as f64 / settled.max(1) as f64,
            energy_j: measured + energy,
            predicted_j: predicted,
            start_s: start,
            duration_s: last - start,
            rows: self.log.reader.rows(),
            exclusions: self.log.reader.exclusions(),
        })
    }

    /// The window that the schedule ends now, from when to when (s on the replay's clock), and the
    /// mass over it. The last known change was at `since`.
    fn window(
        &self,
        clock: f64,
        since: f64,
        now: MassEstimate<f64>,
    ) -> Option<([f64; 2], MassEstimate<f64>)> {
        let (end, length) = (clock.round(), self.policy.window_s);
        // Buckets end with the seconds, whenever the payload changed.
        let since = (since + 1e-9).floor();
        let held = |begin: f64| {
            let ends = (length..length + 1.0).contains(&(end - begin));
            ends.then_some(([begin, begin + length], now))
        };
        match self.policy.kind {
            PolicyKind::Moving => {
                Some(([end - length, end], self.pipeline.over_latest(self.window_buckets)?))
            }
            PolicyKind::Cumulative => (end - since >= length).then_some(([since, end], now)),
            PolicyKind::Known => held(since),
            PolicyKind::Periodic(every) => held(since + every * ((end - since - 0.5) / every).floor()),
        }
    }
}

/// What a window over this time, s on the replay's clock, says of the mass.
fn mass_over([begin, end]: [f64; 2], start: f64, payload: MassEstimate<f64>, truth: &Truth) -> WindowMass {
    let mass = payload.known();
    WindowMass {
        t0_s: start + begin,
        t1_s: start + end,
        mass_kg: mass.map(|mass| mass.mass),
        low_kg: mass.map(|mass| mass.low),
        high_kg: mass.map(|mass| mass.high),
        range: payload.place().map(place_name),
        unknown: match payload {
            MassEstimate::Known(_) | MassEstimate::Beyond(_) => None,
            MassEstimate::Unknown(reason) => Some(reason_text(reason)),
        },
        truth_kg: truth.over(begin),
    }
}

/// Whether the bucket that ends here ends a second.
fn at_second(clock: f64, period_s: f64) -> bool {
    (clock - clock.round()).abs() <= period_s
}

fn instant(row: &RawRow, estimate: &Estimated) -> Option<Instant> {
    let measured_w = estimate.measured?;
    let mass = estimate.mass.known();
    Some(Instant {
        time_s: row.time,
        measured_w,
        told_w: None,
        predicted_w: estimate.power,
        mass_kg: mass.map(|mass| mass.mass),
        interval_kg: mass.map(|mass| (mass.low, mass.high)),
        truth_kg: row.mass,
    })
}

/// A window in which the payload changed has no one mass.
fn blank_straddling(windows: &mut [WindowMass], changes: &[f64]) {
    for window in windows {
        if changes.iter().any(|change| *change > window.t0_s && *change < window.t1_s) {
            window.mass_kg = None;
            window.low_kg = None;
            window.high_kg = None;
            window.range = None;
            window.unknown = Some("the payload changed within this window");
        }
    }
}

/// Where a mass lies, as `--json` names it.
fn place_name(place: Place) -> &'static str {
    match place {
        Place::Within => "within",
        Place::Below => "below",
        Place::Above => "above",
    }
}

/// Since when the logged mass has been what it is.
#[derive(Default)]
struct Truth {
    since: f64,
    mass: Option<f64>,
}

impl Truth {
    fn note(&mut self, clock: f64, mass: Option<f64>) {
        if mass != self.mass {
            *self = Self { since: clock, mass };
        }
    }

    /// The mass, if it has not changed since `begin` (s on the replay's clock).
    fn over(&self, begin: f64) -> Option<f64> {
        // The mass of the first row counts from the start.
        self.mass.filter(|_| self.since <= begin + 1e-9)
    }
}
