//! Squared deviations of the power at rest from one level, and from levels that step.

use super::read::PowerRun;
use super::rests::Rests;

/// Squares over the blocks at rest, W².
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Squares {
    /// About one level a run.
    pub before: f64,
    /// About one level a run and the named steps.
    pub after: f64,
    /// About one level for each state of each run: no step removes that.
    pub floor: f64,
    /// Blocks.
    pub count: f64,
}

impl Squares {
    /// Of one run. `shift`: by how much the named steps have lifted the power at a time.
    pub(super) fn of(run: &PowerRun, rests: &Rests, shift: impl Fn(f64) -> f64) -> Self {
        let at_rest = at_rest(run, rests);
        let about = |values: &[f64]| {
            let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
            values.iter().map(|value| (value - mean).powi(2)).sum::<f64>()
        };
        let before: Vec<f64> = at_rest.iter().map(|rest| rest.power_w).collect();
        let after: Vec<f64> = at_rest.iter().map(|rest| rest.power_w - shift(rest.time_s)).collect();
        let states = at_rest.iter().map(|rest| rest.state).max().map_or(0, |most| most + 1);
        let floor = (0..states).map(|state| {
            let powers = at_rest.iter().filter(|rest| rest.state == state).map(|rest| rest.power_w);
            about(&powers.collect::<Vec<_>>())
        });
        Self { before: about(&before), after: about(&after), floor: floor.sum(), count: at_rest.len() as f64 }
    }

    pub(super) fn add(&mut self, other: &Self) {
        self.before += other.before;
        self.after += other.after;
        self.floor += other.floor;
        self.count += other.count;
    }

    /// Mean of a sum, W².
    pub(super) fn mean(&self, sum: f64) -> f64 {
        sum / self.count.max(1.0)
    }
}

/// A block at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct AtRest {
    pub time_s: f64,
    pub power_w: f64,
    /// Number of its state.
    pub state: usize,
}

/// The blocks of a run at rest.
pub(super) fn at_rest(run: &PowerRun, rests: &Rests) -> Vec<AtRest> {
    let blocks = run.blocks.iter();
    let rest = blocks.filter_map(|block| {
        let time_s = 0.5 * (block.from_s + block.to_s);
        Some(AtRest { time_s, power_w: block.mean, state: rests.state_at(time_s)? })
    });
    rest.collect()
}
