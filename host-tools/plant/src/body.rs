//! The robot as one rigid planar body on driven wheels that roll without slipping.
//!
//! The unknown of the integration is the body's twist ζ; wheel speeds are w = J ζ. One step solves
//!
//! ```text
//! (diag(m, m, m k²) + Jᵀ diag(gain_i n_i Jm_i) J) Δζ = h (Jᵀ (τ_i − λ_i) + Coriolis)
//! ```
//!
//! where gain_i is the gear's wheel torque per motor torque in the direction in which power passes
//! it, τ_i the smooth wheel torques, and λ_i the dry friction, an element of F_i·Sgn(w_i): exactly
//! F_i against the motion, anything within ±F_i at rest. It is found at the end of the step (time
//! stepping after Moreau), so a robot at rest rests, without a smoothed sign and without chatter.
//! Tyres that scrub in turns are one contact more, whose speed is the turn rate.

use super::gear::{Flow, Gear};
use super::kinematics::{Geometry, MAX_WHEELS, Twist, dot};
use super::motor::{Current, Motor};

/// Standard gravity, m/s².
pub(super) const GRAVITY: f64 = 9.80665;

/// Places where dry friction acts: every wheel, and the floor against turning.
const CONTACTS: usize = MAX_WHEELS + 1;

/// Index of the contact that resists turning.
const TURNING: usize = MAX_WHEELS;

/// One driven wheel with all that belongs to it. A cause that concerns one wheel changes its values
/// alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wheel {
    /// Its motor.
    pub motor: Motor,
    /// Its gear.
    pub gear: Gear,
    /// Rolling resistance: force per normal force.
    pub rolling_resistance: f64,
    /// Share of the weight that it carries.
    pub load_share: f64,
    /// Viscous friction of the wheel's bearing, N·m/(rad/s) at the wheel.
    pub viscous: f64,
}

/// What acts on the robot beside its motors. The default is a level floor, the load in the middle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Loads {
    /// Smooth force on the body: forward N, leftward N, counter-clockwise N·m.
    pub force: Twist,
    /// Dry friction at each wheel beside that of its motor and its rolling, N·m.
    pub wheel_friction: [f64; MAX_WHEELS],
    /// Dry friction of the floor against turning, N·m.
    pub turning_friction: f64,
    /// Acceleration that presses the robot to the floor, m/s².
    pub normal_gravity: f64,
    /// How far the centre of mass lies to the left of the middle, m.
    pub offset_m: f64,
}

impl Default for Loads {
    fn default() -> Self {
        Self {
            force: [0.0; 3],
            wheel_friction: [0.0; MAX_WHEELS],
            turning_friction: 0.0,
            normal_gravity: GRAVITY,
            offset_m: 0.0,
        }
    }
}

/// What happened at one wheel during one step, mean values over the step.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct WheelStep {
    /// Winding voltage, V.
    pub voltage: f64,
    /// Winding current.
    pub current: Current,
    /// Wheel speed with which back EMF and viscous torques were computed, rad/s.
    pub predicted_speed: f64,
    /// Torque into the gear at the motor's side, N·m.
    pub shaft_torque: f64,
    /// Wheel torque per shaft torque.
    pub torque_gain: f64,
    /// Share of the dry friction in use, −1 to 1: ±1 while turning.
    pub friction_share: f64,
}

/// The moving robot: parameters and state.
#[derive(Debug, Clone)]
pub struct Body {
    geometry: Geometry,
    gyration_radius_m: f64,
    wheels: [Wheel; MAX_WHEELS],
    loads: Loads,
    wheel_per_twist: [Twist; MAX_WHEELS],
    twist: Twist,
    /// Change of twist per second in the last step.
    acceleration: Twist,
    current: [f64; MAX_WHEELS],
    flow: [Flow; MAX_WHEELS],
    /// Dry friction of the last step, N·m: where the next search starts.
    friction: [f64; CONTACTS],
    response: Response,
}

/// How the body answers to wheel torques, for one mass and one set of gears.
#[derive(Debug, Clone, Default)]
struct Response {
    /// Mass, offset of its centre, torque gains.
    key: Option<(f64, f64, [f64; MAX_WHEELS])>,
    /// Inverse of the mass matrix.
    inverse: [Twist; 3],
    /// Acceleration per torque of every contact, C M⁻¹ Cᵀ with C the wheels' rows of J and (0, 0,
    /// 1).
    contact: [[f64; CONTACTS]; CONTACTS],
}

impl Body {
    /// A robot at rest.
    pub fn new(geometry: Geometry, gyration_radius_m: f64, wheels: [Wheel; MAX_WHEELS]) -> Self {
        Self {
            geometry,
            gyration_radius_m,
            wheels,
            loads: Loads::default(),
            wheel_per_twist: geometry.wheel_per_twist(),
            twist: [0.0; 3],
            acceleration: [0.0; 3],
            current: [0.0; MAX_WHEELS],
            flow: [Flow::default(); MAX_WHEELS],
            friction: [0.0; CONTACTS],
            response: Response::default(),
        }
    }

