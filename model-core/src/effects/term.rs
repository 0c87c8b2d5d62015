//! What coefficients of effects multiply, term by term: each formula stands here once, for a known
//! mass and for an unknown one.

use super::GRAVITY;
use super::layout::Layout;
use crate::motion::{Motion, Wheel};
use crate::real::Real;

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
    /// How much hotter each winding is than in the fit, K, or what stands for it
    /// ([`Term::Winding`]).
    pub warmth: [T; N],
    /// How long the robot has not moved, s: 0 while it moves, infinite before it first does.
    pub still: T,
    /// A measured driver of static power, for example the processor's load in percent.
    pub driver: T,
}

/// What a coefficient multiplies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Term<T> {
    /// Slope by the measured pitch: torque m g pitch · forward_i. Coefficient: 1 / efficiency,
    /// dimensionless.
    GradeByPitch,
    /// The same slope wherever the robot goes: uphill forwards, downhill backwards. Coefficient:
    /// slope over efficiency.
    GradeAhead,
    /// A slope fixed in the world, by its share along (1) or across (0, 1) the heading at the
    /// start. Coefficient as above.
    GradeAlong([T; 2]),
    /// Winding resistance, relative: κ warmth_i. Coefficient: per kelvin, or per whatever the
    /// warmth is in.
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
    /// As [`Term::ScrubPerKg`] of tyres whose sliding shares the ground's grip with their rolling,
    /// N·m/kg; the slip, dimensionless, at which 1/√2 of it is there
    /// ([`SlipMemory::half_slip`](crate::slip::SlipMemory::half_slip)).
    Sliding(T),
    /// As [`Term::ScrubPerKg`], times the square of the load's share of the mass, N·m/kg; the mass
    /// of the empty robot in kg. A load off the centre moves the centre of all by that share, and
    /// the moment of friction of dragged wheels is greatest about the middle: turning about the
    /// best point is the least of its losses, so what it takes is concave in the weights, and falls
    /// with the square.
    OffCentre(T),
    /// Torque T² sgn w, 1/(N·m), T being what passes the gear: the body's share of τ, without that
    /// of rotor and motor friction. A loss that grows with the torque, whichever way the power
    /// goes.
    GearLoad,
    /// Torque |T| sgn w, dimensionless, T being what the motor gives the gear, friction included: τ
    /// without the rotor's share. A loss in proportion to the torque, whichever way the power goes.
    GearShare,
    /// Power (P + s)², 1/W: current through a resistance in the supply, s being the static power
    /// (W) that passes it, too.
    Sag(T),
    /// Share of braking power that returns.
    Return,
    /// Power P + s, dimensionless, s being the static power (W) that the sensor measures, too.
    Gain(T),
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

/// The torque of a term at one wheel, N·m per coefficient, by powers of the mass in kg.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Torque<T> {
    /// What does not depend on the mass.
    pub fixed: T,
    /// What multiplies the mass.
    pub per_kg: T,
    /// What multiplies its square: [`Term::GearLoad`] only.
    pub square: T,
}

impl<T: Real> Torque<T> {
    fn fixed(fixed: T) -> Self {
        Self { fixed, ..Self::default() }
    }

    fn per_kg(per_kg: T) -> Self {
        Self { per_kg, ..Self::default() }
    }

    /// At a mass in kg.
    #[inline]
    pub fn at(&self, mass: T) -> T {
        self.fixed + mass * (self.per_kg + mass * self.square)
    }

    /// Its tangent at a mass in kg. Away from there it is off by [`square`](Self::square) ·
    /// (distance in kg)².
    #[inline]
    pub fn tangent(&self, mass: T) -> [T; 2] {
        let slope = self.square * mass;
        [self.fixed - slope * mass, self.per_kg + slope + slope]
    }
}

/// The power of a term on the supply's side, W per coefficient, by powers of what the wheels draw.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Supply<T> {
    /// W, whatever the wheels draw.
    pub constant: T,
    /// What multiplies the drawn power.
    pub gain: T,
    /// What multiplies its square, 1/W.
    pub square: T,
}

impl<T: Real> Supply<T> {
    /// Where the wheels draw `power` (W).
    #[inline]
    pub fn at(&self, power: T) -> T {
        self.constant + power * (self.gain + power * self.square)
    }
}

