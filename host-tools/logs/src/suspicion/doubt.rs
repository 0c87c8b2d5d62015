//! What there is to doubt of a log, in words; and what is known of any robot.

use serde::Serialize;

use crate::robot::Robot;

/// One reason to doubt a log.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Suspicion {
    /// Which.
    pub kind: Kind,
    /// What was found, against what was expected.
    pub text: String,
    /// What would mend it.
    pub remedy: String,
}

/// Kinds of suspicions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// Speeds of the wheels are in a different unit.
    SpeedUnit,
    /// So slow that driving costs much: speeds may be in m/s.
    SpeedDear,
    /// A wheel's speed has the wrong sign.
    SpeedSign,
    /// Power is in a different unit.
    PowerUnit,
    /// Power is negative while the robot drives.
    PowerSign,
    /// Power is 0 while the robot drives.
    NoPower,
    /// A sensor ends at a value.
    Clipped,
    /// Power comes later, or earlier, than the speeds that it belongs to.
    PowerLate,
    /// Masses are in a different unit, or none that this robot can have.
    Mass,
    /// Some rows have no mass.
    Unlabelled,
}

impl Kind {
    /// Whether the log is another one than its columns say: whatever is computed from it is wrong.
    /// The sign of one wheel is told by how robots are usually driven, which is less sure; masses are
    /// refused by whoever uses them.
    pub fn is_misread(self) -> bool {
        matches!(self, Self::SpeedUnit | Self::PowerUnit | Self::PowerSign | Self::NoPower)
    }
}

/// The mass that stands for a robot whose log tells none, kg: between empty and full, as far from
/// either.
pub(super) fn usual_mass_kg(robot: &Robot) -> f64 {
    (robot.mass_no_load_kg() * robot.mass_full_load_kg()).sqrt()
}
