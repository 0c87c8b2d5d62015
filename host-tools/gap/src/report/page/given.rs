//! What the page is told beside the report.

use std::path::PathBuf;

use super::course::Course;
use crate::report::localise::Cell;

/// What was asked for: shown, so that it can be asked again.
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

/// The same disagreement as another model of the robot sees it: the simulated plant.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulated {
    /// What was simulated and what came of it, sentences.
    pub text: Vec<String>,
    /// Run by run: measured, and simulated before and after.
    pub courses: Vec<Course>,
    /// Where the residual lies.
    pub cells: Vec<Cell>,
}