/// What all wheels do together.
pub(super) struct Whole<'m, T, const N: usize> {
    pub(super) layout: &'m Layout<T, N>,
    pub(super) motion: &'m Motion<T, N>,
    /// rad/s.
    pub(super) dead_band: T,
    /// Share of the turn's scrub that is there.
    pub(super) turning: T,
}

/// One wheel's place.
pub(super) struct Place<T> {
    pub(super) index: u8,
    pub(super) forward: T,
    pub(super) side: T,
    pub(super) turn: T,
}

impl<T: Real> Term<T> {
    /// Torque at a wheel per coefficient. `gear_input` is what its motor gives the gear without
    /// effects: what does not depend on the mass (N·m) and what multiplies it (N·m/kg). Zero for
    /// supply terms.
    #[inline]
    pub(super) fn torque<const N: usize>(
        &self,
        at: &Place<T>,
        wheel: &Wheel<T>,
        whole: &Whole<'_, T, N>,
        gear_input: [T; 2],
        scene: &Scene<T, N>,
    ) -> Torque<T> {
        let gravity = T::from_f64(GRAVITY);
        match *self {
            Term::GradeByPitch => Torque::per_kg(gravity * scene.pitch * at.forward),
            Term::GradeAhead => Torque::per_kg(gravity * at.forward),
            Term::GradeAlong([x, y]) => {
                let [cos, sin] = scene.heading;
                Torque::per_kg(gravity * at.forward * (x * cos + y * sin))
            }
            Term::Windage => Torque::fixed(wheel.speed * wheel.speed.abs()),
            Term::Stribeck(speed) => {
                let share = wheel.speed / speed;
                Torque::fixed(wheel.direction * (-(share * share)).exp())
            }
            Term::Viscous => Torque::fixed(wheel.speed),
            Term::WarmUp(time) => Torque::fixed(wheel.speed * (-(scene.time / time)).exp()),
            Term::Rolling => Torque::per_kg(wheel.direction),
            Term::RollingFrom(from) if scene.time >= from => Torque::per_kg(wheel.direction),
            Term::Offset => Torque::per_kg(wheel.direction * at.side),
            Term::Drag(index) if index == at.index => Torque::fixed(wheel.direction),
            Term::Scrub => Torque::fixed(at.turn * whole.turning),
            Term::ScrubPerKg => Torque::per_kg(at.turn * whole.turning),
            Term::Sliding(half_slip) => {
                Torque::per_kg(at.turn * whole.layout.sliding(whole.motion, half_slip, whole.dead_band))
            }
            Term::OffCentre(empty) if scene.mass > empty => {
                let share = (scene.mass - empty) / scene.mass;
                Torque::per_kg(share * share * at.turn * whole.turning)
            }
            Term::GearLoad => {
                let [_, load] = gear_input;
                Torque { square: load * load * wheel.direction, ..Torque::default() }
            }
            Term::GearShare => {
                let [fixed, per_kg] = gear_input;
                let along = (fixed + scene.mass * per_kg).sign() * wheel.direction;
                Torque { fixed: along * fixed, per_kg: along * per_kg, ..Torque::default() }
            }
            _ => Torque::default(),
        }
    }

    /// Power per coefficient on the supply's side. Nothing for torque terms.
    #[inline]
    pub(super) fn supply<const N: usize>(&self, scene: &Scene<T, N>) -> Supply<T> {
        let constant = |constant| Supply { constant, ..Supply::default() };
        match *self {
            // (P + s)², and P + s.
            Term::Sag(with) => Supply { square: T::ONE, gain: T::TWO * with, constant: with * with },
            Term::Gain(with) => Supply { gain: T::ONE, constant: with, ..Supply::default() },
            Term::Constant => constant(T::ONE),
            Term::StepAt(from) if scene.time >= from => constant(T::ONE),
            // For ever counts from the first motion on, too: before it the robot has stood still
            // for ever.
            Term::WithMotion(hold) if scene.still.is_finite() && scene.still <= hold => constant(T::ONE),
            Term::Driver => constant(scene.driver),
            _ => Supply::default(),
        }
    }
}
