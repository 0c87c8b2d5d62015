//! The levels that the power of a run keeps returning to, and the times at which they change.

use answers::inspect::{Block, StaticPower, StaticState};
use numerics::robust::scale;

use super::read::PowerRun;
use residuals::thresholds::power_only::{LEAST_REST_S, LEAST_RUNS, LEAST_SHARE, ROUGHER, WANDER_S};

/// A level that the power stays at, from a time to another.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Visit {
    from_s: f64,
    to_s: f64,
    level: usize,
}

/// A level that the power returns to.
#[derive(Debug, Clone, PartialEq)]
pub struct Rest {
    /// Its mean, W.
    pub level_w: f64,
    /// Its standard error, W: the wander of rests over the root of the number of visits.
    pub std_err_w: f64,
    /// When, from and to, s.
    pub visits: Vec<(f64, f64)>,
}

/// A change of the level that the power returns to.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// Time of the last moment at the one level, and of the first one at the other, s.
    pub between_s: (f64, f64),
    /// Before.
    pub from: Rest,
    /// After.
    pub to: Rest,
}

impl Step {
    /// Its size, W.
    pub fn size_w(&self) -> f64 {
        self.to.level_w - self.from.level_w
    }

    /// Standard error of its size, W.
    pub fn std_err_w(&self) -> f64 {
        self.from.std_err_w.hypot(self.to.std_err_w)
    }

    /// Whether a time is after the step.
    fn is_after(&self, time: f64) -> bool {
        time >= self.between_s.1
    }
}

/// What a run shows at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct Rests {
    /// Changes that last, in the order of time.
    pub steps: Vec<Step>,
    /// The lowest level, where there is any.
    pub lowest: Option<Rest>,
    /// Levels that the power rose to, passed, or held too briefly for a rest.
    pub others: usize,
    /// How far means over two seconds wander at rest, W.
    pub wander_w: f64,
}

impl Rests {
    /// Of a run.
    pub fn of(run: &PowerRun) -> Self {
        let power = StaticPower::of(&run.blocks, false);
        let mut levels: Vec<StaticState> = power.standing.into_iter().chain(power.moving).collect();
        levels.sort_by(|a, b| a.mean_w.total_cmp(&b.mean_w));
        let mut visits: Vec<Visit> = levels
            .iter()
            .enumerate()
            .flat_map(|(level, state)| {
                state.visits.iter().map(move |&(from_s, to_s)| Visit { from_s, to_s, level })
            })
            .collect();
        visits.sort_by(|a, b| a.from_s.total_cmp(&b.from_s));
        let mut search = Search { levels: &levels, steps: Vec::new() };
        let lowest = levels.first().map(|_| search.all(&visits, 0));
        search.collect(&visits);
        // The greatest wander of any rest of a step.
        let rests = search.steps.iter().flat_map(|step| [&step.from, &step.to]);
        let greatest = rests.chain(&lowest).map(|rest| wander(&run.blocks, &rest.visits)).fold(0.0, f64::max);
        let mut steps = search.steps;
        for rest in steps.iter_mut().flat_map(|step| [&mut step.from, &mut step.to]) {
            rest.std_err_w = rest.std_err_w.max(greatest / (rest.visits.len() as f64).sqrt());
        }
        let used = if lowest.is_some() { steps.len() + 1 } else { 0 };
        Self { others: levels.len().saturating_sub(used), steps, lowest, wander_w: greatest }
    }

    /// The state at a time, numbered from 0; `None` where the time is not at rest.
    pub fn state_at(&self, time: f64) -> Option<usize> {
        let inside = |rest: &Rest| rest.visits.iter().any(|&(from, to)| time >= from && time <= to);
        let state = self.steps.iter().filter(|step| step.is_after(time)).count();
        let rest = match state.checked_sub(1) {
            Some(before) => self.steps.get(before).map(|step| &step.to),
            None => self.steps.first().map(|step| &step.from).or(self.lowest.as_ref()),
        };
        rest.is_some_and(inside).then_some(state)
    }
}

