//! Motor sets: the paper's Table 3, a servo like the XL430-W250 and a gear motor, on a robot like
//! the TurtleBot3 Burger.

use serde::Serialize;

use super::body::{GRAVITY, Wheel};
use super::controller::Gains;
use super::gear::Gear;
use super::kinematics::{Geometry, Kinematics, MAX_WHEELS};
use super::motor::Motor;
use super::profile::Limits;

/// Which plant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum PlantSet {
    /// The paper's simulated motors (Table 3). They do not conserve energy: Kt and Ke differ.
    Table3,
    /// A servo motor like the XL430-W250, from its published stall and no-load figures.
    Servo,
    /// A gear motor four times as fast, from the published figures of one of 37 mm: winding, supply
    /// and braking matter to it.
    Gearmotor,
}

/// Everything about the robot that does not change during a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Robot {
    /// Wheel layout and lengths.
    pub geometry: Geometry,
    /// Radius of gyration about the vertical axis, m; taken as the same with and without payload.
    pub gyration_radius_m: f64,
    /// Wheels with motors and gears.
    pub wheels: [Wheel; MAX_WHEELS],
    /// Speed loop.
    pub gains: Gains,
    /// Standard deviation of the bounded noise on the loop's speed measurement, rad/s at the wheel.
    pub loop_noise_rad_s: f64,
    /// Supply voltage, V: the loop's limit and what the power sensor sees.
    pub supply_v: f64,
    /// Limits of generated profiles.
    pub limits: Limits,
}

/// μ_r of paper Section 6; also for the servo's robot, which stands on the same kind of wheels.
const ROLLING_RESISTANCE: f64 = 0.032;

/// From a gentle start to a brisk one of a small robot, m/s².
const GENTLE_M_S2: (f64, f64) = (0.05, 0.5);

/// Gear ratio of the first two sets (paper Table 3; XL430-W250 e-manual, Specifications).
const GEAR_RATIO: f64 = 258.5;

impl Robot {
    /// A robot with the motors of `set` on the wheels of `kinematics`, with the Burger's
    /// dimensions: wheel radius 33 mm, track 160 mm (paper Table 2, twice the turning radius;
    /// URDF). The three- and four-wheeled relatives keep these lengths, with 160 mm between front
    /// and rear wheels.
    pub fn new(set: PlantSet, kinematics: Kinematics) -> Self {
        let geometry = Geometry { kinematics, wheel_radius_m: 0.033, track_m: 0.160, wheelbase_m: 0.160 };
        let (motor, gear) = match set {
            PlantSet::Table3 => (table3_motor(), Gear { ratio: GEAR_RATIO, efficiency: 0.75 }),
            PlantSet::Servo => servo_motor(),
            PlantSet::Gearmotor => gear_motor(),
        };
        let wheel = Wheel {
            motor,
            gear,
            rolling_resistance: ROLLING_RESISTANCE,
            load_share: 1.0 / geometry.wheels() as f64,
            viscous: 0.0,
        };
        let (supply_v, speed_m_s, turn_rad_s, acceleration_m_s2, proportional, loop_noise_rad_s) = match set {
            // A full 3S lithium battery, 4.2 V a cell: 0.22 m/s needs 12.41 V of back EMF alone. R
            // is small: 1 mV of loop noise is 1 mA, a tenth of the current at constant speed. Gain
            // and noise (0.05 rad/s at the rotor) are chosen so that it shows as about 1 % of the
            // power. 2.84 rad/s: paper Table 2.
            PlantSet::Table3 => (12.6, 0.22, 2.84, GENTLE_M_S2, 0.5, 2e-4),
            // 12 V is the servo's recommended supply (61 rpm, 0.2108 m/s unloaded); 0.20 m/s leaves
            // the voltage to accelerate with 6 kg. Its stiffer winding bears ten times the noise.
            PlantSet::Servo => (12.0, 0.20, 2.84, GENTLE_M_S2, 2.0, 2e-3),
            // 0.8 m/s needs 8.1 V; 1.5 m/s² with 6 kg needs 3 V more. 1 V/(rad/s) settles within 25
            // ms.
            PlantSet::Gearmotor => (12.0, 0.80, 6.0, (0.15, 1.5), 1.0, 1e-2),
        };
        let gains = Gains {
            feed_forward: motor.electrical_constant * gear.ratio,
            proportional,
            // A tenth of a second: slower than the loop's own 10 to 30 ms, faster than any
            // manoeuvre.
            integral: proportional / 0.1,
            rest_band: 0.05,
        };
        Self {
            geometry,
            // Between a disk of the Burger's turning radius 80 mm (80/√2 = 57 mm) and its URDF's
            // outer parts.
            gyration_radius_m: 0.06,
            wheels: [wheel; MAX_WHEELS],
            gains,
            loop_noise_rad_s,
            supply_v,
            limits: Limits { speed_m_s, turn_rad_s, acceleration_m_s2 },
        }
    }
}

/// Paper Table 3, as printed but for Ke's unit, which is V/(rad/s): 0.0072 · 258.5 · 0.22/0.033 =
/// 12.4 V is the battery's voltage at full speed. No Coulomb friction is given.
fn table3_motor() -> Motor {
    Motor {
        resistance_ohm: 0.75,
        inductance_h: 0.72e-3,
        torque_constant: 0.037,
        electrical_constant: 0.0072,
        rotor_inertia: 1.2182e-5,
        viscous: 2e-7,
        windage: 0.0,
        coulomb: 0.0,
    }
}

