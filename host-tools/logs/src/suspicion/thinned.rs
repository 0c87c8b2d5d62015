//! Some rows of a log, evenly over the whole, in bounded memory.

use numerics::robust;

/// Most wheels that the tools are compiled for.
const MOST_WHEELS: usize = model_core::coefficients::MOST_WHEELS;

/// Most rows kept; when there are more, every second one goes.
const MOST_ROWS: usize = 1 << 15;

/// One row.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row {
    speeds: [f64; MOST_WHEELS],
    wheels: usize,
    pub(super) power_w: f64,
    /// NaN where the log does not tell.
    pub(super) mass_kg: f64,
    pub(super) moves: bool,
}

impl Row {
    pub(super) fn new(wheels: &[f64], power_w: f64, mass_kg: f64, moves: bool) -> Self {
        let mut speeds = [0.0; MOST_WHEELS];
        let count = wheels.len().min(MOST_WHEELS);
        speeds[..count].copy_from_slice(&wheels[..count]);
        Self { speeds, wheels: count, power_w, mass_kg, moves }
    }

    /// Speeds of the wheels, rad/s.
    pub(super) fn wheels(&self) -> &[f64] {
        &self.speeds[..self.wheels]
    }

    /// Speed of the fastest wheel, rad/s.
    pub(super) fn fastest(&self) -> f64 {
        self.wheels().iter().fold(0.0, |fastest, speed| fastest.max(speed.abs()))
    }
}

/// Every k-th row, k doubling.
#[derive(Debug, Default)]
pub(super) struct Thinned {
    rows: Vec<Row>,
    doublings: u32,
    seen: u64,
}

impl Thinned {
    pub(super) fn add(&mut self, row: Row) {
        if self.seen.is_multiple_of(1 << self.doublings) {
            if self.rows.len() == MOST_ROWS {
                let mut place = 0;
                self.rows.retain(|_| {
                    place += 1;
                    place % 2 == 1
                });
                self.doublings += 1;
            }
            if self.seen.is_multiple_of(1 << self.doublings) {
                self.rows.push(row);
            }
        }
        self.seen += 1;
    }

    pub(super) fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// Median power while no wheel moves, W; 0 where that never is.
    pub(super) fn standing_power_w(&self) -> f64 {
        let mut standing: Vec<f64> =
            self.rows.iter().filter(|row| !row.moves).map(|row| row.power_w).collect();
        robust::median(&mut standing).unwrap_or(0.0)
    }
}