struct Search<'a> {
    levels: &'a [StaticState],
    steps: Vec<Step>,
}

impl Search<'_> {
    /// Steps among these visits: up after the last visit of the lowest level, down before its
    /// first.
    fn collect(&mut self, visits: &[Visit]) {
        let Some(lowest) = visits.iter().map(|visit| visit.level).min() else { return };
        let at = |visit: &Visit| visit.level == lowest;
        let (Some(first), Some(last)) = (visits.iter().position(at), visits.iter().rposition(at)) else {
            return;
        };
        let (before, here, after) = (&visits[..first], &visits[first..=last], &visits[last + 1..]);
        let low = self.all(here, lowest);
        if let Some((rest, from_s, _)) = self.rest(before)
            && self.is_rest(&low, here, lowest)
        {
            let between_s = (rest.visits.last().map_or(from_s, |visit| visit.1), here[0].from_s);
            self.add(rest, low.clone(), between_s);
        }
        self.collect(before);
        if let Some((rest, _, _)) = self.rest(after)
            && self.is_held(&low)
        {
            let between_s = (here[here.len() - 1].to_s, rest.visits.first().map_or(0.0, |visit| visit.0));
            self.add(low, rest, between_s);
        }
        self.collect(after);
    }

    fn add(&mut self, from: Rest, to: Rest, between_s: (f64, f64)) {
        self.steps.push(Step { between_s, from, to });
        self.steps.sort_by(|a, b| a.between_s.0.total_cmp(&b.between_s.0));
    }

    /// The lowest level of some visits if it is one that the power returns to, with their beginning
    /// and end.
    fn rest(&self, visits: &[Visit]) -> Option<(Rest, f64, f64)> {
        let lowest = visits.iter().map(|visit| visit.level).min()?;
        let rest = self.all(visits, lowest);
        let (first, last) = (visits.first()?, visits.last()?);
        self.is_rest(&rest, visits, lowest).then_some((rest, first.from_s, last.to_s))
    }

    fn is_rest(&self, rest: &Rest, visits: &[Visit], level: usize) -> bool {
        let (Some(first), Some(last)) = (visits.first(), visits.last()) else { return false };
        let span = last.to_s - first.from_s;
        let held: f64 = rest.visits.iter().map(|(from, to)| to - from).sum();
        rest.visits.len() >= LEAST_RUNS
            && held >= LEAST_SHARE * span
            && self.is_held(rest)
            && self.levels[level].std_w
                <= ROUGHER * self.levels.iter().map(|state| state.std_w).fold(f64::INFINITY, f64::min)
    }

    fn is_held(&self, rest: &Rest) -> bool {
        rest.visits.iter().map(|(from, to)| to - from).sum::<f64>() >= LEAST_REST_S
    }

    /// All visits of a level among these.
    fn all(&self, visits: &[Visit], level: usize) -> Rest {
        let state = &self.levels[level];
        let inside = visits.iter().filter(|visit| visit.level == level);
        Rest {
            level_w: state.mean_w,
            std_err_w: state.std_err_w,
            visits: inside.map(|visit| (visit.from_s, visit.to_s)).collect(),
        }
    }
}

/// Scatter of means over some seconds within visits of one level, by their median size.
fn wander(blocks: &[Block], visits: &[(f64, f64)]) -> f64 {
    let mut means: Vec<f64> = Vec::new();
    for &(from, to) in visits {
        let inside: Vec<&Block> =
            blocks.iter().filter(|block| block.from_s >= from && block.to_s <= to).collect();
        let mut start = 0;
        for end in 0..inside.len() {
            if inside[end].to_s - inside[start].from_s >= WANDER_S {
                let window = &inside[start..=end];
                means.push(window.iter().map(|block| block.mean).sum::<f64>() / window.len() as f64);
                start = end + 1;
            }
        }
    }
    scale(&means).unwrap_or(0.0)
}
