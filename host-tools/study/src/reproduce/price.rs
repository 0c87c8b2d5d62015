//! Cost of sensing and computing against their savings, over window lengths.
//!
//! The policy is Algorithm 2's: a task begins with another payload. For T s sensors and estimator
//! run, and power is predicted with the previous task's mass; then with m̂(T). The paper names this
//! price and leaves it open (Sections 5.2 and 8). What follows is this project's interpretation,
//! with figures from data sheets and from the bench ([`electronics`](super::electronics)).
//!
//! A mispredicted joule counts as a spent joule. In truth its cost depends on the mission:
//! [`Best::break_even`] gives the worth below which sensing and computing weigh as much.

use plant::experiment;
use serde::Serialize;

use super::electronics::{Counts, INSTRUCTION_J, SHUNT_OHM, sensors_w};
use super::table::{Cell, Column, Format, Mark, Row, Table, column, distinct, number};

/// What prices are computed from.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Input {
    /// Lengths of the tasks, s.
    pub(super) tasks_s: Vec<f64>,
    /// One entry a method and window.
    pub(super) points: Vec<PricePoint>,
    /// Samples per second, Hz.
    pub(super) rate_hz: f64,
    /// Instructions of a sample, method by method; a method without a count is priced NaN.
    pub(super) instructions: Vec<(&'static str, Counts)>,
}

/// Lengths of the tasks by default, s: a minute, five and thirty.
const TASKS_S: [f64; 3] = [60.0, 300.0, 1800.0];

/// The bench's names for the estimators of the methods that estimate the mass. Windows of up to 32
/// s; longer rings cost the same.
const COUNTED: [(&str, &str); 3] = [
    ("signed", "signed window, 32 buckets"),
    ("eq18-published", "eq18-published roots, 32 buckets"),
    ("eq18", "eq18 roots, 32 buckets"),
];

/// No points; everything else from the experiment and the bench.
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

/// The value of a window of one length for one method.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct PricePoint {
    /// T, s.
    pub(super) window_s: f64,
    /// The method.
    pub(super) method: &'static str,
    /// Mean |P̂(m) − P̂(truth)| with the mass of the task before, W.
    pub(super) old_mass_w: f64,
    /// The same with m̂(T), or with the previous mass where T gives none, W.
    pub(super) new_mass_w: f64,
    /// Root mean square of the motors' current, A.
    pub(super) actuation_a: f64,
}

/// What a task costs, split, J.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct Split {
    /// Supply and inputs of the sensors during T.
    pub(super) sensors_j: f64,
    /// The motors' current through the sensor's shunt. It stays in the rail when the sensor sleeps:
    /// it counts for the whole task, and is the same for every window.
    pub(super) shunt_j: f64,
    /// Instructions of the estimator during T.
    pub(super) computing_j: f64,
    /// Mispredicted during T, with the mass of the task before.
    pub(super) before_j: f64,
    /// Mispredicted after T, with m̂(T).
    pub(super) after_j: f64,
}

impl Split {
    /// All parts together, J.
    pub(super) fn total_j(&self) -> f64 {
        self.spent_j() + self.shunt_j + self.mispredicted_j()
    }

    /// Energy of sensors and processor due to T, J.
    pub(super) fn spent_j(&self) -> f64 {
        self.sensors_j + self.computing_j
    }

    /// Energy mispredicted, J.
    pub(super) fn mispredicted_j(&self) -> f64 {
        self.before_j + self.after_j
    }

    /// The greatest part.
    pub(super) fn dominant(&self) -> &'static str {
        let shares = [
            ("sensors", self.sensors_j),
            ("shunt", self.shunt_j),
            ("computing", self.computing_j),
            ("error before the estimate", self.before_j),
            ("error behind the estimate", self.after_j),
        ];
        shares.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).map_or("nothing", |share| share.0)
    }
}

/// One task with one window.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Priced {
    /// D, s.
    pub(super) task_s: f64,
    /// The method.
    pub(super) method: &'static str,
    /// T, s; shorter than the task.
    pub(super) window_s: f64,
    /// The parts.
    pub(super) split: Split,
    /// Their sum, J.
    pub(super) total_j: f64,
}

/// The window that costs least.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Best {
    /// D, s.
    pub(super) task_s: f64,
    /// The method.
    pub(super) method: &'static str,
    /// T, s.
    pub(super) window_s: f64,
    /// Whether it is the shortest or the longest tried: the least may lie outside.
    pub(super) at_end: bool,
    /// The parts.
    pub(super) split: Split,
    /// Their sum, J.
    pub(super) total_j: f64,
    /// The part that weighs most.
    pub(super) dominant: &'static str,
    /// Joules spent due to T for every joule mispredicted. If a mispredicted joule is worth less
    /// than this share of a spent one, sensing and computing cost more. NaN where nothing is
    /// mispredicted.
    pub(super) break_even: f64,
}

