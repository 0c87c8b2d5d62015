//! What a reproduction finds: everything that its tables, figures and page show.

use serde::Serialize;

use crate::compare::{LeftOut, MassSource};

/// All of it.
#[derive(Debug, Clone, Serialize)]
pub struct Study {
    /// What was asked for.
    pub settings: Settings,
    /// Section 6 of the paper.
    pub simulation: Simulation,
    /// Section 7, in the experiment's regime.
    pub experiment: Experiment,
    /// Fig. 4's policies and the change detector on the same logs.
    pub recalibration: Vec<Recalibration>,
    /// What sensing and computing cost against what they save.
    pub price: super::price::Price,
    /// Where print and derivation differ, and what each difference costs.
    pub print: Vec<super::print::Difference>,
}

/// What was asked for.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Settings {
    /// The first seed; figures over time show this one.
    pub first_seed: u64,
    /// Number of seeds that figures with a spread are over.
    pub seeds: u64,
    /// Payload windows of the sweep, in s.
    pub windows_s: Vec<u32>,
    /// Names of the baselines.
    pub baselines: Vec<&'static str>,
}

/// A figure over seeds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spread {
    /// Mean over seeds.
    pub mean: f64,
    /// 95 % interval of the mean (Student's t over seeds); NaN with one seed.
    pub low: f64,
    /// 95 % interval of the mean (Student's t over seeds); NaN with one seed.
    pub high: f64,
    /// The least of a seed.
    pub least: f64,
    /// The greatest of a seed.
    pub greatest: f64,
    /// Seeds that have a value.
    pub count: usize,
}

/// One log behind the filter.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Trace {
    /// Time since its start, s.
    pub time_s: Vec<f64>,
    /// Speeds of the left and the right wheel, rad/s.
    pub wheel_rad_s: [Vec<f64>; 2],
    /// Measured actuation power, W.
    pub measured_w: Vec<f64>,
    /// True total mass, kg.
    pub truth_kg: Vec<f64>,
}

/// What a method made of a log, sample by sample of its [`Trace`]; NaN where it does not know.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Followed {
    /// The method, as tables name it.
    pub method: String,
    /// P̂, W.
    pub predicted_w: Vec<f64>,
    /// m̂, kg; empty for methods without one.
    pub mass_kg: Vec<f64>,
    /// 95 % interval of m̂, kg; empty for methods without one.
    pub low_kg: Vec<f64>,
    /// 95 % interval of m̂, kg; empty for methods without one.
    pub high_kg: Vec<f64>,
}

/// A log, and what methods made of it.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Course {
    /// The log.
    pub trace: Trace,
    /// Ours first, the paper's second, then the others.
    pub methods: Vec<Followed>,
}

/// Section 6: the simulated robot of Tables 2 and 3.
#[derive(Debug, Clone, Serialize)]
pub struct Simulation {
    /// Fig. 5a, b: training, payload known.
    pub training: Course,
    /// Fig. 5c, d and 7: test, payload from the first 10 s of each task.
    pub test: Course,
    /// Fig. 6: the mass by a moving window of 10 s.
    pub moving: Course,
    /// Ours, the paper's, Eq. 18 corrected; in this order.
    pub rows: Vec<SimulationRow>,
    /// What the paper states of its method.
    pub published: PublishedSimulation,
}

/// One method in Section 6, over seeds.
#[derive(Debug, Clone, Serialize)]
pub struct SimulationRow {
    /// The method.
    pub method: String,
    /// Of the predicted power, %.
    pub mape_percent: Spread,
    /// Of the predicted power.
    pub r2: Spread,
    /// Mass error of the first 10 s, %.
    pub after_start_percent: Spread,
    /// Mass error of the first 10 s after the change, %.
    pub after_change_percent: Spread,
    /// Mass error of the worst 10 s, %.
    pub worst_start_percent: Spread,
}

/// Section 6's figures.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PublishedSimulation {
    /// %
    pub mape_percent: f64,
    /// 1
    pub r2: f64,
    /// %
    pub after_start_percent: f64,
    /// %
    pub after_change_percent: f64,
    /// %
    pub worst_start_percent: f64,
}

