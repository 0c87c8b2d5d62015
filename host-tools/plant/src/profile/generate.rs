//! Profiles drawn from a seed.

use rand::RngExt;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::super::kinematics::{Geometry, Twist};
use super::super::noise::{Stream, stream};
use super::{Limits, Profile, ProfileKind, Rounds};

impl Profile {
    /// A generated profile of a kind that needs no further figures; `Constant` drives straight at
    /// 0.9 of the limit.
    pub fn generate(
        kind: ProfileKind,
        geometry: &Geometry,
        limits: &Limits,
        duration_s: f64,
        seed: u64,
    ) -> Self {
        match kind {
            ProfileKind::Training => training(geometry, limits, duration_s, seed),
            ProfileKind::Test => test(geometry, limits, duration_s, seed),
            ProfileKind::Constant => Self::constant(geometry, limits, [0.9 * limits.speed_m_s, 0.0, 0.0]),
            ProfileKind::Standstill => Self::from_twists([(0.0, [0.0; 3])]),
        }
    }

    /// Rounds of at least `duration_s` seconds.
    pub fn rounds(geometry: &Geometry, limits: &Limits, duration_s: f64, kind: &Rounds, seed: u64) -> Self {
        rounds(geometry, limits, duration_s, kind, seed)
    }

    /// One second of rest, a ramp of 0.2 m/s² (at the fastest wheel) to the twist, then constant.
    pub fn constant(geometry: &Geometry, limits: &Limits, twist: Twist) -> Self {
        constant(geometry, limits, twist)
    }
}

/// A drive in the making.
struct Path<'a> {
    geometry: &'a Geometry,
    limits: &'a Limits,
    rng: ChaCha8Rng,
    now_s: f64,
    twist: Twist,
    knots: Vec<(f64, Twist)>,
}

impl<'a> Path<'a> {
    fn new(geometry: &'a Geometry, limits: &'a Limits, rng: ChaCha8Rng) -> Self {
        Self { geometry, limits, rng, now_s: 0.0, twist: [0.0; 3], knots: vec![(0.0, [0.0; 3])] }
    }

    fn hold(&mut self, seconds: f64) {
        self.now_s += seconds;
        self.knots.push((self.now_s, self.twist));
    }

    /// Time, s, to change by `change` when the fastest changing rim does so at `acceleration`,
    /// m/s².
    fn ramp_time(&self, change: Twist, acceleration: f64) -> f64 {
        let rim = self.geometry.wheel_speeds(change).into_iter().fold(0.0, |a: f64, w| a.max(w.abs()));
        rim * self.geometry.wheel_radius_m / acceleration
    }

    /// A straight ramp: the side of a trapezoid.
    fn ramp(&mut self, target: Twist, acceleration: f64) {
        let target = self.limits.hold(target, self.geometry);
        let time = self.ramp_time(minus(target, self.twist), acceleration);
        self.twist = target;
        if time > 0.0 {
            self.hold(time);
        }
    }

    /// A rounded ramp (raised cosine) whose steepest place has `acceleration`.
    fn swing(&mut self, target: Twist, acceleration: f64) {
        const PIECES: u32 = 16;
        let (from, target) = (self.twist, self.limits.hold(target, self.geometry));
        let change = minus(target, from);
        let time = std::f64::consts::FRAC_PI_2 * self.ramp_time(change, acceleration);
        if time == 0.0 {
            return;
        }
        for piece in 1..=PIECES {
            let share = f64::from(piece) / f64::from(PIECES);
            let risen = 0.5 - 0.5 * (std::f64::consts::PI * share).cos();
            self.twist =
                if piece == PIECES { target } else { std::array::from_fn(|i| from[i] + risen * change[i]) };
            self.hold(time / f64::from(PIECES));
        }
    }

    fn uniform(&mut self, from: f64, to: f64) -> f64 {
        self.rng.random_range(from..to)
    }

    fn between(&mut self, (low, high): (f64, f64)) -> f64 {
        low + (high - low) * self.uniform(0.0, 1.0)
    }

    fn log_uniform(&mut self, from: f64, to: f64) -> f64 {
        self.uniform(from.ln(), to.ln()).exp()
    }

    fn acceleration(&mut self) -> f64 {
        let (gentlest, briskest) = self.limits.acceleration_m_s2;
        self.log_uniform(gentlest, briskest)
    }

    fn sign(&mut self) -> f64 {
        if self.rng.random_bool(0.5) { 1.0 } else { -1.0 }
    }

    /// Turn rate, rad/s, at which the wheels of a robot that spins have the rim speed `speed`.
    fn spin(&self, speed: f64) -> f64 {
        speed / self.ramp_time([0.0, 0.0, 1.0], 1.0)
    }

    fn finish(self) -> Profile {
        Profile::from_twists(self.knots)
    }
}

fn minus(a: Twist, b: Twist) -> Twist {
    std::array::from_fn(|i| a[i] - b[i])
}

#[derive(Clone, Copy)]
enum Manoeuvre {
    Straight,
    Reverse,
    Curve(f64),
    ReverseCurve,
    Spin(f64),
    Sideways,
    Stop,
}