    /// Body twist: forward m/s, leftward m/s, turn rate rad/s.
    pub fn twist(&self) -> Twist {
        self.twist
    }

    /// From the next step on the wheels have these values, and these loads act.
    pub(super) fn meet(&mut self, wheels: &[Wheel; MAX_WHEELS], loads: &Loads) {
        self.wheels = *wheels;
        self.loads = *loads;
    }

    /// Sets a moving start.
    #[cfg(test)]
    pub(super) fn set_twist(&mut self, twist: Twist) {
        self.twist = twist;
    }

    /// Wheel speeds, rad/s.
    pub fn wheel_speeds(&self) -> [f64; MAX_WHEELS] {
        self.wheel_per_twist.map(|row| dot(row, self.twist))
    }

    /// Winding currents, A.
    pub fn currents(&self) -> [f64; MAX_WHEELS] {
        self.current
    }

    /// Advances by `h` seconds with total mass `mass_kg` and the windings at `voltage`.
    pub fn step(&mut self, voltage: &[f64; MAX_WHEELS], mass_kg: f64, h: f64) -> [WheelStep; MAX_WHEELS] {
        let count = self.geometry.wheels();
        let before = self.wheel_speeds();
        let mut steps = [WheelStep::default(); MAX_WHEELS];
        for i in 0..count {
            let Wheel { motor, gear, .. } = &self.wheels[i];
            // Half a step ahead: back EMF at mid-step makes the electrical side second order.
            let predicted = before[i] + 0.5 * h * dot(self.wheel_per_twist[i], self.acceleration);
            let current = motor.conduct(self.current[i], voltage[i], gear.ratio * predicted, h);
            self.current[i] = current.end;
            steps[i] = WheelStep { voltage: voltage[i], current, predicted_speed: predicted, ..steps[i] };
        }
        let start = self.twist;
        // The power flow at a gear and the acceleration depend on each other. Mostly the flow of
        // the last step still fits; near zero gear torque both directions give the same motion.
        for _ in 0..4 {
            let end = self.solve(start, &mut steps, mass_kg, h);
            let speeds = self.wheel_per_twist.map(|row| dot(row, end));
            let mut consistent = true;
            for i in 0..count {
                let Wheel { motor, gear, .. } = &self.wheels[i];
                let step = &mut steps[i];
                let shaft_acceleration = gear.ratio * (speeds[i] - before[i]) / h;
                step.shaft_torque = motor.torque_constant * step.current.mean
                    - motor.drag(gear.ratio * step.predicted_speed)
                    - motor.coulomb * step.friction_share
                    - motor.rotor_inertia * shaft_acceleration;
                let flow = Gear::flow(step.shaft_torque, speeds[i]);
                consistent &= flow == self.flow[i];
                self.flow[i] = flow;
            }
            self.twist = end;
            if consistent {
                break;
            }
        }
        for (a, (end, start)) in self.acceleration.iter_mut().zip(self.twist.iter().zip(start)) {
            *a = (end - start) / h;
        }
        steps
    }

    /// The twist after `h` seconds from `start`, with the power flows as assumed in `self.flow`.
    fn solve(&mut self, start: Twist, steps: &mut [WheelStep; MAX_WHEELS], mass_kg: f64, h: f64) -> Twist {
        let count = self.geometry.wheels();
        for (step, (wheel, flow)) in steps[..count].iter_mut().zip(self.wheels.iter().zip(self.flow)) {
            step.torque_gain = wheel.gear.torque_gain(flow);
        }
        self.prepare_response(mass_kg, steps.map(|step| step.torque_gain));
        let Loads { mut force, wheel_friction, turning_friction, offset_m, .. } = self.loads;
        if self.geometry.holonomic() {
            // The body frame turns with the robot. (Wheels that cannot roll sideways take this
            // force themselves.)
            let [vx, vy, omega] = start;
            force[0] += mass_kg * omega * vy;
            force[1] -= mass_kg * omega * (vx - omega * offset_m);
            force[2] -= mass_kg * offset_m * omega * vy;
        } else {
            force[1] = 0.0;
        }
        let mut limit = [0.0; CONTACTS];
        limit[TURNING] = turning_friction;
        for i in 0..count {
            let Wheel { motor, gear, .. } = &self.wheels[i];
            let step = &mut steps[i];
            let shaft =
                motor.torque_constant * step.current.mean - motor.drag(gear.ratio * step.predicted_speed);
            let torque = step.torque_gain * shaft - self.wheels[i].viscous * step.predicted_speed;
            for (f, j) in force.iter_mut().zip(self.wheel_per_twist[i]) {
                *f += j * torque;
            }
            limit[i] = step.torque_gain * motor.coulomb + self.rolling_torque(i, mass_kg) + wheel_friction[i];
        }
        let free = self.advance(start, force, h);
        self.find_friction(free, &limit, h);
        for i in 0..count {
            steps[i].friction_share = if limit[i] > 0.0 { self.friction[i] / limit[i] } else { 0.0 };
            for (f, j) in force.iter_mut().zip(self.wheel_per_twist[i]) {
                *f -= j * self.friction[i];
            }
        }
        force[2] -= self.friction[TURNING];
        self.advance(start, force, h)
    }