/// Section 7: the experiment's regime.
#[derive(Debug, Clone, Serialize)]
pub struct Experiment {
    /// The regime's knobs: name, value with unit, why.
    pub knobs: Vec<Knob>,
    /// How near the paper's methods come to their published figures.
    pub nearness: Vec<Nearness>,
    /// Fig. 9a: the rails while the robot is loaded.
    pub rails: Rails,
    /// Step 1 on the training log, payload known.
    pub training: Course,
    /// Fig. 13 to 15: power of the test log with a moving window of 25 s; the baselines behind ours and the paper's.
    pub test: Course,
    /// Fig. 10: the mass by all samples since a known change.
    pub cumulative: Course,
    /// Fig. 11: the mass by moving windows of 12.5 s and 50 s.
    pub moving: Vec<(f64, Course)>,
    /// Fig. 12: one entry a window and method, by window.
    pub windows: Vec<WindowRow>,
    /// Power at a moving window of 25 s: ours, the paper's, then every baseline.
    pub models: Vec<ModelRow>,
    /// Baselines that these logs do not allow.
    pub left_out: Vec<LeftOut>,
    /// Share of the samples behind the first window in which every model is judged, %: where the mass is known to those
    /// that have to find it.
    pub share_known: Spread,
}

/// One setting of the regime.
#[derive(Debug, Clone, Serialize)]
pub struct Knob {
    /// What is set.
    pub name: &'static str,
    /// To what.
    pub value: String,
    /// Why.
    pub reason: &'static str,
}

/// A published figure and what comes out here.
#[derive(Debug, Clone, Serialize)]
pub struct Nearness {
    /// Which figure.
    pub what: String,
    /// As published.
    pub published: f64,
    /// As measured here.
    pub here: Spread,
    /// Ours on the same logs.
    pub ours: Spread,
    /// Its unit; `%` or nothing.
    pub unit: &'static str,
}

/// Powers of the rails over time (moving averages of 20 samples, as the paper's).
#[derive(Debug, Clone, Default, Serialize)]
pub struct Rails {
    /// s
    pub time_s: Vec<f64>,
    /// At the battery, W.
    pub battery_w: Vec<f64>,
    /// Of the motors, W.
    pub actuation_w: Vec<f64>,
    /// Of all else, W.
    pub static_w: Vec<f64>,
    /// Fig. 9b: samples of the static power, not averaged, W.
    pub static_samples_w: Vec<f64>,
    /// Their mean and standard deviation, W (Eq. 29).
    pub gaussian_w: (f64, f64),
}

/// One method at one window, worst-case start, over seeds.
#[derive(Debug, Clone, Serialize)]
pub struct WindowRow {
    /// s
    pub window_s: f64,
    /// The method.
    pub method: String,
    /// Mass error of the worst window, %; mean of the two payloads.
    pub worst_mass_percent: Spread,
    /// Mass error over all windows, %.
    pub mean_mass_percent: Spread,
    /// Of the power predicted with the worst window's mass, %.
    pub mape_percent: Spread,
    /// Of the power predicted with the worst window's mass.
    pub r2: Spread,
    /// Share of the windows in which the mass is known, %.
    pub known_percent: Spread,
}

/// One model's power at a moving window of 25 s, over seeds.
#[derive(Debug, Clone, Serialize)]
pub struct ModelRow {
    /// The model.
    pub name: String,
    /// What it is.
    pub source: String,
    /// Where the mass came from.
    pub mass: MassSource,
    /// %
    pub mape_percent: Spread,
    /// 1
    pub r2: Spread,
    /// W
    pub rmse_w: Spread,
    /// Seeds in which ours has the lower MAPE and the higher R² on the same log.
    pub ours_ahead: u64,
    /// Seeds in which ours has the higher MAPE or the lower R².
    pub ours_behind: u64,
    /// As published, where it is: MAPE in % and R².
    pub published: Option<(f64, f64)>,
}

/// One recalibration policy, over seeds.
#[derive(Debug, Clone, Serialize)]
pub struct Recalibration {
    /// The policy.
    pub policy: String,
    /// The estimator under it.
    pub method: String,
    /// Time from a payload change until the mass is within 10 % of the truth for good, s.
    pub delay_s: Spread,
    /// Changes after which it never is, of all.
    pub never: (u64, u64),
    /// Restarts without a change, per hour.
    pub false_restarts_per_hour: Spread,
    /// |∫ P̂ dt − ∫ P dt| ∕ ∫ P dt, %.
    pub energy_error_percent: Spread,
    /// ∫ |P̂ − P| dt ∕ ∫ P dt, %: what errors of both signs do not cancel.
    pub absolute_energy_error_percent: Spread,
    /// Share of the time without an estimate, %.
    pub unknown_percent: Spread,
}
