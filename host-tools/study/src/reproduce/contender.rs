//! The models that find the mass themselves: ours, the paper's as printed, and the paper's as
//! derived.

use std::path::{Path, PathBuf};

use answers::estimate::{Instant, Payloads, Policy, PolicyKind, Replay, replay};
use fit::dataset::{Dataset, Kept, Reading, Row};
use fit::pgd;
use logs::robot::Robot;
use model::coefficients::{FittedModel, Method, ModelKind};
use support::context::Context;
use support::error::{Error, Result};

use super::course::{Course, Followed, Trace};
use crate::baselines::Point;
use crate::compare::points::{self, Wanted};

/// A model with its way to the mass.
#[derive(Debug, Clone, Copy)]
pub(super) struct Contender {
    /// As in `gmr compare`.
    pub(super) name: &'static str,
    /// What it is.
    pub(super) source: &'static str,
    kind: ModelKind,
    method: Method,
    /// It notices payload changes by itself.
    pub(super) detects: bool,
}

/// Ours, the paper's, the paper's without its misprints.
pub(super) const CONTENDERS: [Contender; 3] = [
    Contender {
        name: "signed",
        source: "ours: signed torque model, least squares over the window",
        kind: ModelKind::Signed,
        method: Method::Physical,
        detects: true,
    },
    Contender {
        name: "eq18-published",
        source: "the paper's: Eq. 18 as printed, Algorithm 1, averaged roots of Eq. 24",
        kind: ModelKind::Eq18Published,
        method: Method::Pgd,
        detects: false,
    },
    Contender {
        name: "eq18",
        source: "Eq. 18 as derived, exact non-negative least squares, averaged roots",
        kind: ModelKind::Eq18,
        method: Method::Nnls,
        detects: false,
    },
];

impl Contender {
    /// Fits the training rows.
    pub(super) fn fit<'a>(
        &self,
        context: &'a Context,
        robot: &'a Robot,
        training: &Dataset,
    ) -> Result<Fitted<'a>> {
        let settings = pgd::Settings::default();
        let training = training.with_gate(self.kind.gate());
        let fit = fit::fit(robot, &training, self.kind, self.method, &settings)?;
        Ok(Fitted { contender: *self, context, robot, coefficients: fit.coefficients() })
    }
}

/// A fitted contender.
pub(super) struct Fitted<'a> {
    /// Which.
    pub(super) contender: Contender,
    context: &'a Context,
    robot: &'a Robot,
    coefficients: FittedModel,
}

impl Fitted<'_> {
    /// P̂ at a mass, W.
    pub(super) fn power(&self, row: &Row, mass_kg: f64) -> f64 {
        Kept { mass: mass_kg, ..row.view() }.predicted(&self.coefficients.model).unwrap_or(f64::NAN)
    }

    /// P̂ of a log with the mass given, as a curve.
    pub(super) fn given_mass(&self, log: &Log) -> Followed {
        Followed {
            method: self.contender.name.to_owned(),
            predicted_w: log.rows.iter().map(|row| self.power(row, row.mass)).collect(),
            ..Followed::default()
        }
    }

    /// Replays a log under a policy. One instant a row of the log.
    pub(super) fn follow(&self, log: &Log, policy: &Policy) -> Result<(Replay, Vec<Instant>)> {
        let mut instants = Vec::with_capacity(log.rows.len());
        let payloads = Payloads::default_for(&self.coefficients.model);
        let replayed =
            replay(self.context, self.robot, &self.coefficients, &log.file, payloads, policy, &mut |now| {
                instants.push(*now)
            })?;
        if instants.len() != log.rows.len() {
            let (count, expected) = (instants.len(), log.rows.len());
            return Err(Error::failed(format!("{count} estimates for {expected} rows")).in_file(&log.file));
        }
        Ok((replayed, instants))
    }

    /// As curves.
    pub(super) fn followed(&self, instants: &[Instant]) -> Followed {
        let known = |value: Option<f64>| value.unwrap_or(f64::NAN);
        Followed {
            method: self.contender.name.to_owned(),
            predicted_w: instants.iter().map(|now| known(now.predicted_w)).collect(),
            mass_kg: instants.iter().map(|now| known(now.mass_kg)).collect(),
            interval_kg: instants.iter().map(|now| now.interval_kg.unwrap_or((f64::NAN, f64::NAN))).collect(),
        }
    }
}

/// The latest window, at every second.
pub(super) fn moving(window_s: f64, detect: bool) -> Policy {
    Policy { window_s, kind: PolicyKind::Moving, changes_s: Vec::new(), detect }
}

/// A log with its rows after the filter.
pub(super) struct Log {
    pub(super) file: PathBuf,
    pub(super) rows: Vec<Row>,
    pub(super) points: Vec<Point>,
}

impl Log {
    /// Behind the filter of a fit.
    pub(super) fn read(
        context: &Context,
        robot: &Robot,
        training: &Dataset,
        file: &Path,
        wanted: &Wanted,
    ) -> Result<Self> {
        let files = [file.to_owned()];
        let read = points::read(context, robot, &training.robot, &files, robot.mass_no_load_kg(), wanted, 1)?;
        let (rows, points) = read.into_iter().unzip();
        Ok(Self { file: file.to_owned(), rows, points })
    }

    /// Its masses in order, kg, each with its first row and the one after its last.
    pub(super) fn tasks(&self) -> Vec<Task> {
        let mut tasks: Vec<Task> = Vec::new();
        for (index, row) in self.rows.iter().enumerate() {
            match tasks.last_mut() {
                Some(task) if task.mass_kg == row.mass => task.to = index + 1,
                _ => tasks.push(Task { mass_kg: row.mass, from: index, to: index + 1 }),
            }
        }
        tasks
    }

    /// The fitted contenders on this log, each with its policy.
    pub(super) fn course(
        &self,
        fitted: &[Fitted<'_>],
        policy: impl Fn(&Contender) -> Policy,
    ) -> Result<Course> {
        let follow =
            |fitted: &Fitted<'_>| Ok(fitted.followed(&fitted.follow(self, &policy(&fitted.contender))?.1));
        Ok(Course { trace: self.trace(), methods: fitted.iter().map(follow).collect::<Result<_>>()? })
    }

    /// As curves.
    pub(super) fn trace(&self) -> Trace {
        let wheel = |side: usize| self.rows.iter().map(|row| row.wheels[side].speed).collect();
        Trace {
            time_s: self.rows.iter().map(|row| row.time).collect(),
            wheel_rad_s: [wheel(0), wheel(1)],
            measured_w: self.rows.iter().map(|row| row.power).collect(),
            truth_kg: self.rows.iter().map(|row| row.mass).collect(),
        }
    }
}

/// Rows with one payload.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Task {
    /// Total mass, kg.
    pub(super) mass_kg: f64,
    /// The first row.
    pub(super) from: usize,
    /// Behind the last row.
    pub(super) to: usize,
}

/// Reads the log to fit.
pub(super) fn training(context: &Context, robot: &Robot, file: &Path) -> Result<Dataset> {
    let gate = ModelKind::Signed.gate();
    let reading = Reading { gate, cutoff_hz: None, mass_kg: robot.mass_no_load_kg() };
    fit::read(context, robot, &[file.to_owned()], &reading)
}
