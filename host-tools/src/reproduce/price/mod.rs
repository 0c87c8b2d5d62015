//! What sensing and computing cost against what they save, over window lengths.
//!
//! The policy is Algorithm 2's: a task begins with another payload; for T s sensors and estimator run, and power is predicted with
//! the mass of the task before; from then on with m̂(T). The paper names this price and leaves it open (Sections 5.2 and 8); what
//! follows is this project's reading of it, with figures from data sheets ([`hardware`]) and from the bench ([`instructions`]).
//!
//! A joule that is predicted wrongly is counted as a joule spent. It is not: what a wrong joule costs is the mission's business.
//! [`Best::break_even`] says how little it may be worth before sensing and computing weigh as much.

pub mod hardware;
pub mod instructions;

use serde::Serialize;

use self::instructions::Counts;
use crate::plant::experiment;

/// What prices are computed from.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Input {
    /// Lengths of the tasks, s.
    pub tasks_s: Vec<f64>,
    /// One entry a method and window.
    pub points: Vec<PricePoint>,
    /// Samples per second, Hz.
    pub rate_hz: f64,
    /// What a sample takes, method by method; one that is not here is priced NaN.
    pub instructions: Vec<(&'static str, Counts)>,
}

/// Lengths of the tasks unless told otherwise, s: a minute, five and thirty.
const TASKS_S: [f64; 3] = [60.0, 300.0, 1800.0];

/// What the bench calls the estimators of the methods that find the mass. Windows of up to 32 s; longer rings cost the same.
const COUNTED: [(&str, &str); 3] = [
    ("signed", "signed window, 32 buckets"),
    ("eq18-published", "eq18-published roots, 32 buckets"),
    ("eq18", "eq18 roots, 32 buckets"),
];

/// No points yet; everything else as the experiment and the bench have it.
impl Default for Input {
    fn default() -> Self {
        let counted = COUNTED.iter().filter_map(|(method, name)| Some((*method, Counts::of(name).ok()?)));
        Self {
            tasks_s: TASKS_S.to_vec(),
            points: Vec::new(),
            rate_hz: experiment::REGIME.rate_hz,
            instructions: counted.collect(),
        }
    }
}

/// What a window of one length is worth to one method.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PricePoint {
    /// T, s.
    pub window_s: f64,
    /// The method.
    pub method: String,
    /// Mean |P̂(m) − P̂(truth)| with the mass of the task before, W.
    pub old_mass_w: f64,
    /// The same with m̂(T); with the mass before where T says nothing, W.
    pub new_mass_w: f64,
    /// Root mean square of the motors' current, A.
    pub actuation_a: f64,
}

/// What a task costs, split, J.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Split {
    /// Supply and inputs of the sensors during T.
    pub sensors_j: f64,
    /// The motors' current through the sensor's shunt. It stays in the rail when the sensor sleeps: it counts for the whole task,
    /// and is the same for every window.
    pub shunt_j: f64,
    /// Instructions of the estimator during T.
    pub computing_j: f64,
    /// Mispredicted during T, with the mass of the task before.
    pub before_j: f64,
    /// Mispredicted behind T, with m̂(T).
    pub after_j: f64,
}

impl Split {
    /// All parts together, J.
    pub fn total_j(&self) -> f64 {
        self.spent_j() + self.shunt_j + self.mispredicted_j()
    }

    /// What sensors and processor take because of T, J.
    pub fn spent_j(&self) -> f64 {
        self.sensors_j + self.computing_j
    }

    /// Energy mispredicted, J.
    pub fn mispredicted_j(&self) -> f64 {
        self.before_j + self.after_j
    }

    /// The greatest part.
    pub fn dominant(&self) -> &'static str {
        let parts = [
            ("sensors", self.sensors_j),
            ("shunt", self.shunt_j),
            ("computing", self.computing_j),
            ("error before the estimate", self.before_j),
            ("error behind the estimate", self.after_j),
        ];
        parts.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).map_or("nothing", |part| part.0)
    }
}

