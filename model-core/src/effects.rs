//! Effects that a fitted torque model may lack: what each adds to the wheels' torques, or to the power they sum up to.
//!
//! An effect is a [`Term`] times a coefficient. Torque terms add to τ_i of [`crate::torque`] and so pass the winding loss
//! and the clamp as every torque does; supply terms act on the sum of the wheels' powers. With a coefficient of 0 each of
//! them leaves the power as it was.

use crate::kinematics::Kinematics;
use crate::motion::{Motion, Wheel};
use crate::real::Real;
use crate::torque::{Drive, TorqueModel};

/// Standard gravity, m/s².
pub const GRAVITY: f64 = 9.80665;

/// Where the wheels are, as far as effects care.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layout<T, const N: usize> {
    /// Row vx of R, m: what a wheel's speed adds to the forward speed.
    pub forward: [T; N],
    /// −1 for wheels left of the centre, 1 for those right of it, 0 where a wheel is on neither side.
    pub side: [T; N],
    /// Row ω of R over its largest entry.
    pub turn: [T; N],
}

impl<T: Real, const N: usize> Layout<T, N> {
    /// From R.
    pub fn new(kinematics: &Kinematics<T, N>) -> Self {
        let [forward, _, turn] = *kinematics.rows();
        let most = turn.iter().fold(T::ZERO, |most, entry| most.at_least(entry.abs()));
        let turn = turn.map(|entry| if most > T::ZERO { entry / most } else { T::ZERO });
        // Forward turning wheels on the left turn the robot clockwise: their entry is negative.
        let mut side = [T::ZERO; N];
        for ((side, turn), forward) in side.iter_mut().zip(&turn).zip(&forward) {
            if *forward != T::ZERO {
                *side = (*turn * *forward).sign();
            }
        }
        Self { forward, side, turn }
    }
}

/// What surrounds the wheels at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scene<T, const N: usize> {
    /// Total mass, kg.
    pub mass: T,
    /// Time since the start of the run, s.
    pub time: T,
    /// Pitch, nose up, rad; 0 where nobody measures it.
    pub pitch: T,
    /// Cosine and sine of the heading since the start of the run.
    pub heading: [T; 2],
    /// How much hotter each winding is than in the fit, K, or what stands for it ([`Term::Winding`]).
    pub warmth: [T; N],
    /// How long the robot has not moved, s: 0 while it moves, infinite before it first does.
    pub still: T,
    /// A measured driver of static power, for example the processor's load in percent.
    pub driver: T,
}

/// What a coefficient multiplies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Term<T> {
    /// Slope by the measured pitch: torque m g pitch · forward_i. Coefficient: 1 / efficiency, dimensionless.
    GradeByPitch,
    /// The same slope wherever the robot goes: uphill forwards, downhill backwards. Coefficient: slope over efficiency.
    GradeAhead,
    /// A slope fixed in the world, by its share along (1) or across (0, 1) the heading at the start. Coefficient as above.
    GradeAlong([T; 2]),
    /// Winding resistance, relative: κ warmth_i. Coefficient: per kelvin, or per whatever the warmth is in.
    Winding,
    /// Torque w |w|, N·m·s²/rad².
    Windage,
    /// Torque sgn w exp(−(w / speed)²), N·m; the speed in rad/s.
    Stribeck(T),
    /// Torque w, N·m·s/rad.
    Viscous,
    /// Torque w exp(−t / time), N·m·s/rad; the time in s.
    WarmUp(T),
    /// Torque m sgn w, N·m/kg.
    Rolling,
    /// Torque m sgn w from a time in s on, N·m/kg.
    RollingFrom(T),
    /// Torque m sgn w on the right, the opposite on the left, N·m/kg.
    Offset,
    /// Torque sgn w at one wheel, counted from 0, N·m.
    Drag(u8),
    /// Torque along the turn, share of the wheel in it, N·m.
    Scrub,
    /// As [`Term::Scrub`], times the mass, N·m/kg.
    ScrubPerKg,
    /// Torque T² sgn w, 1/(N·m), T being what passes the gear: the body's share of τ, without that of rotor and motor friction.
    /// A loss that grows with the torque, whichever way the power goes.
    GearLoad,
    /// Power P², 1/W: current through a resistance in the supply.
    Sag,
    /// Share of braking power that returns.
    Return,
    /// Power P, dimensionless.
    Gain,
    /// Power 1, W.
    Constant,
    /// Power from a time in s on, W.
    StepAt(T),
    /// Power while the robot moves and for a time in s afterwards, W.
    WithMotion(T),
    /// Power in proportion to the driver, W per its unit.
    Driver,
}

/// A term and its coefficient.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effect<T> {
    /// What is multiplied.
    pub term: Term<T>,
    /// By how much.
    pub coefficient: T,
}

