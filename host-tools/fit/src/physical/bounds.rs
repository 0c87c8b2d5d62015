//! What a motor and a wheel can be.
//!
//! Wide ranges from the robot's mass, its wheels and the speeds that it drove, narrower ones for κ
//! where robot.toml tells of the motors. Data that determine a parameter do not come near them;
//! data that do not would run to 10⁶ or 10⁻⁵ without.

use logs::robot::Motor;
use logs::robot::chassis::Chassis;
use model_core::effects::GRAVITY;
use model_core::plausibility::LEAST_GEAR_EFFICIENCY;
pub(crate) use model_core::plausibility::MOST_GEAR_LOSS;
use nalgebra::Const;
use numerics::levenberg_marquardt;

use super::super::dataset::Stretch;
use super::super::verdict::{self, Description};
use super::FreeTerms;
use super::cost::{PARAMETERS as COUNT, Parameters, WINDING_LOSS};

/// Least efficiency of motor, gear and drive together: torques are found with it folded in.
const LEAST_EFFICIENCY: f64 = 0.2;

/// Greatest friction between wheel and ground: rubber on rough asphalt.
const GREATEST_FRICTION: f64 = 1.5;

/// The robot can climb this on its own wheels, empty: what its motors can do at least, as a share
/// of its weight.
const LEAST_GRADE: f64 = 0.1;

/// Its motors turn at most so many times as fast as it was driven.
const SPEED_RESERVE: f64 = 2.0;

/// Rotors have at most so many times the body's own inertia, as the wheels see both: with the
/// square of a gear ratio of some hundreds those of small servos reach fifty (Table 3).
const MOST_ROTOR_SHARE: f64 = 1000.0;

/// Copper warms by some 100 K, and leads and bridge have a resistance, too.
const HOT: f64 = 1.5;
/// Spread of motors about their data sheet.
const SPREAD: f64 = 0.8;

/// Least and greatest value of each parameter, in the order of [`Parameters`].
#[derive(Debug, Clone, PartialEq)]
pub struct Bounds(levenberg_marquardt::Bounds<Const<COUNT>>);

/// A parameter at a bound other than 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AtBound {
    /// Which.
    pub description: &'static Description,
    /// The bound, in the parameter's unit.
    pub bound: f64,
    /// robot.toml tells of the motor that it is the bound of.
    pub of_motor: bool,
}

impl AtBound {
    /// Whether it is a loss of the gear: a term that a fit can do without.
    pub fn is_of_gear_loss(&self) -> bool {
        self.description.name == verdict::of_torque(super::GEAR_LOSS).name
    }

    /// What would determine the parameter.
    pub fn remedy(&self) -> String {
        let mut remedy = self.description.remedy.to_owned();
        if self.description.name == "winding_loss" && !self.of_motor {
            remedy.push_str(", or give motor_resistance_ohm, motor_torque_constant_nm_a and motor_gear_ratio in robot.toml");
        }
        remedy
    }
}

impl Bounds {
    /// For a robot on these drives, with what is known of its motors and the terms that are free.
    ///
    /// Weight m g on N wheels of radius r gives the torque T = m g r / N at which they slip with a
    /// friction of 1.
    ///
    /// | parameter | at most |
    /// |---|---|
    /// | coulomb, imbalance | T of the full robot / efficiency: the drag of a robot whose wheels are locked |
    /// | rolling, scrub | T per kilogram times 1 and 1.5, the greatest friction / efficiency |
    /// | viscous | that of coulomb at the fastest speed driven |
    /// | rotor_inertia | a thousand times the body's own m r² / N |
    /// | inertia_gain | 1 / least efficiency² |
    /// | gear_loss | the least efficiency of a gear |
    /// | bridge_drop | half of the supply: half of the speed without load, that is the fastest speed driven |
    /// | winding_loss | κ = R/(Kt n)² is no-load speed over stall torque: twice the speed driven over 0.1 T of the empty robot |
    pub fn of(robot: &Chassis, rows: Stretch<'_>, motor: Option<&Motor>, free_terms: FreeTerms) -> Self {
        let speeds = rows.iter().flat_map(|row| row.wheels).map(|wheel| wheel.speed.abs());
        Self::up_to(robot, speeds.fold(0.0, f64::max), motor, free_terms)
    }

