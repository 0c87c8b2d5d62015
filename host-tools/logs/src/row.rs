//! Rows after the filter, and the run that they are.

use std::sync::Arc;

use super::motions::Motions;
use super::robot::chassis::Wheels;
use super::shared::Shared;

/// One row after the filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// The wheels.
    pub wheels: Wheels,
    /// Actuation power, W.
    pub power: f64,
    /// Total mass as the log tells it, kg.
    pub mass: f64,
    /// Time since the start of the run, s.
    pub time: f64,
    /// Turn rate, rad/s.
    pub turn_rate: f64,
    /// Forward speed, m/s.
    pub speed: f64,
    /// Cosine and sine of the heading since the start of the run.
    pub heading: [f64; 2],
    /// How long the robot has not moved, s: 0 while it moves, infinite before it first does.
    pub still: f64,
    /// Does not continue the row before: the first of the run, or after a gap.
    pub starts: bool,
}

/// One run; a clone shares its rows and columns.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// Its log, and its name there where the log holds several.
    pub name: String,
    /// Its rows.
    pub rows: Shared<Row>,
    /// Further columns after the filter, in the order of
    /// [`Runs::columns`](super::runs::Runs::columns); empty where this run lacks one.
    pub extras: Vec<Shared<f64>>,
    /// When the robot moved.
    pub motions: Arc<Motions>,
    /// One of those that the base was fitted to: without any effect.
    pub clean: bool,
}

impl Run {
    /// The further column at this place; empty where the run lacks it.
    pub fn extra(&self, place: usize) -> &[f64] {
        self.extras.get(place).map_or(&[], |column| column)
    }
}