impl<T: Real> Term<T> {
    /// Torque at a wheel per coefficient; `load` (N·m) is what passes its gear without effects. Zero for supply terms.
    #[inline]
    fn torque<const N: usize>(
        &self,
        at: &Place<T>,
        wheel: &Wheel<T>,
        turning: T,
        load: T,
        scene: &Scene<T, N>,
    ) -> T {
        let gravity = T::from_f64(GRAVITY);
        match *self {
            Term::GradeByPitch => scene.mass * gravity * scene.pitch * at.forward,
            Term::GradeAhead => scene.mass * gravity * at.forward,
            Term::GradeAlong([x, y]) => {
                let [cos, sin] = scene.heading;
                scene.mass * gravity * at.forward * (x * cos + y * sin)
            }
            Term::Windage => wheel.speed * wheel.speed.abs(),
            Term::Stribeck(speed) => {
                let share = wheel.speed / speed;
                wheel.direction * (-(share * share)).exp()
            }
            Term::Viscous => wheel.speed,
            Term::WarmUp(time) => wheel.speed * (-(scene.time / time)).exp(),
            Term::Rolling => scene.mass * wheel.direction,
            Term::RollingFrom(from) if scene.time >= from => scene.mass * wheel.direction,
            Term::Offset => scene.mass * wheel.direction * at.side,
            Term::Drag(index) if index == at.index => wheel.direction,
            Term::Scrub => at.turn * turning,
            Term::ScrubPerKg => scene.mass * at.turn * turning,
            Term::GearLoad => load * load * wheel.direction,
            _ => T::ZERO,
        }
    }

    /// Power per coefficient where the wheels draw `power` (W).
    #[inline]
    fn supply<const N: usize>(&self, power: T, scene: &Scene<T, N>) -> T {
        match *self {
            Term::Sag => power * power,
            Term::Gain => power,
            Term::Constant => T::ONE,
            Term::StepAt(from) if scene.time >= from => T::ONE,
            Term::WithMotion(hold) if scene.still <= hold => T::ONE,
            Term::Driver => scene.driver,
            _ => T::ZERO,
        }
    }
}

/// One wheel's place.
struct Place<T> {
    index: u8,
    forward: T,
    side: T,
    turn: T,
}

/// Sign of the turn, 0 straight ahead: where the outermost wheels' part in it is within the dead band (rad/s).
#[inline]
fn turning<T: Real, const N: usize>(layout: &Layout<T, N>, motion: &Motion<T, N>, dead_band: T) -> T {
    let mut sum = T::ZERO;
    for (share, wheel) in layout.turn.iter().zip(&motion.wheels) {
        sum += *share * wheel.speed;
    }
    if sum.abs() > dead_band { sum.sign() } else { T::ZERO }
}

/// The torque model with effects, and what it needs to know of the robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extended<'a, T, const N: usize> {
    /// The fitted model.
    pub torque: TorqueModel<T>,
    /// Whether it clamps braking power.
    pub drive: Drive,
    /// Where the wheels are.
    pub layout: Layout<T, N>,
    /// Wheels slower than this are at rest, rad/s.
    pub dead_band: T,
    /// What is added, in any order: no effect sees another one's torque.
    pub effects: &'a [Effect<T>],
}

impl<T: Real, const N: usize> Extended<'_, T, N> {
    /// Power in W, before the effects on the supply's side, which see the sum of the wheels only.
    #[inline]
    fn drawn(&self, motion: &Motion<T, N>, scene: &Scene<T, N>) -> T {
        let turning = turning(&self.layout, motion, self.dead_band);
        let mut returned = T::ZERO;
        for effect in self.effects {
            if effect.term == Term::Return {
                returned += effect.coefficient;
            }
        }
        let mut sum = T::ZERO;
        let layout = self.layout.forward.iter().zip(&self.layout.side).zip(&self.layout.turn);
        let wheels = motion.wheels.iter().zip(layout).zip(&scene.warmth);
        for (index, ((wheel, ((&forward, &side), &turn)), &warmth)) in (0..).zip(wheels) {
            let at = Place { index, forward, side, turn };
            if wheel.direction == T::ZERO {
                continue;
            }
            let alone = self.torque.torque(wheel, scene.mass);
            let load = self.torque.load(wheel, scene.mass);
            let mut torque = alone;
            let mut loss = self.torque.winding_loss;
            for effect in self.effects {
                torque += effect.coefficient * effect.term.torque(&at, wheel, turning, load, scene);
                if effect.term == Term::Winding {
                    loss += self.torque.winding_loss * effect.coefficient * warmth;
                }
            }
            let power = torque * (wheel.speed + loss * torque);
            sum += match self.drive {
                Drive::Dissipative if power < T::ZERO => returned * power,
                _ => power,
            };
        }
        sum
    }

    /// Power in W, all effects included.
    #[inline]
    pub fn power(&self, motion: &Motion<T, N>, scene: &Scene<T, N>) -> T {
        let drawn = self.drawn(motion, scene);
        let mut power = drawn;
        for effect in self.effects {
            power += effect.coefficient * effect.term.supply(drawn, scene);
        }
        power
    }
}
