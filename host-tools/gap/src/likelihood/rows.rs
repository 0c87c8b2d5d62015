//! The rows that count, and the pieces that they make.
//!
//! Every row is predicted, for a delay is interpolated between them; the likelihood sees one
//! of so many, as the filter leaves no more.

use logs::runs::Runs;

use super::priors::{ORDER, ROWS_PER_CUTOFF};

/// Of one run.
#[derive(Debug, Clone, PartialEq)]
pub struct Kept {
    /// Places of the kept rows.
    pub rows: Vec<usize>,
    /// Of each, whether the rows of its past are kept too.
    pub known: Vec<bool>,
}

impl Kept {
    /// Every `stride`-th row of each piece.
    fn of(starts: impl Iterator<Item = bool>, stride: usize) -> Self {
        let (mut rows, mut known) = (Vec::new(), Vec::new());
        let mut age = 0;
        for (place, starts) in starts.enumerate() {
            age = if starts { 0 } else { age + 1 };
            if age % stride == 0 {
                rows.push(place);
                known.push(age / stride >= ORDER);
            }
        }
        Self { rows, known }
    }

    /// What of a run's values is kept.
    pub fn thin(&self, values: &[f64]) -> Vec<f64> {
        self.rows.iter().map(|&row| values.get(row).copied().unwrap_or(0.0)).collect()
    }

    /// How many rows have a known past: the information that there is.
    pub fn count(&self) -> f64 {
        self.known.iter().filter(|known| **known).count() as f64
    }
}

/// Of all runs.
pub fn kept(runs: &Runs) -> Vec<Kept> {
    let wanted = ROWS_PER_CUTOFF * runs.cutoffs.power;
    let stride = (1.0 / (runs.period_s * wanted)).round().max(1.0) as usize;
    runs.runs.iter().map(|run| Kept::of(run.rows.iter().map(|row| row.starts), stride)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Forty rows with a gap before the 20th, every second kept: eight of each piece have no past.
    #[test]
    fn no_past_reaches_over_a_gap() {
        let kept = Kept::of((0..40).map(|row| row == 0 || row == 20), 2);
        assert_eq!(kept.rows.len(), 20);
        assert_eq!(kept.count(), 4.0);
        assert_eq!((kept.rows[10], kept.known[10], kept.known[8]), (20, false, true));
    }
}