/// Every price, and the best windows.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub(super) struct Price {
    /// By task, then in the order of the points.
    pub(super) priced: Vec<Priced>,
    /// One entry a task and method.
    pub(super) best: Vec<Best>,
    /// Power of the sensors while they run, W.
    pub(super) sensors_w: f64,
    /// Energy of an instruction, J.
    pub(super) instruction_j: f64,
}

/// Prices of every task with every window that fits into it. A point that is not finite is priced
/// NaN and is never the best.
pub(super) fn price(input: &Input) -> Price {
    let mut price = Price { sensors_w: sensors_w(), instruction_j: INSTRUCTION_J, ..Price::default() };
    for &task_s in &input.tasks_s {
        let first = price.priced.len();
        let fitting = input.points.iter().filter(|point| point.window_s < task_s);
        price.priced.extend(fitting.map(|point| priced(task_s, point, input)));
        let methods = distinct(price.priced[first..].iter().map(|priced| priced.method));
        price.best.extend(methods.into_iter().filter_map(|method| {
            let tried = price.priced[first..].iter().filter(|priced| priced.method == method);
            best(&tried.collect::<Vec<_>>())
        }));
    }
    price
}

fn priced(task_s: f64, point: &PricePoint, input: &Input) -> Priced {
    let counts = input.instructions.iter().find(|(method, _)| *method == point.method);
    let per_sample = counts.map_or(f64::NAN, |(_, counts)| counts.per_sample(input.rate_hz));
    let window_s = point.window_s;
    let split = Split {
        sensors_j: sensors_w() * window_s,
        shunt_j: SHUNT_OHM * point.actuation_a.powi(2) * task_s,
        computing_j: per_sample * INSTRUCTION_J * input.rate_hz * window_s,
        before_j: point.old_mass_w * window_s,
        after_j: point.new_mass_w * (task_s - window_s),
    };
    Priced { task_s, method: point.method, window_s, split, total_j: split.total_j() }
}

/// The cheapest of one task and method; the shorter window where two cost the same.
fn best(tried: &[&Priced]) -> Option<Best> {
    let finite = || tried.iter().filter(|priced| priced.total_j.is_finite());
    let least =
        finite().min_by(|a, b| a.total_j.total_cmp(&b.total_j).then(a.window_s.total_cmp(&b.window_s)))?;
    let shortest = finite().map(|priced| priced.window_s).fold(f64::INFINITY, f64::min);
    let longest = finite().map(|priced| priced.window_s).fold(0.0, f64::max);
    let mispredicted = least.split.mispredicted_j();
    Some(Best {
        task_s: least.task_s,
        method: least.method,
        window_s: least.window_s,
        at_end: least.window_s == shortest || least.window_s == longest,
        split: least.split,
        total_j: least.total_j,
        dominant: least.split.dominant(),
        break_even: if mispredicted > 0.0 { least.split.spent_j() / mispredicted } else { f64::NAN },
    })
}

const COLUMNS: [Column; 11] = [
    column("", "task s", Format::Number(0)),
    column("", "method", Format::Words),
    column("", "window s", Format::AsShown),
    column("", "sensors J", Format::Number(4)),
    column("", "shunt J", Format::Number(4)),
    column("", "computing J", Format::Number(4)),
    column("", "error before J", Format::Number(4)),
    column("", "error behind J", Format::Number(4)),
    column("", "total J", Format::Number(4)),
    column("", "greatest part", Format::Words),
    column("", "break-even", Format::Number(4)),
];

