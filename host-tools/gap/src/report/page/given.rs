//! Inputs of the page beside the report.

use std::path::PathBuf;

use super::course::Course;
use crate::report::localise::Cell;

/// The request, shown so that it can be repeated.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Inputs {
    /// Name of the robot.
    pub robot: String,
    /// Coefficients of the base.
    pub coefficients: Option<PathBuf>,
    /// Logs of the runs in question.
    pub logs: Vec<PathBuf>,
    /// Logs of the clean runs that were at hand.
    pub clean: Vec<PathBuf>,
    /// Further options and their values.
    pub options: Vec<(String, String)>,
}

/// The simulated plant's disagreement with the measurement.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulated {
    /// The simulation and its result, sentences.
    pub text: Vec<String>,
    /// Run by run: measured, and simulated before and after.
    pub courses: Vec<Course>,
    /// Where the residual lies.
    pub cells: Vec<Cell>,
}
