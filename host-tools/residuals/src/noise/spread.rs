//! How the scatter of the residual varies from row to row: with jerk, acceleration and power.
//!
//! Models of filtered signals fail where a wheel starts or stops: power is no linear function of
//! speed there, and the filter mixes rows before with rows after. Such rows scatter several times
//! as much as steady ones. With equal weights they would drown the steady rows.

use logs::runs::Runs;
use numerics::robust::scale_of_sizes;

use super::whiten::Signal;
use crate::thresholds::noise::{LEAST_ROWS, LEVELS, REACH, ROUNDS};

/// How the scatter depends on the three measures, as factors of the variance.
#[derive(Debug, Clone, PartialEq)]
pub struct Spread {
    /// Where the levels of each measure end.
    edges: [Vec<f64>; 3],
    /// The factor of each level.
    factors: [Vec<f64>; 3],
}

impl Spread {
    /// Of the rows of some runs whose weight is not 0.
    pub fn fit(runs: &Runs, residual: &Signal, known: &Signal, of: impl Fn(usize) -> bool) -> Self {
        let places: Vec<usize> = (0..runs.runs.len()).filter(|&place| of(place)).collect();
        let rows = || {
            let known = move |place: usize, row: usize| known[place][row] > 0.0;
            places.iter().flat_map(move |&place| {
                (0..residual[place].len()).filter(move |&row| known(place, row)).map(move |row| (place, row))
            })
        };
        let measures = measures(runs);
        let edges = std::array::from_fn(|m| {
            let values: Vec<f64> = rows().map(|(place, row)| measures[m][place][row]).collect();
            edges_of(values)
        });
        let mut spread = Self { edges, factors: std::array::from_fn(|_| vec![1.0; LEVELS]) };
        for _ in 0..ROUNDS {
            for m in 0..3 {
                let mut sizes: Vec<Vec<f64>> = vec![Vec::new(); LEVELS];
                for (place, row) in rows() {
                    let at = std::array::from_fn(|m| measures[m][place][row]);
                    sizes[level(&spread.edges[m], at[m])]
                        .push(residual[place][row].abs() / spread.variance(&at).sqrt());
                }
                for (factor, mut sizes) in spread.factors[m].iter_mut().zip(sizes) {
                    // The weights deal with stray rows.
                    if sizes.len() >= LEAST_ROWS
                        && let Some(scale) = scale_of_sizes(&mut sizes)
                    {
                        *factor *= scale.powi(2).max(1e-12);
                    }
                }
            }
        }
        spread
    }

    /// Standard deviation of each row's scatter.
    pub fn of(&self, runs: &Runs) -> Signal {
        let measures = measures(runs);
        let row = |place: usize, row: usize| {
            self.variance(&std::array::from_fn(|m| measures[m][place][row])).sqrt()
        };
        let runs = runs.runs.iter().enumerate();
        runs.map(|(place, run)| (0..run.rows.len()).map(|k| row(place, k)).collect()).collect()
    }

    fn variance(&self, at: &[f64; 3]) -> f64 {
        let factors = self.edges.iter().zip(&self.factors).zip(at);
        factors.map(|((edges, factors), value)| factors[level(edges, *value)]).product()
    }
}

fn level(edges: &[f64], value: f64) -> usize {
    edges.iter().filter(|edge| value >= **edge).count()
}

fn edges_of(mut values: Vec<f64>) -> Vec<f64> {
    if values.is_empty() {
        return Vec::new();
    }
    values.sort_by(f64::total_cmp);
    (1..LEVELS).map(|level| values[level * values.len() / LEVELS]).collect()
}

fn measures(runs: &Runs) -> [Signal; 3] {
    [jerk(runs), acceleration(runs), power(runs)]
}

fn acceleration(runs: &Runs) -> Signal {
    runs.runs
        .iter()
        .map(|run| {
            run.rows.iter().map(|row| row.wheels.iter().map(|wheel| wheel.acceleration.abs()).sum()).collect()
        })
        .collect()
}

fn power(runs: &Runs) -> Signal {
    // Speed stands for the power: the power itself holds the noise.
    runs.runs
        .iter()
        .map(|run| {
            run.rows
                .iter()
                .map(|row| row.mass * row.wheels.iter().map(|wheel| wheel.speed.abs()).sum::<f64>())
                .collect()
        })
        .collect()
}

/// Greatest change of a wheel's acceleration near a row.
fn jerk(runs: &Runs) -> Signal {
    runs.runs
        .iter()
        .map(|run| {
            let steps: Vec<f64> = (0..run.rows.len())
                .map(|k| {
                    let before = &run.rows[k.saturating_sub(1)].wheels;
                    let now = &run.rows[k].wheels;
                    now.iter().zip(before.iter()).map(|(a, b)| (a.acceleration - b.acceleration).abs()).sum()
                })
                .collect();
            (0..steps.len())
                .map(|k| {
                    let near = k.saturating_sub(REACH)..(k + REACH).min(steps.len());
                    steps[near].iter().fold(0.0, |most: f64, step| most.max(*step))
                })
                .collect()
        })
        .collect()
}
