//! What can be wrong with coefficients, as a value: whoever reads them can tell another robot's
//! from damaged ones.

use model_core::plausibility::LEAST_CUTOFF;
use thiserror::Error;

use crate::effects::written::Wrong;

/// Key of the filter's cutoff.
pub(super) const CUTOFF: &str = "filter_cutoff_hz";

/// Key of the true slip's coefficient.
pub(super) const TRUE_SLIP: &str = "true_slip_s_rad";

/// Key of the share of the power that a fit explains.
const R2: &str = "r2";

/// Why a text is no coefficients, or none for this robot.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum InvalidCoefficients {
    /// No TOML, or not with the keys that a fit writes.
    #[error("{message}; expected coefficients as gmr fit writes them")]
    Layout {
        /// What the parser says.
        message: String,
        /// Where, counted from 1.
        line: Option<u64>,
    },
    /// Of another version.
    #[error("format {format}; expected {}, {}, {} or {}", .known[0], .known[1], .known[2], .known[3])]
    Format {
        /// The version found.
        format: u32,
        /// Those known here.
        known: [u32; 4],
    },
    /// Fitted for another robot.
    #[error("{0}")]
    OtherRobot(Difference),
    /// The robot's section is of none.
    #[error("{0}")]
    Robot(String),
    /// A number that no fit gives.
    #[error("found {value}; expected a finite number not below 0")]
    Number {
        /// Its key.
        key: String,
        /// The number.
        value: f64,
    },
    /// A filter that no robot has.
    #[error("found {value}; expected {LEAST_CUTOFF} or more: a slower filter settles too late for any mass")]
    Cutoff {
        /// Hz
        value: f64,
    },
    /// A parameter of the model is not there.
    #[error("{name} is missing or not a number")]
    NoParameter {
        /// Which.
        name: &'static str,
    },
    /// True slip, where nothing measures a turn rate.
    #[error(
        "true slip needs the turn rate of a gyro, which only gmr estimate and gmr gap read, from a log; expected coefficients without: \
         gmr fit --no-gyro"
    )]
    TrueSlip,
    /// A fit that says less than the mean of its own rows.
    #[error("NOT USABLE ({0}): fit again; gmr inspect says what the logs lack")]
    NotUsable(String),
    /// No covariance of these parameters.
    #[error("{0}")]
    Covariance(InvalidCovariance),
    /// An effect that is unknown, lacks something, or makes powers that no robot draws.
    #[error("{}", .0.message)]
    Effect(Wrong),
}

/// What makes another robot of one.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum Difference {
    /// The number of wheels.
    #[error("fitted for a robot with {wheels} wheels; expected {expected}: wrong robot?")]
    Wheels {
        /// As the file says.
        wheels: usize,
        /// As the robot has.
        expected: usize,
    },
    /// What it is built like.
    #[error(
        "these coefficients are for another robot: {robot} differs from {fitted}, which they were fitted for, in {what}"
    )]
    Body {
        /// Which part of it.
        what: &'static str,
        /// The robot's name.
        robot: String,
        /// The name in the file.
        fitted: String,
    },
    /// A key of robot.toml that decides what the fit took for power and motion.
    #[error("these coefficients are for another robot: {key} = {now} of {name}, but fitted with {fitted}")]
    Setting {
        /// The key.
        key: &'static str,
        /// The robot's name.
        name: String,
        /// What the robot's file says.
        now: String,
        /// What the coefficients say.
        fitted: String,
    },
}

/// Why a matrix is no covariance.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum InvalidCovariance {
    /// Not square, or of another number of parameters, or with what is no number.
    #[error("expected {size} rows of {size} finite numbers, one a parameter")]
    Entries {
        /// How many parameters there are.
        size: usize,
    },
    /// A variance below 0.
    #[error("the variance in row {row} is {value}; expected 0 or more")]
    Variance {
        /// Which, from 1.
        row: usize,
        /// What was found.
        value: f64,
    },
    /// Two entries that have to be equal are not.
    #[error(
        "{above} in row {row}, column {column}, but {below} across the diagonal; expected a symmetric matrix"
    )]
    Asymmetric {
        /// From 1.
        row: usize,
        /// From 1.
        column: usize,
        /// Above the diagonal.
        above: f64,
        /// Below it.
        below: f64,
    },
    /// Two parameters that vary together more than they vary.
    #[error("a correlation of {correlation} in row {row}, column {column}; expected −1 to 1")]
    Correlation {
        /// From 1.
        row: usize,
        /// From 1.
        column: usize,
        /// What was found.
        correlation: f64,
    },
}

impl InvalidCoefficients {
    /// The key at fault; a section's name where it is about all of it.
    pub fn key(&self) -> Option<&str> {
        match self {
            Self::Layout { .. } => None,
            Self::Format { .. } => Some("format"),
            Self::OtherRobot(_) | Self::Robot(_) => Some("robot"),
            Self::Number { key, .. } => Some(key),
            Self::Cutoff { .. } => Some(CUTOFF),
            Self::NoParameter { .. } => Some("parameters"),
            Self::TrueSlip => Some(TRUE_SLIP),
            Self::NotUsable(_) => Some(R2),
            Self::Covariance(_) => Some("covariance"),
            Self::Effect(wrong) => Some(wrong.key),
        }
    }

    /// The line of a text at fault, counted from 1.
    pub(super) fn line(&self, text: &str) -> Option<u64> {
        match self {
            Self::Layout { line, .. } => *line,
            Self::Number { key, .. } => line_of(text, key),
            Self::Cutoff { .. } => line_of(text, CUTOFF),
            Self::TrueSlip => line_of(text, TRUE_SLIP),
            Self::NotUsable(_) => line_of(text, R2),
            Self::Covariance(_) => line_of(text, "covariance"),
            Self::Effect(wrong) => line_of_effect(text, wrong.place, wrong.key),
            Self::Format { .. } | Self::OtherRobot(_) | Self::Robot(_) | Self::NoParameter { .. } => None,
        }
    }
}

/// The line on which a key stands.
fn line_of(text: &str, key: &str) -> Option<u64> {
    let holds = |line: &str| line.split_once('=').is_some_and(|(name, _)| name.trim() == key);
    text.lines().position(holds).map(|index| index as u64 + 1)
}

/// The line of a key within the effect at this place, or of the effect where it has no such key.
fn line_of_effect(text: &str, place: usize, key: &str) -> Option<u64> {
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    let mut starts = lines.iter().enumerate().filter(|(_, line)| **line == "[[effects]]").map(|(at, _)| at);
    let start = starts.nth(place)?;
    let end = starts.next().unwrap_or(lines.len());
    let holds = |line: &&str| line.split_once('=').is_some_and(|(name, _)| name.trim() == key);
    let within = lines[start..end].iter().position(holds).unwrap_or(0);
    Some((start + within) as u64 + 1)
}