    /// The same of rows whose fastest wheel turned at so many rad/s.
    pub fn up_to(robot: &Chassis, fastest: f64, motor: Option<&Motor>, free_terms: FreeTerms) -> Self {
        // λ_max of M'' is the inertia per kilogram that the stiffest common motion shows to one
        // wheel: r²/N where all drive straight ahead.
        let wheels = robot.wheels() as f64;
        let per_wheel = robot.mass_matrix().symmetric_eigenvalues().max();
        let radius = (wheels * per_wheel).sqrt();
        let per_kg = GRAVITY * radius / wheels;
        let (empty, full) = (robot.range().no_load(), robot.range().full_load());
        let fastest = fastest.max(robot.dead_band()).max(1e-3);
        let drag = full * per_kg / LEAST_EFFICIENCY;
        let stall = LEAST_GRADE * empty * per_kg;
        let widest = SPEED_RESERVE * fastest / (stall * LEAST_GEAR_EFFICIENCY.powi(2));
        let (least_loss, most_loss) = motor.map_or((0.0, widest), |motor| {
            let ideal = motor.resistance_ohm / (motor.torque_constant_nm_a * motor.gear_ratio).powi(2);
            let efficiency = motor.gear_efficiency.unwrap_or(LEAST_GEAR_EFFICIENCY);
            (SPREAD * ideal, HOT * ideal / efficiency.powi(2))
        });
        let imbalance = if free_terms.unequal_sides { drag } else { 0.0 };
        let [gear_loss, share] = free_terms.gear_loss.map_or([0.0; 2], |share| [MOST_GEAR_LOSS, share]);
        let bridge_drop = if free_terms.bridge_drop { 0.5 * SPEED_RESERVE * fastest } else { 0.0 };
        let upper = [
            drag,
            per_kg / LEAST_EFFICIENCY,
            drag / fastest,
            MOST_ROTOR_SHARE * full * per_wheel,
            LEAST_EFFICIENCY.powi(-2),
            most_loss,
            GREATEST_FRICTION * per_kg / LEAST_EFFICIENCY,
            imbalance,
            gear_loss,
            bridge_drop,
            share,
        ];
        let lower = [0.0, 0.0, 0.0, 0.0, 0.0, least_loss, 0.0, -imbalance, 0.0, 0.0, share];
        Self(levenberg_marquardt::Bounds { lower: lower.into(), upper: upper.into() })
    }

    /// Any, in the order of the parameters.
    #[cfg(test)]
    pub(super) fn from_ends(lower: [f64; COUNT], upper: [f64; COUNT]) -> Self {
        Self(levenberg_marquardt::Bounds { lower: lower.into(), upper: upper.into() })
    }

    /// As the solver takes them.
    pub fn as_box(&self) -> &levenberg_marquardt::Bounds<Const<COUNT>> {
        &self.0
    }

    /// Which parameters may move.
    pub(super) fn free(&self) -> [bool; COUNT] {
        std::array::from_fn(|place| self.0.lower[place] < self.0.upper[place])
    }

    /// Least values.
    pub fn lower(&self) -> &Parameters {
        &self.0.lower
    }

    /// Greatest values.
    pub fn upper(&self) -> &Parameters {
        &self.0.upper
    }

    /// Free parameters at a bound other than 0.
    pub fn met_by(&self, parameters: &Parameters) -> Vec<AtBound> {
        let at = |place: usize| {
            let bounds = [self.0.lower[place], self.0.upper[place]];
            let met = bounds.into_iter().find(|bound| *bound != 0.0 && parameters[place] == *bound)?;
            Some(AtBound {
                description: verdict::of_torque(place),
                bound: met,
                of_motor: place == WINDING_LOSS && self.0.lower[place] > 0.0,
            })
        };
        let free = self.free();
        (0..COUNT).filter(|place| free[*place]).filter_map(at).collect()
    }
}
