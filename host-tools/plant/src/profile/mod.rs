//! Commanded motion over time.

mod file;
mod generate;

use serde::Serialize;

use super::kinematics::{Geometry, MAX_WHEELS, Twist};

pub use file::read;

/// Limits within which profiles are generated.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Limits {
    /// Largest forward or sideways speed, m/s; no wheel's rim turns faster either.
    pub speed_m_s: f64,
    /// Largest turn rate, rad/s.
    pub turn_rad_s: f64,
    /// The gentlest and the briskest acceleration at the fastest changing wheel's rim, m/s².
    pub acceleration_m_s2: (f64, f64),
}

impl Limits {
    /// By how much a twist exceeds the limits of the body or of any wheel; 1 or less keeps them.
    fn strain(&self, twist: Twist, geometry: &Geometry) -> f64 {
        let wheel_limit = self.speed_m_s / geometry.wheel_radius_m;
        geometry
            .wheel_speeds(twist)
            .into_iter()
            .map(|w| w.abs() / wheel_limit)
            .chain([twist[0].hypot(twist[1]) / self.speed_m_s, twist[2].abs() / self.turn_rad_s])
            .fold(0.0, f64::max)
    }

    /// Whether a twist keeps the limits of the body and of every wheel.
    pub fn allow(&self, twist: Twist, geometry: &Geometry) -> bool {
        twist.iter().all(|x| x.is_finite()) && self.strain(twist, geometry) <= 1.0 + 1e-9
    }

    /// Scales a twist down, keeping its curvature, until the limits hold.
    fn hold(&self, twist: Twist, geometry: &Geometry) -> Twist {
        let excess = self.strain(twist, geometry).max(1.0);
        twist.map(|x| x / excess)
    }
}

/// Profiles that can be generated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum ProfileKind {
    /// Trapezoids over all speeds and accelerations: straight, curved, reverse, spins, stops.
    Training,
    /// Another kind of drive: legs with swinging speed and weaving, rounded turns, short stops.
    Test,
    /// Up to one speed, then constant.
    Constant,
    /// Nothing moves.
    Standstill,
}

/// Rounds driven by commands of a linear and an angular velocity (the paper's Section 7.1).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Rounds {
    /// The slowest and the fastest leg, share of the limit.
    pub speed: (f64, f64),
    /// The sharpest curve: track width over radius of the path.
    pub curve: f64,
    /// The shortest and the longest time at one speed, s.
    pub hold_s: (f64, f64),
    /// The gentlest and the briskest change of speed at the fastest changing rim, m/s².
    pub acceleration_m_s2: (f64, f64),
    /// Shares of turns on the spot, stops and legs in reverse.
    pub shares: [f64; 3],
}

/// A commanded motion as straight lines between knots in time; held after the last knot.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    time_s: Vec<f64>,
    command: Commands,
}

#[derive(Debug, Clone, PartialEq)]
enum Commands {
    Twist(Vec<Twist>),
    Wheels(Vec<[f64; MAX_WHEELS]>),
}

impl Profile {
    /// Commanded body twists (m/s, m/s, rad/s) at ascending times, s. The first should be at 0 and
    /// at rest.
    pub fn from_twists(knots: impl IntoIterator<Item = (f64, Twist)>) -> Self {
        let (time_s, twists) = knots.into_iter().unzip();
        Self { time_s, command: Commands::Twist(twists) }
    }

    /// Commanded wheel speeds, rad/s, at ascending times, s.
    pub fn from_wheel_speeds(knots: impl IntoIterator<Item = (f64, [f64; MAX_WHEELS])>) -> Self {
        let (time_s, wheels) = knots.into_iter().unzip();
        Self { time_s, command: Commands::Wheels(wheels) }
    }

    /// The same drive in a mirror: left and right exchanged.
    #[must_use]
    pub fn mirrored(&self, geometry: &Geometry) -> Self {
        let command = match &self.command {
            Commands::Twist(twists) => {
                Commands::Twist(twists.iter().map(|&[x, y, turn]| [x, -y, -turn]).collect())
            }
            Commands::Wheels(wheels) => {
                Commands::Wheels(wheels.iter().map(|w| geometry.mirrored(*w)).collect())
            }
        };
        Self { time_s: self.time_s.clone(), command }
    }

    /// Wheel speeds asked for at a time. `cursor` remembers the place between calls with ascending
    /// times.
    pub(super) fn wheel_speeds_at(
        &self,
        geometry: &Geometry,
        time_s: f64,
        cursor: &mut usize,
    ) -> [f64; MAX_WHEELS] {
        let (from, to, share) = self.place(time_s, cursor);
        match &self.command {
            Commands::Twist(twists) => geometry.wheel_speeds(between(twists[from], twists[to], share)),
            Commands::Wheels(wheels) => between(wheels[from], wheels[to], share),
        }
    }

