//! What candidates are made for: the sizes of some runs, of the robot, and of what was fitted to
//! it.

use model_core::torque::TorqueModel;

/// A column that every run has.
#[derive(Debug, Clone, PartialEq)]
pub struct ScopeColumn {
    /// Its name.
    pub name: String,
    /// Its place among the further columns of the runs.
    pub place: usize,
    /// Its least value.
    pub least: f64,
}

/// Sizes that say which effects can show, and which coefficients are plausible.
#[derive(Debug, Clone, PartialEq)]
pub struct Scope {
    /// The base.
    pub base: TorqueModel<f64>,
    /// Whether it was fitted at one total mass: friction that grows with the mass and friction that
    /// does not are then one.
    pub one_mass: bool,
    /// Whether the drives feed braking power back.
    pub regenerative: bool,
    /// Whether the base has a scrub of its own.
    pub scrubs: bool,
    /// Whether that builds up with the slip of a turn.
    pub slips: bool,
    /// Static power that was taken off the logs, W.
    pub static_power: f64,
    /// For each wheel: below 0 on the left, above 0 on the right, 0 on neither side.
    pub sides: Vec<f64>,
    /// Further columns that every run has.
    pub columns: Vec<ScopeColumn>,
    /// Wheel speed that is rarely exceeded, rad/s.
    pub speed: f64,
    /// Torque of the base at that speed and the middle mass, N·m.
    pub torque: f64,
    /// Middle mass, kg.
    pub mass: f64,
    /// Mass of the empty robot, kg.
    pub empty: f64,
    /// Least mass in the runs, kg.
    pub lightest: f64,
    /// Length of the longest run, s.
    pub duration: f64,
    /// Usual power in motion, W.
    pub power: f64,
}

/// Losses beyond this many times the base's own torque belong to another robot.
const MUCH: f64 = 20.0;

impl Scope {
    /// A column that every run has.
    pub fn column(&self, name: &str) -> Option<&ScopeColumn> {
        self.columns.iter().find(|column| column.name == name)
    }

    /// Whether there are wheels on two sides.
    pub fn has_sides(&self) -> bool {
        self.sides.iter().any(|side| *side > 0.0) && self.sides.iter().any(|side| *side < 0.0)
    }

    /// The greatest torque that an effect can take, N·m.
    pub(super) fn much(&self) -> f64 {
        MUCH * self.torque
    }

    /// The same per kilogram, N·m/kg.
    pub(super) fn much_per_kg(&self) -> f64 {
        self.much() / self.mass
    }

    /// The same per speed, N·m·s/rad.
    pub(super) fn much_per_speed(&self) -> f64 {
        self.much() / self.speed
    }

    /// The greatest mass that nobody noted, kg.
    pub(super) fn much_mass(&self) -> f64 {
        MUCH * self.mass
    }

    /// The greatest loss per torque, 1/(N·m).
    pub(super) fn much_per_torque(&self) -> f64 {
        MUCH / self.torque
    }
}