/// What makers publish of a motor with its gear.
#[derive(Debug, Clone, Copy)]
struct Published {
    /// Voltage of the figures, V.
    voltage: f64,
    /// Stall torque after the gear, N·m.
    stall_torque: f64,
    /// Stall current, A.
    stall_current: f64,
    /// Speed after the gear without load, rev/min.
    no_load_rpm: f64,
    /// Current without load, A.
    no_load_current: f64,
    /// Motor turns per turn after the gear.
    ratio: f64,
}

/// XL430-W250 (e-manual, Specifications, at 11.1 V). Its current without load is not published;
/// 0.05 A (4 % of stall) is usual for coreless motors of this size and gives a gear efficiency that
/// four or five plastic and metal stages can have.
const XL430: Published = Published {
    voltage: 11.1,
    stall_torque: 1.4,
    stall_current: 1.3,
    no_load_rpm: 57.0,
    no_load_current: 0.05,
    ratio: GEAR_RATIO,
};

/// Pololu 37D, 12 V, 30:1 (data sheet, revision 1.2: 330 rev/min and 0.2 A without load, 140 kg·mm
/// and 5.5 A at stall).
const GEARMOTOR_37D: Published = Published {
    voltage: 12.0,
    stall_torque: 0.140 * GRAVITY,
    stall_current: 5.5,
    no_load_rpm: 330.0,
    no_load_current: 0.2,
    ratio: 30.0,
};

impl Published {
    /// A motor and gear that meet these figures.
    ///
    /// At stall all voltage falls across R. Without load V = R i0 + K w0, and the torque K i0 feeds
    /// friction, half of it Coulomb, half viscous (not published; the split moves the power by less
    /// than i0's uncertainty). Torque at the stalled output is n η (K i_s − Coulomb), which leaves
    /// η.
    fn motor(self, inductance_h: f64, rotor_inertia: f64) -> (Motor, Gear) {
        let shaft_speed = self.no_load_rpm * std::f64::consts::TAU / 60.0 * self.ratio;
        let resistance_ohm = self.voltage / self.stall_current;
        let constant = (self.voltage - resistance_ohm * self.no_load_current) / shaft_speed;
        let friction = constant * self.no_load_current;
        let coulomb = 0.5 * friction;
        let shaft_stall = constant * self.stall_current - coulomb;
        let motor = Motor {
            resistance_ohm,
            inductance_h,
            torque_constant: constant,
            electrical_constant: constant,
            rotor_inertia,
            viscous: 0.5 * friction / shaft_speed,
            windage: 0.0,
            coulomb,
        };
        (motor, Gear { ratio: self.ratio, efficiency: self.stall_torque / (self.ratio * shaft_stall) })
    }
}

/// Inductance and inertia are not published: coreless windings of 8 to 10 Ω and 16 mm have 0.2 to
/// 0.4 mH (L/R = 35 µs: no part in it), their rotors about 1 g·cm². Reflected: 258.5² · 1e-7 =
/// 6.7e-3 kg·m². The gear's η is 0.61.
fn servo_motor() -> (Motor, Gear) {
    XL430.motor(0.3e-3, 1e-7)
}

/// Inductance and inertia are not published: iron-cored motors of 2 Ω and this size have 1 to 2 mH
/// and 20 g·cm². Reflected: 30² · 2e-6 = 1.8e-3 kg·m², as much as 3.3 kg on two wheels. The gear's
/// η is 0.76.
fn gear_motor() -> (Motor, Gear) {
    GEARMOTOR_37D.motor(1.5e-3, 2e-6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_servo_is_physically_plausible() {
        let robot = Robot::new(PlantSet::Servo, Kinematics::Differential);
        let Wheel { motor, gear, .. } = robot.wheels[0];
        // By hand: R = 11.1/1.3; K = (11.1 − 8.5385·0.05)/(57·2π/60·258.5) = 10.6731/1543.01.
        assert!((motor.resistance_ohm - 8.5385).abs() < 1e-4);
        assert!((motor.torque_constant - 6.9171e-3).abs() < 1e-6);
        // η = 1.4 / (258.5 · (6.9171e-3·1.3 − 1.7293e-4)) = 1.4/2.27976
        assert!((gear.efficiency - 0.6141).abs() < 1e-4, "{}", gear.efficiency);
        let reflected = motor.rotor_inertia * gear.ratio * gear.ratio;
        assert!((1e-3..1e-2).contains(&reflected));
    }

    #[test]
    fn the_gear_motor_is_physically_plausible() {
        let robot = Robot::new(PlantSet::Gearmotor, Kinematics::Differential);
        let Wheel { motor, gear, .. } = robot.wheels[0];
        // By hand: R = 12/5.5; K = (12 − 2.1818·0.2)/(330·2π/60·30) = 11.5636/1036.73.
        assert!((motor.resistance_ohm - 2.1818).abs() < 1e-4);
        assert!((motor.torque_constant - 1.11540e-2).abs() < 1e-6);
        // η = 1.37293 / (30 · (1.11540e-2·5.5 − 1.11540e-3)) = 1.37293/1.80695
        assert!((gear.efficiency - 0.7598).abs() < 1e-4, "{}", gear.efficiency);
    }
}