/// The best windows.
pub(super) fn table(price: &Price) -> Table {
    let row = |best: &Best| {
        let window = format!("{}{}", number(best.window_s, 1), if best.at_end { " (end)" } else { "" });
        let Split { sensors_j, shunt_j, computing_j, before_j, after_j } = best.split;
        let joules = [sensors_j, shunt_j, computing_j, before_j, after_j, best.total_j].map(Cell::from);
        let first: [Cell; 3] = [best.task_s.into(), best.method.into(), window.into()];
        let last: [Cell; 2] = [best.dominant.into(), best.break_even.into()];
        Row::new(Mark::None, first.into_iter().chain(joules).chain(last))
    };
    Table {
        name: "price",
        title: "Price of sensing and computing: the window that costs least",
        columns: &COLUMNS,
        rows: price.best.iter().map(row).collect(),
        note: format!(
            "a sensor draws {} mW, an instruction takes {} nJ; a mispredicted joule counts as one spent; break-even: the worth of a \
             mispredicted joule below which sensors and computing weigh more; (end): the shortest or longest window tried",
            number(1e3 * price.sensors_w, 2),
            number(1e9 * price.instruction_j, 3)
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(window_s: f64, method: &'static str, new_mass_w: f64) -> PricePoint {
        PricePoint { window_s, method, old_mass_w: 0.5, new_mass_w, actuation_a: 0.4 }
    }

    /// Every sample takes 300 instructions, 200 samples a second.
    fn input(tasks_s: Vec<f64>, points: Vec<PricePoint>) -> Input {
        let counts = Counts { sample: 300, closing: 300 };
        Input { tasks_s, points, rate_hz: 200.0, instructions: vec![("ours", counts), ("paper", counts)] }
    }

    /// By hand: 3.3 V · 0.7 mA + 12 V · 77.5 µA = 2.31 + 0.93 mW; 3.3 V · 102 mA ∕ 216 MHz =
    /// 1.55833 nJ.
    #[test]
    fn the_parts_draw_what_their_data_sheets_say() {
        assert!((sensors_w() - 3.24e-3).abs() < 1e-9, "{}", sensors_w());
        assert!((INSTRUCTION_J - 1.55833e-9).abs() < 1e-14, "{}", INSTRUCTION_J);
    }

    /// 60 s with 10 s of estimating at 200 Hz, by hand: sensors 3.24 mW · 10 s; shunt 0.1 Ω · 0.16
    /// A² · 60 s = 0.96 J; computing 300 · 1.55833 nJ · 200 Hz · 10 s = 0.935 mJ; errors 0.5 W · 10
    /// s and 0.1 W · 50 s. All are products of a few numbers: rounding is far below a nanojoule but
    /// for computing's constant, whose sixth digit is 5e-9 J here.
    #[test]
    fn a_task_is_priced_part_by_part() {
        let price = price(&input(vec![60.0], vec![point(10.0, "ours", 0.1)]));
        let split = price.priced[0].split;
        let near = |value: f64, expected: f64| assert!((value - expected).abs() < 1e-8, "{value} {expected}");
        near(split.sensors_j, 0.0324);
        near(split.shunt_j, 0.96);
        near(split.computing_j, 9.35e-4);
        near(split.before_j, 5.0);
        near(split.after_j, 5.0);
        near(price.priced[0].total_j, 10.993_335);
        near(price.best[0].break_even, 0.033_335 / 10.0);
    }

    /// Errors of 0.5 W before and 2 ∕ T W after the estimate: 60 s cost 5 + 10, 10 + 4 and 20 + 1 J
    /// beside the same shunt and little else.
    #[test]
    fn the_best_window_is_the_cheapest_of_its_task_and_method() {
        let points = [10.0, 20.0, 40.0].map(|t| point(t, "ours", 2.0 / t)).to_vec();
        let points = [points, vec![point(10.0, "paper", 0.3), point(40.0, "paper", f64::NAN)]].concat();
        let price = price(&input(vec![60.0, 15.0], points));
        let best: Vec<_> = price.best.iter().map(|best| (best.task_s, best.method, best.window_s)).collect();
        assert_eq!(
            best,
            [(60.0, "ours", 20.0), (60.0, "paper", 10.0), (15.0, "ours", 10.0), (15.0, "paper", 10.0)]
        );
        assert!(!price.best[0].at_end && price.best[1].at_end);
        assert_eq!(price.best[0].dominant, "error before the estimate");
        // Windows of 20 and 40 s do not fit into 15 s.
        assert_eq!(price.priced.iter().filter(|priced| priced.task_s == 15.0).count(), 2);
    }

    #[test]
    fn the_bench_has_counted_every_method() {
        let default = Input::default();
        assert_eq!(default.instructions.len(), COUNTED.len());
        assert!(
            default
                .instructions
                .iter()
                .all(|(_, counts)| counts.closing > counts.sample && counts.sample > 0)
        );
    }

    /// A method without a count has no price, instead of free computing.
    #[test]
    fn a_method_without_a_count_has_no_price() {
        let price = price(&input(vec![60.0], vec![point(10.0, "other", 0.1)]));
        assert!(price.priced[0].total_j.is_nan() && price.best.is_empty());
    }
}
