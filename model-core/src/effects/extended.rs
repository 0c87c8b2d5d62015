//! The torque model with effects: its power at a known mass, and as a polynomial of an unknown one.

use super::layout::Layout;
use super::term::{Effect, Place, Scene, Supply, Term, Whole};
use crate::model::{MassRange, Response};
use crate::motion::{Motion, Wheel};
use crate::polynomial::Polynomial;
use crate::real::Real;
use crate::torque::{Drive, TorqueModel, WheelPower};

/// Share of the turn's scrub that is there: as the motion has it where the wheels scrub, else the
/// sign of the turn, 0 straight ahead, where the outermost wheels' part in it is within the dead
/// band (rad/s).
#[inline]
fn turning<T: Real, const N: usize>(layout: &Layout<T, N>, motion: &Motion<T, N>, dead_band: T) -> T {
    let mut sum = T::ZERO;
    for (share, wheel) in layout.turn.iter().zip(&motion.wheels) {
        if wheel.scrub != T::ZERO && *share != T::ZERO {
            return wheel.scrub / *share;
        }
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
    /// The wheels that turn, with their places and how warm they are: at rest there is nothing for
    /// a torque to act on.
    fn turning_wheels<'m>(
        &'m self,
        motion: &'m Motion<T, N>,
        scene: &'m Scene<T, N>,
    ) -> impl Iterator<Item = (Place<T>, &'m Wheel<T>, T)> {
        let layout = self.layout.forward.iter().zip(&self.layout.side).zip(&self.layout.turn);
        let wheels = motion.wheels.iter().zip(layout).zip(&scene.warmth);
        (0..).zip(wheels).filter_map(|(index, ((wheel, ((&forward, &side), &turn)), &warmth))| {
            let at = Place { index, forward, side, turn };
            (wheel.direction != T::ZERO).then_some((at, wheel, warmth))
        })
    }

    #[inline]
    fn whole<'m>(&'m self, motion: &'m Motion<T, N>) -> Whole<'m, T, N> {
        let dead_band = self.dead_band;
        Whole { layout: &self.layout, motion, dead_band, turning: turning(&self.layout, motion, dead_band) }
    }

    /// κ of a winding that is so warm.
    #[inline]
    fn winding_loss(&self, effect: &Effect<T>, warmth: T) -> T {
        match effect.term {
            Term::Winding => self.torque.winding_loss * effect.coefficient * warmth,
            _ => T::ZERO,
        }
    }

    /// Share of the braking power that returns.
    #[inline]
    fn returned(&self) -> T {
        let mut returned = T::ZERO;
        for effect in self.effects {
            if effect.term == Term::Return {
                returned += effect.coefficient;
            }
        }
        returned
    }

    /// Power in W, before the effects on the supply's side, which see the sum of the wheels only.
    #[inline]
    fn drawn(&self, motion: &Motion<T, N>, scene: &Scene<T, N>) -> T {
        let whole = self.whole(motion);
        let returned = self.returned();
        let mut sum = T::ZERO;
        for (at, wheel, warmth) in self.turning_wheels(motion, scene) {
            let mut torque = self.torque.torque(wheel, scene.mass);
            let gear_input = self.torque.gear_input(wheel, scene.mass);
            let mut draw = self.torque.draw();
            for effect in self.effects {
                let effect_torque = effect.term.torque(&at, wheel, &whole, gear_input, scene);
                torque += effect.coefficient * effect_torque.at(scene.mass);
                draw.winding_loss += self.winding_loss(effect, warmth);
            }
            let power = draw.power(wheel.speed, torque);
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
        self.supplied(self.drawn(motion, scene), scene)
    }

    /// What the supply gives where the wheels draw `drawn`, both in W.
    #[inline]
    fn supplied(&self, drawn: T, scene: &Scene<T, N>) -> T {
        let mut power = drawn;
        for effect in self.effects {
            power += effect.coefficient * effect.term.supply(scene).at(drawn);
        }
        power
    }

    /// What the wheels draw where the supply was measured to give `measured`, both in W: the
    /// inverse of what effects add on the supply's side. Below what any drawn power explains, where
    /// the parabola of a sagging supply turns, on a straight line.
    #[inline]
    pub fn drawn_of(&self, measured: T, scene: &Scene<T, N>) -> T {
        let mut sum = Supply::default();
        for effect in self.effects {
            let supply = effect.term.supply(scene);
            sum.constant += effect.coefficient * supply.constant;
            sum.gain += effect.coefficient * supply.gain;
            sum.square += effect.coefficient * supply.square;
        }
        // square · drawn² + (1 + gain) · drawn = measured − constant, by the root that stays where
        // the square vanishes.
        let (factor, power) = (T::ONE + sum.gain, measured - sum.constant);
        let four = T::TWO * T::TWO;
        let discriminant = T::ZERO.at_least(factor * factor + four * sum.square * power);
        T::TWO * power / (factor + discriminant.sqrt())
    }

    /// What the wheels draw as a polynomial of the mass about the middle of `range`, and the power
    /// with all effects at `d` kg beyond it: what the estimator asks for every sample.
    ///
    /// Torques are linear in the mass but for [`Term::GearLoad`], whose square of the mass is
    /// replaced by its tangent at the mass of the scene: there the polynomial is exact; `off` kg
    /// away the torque is short by coefficient · load² · off², load being what passes the gear per
    /// kilogram. [`Term::GearShare`] keeps the direction that the torque has at the mass of the
    /// scene.
    #[inline]
    pub fn response_and_power(
        &self,
        motion: &Motion<T, N>,
        scene: &Scene<T, N>,
        range: &MassRange<T>,
        d: T,
    ) -> (Response<T>, T) {
        let whole = self.whole(motion);
        let mut response = Response { polynomial: Polynomial::NOTHING, may_clamp: false };
        let mut powers = [Polynomial::NOTHING; N];
        let mut least_of_all = T::INFINITY;
        let wheels = self.turning_wheels(motion, scene);
        for (power, (at, wheel, warmth)) in powers.iter_mut().zip(wheels) {
            let [mut fixed, mut per_kg] = self.torque.parts(wheel, scene.mass);
            let gear_input = self.torque.gear_input(wheel, scene.mass);
            let mut draw = self.torque.draw();
            for effect in self.effects {
                let effect_torque = effect.term.torque(&at, wheel, &whole, gear_input, scene);
                let [effect_fixed, effect_per_kg] = effect_torque.tangent(scene.mass);
                fixed += effect.coefficient * effect_fixed;
                per_kg += effect.coefficient * effect_per_kg;
                draw.winding_loss += self.winding_loss(effect, warmth);
            }
            let torque = fixed + range.middle() * per_kg;
            let WheelPower { polynomial, least } =
                WheelPower::new(wheel, torque, per_kg, &draw, range.reach());
            *power = polynomial;
            response.polynomial += polynomial;
            least_of_all = least_of_all.least(least);
        }
        response.may_clamp = least_of_all < T::ZERO && matches!(self.drive, Drive::Dissipative);
        let drawn = if response.may_clamp {
            let returned = self.returned();
            let mut sum = T::NOTHING;
            for power in &powers {
                let power = power.at(d);
                sum += if power < T::ZERO { returned * power } else { power };
            }
            sum
        } else {
            response.polynomial.at(d)
        };
        (response, self.supplied(drawn, scene))
    }
}
