//! The rows that count, and the pieces that they make.
//!
//! Every row is predicted, for a delay is interpolated between them; the likelihood sees one
//! of so many, as the filter leaves no more.

use logs::runs::{ROWS_PER_CUTOFF, Row, Run, Runs};

/// All runs with the rows that count.
#[derive(Debug, Clone)]
pub struct Kept {
    /// The runs with these rows alone.
    pub runs: Runs,
    /// Places of the kept rows, run by run.
    places: Vec<Vec<usize>>,
}

impl Kept {
    /// Every so many-th row of each piece.
    pub fn of(runs: &Runs) -> Self {
        let wanted = ROWS_PER_CUTOFF * runs.cutoffs.power;
        let stride = (1.0 / (runs.period_s * wanted)).round().max(1.0) as usize;
        let places: Vec<Vec<usize>> = runs.runs.iter().map(|run| every(stride, &run.rows)).collect();
        let thinned = |(run, places): (&Run, &Vec<usize>)| Run {
            rows: places.iter().map(|&row| run.rows[row]).collect(),
            extras: Vec::new(),
            ..run.clone()
        };
        let thin = runs.runs.iter().zip(&places).map(thinned).collect();
        let runs = Runs { runs: thin, period_s: stride as f64 * runs.period_s, ..runs.clone() };
        Self { runs, places }
    }

    /// What of a run's values is kept.
    pub fn thin(&self, run: usize, values: &[f64]) -> Vec<f64> {
        self.places[run].iter().map(|&row| values.get(row).copied().unwrap_or(0.0)).collect()
    }
}

/// Places of every `stride`-th row of each piece.
fn every(stride: usize, rows: &[Row]) -> Vec<usize> {
    let ages = rows.iter().scan(0, |age, row| {
        *age = if row.starts { 0 } else { *age + 1 };
        Some(*age)
    });
    ages.enumerate().filter(|(_, age)| age % stride == 0).map(|(place, _)| place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::likelihood::tests::{Normal, runs};

    /// Forty rows with a gap before the 19th, every second kept: each piece begins anew.
    #[test]
    fn every_piece_begins_with_its_first_row() {
        let mut rows = runs(1, &[], &mut Normal(1)).runs[0].rows[..40].to_vec();
        rows[0].starts = true;
        rows[19].starts = true;
        let places = every(2, &rows);
        assert_eq!(places.len(), 21);
        assert_eq!(places[9..12], [18, 19, 21]);
    }
}