    /// Body twist asked for at a time (m/s, m/s, rad/s). `cursor` as in [`Self::wheel_speeds_at`].
    pub(super) fn twist_at(&self, geometry: &Geometry, time_s: f64, cursor: &mut usize) -> Twist {
        let (from, to, share) = self.place(time_s, cursor);
        match &self.command {
            Commands::Twist(twists) => between(twists[from], twists[to], share),
            Commands::Wheels(wheels) => geometry.twist(between(wheels[from], wheels[to], share)),
        }
    }

    /// The knots around a time, and the share of the way from one to the other.
    fn place(&self, time_s: f64, cursor: &mut usize) -> (usize, usize, f64) {
        while *cursor + 1 < self.time_s.len() && self.time_s[*cursor + 1] <= time_s {
            *cursor += 1;
        }
        let (from, to) = (*cursor, (*cursor + 1).min(self.time_s.len().saturating_sub(1)));
        let span = self.time_s[to] - self.time_s[from];
        let share = if span > 0.0 { ((time_s - self.time_s[from]) / span).max(0.0) } else { 0.0 };
        (from, to, share)
    }

    /// Time of the last knot, s.
    pub fn end_s(&self) -> f64 {
        self.time_s.last().copied().unwrap_or(0.0)
    }
}

fn between<const K: usize>(from: [f64; K], to: [f64; K], share: f64) -> [f64; K] {
    std::array::from_fn(|i| from[i] + share * (to[i] - from[i]))
}

#[cfg(test)]
mod tests {
    use super::super::kinematics::Kinematics;
    use super::*;

    const LIMITS: Limits = Limits { speed_m_s: 0.22, turn_rad_s: 2.84, acceleration_m_s2: (0.05, 0.5) };

    pub(super) fn geometry(kinematics: Kinematics) -> Geometry {
        Geometry { kinematics, wheel_radius_m: 0.033, track_m: 0.16, wheelbase_m: 0.16 }
    }

    #[test]
    fn generated_profiles_keep_the_limits_of_body_wheels_and_acceleration() {
        for kinematics in [Kinematics::Differential, Kinematics::Skid, Kinematics::Omni, Kinematics::Mecanum]
        {
            let geometry = geometry(kinematics);
            for (kind, seed) in
                [ProfileKind::Training, ProfileKind::Test].into_iter().flat_map(|k| [(k, 1), (k, 2)])
            {
                let profile = Profile::generate(kind, &geometry, &LIMITS, 200.0, seed);
                assert!(profile.end_s() >= 200.0);
                let mut cursor = 0;
                let mut last = [0.0; MAX_WHEELS];
                for k in 0..20_000 {
                    let speeds = profile.wheel_speeds_at(&geometry, f64::from(k) * 0.01, &mut cursor);
                    for (w, l) in speeds.iter().zip(last) {
                        assert!(w.abs() * 0.033 <= 0.22 + 1e-9);
                        // 0.5 m/s² at the rim, exceeded by nothing but rounding.
                        assert!((w - l).abs() * 0.033 <= 0.5 * 0.01 * 1.001 + 1e-12, "{kind:?} {k} {w} {l}");
                    }
                    last = speeds;
                }
            }
        }
    }

    #[test]
    fn a_training_profile_holds_every_kind_of_motion() {
        let geometry = geometry(Kinematics::Differential);
        for seed in 0..10 {
            let profile = Profile::generate(ProfileKind::Training, &geometry, &LIMITS, 100.0, seed);
            let mut cursor = 0;
            // Samples of 0.1 s: slow, fast, reverse, spin left, spin right, rest.
            let mut counts = [0; 6];
            for k in 0..1000 {
                let [left, right, ..] = profile.wheel_speeds_at(&geometry, f64::from(k) * 0.1, &mut cursor);
                let (v, turn) = ((left + right) * 0.0165, (right - left) * 0.033 / 0.16);
                counts[0] += usize::from(v > 0.01 && v < 0.08);
                counts[1] += usize::from(v > 0.15);
                counts[2] += usize::from(v < -0.02);
                counts[3] += usize::from(v.abs() < 1e-9 && turn > 0.3);
                counts[4] += usize::from(v.abs() < 1e-9 && turn < -0.3);
                counts[5] += usize::from(left == 0.0 && right == 0.0);
            }
            assert!(counts.iter().all(|&count| count >= 10), "seed {seed}: {counts:?}");
        }
    }

    #[test]
    fn knots_are_joined_by_straight_lines() {
        let geometry = geometry(Kinematics::Differential);
        let profile = Profile::from_twists([(0.0, [0.0; 3]), (2.0, [0.2, 0.0, 0.0])]);
        let mut cursor = 0;
        let speeds =
            [0.0, 0.5, 2.0, 9.0].map(|t| profile.wheel_speeds_at(&geometry, t, &mut cursor)[0] * 0.033);
        for (speed, expected) in speeds.into_iter().zip([0.0, 0.05, 0.2, 0.2]) {
            assert!((speed - expected).abs() < 1e-12);
        }
    }
}
