//! Where the residual lies: its mean by speed, acceleration, turn rate, mass, time and every further column.

use serde::Serialize;

use super::runs::{Row, Runs};
use super::whiten::Signal;

/// One cell of a map.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cell {
    /// What is binned.
    pub axis: String,
    /// From …
    pub from: f64,
    /// … to.
    pub to: f64,
    /// Mean residual, W.
    pub mean_residual_w: f64,
    /// Half the 95 % interval, by the scatter of the runs' means, W.
    pub band_w: f64,
}

/// Bins of an axis: equal numbers of rows.
const BINS: usize = 6;

/// Rows of a run in a cell that say something about it.
const LEAST_ROWS: usize = 10;

/// All cells, the axes in order.
pub fn cells<const N: usize>(runs: &Runs<N>, residual: &Signal) -> Vec<Cell> {
    type Axis<const N: usize> = (&'static str, fn(&Row<N>) -> f64);
    let axes: [Axis<N>; 7] = [
        ("speed", |row| row.speed),
        ("acceleration", |row| {
            row.motion.wheels.iter().map(|w| w.acceleration * w.direction).sum::<f64>() / N as f64
        }),
        ("turn-rate", |row| row.turn_rate),
        ("mass", |row| row.mass),
        ("time", |row| row.time),
        ("side", |row| {
            let first = row.motion.wheels.first().map_or(0.0, |wheel| wheel.speed.abs());
            let last = row.motion.wheels.last().map_or(0.0, |wheel| wheel.speed.abs());
            last - first
        }),
        ("heading", |row| row.heading[1].atan2(row.heading[0])),
    ];
    let mut cells = Vec::new();
    for (name, value) in axes {
        let values: Signal = runs.runs.iter().map(|run| run.rows.iter().map(value).collect()).collect();
        cells.extend(axis(name, &values, residual));
    }
    for (place, name) in runs.columns.iter().enumerate() {
        if runs.runs.iter().all(|run| !run.extras[place].is_empty()) {
            let values: Signal = runs.runs.iter().map(|run| run.extras[place].clone()).collect();
            cells.extend(axis(name, &values, residual));
        }
    }
    cells
}

fn axis(name: &str, values: &Signal, residual: &Signal) -> Vec<Cell> {
    let mut sorted: Vec<f64> = values.iter().flatten().copied().filter(|value| value.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let Some(&last) = sorted.last() else { return Vec::new() };
    let mut edges: Vec<f64> = (0..BINS).map(|bin| sorted[bin * sorted.len() / BINS]).collect();
    edges.push(last);
    edges.dedup();
    if edges.len() == 1 {
        return Vec::new();
    }
    let bins = edges.len() - 1;
    let cell = |bin: usize| {
        let (from, to) = (edges[bin], edges[bin + 1]);
        let inside = |value: f64| value >= from && (value < to || bin + 1 == bins);
        let mut means = Vec::new();
        let (mut sum, mut rows) = (0.0, 0.0);
        for (values, residual) in values.iter().zip(residual) {
            let own: Vec<f64> =
                values.iter().zip(residual).filter(|(value, _)| inside(**value)).map(|(_, r)| *r).collect();
            if own.len() >= LEAST_ROWS {
                sum += own.iter().sum::<f64>();
                rows += own.len() as f64;
                means.push(own.iter().sum::<f64>() / own.len() as f64);
            }
        }
        let count = means.len() as f64;
        if means.len() < 2 {
            return None;
        }
        let mean = means.iter().sum::<f64>() / count;
        let variance = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (count - 1.0);
        Some(Cell {
            axis: name.to_owned(),
            from,
            to,
            mean_residual_w: sum / rows,
            band_w: 1.96 * (variance / count).sqrt(),
        })
    };
    (0..bins).filter_map(cell).collect()
}