    /// Rolling resistance of a wheel as a torque, N·m: μ_r times its share of the weight times the
    /// radius.
    pub(super) fn rolling_torque(&self, wheel: usize, mass_kg: f64) -> f64 {
        let Wheel { rolling_resistance, load_share, .. } = self.wheels[wheel];
        rolling_resistance * mass_kg * load_share * self.loads.normal_gravity * self.geometry.wheel_radius_m
    }

    fn advance(&self, start: Twist, force: Twist, h: f64) -> Twist {
        let mut end = start;
        for (e, row) in end.iter_mut().zip(self.response.inverse) {
            *e += h * dot(row, force);
        }
        end
    }

    /// Dry friction that brings each contact's speed to zero where the limit allows it (projected
    /// Gauss–Seidel).
    fn find_friction(&mut self, free: Twist, limit: &[f64; CONTACTS], h: f64) {
        // Row i: what torque at contact i does to the speed of every contact within the step
        // (symmetric).
        let reach = self.response.contact.map(|row| row.map(|x| h * x));
        let mut speed = [0.0; CONTACTS];
        for (s, row) in speed.iter_mut().zip(self.wheel_per_twist) {
            *s = dot(row, free);
        }
        speed[TURNING] = free[2];
        let brake = |speed: &mut [f64; CONTACTS], i: usize, torque: f64| {
            for (s, r) in speed.iter_mut().zip(reach[i]) {
                *s -= r * torque;
            }
        };
        let wheels = self.geometry.wheels();
        let contacts = || (0..wheels).chain((limit[TURNING] > 0.0).then_some(TURNING));
        if limit[TURNING] <= 0.0 {
            self.friction[TURNING] = 0.0;
        }
        for i in contacts() {
            brake(&mut speed, i, self.friction[i]);
        }
        for _ in 0..60 {
            let mut largest = 0.0_f64;
            for i in contacts() {
                let wanted = self.friction[i] + speed[i] / reach[i][i];
                let change = wanted.clamp(-limit[i], limit[i]) - self.friction[i];
                self.friction[i] += change;
                brake(&mut speed, i, change);
                largest = largest.max((change * reach[i][i]).abs());
            }
            // Well below the last digit that a log shows.
            if largest < 1e-12 {
                break;
            }
        }
    }

    fn prepare_response(&mut self, mass_kg: f64, gains: [f64; MAX_WHEELS]) {
        let offset = self.loads.offset_m;
        if self.response.key == Some((mass_kg, offset, gains)) {
            return;
        }
        // A mass beside the middle resists turning more, and turning moves it forward or back
        // (Steiner).
        let turning = mass_kg * (self.gyration_radius_m * self.gyration_radius_m + offset * offset);
        let coupling = -mass_kg * offset;
        let mut inertia = [[mass_kg, 0.0, coupling], [0.0, mass_kg, 0.0], [coupling, 0.0, turning]];
        let wheels = self.wheels.iter().zip(self.wheel_per_twist).zip(gains);
        for ((Wheel { motor, gear, .. }, row), gain) in wheels.take(self.geometry.wheels()) {
            let reflected = gain * gear.ratio * motor.rotor_inertia;
            for a in 0..3 {
                for b in 0..3 {
                    inertia[a][b] += row[a] * reflected * row[b];
                }
            }
        }
        let inverse = invert(&inertia);
        let mut rows = [[0.0, 0.0, 1.0]; CONTACTS];
        rows[..MAX_WHEELS].copy_from_slice(&self.wheel_per_twist);
        let contact = rows.map(|row| {
            let reach = inverse.map(|r| dot(r, row));
            rows.map(|other| dot(reach, other))
        });
        self.response = Response { key: Some((mass_kg, offset, gains)), inverse, contact };
    }
}

/// Inverse of a symmetric positive definite 3×3 matrix, by cofactors.
fn invert(m: &[Twist; 3]) -> [Twist; 3] {
    let cross = |a: Twist, b: Twist| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    // For a symmetric matrix the cross products of its rows are the rows of the adjugate.
    let adjugate = [cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])];
    let determinant = dot(m[0], adjugate[0]);
    adjugate.map(|row| row.map(|x| x / determinant))
}