/// Decks of manoeuvres in random order. Every deck (about 50 s) holds slow and fast, forward and
/// reverse, left and right, its speeds stratified.
fn training(geometry: &Geometry, limits: &Limits, duration_s: f64, seed: u64) -> Profile {
    use Manoeuvre::{Curve, Reverse, ReverseCurve, Sideways, Spin, Stop, Straight};
    let mut path = Path::new(geometry, limits, stream(seed, Stream::Training));
    path.hold(1.0);
    while path.now_s < duration_s {
        let mut deck = vec![Straight, Straight, Straight, Reverse, Curve(1.0), Curve(-1.0)];
        deck.extend([ReverseCurve, Spin(1.0), Spin(-1.0), Stop]);
        if geometry.holonomic() {
            deck.extend([Sideways, Sideways]);
        }
        let count = deck.len();
        let mut strata: Vec<usize> = (0..count).collect();
        deck.shuffle(&mut path.rng);
        strata.shuffle(&mut path.rng);
        for (manoeuvre, stratum) in deck.into_iter().zip(strata) {
            let place = (stratum as f64 + path.uniform(0.0, 1.0)) / count as f64;
            let speed = (0.1 + 0.9 * place) * limits.speed_m_s;
            let radius = path.log_uniform(0.5, 10.0) * geometry.track_m;
            let side = path.sign();
            let target = match manoeuvre {
                Straight => [speed, 0.0, 0.0],
                Reverse => [-speed, 0.0, 0.0],
                Curve(side) => [speed, 0.0, side * speed / radius],
                ReverseCurve => [-speed, 0.0, side * speed / radius],
                Spin(side) => [0.0, 0.0, side * path.spin(speed)],
                Sideways => {
                    let (sin, cos) = path.uniform(0.0, std::f64::consts::TAU).sin_cos();
                    [speed * cos, speed * sin, side * 0.3 * speed / radius]
                }
                Stop => [0.0; 3],
            };
            let acceleration = path.acceleration();
            path.ramp(target, acceleration);
            let hold =
                if matches!(manoeuvre, Stop) { path.uniform(1.0, 2.0) } else { path.log_uniform(1.0, 4.0) };
            path.hold(hold);
        }
    }
    path.finish()
}

/// Legs of a mission: the speed swings and the heading weaves while driving, turns are rounded,
/// stops are short.
fn test(geometry: &Geometry, limits: &Limits, duration_s: f64, seed: u64) -> Profile {
    let mut path = Path::new(geometry, limits, stream(seed, Stream::Test));
    path.hold(0.5);
    while path.now_s < duration_s {
        let direction = if path.rng.random_bool(0.2) { -1.0 } else { 1.0 };
        let heading = if geometry.holonomic() { path.uniform(-1.5, 1.5) } else { 0.0 };
        let cruise = direction * path.uniform(0.25, 0.95) * limits.speed_m_s;
        let turn = path.uniform(-0.5, 0.5) * cruise.abs() / geometry.track_m;
        let swings = path.rng.random_range(2..=5);
        for _ in 0..swings {
            let speed = cruise * path.uniform(0.6, 1.3);
            let turn = turn + path.uniform(-0.4, 0.4) * cruise.abs() / geometry.track_m;
            let acceleration = path.acceleration();
            path.swing([speed * heading.cos(), speed * heading.sin(), turn], acceleration);
            let hold = path.uniform(0.0, 2.0);
            path.hold(hold);
        }
        match path.rng.random_range(0..4) {
            0 => {
                let acceleration = path.acceleration();
                path.swing([0.0; 3], acceleration);
                let rest = path.uniform(0.3, 1.2);
                path.hold(rest);
            }
            1 => {
                let rim = path.sign() * path.uniform(0.2, 0.9) * limits.speed_m_s;
                let spin = path.spin(rim);
                let acceleration = path.acceleration();
                path.swing([0.0, 0.0, spin], acceleration);
                let hold = path.uniform(0.5, 2.0);
                path.hold(hold);
            }
            _ => {}
        }
    }
    path.finish()
}

/// Legs of a round, each with a speed and a curve of its own; turns on the spot, legs in reverse
/// and stops among them.
fn rounds(geometry: &Geometry, limits: &Limits, duration_s: f64, rounds: &Rounds, seed: u64) -> Profile {
    let mut path = Path::new(geometry, limits, stream(seed, Stream::Rounds));
    path.hold(1.0);
    while path.now_s < duration_s {
        let speed = path.between(rounds.speed) * limits.speed_m_s;
        let curve = path.between((-rounds.curve, rounds.curve));
        let side = path.sign();
        let kind = path.uniform(0.0, 1.0);
        let [spin, stop, reverse] = rounds.shares;
        let target = if kind < spin {
            [0.0, 0.0, side * path.spin(SPIN_SHARE * speed)]
        } else if kind < spin + stop {
            [0.0; 3]
        } else if kind < spin + stop + reverse {
            [-speed, 0.0, 0.0]
        } else {
            // The outer wheel has the leg's speed.
            [speed * (1.0 - 0.5 * curve.abs()), 0.0, curve * speed / geometry.track_m]
        };
        let (gentlest, briskest) = rounds.acceleration_m_s2;
        let acceleration = path.log_uniform(gentlest, briskest);
        path.ramp(target, acceleration);
        let hold = path.between(rounds.hold_s);
        path.hold(hold);
    }
    path.finish()
}

/// Wheels turn slower on the spot than on a leg, by this factor.
const SPIN_SHARE: f64 = 0.8;

fn constant(geometry: &Geometry, limits: &Limits, twist: Twist) -> Profile {
    let mut path = Path::new(geometry, limits, stream(0, Stream::Training));
    path.hold(1.0);
    path.ramp(twist, 0.2);
    path.finish()
}
