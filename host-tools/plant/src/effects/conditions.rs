//! What effects can change: the machine, what acts on it, and what its sensors make of it.

use super::super::body::{Loads, Wheel, WheelStep};
use super::super::drive::Drive;
use super::super::kinematics::{MAX_WHEELS, Twist};
use super::super::sets::Robot;

/// Everything that effects may change, for one integration step. Without effects it is the
/// scenario's robot.
#[derive(Debug, Clone, PartialEq)]
pub(in super::super) struct Conditions {
    /// Wheels with motors and gears.
    pub(in super::super) wheels: [Wheel; MAX_WHEELS],
    /// What acts on wheels and body beside the motors.
    pub(in super::super) loads: Loads,
    /// Mass on the wheels beyond the one in the log, kg.
    pub(in super::super) unnoted_kg: f64,
    /// Resistance between power sensor and drives, Ω.
    pub(in super::super) lead_ohm: f64,
    /// Share of the braking power that a drive returns although it is said not to.
    pub(in super::super) returned: f64,
    /// Power beside the drives', W.
    pub(in super::super) static_w: f64,
    /// Reading of the power sensor per watt.
    pub(in super::super) power_gain: f64,
    /// Reading of the power sensor without power, W.
    pub(in super::super) power_offset_w: f64,
    /// Speed as every encoder gives it per true speed; loop and log have the same encoder.
    pub(in super::super) speed_scale: [f64; MAX_WHEELS],
    /// How far the ground rises per length ahead of the robot and to its left.
    pub(in super::super) rise: [f64; 2],
    /// Coefficient of friction of tyres that slide over the floor; 0 where none does.
    pub(in super::super) sliding_friction: f64,
    /// Windings hotter than those of `wheels` were measured at, K.
    pub(in super::super) winding_rise_k: [f64; MAX_WHEELS],
}

impl Conditions {
    /// The robot as it is, on level floor, with true sensors.
    pub(in super::super) fn new(robot: &Robot) -> Self {
        Self {
            wheels: robot.wheels,
            loads: Loads::default(),
            unnoted_kg: 0.0,
            lead_ohm: 0.0,
            returned: 0.0,
            static_w: 0.0,
            power_gain: 1.0,
            power_offset_w: 0.0,
            speed_scale: [1.0; MAX_WHEELS],
            rise: [0.0; 2],
            sliding_friction: 0.0,
            winding_rise_k: [0.0; MAX_WHEELS],
        }
    }

    /// Slope under the robot, nose up, rad.
    pub(in super::super) fn pitch_rad(&self) -> f64 {
        self.rise[0].asin()
    }

    /// Heading counter-clockwise from straight uphill, rad within ±π; 0 on level ground.
    pub(in super::super) fn slope_heading_rad(&self) -> f64 {
        let [ahead, left] = self.rise;
        (-left).atan2(ahead)
    }

    /// Coefficient of rolling friction, as the wheels share the weight.
    pub(in super::super) fn rolling_friction(&self) -> f64 {
        let carrying = self.wheels.iter().map(|wheel| (wheel.rolling_resistance, wheel.load_share));
        let (sum, shares) =
            carrying.fold((0.0, 0.0), |(sum, all), (mu, share)| (sum + mu * share, all + share));
        sum / shares
    }

    /// Power that one motor takes from the leads, W.
    pub(in super::super) fn drive_power(&self, drive: &Drive, voltage: f64, current: f64) -> f64 {
        let motor = voltage * current;
        if motor < 0.0 && !drive.regeneration {
            self.returned * motor * drive.efficiency
        } else {
            drive.supply_power(voltage, current)
        }
    }

    /// Current, A, that the drives draw through the leads from a supply of `supply_v` to get
    /// `power_w`.
    ///
    /// The smaller solution of (E − R I) I = P. Where the leads cannot carry P, the current at
    /// which they carry most, E/(2R): the drives' voltage is then half of E, and the loop has to do
    /// with that from its next period on.
    pub(in super::super) fn lead_current(&self, power_w: f64, supply_v: f64) -> f64 {
        let rest = supply_v * supply_v - 4.0 * self.lead_ohm * power_w;
        if rest < 0.0 {
            return 0.5 * supply_v / self.lead_ohm;
        }
        2.0 * power_w / (supply_v + rest.sqrt())
    }

    /// What the power sensor makes of a true power, W.
    pub(in super::super) fn reading(&self, power_w: f64) -> f64 {
        self.power_gain * (power_w + self.static_w) + self.power_offset_w
    }
}

/// What effects can know of the run.
#[derive(Debug, Clone)]
pub(in super::super) struct Now {
    /// Time since the start, s.
    pub(in super::super) time_s: f64,
    /// Length of the step, s.
    pub(in super::super) step_s: f64,
    /// Total mass that the log notes, kg.
    pub(in super::super) mass_kg: f64,
    /// Body twist: forward m/s, leftward m/s, turn rate rad/s.
    pub(in super::super) twist: Twist,
    /// Heading since the start, counter-clockwise, rad.
    pub(in super::super) heading_rad: f64,
    /// Wheel speeds, rad/s.
    pub(in super::super) wheel_rad_s: [f64; MAX_WHEELS],
    /// What happened at the wheels in the last step.
    pub(in super::super) last: [WheelStep; MAX_WHEELS],
    /// Resistances of the windings in the last step, Ω.
    pub(in super::super) winding_ohm: [f64; MAX_WHEELS],
    /// Load of the computer, percent.
    pub(in super::super) cpu_percent: f64,
}
