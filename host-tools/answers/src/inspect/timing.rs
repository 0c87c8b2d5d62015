//! Steps of time: rate, jitter, gaps.

use logs::{Gap, MIN_GAP_FACTOR};
use serde::Serialize;

use super::sketch::median;

/// Rows whose steps give the median sample period.
const PERIOD_ROWS: usize = 4096;

/// Longest gaps kept for the report.
const KEPT_GAPS: usize = 20;

/// Steps from row to row within runs.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Timing {
    /// Spread of the step.
    pub jitter: Jitter,
    /// Gaps in all: steps above three median periods.
    pub gap_count: u64,
    /// The longest gaps, in order of time.
    pub gaps: Vec<Gap>,
}

/// Spread of the step from row to row, gaps left out, s.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub struct Jitter {
    /// Standard deviation.
    pub std_s: f64,
    /// Shortest step.
    pub min_s: f64,
    /// Longest step that is no gap.
    pub max_s: f64,
}

#[derive(Default)]
pub(super) struct Steps {
    first: Vec<f64>,
    waiting: Vec<(f64, Gap)>,
    period_s: Option<f64>,
    count: f64,
    mean: f64,
    squares: f64,
    timing: Timing,
}

impl Steps {
    /// Adds the step to a row; whether it is a gap. While the period is not known yet nothing is.
    pub(super) fn add(&mut self, line: u64, from_s: f64, to_s: f64) -> bool {
        let step = to_s - from_s;
        let gap = Gap { line, from_s, to_s };
        if let Some(period) = self.period_s {
            return self.judge(step, gap, period);
        }
        self.first.push(step);
        self.waiting.push((step, gap));
        if self.first.len() == PERIOD_ROWS {
            self.settle();
        }
        // A guess for the rows before the period is settled: derivatives must not cross a hole.
        let recent = &self.first[self.first.len().saturating_sub(9)..];
        recent.len() == 9 && step > MIN_GAP_FACTOR * median(&mut recent.to_vec())
    }

    fn settle(&mut self) {
        let period = median(&mut self.first);
        self.period_s = Some(period);
        for (step, gap) in std::mem::take(&mut self.waiting) {
            self.judge(step, gap, period);
        }
    }

    fn judge(&mut self, step: f64, gap: Gap, period: f64) -> bool {
        let jitter = &mut self.timing.jitter;
        if self.count == 0.0 || step < jitter.min_s {
            jitter.min_s = step;
        }
        if step > MIN_GAP_FACTOR * period {
            self.timing.gap_count += 1;
            self.timing.gaps.push(gap);
            if self.timing.gaps.len() > 2 * KEPT_GAPS {
                self.keep_longest();
            }
            return true;
        }
        jitter.max_s = jitter.max_s.max(step);
        self.count += 1.0;
        let deviation = step - self.mean;
        self.mean += deviation / self.count;
        self.squares += deviation * (step - self.mean);
        false
    }

    fn keep_longest(&mut self) {
        let length = |gap: &Gap| gap.to_s - gap.from_s;
        self.timing.gaps.sort_by(|a, b| length(b).total_cmp(&length(a)));
        self.timing.gaps.truncate(KEPT_GAPS);
        self.timing.gaps.sort_by_key(|gap| gap.line);
    }

    /// Median period of the rows so far, s.
    pub(super) fn period_s(&self) -> f64 {
        self.period_s.unwrap_or_else(|| median(&mut self.first.clone()))
    }

    /// Median period, s, and the steps.
    pub(super) fn finish(mut self) -> (f64, Timing) {
        if self.period_s.is_none() {
            self.settle();
        }
        self.keep_longest();
        self.timing.jitter.std_s = (self.squares / self.count.max(1.0)).sqrt();
        (self.period_s(), self.timing)
    }
}
