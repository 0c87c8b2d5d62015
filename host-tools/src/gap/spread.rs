//! How the scatter of what is left varies from row to row: with jerk, acceleration and power.
//!
//! No model of filtered signals is right where a wheel starts or stops: the power is no linear function of the speeds there, and
//! the filter mixes what was before with what comes behind. Such rows scatter several times as much as steady ones. Weighed alike
//! they would drown what the steady ones say.

use super::runs::Runs;
use super::whiten::Signal;

/// Levels of each measure: equal numbers of rows.
const LEVELS: usize = 8;

/// Rows of a level that tell its scatter.
const LEAST_ROWS: usize = 40;

/// A few rounds settle what each measure explains beyond the others.
const ROUNDS: usize = 4;

/// Rows before and behind that share in the jerk of a row: the filter's memory.
const REACH: usize = 2;

/// Standard deviation of each row's scatter relative to the usual. `None` rows (of no weight) have 1.
pub fn relative<const N: usize>(runs: &Runs<N>, left: &Signal, known: &Signal) -> Signal {
    let measures = [jerk(runs), acceleration(runs), power(runs)];
    let levels: Vec<Vec<Vec<usize>>> = measures.iter().map(ranked).collect();
    let mut variance: Signal = left.iter().map(|run| vec![1.0; run.len()]).collect();
    for _ in 0..ROUNDS {
        for level in &levels {
            let mut squares: Vec<Vec<f64>> = vec![Vec::new(); LEVELS];
            for (run, own) in level.iter().enumerate() {
                for (row, &bin) in own.iter().enumerate() {
                    if known[run][row] > 0.0 {
                        squares[bin].push(left[run][row].powi(2) / variance[run][row]);
                    }
                }
            }
            let factors = squares.into_iter().map(scatter).collect::<Vec<_>>();
            for (own, variance) in level.iter().zip(&mut variance) {
                for (&bin, variance) in own.iter().zip(variance) {
                    *variance *= factors[bin];
                }
            }
        }
    }
    for value in variance.iter_mut().flatten() {
        *value = value.sqrt();
    }
    variance
}

/// Mean square without the stray tenth, which the weights deal with.
fn scatter(mut squares: Vec<f64>) -> f64 {
    if squares.len() < LEAST_ROWS {
        return 1.0;
    }
    squares.sort_by(f64::total_cmp);
    squares.truncate(squares.len() * 9 / 10);
    // Of a normal variable the lower nine tenths of squares have a mean of 0.623.
    (squares.iter().sum::<f64>() / squares.len() as f64 / 0.623).max(1e-12)
}

fn acceleration<const N: usize>(runs: &Runs<N>) -> Signal {
    runs.runs
        .iter()
        .map(|run| {
            run.rows
                .iter()
                .map(|row| row.motion.wheels.iter().map(|wheel| wheel.acceleration.abs()).sum())
                .collect()
        })
        .collect()
}

fn power<const N: usize>(runs: &Runs<N>) -> Signal {
    // Speed stands for the power: the power itself holds the noise.
    runs.runs
        .iter()
        .map(|run| {
            run.rows
                .iter()
                .map(|row| row.mass * row.motion.wheels.iter().map(|wheel| wheel.speed.abs()).sum::<f64>())
                .collect()
        })
        .collect()
}

/// Greatest change of a wheel's acceleration near a row.
fn jerk<const N: usize>(runs: &Runs<N>) -> Signal {
    runs.runs
        .iter()
        .map(|run| {
            let steps: Vec<f64> = (0..run.rows.len())
                .map(|k| {
                    let before = &run.rows[k.saturating_sub(1)].motion.wheels;
                    let now = &run.rows[k].motion.wheels;
                    now.iter().zip(before).map(|(a, b)| (a.acceleration - b.acceleration).abs()).sum()
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

/// The level of each row.
fn ranked(values: &Signal) -> Vec<Vec<usize>> {
    let mut sorted: Vec<f64> = values.iter().flatten().copied().collect();
    sorted.sort_by(f64::total_cmp);
    let edges: Vec<f64> = (1..LEVELS).map(|level| sorted[level * sorted.len() / LEVELS]).collect();
    let level = |value: &f64| edges.iter().filter(|edge| value >= edge).count();
    values.iter().map(|run| run.iter().map(level).collect()).collect()
}