/// One task with one window.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Priced {
    /// D, s.
    pub task_s: f64,
    /// The method.
    pub method: String,
    /// T, s; shorter than the task.
    pub window_s: f64,
    /// The parts.
    pub split: Split,
    /// Their sum, J.
    pub total_j: f64,
}

/// The window that costs least.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Best {
    /// D, s.
    pub task_s: f64,
    /// The method.
    pub method: String,
    /// T, s.
    pub window_s: f64,
    /// It is the shortest or the longest of those that were tried: the least may lie beyond.
    pub at_end: bool,
    /// The parts.
    pub split: Split,
    /// Their sum, J.
    pub total_j: f64,
    /// The part that weighs most.
    pub dominant: &'static str,
    /// Joules spent because of T for every joule mispredicted: a mispredicted joule that is worth less than this share of a spent one
    /// makes sensing and computing the greater part. NaN where nothing is mispredicted.
    pub break_even: f64,
}

/// Every price, and the best windows.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Price {
    /// By task, then in the order of the points.
    pub priced: Vec<Priced>,
    /// One entry a task and method.
    pub best: Vec<Best>,
    /// Power of the sensors while they run, W.
    pub sensors_w: f64,
    /// Energy of an instruction, J.
    pub instruction_j: f64,
}

/// Prices of every task with every window that fits into it. A point that is not finite is priced NaN and is never the best.
pub fn price(input: &Input) -> Price {
    let mut price = Price {
        sensors_w: hardware::sensors_w(),
        instruction_j: hardware::INSTRUCTION_J,
        ..Price::default()
    };
    for &task_s in &input.tasks_s {
        let first = price.priced.len();
        let fitting = input.points.iter().filter(|point| point.window_s < task_s);
        price.priced.extend(fitting.map(|point| priced(task_s, point, input)));
        let mut methods: Vec<&str> = Vec::new();
        for priced in &price.priced[first..] {
            if !methods.contains(&priced.method.as_str()) {
                methods.push(&priced.method);
            }
        }
        price.best.extend(methods.into_iter().filter_map(|method| {
            let own = price.priced[first..].iter().filter(|priced| priced.method == method);
            best(&own.collect::<Vec<_>>())
        }));
    }
    price
}

fn priced(task_s: f64, point: &PricePoint, input: &Input) -> Priced {
    let counts = input.instructions.iter().find(|(method, _)| *method == point.method);
    let per_sample = counts.map_or(f64::NAN, |(_, counts)| counts.per_sample(input.rate_hz));
    let window_s = point.window_s;
    let split = Split {
        sensors_j: hardware::sensors_w() * window_s,
        shunt_j: hardware::SHUNT_OHM * point.actuation_a.powi(2) * task_s,
        computing_j: per_sample * hardware::INSTRUCTION_J * input.rate_hz * window_s,
        before_j: point.old_mass_w * window_s,
        after_j: point.new_mass_w * (task_s - window_s),
    };
    Priced { task_s, method: point.method.clone(), window_s, split, total_j: split.total_j() }
}

/// The cheapest of one task and method; the shorter window where two cost the same.
fn best(own: &[&Priced]) -> Option<Best> {
    let finite = || own.iter().filter(|priced| priced.total_j.is_finite());
    let least =
        finite().min_by(|a, b| a.total_j.total_cmp(&b.total_j).then(a.window_s.total_cmp(&b.window_s)))?;
    let shortest = finite().map(|priced| priced.window_s).fold(f64::INFINITY, f64::min);
    let longest = finite().map(|priced| priced.window_s).fold(0.0, f64::max);
    let mispredicted = least.split.mispredicted_j();
    Some(Best {
        task_s: least.task_s,
        method: least.method.clone(),
        window_s: least.window_s,
        at_end: least.window_s == shortest || least.window_s == longest,
        split: least.split,
        total_j: least.total_j,
        dominant: least.split.dominant(),
        break_even: if mispredicted > 0.0 { least.split.spent_j() / mispredicted } else { f64::NAN },
    })
}

#[cfg(test)]
mod tests;
