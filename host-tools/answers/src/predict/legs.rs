//! Legs to speeds: turn on the spot, drive straight, pause; each with the ramps that the robot's
//! limits allow.

use logs::robot::Robot;

use super::report::Limit;

/// Turn by `turn_rad` on the spot, then drive `distance_m`, then stand `pause_s`.
#[derive(Debug, Clone, PartialEq)]
pub struct Leg {
    pub(super) name: String,
    pub(super) distance_m: f64,
    pub(super) speed_m_s: f64,
    pub(super) turn_rad: f64,
    pub(super) slope_rad: f64,
    pub(super) pause_s: f64,
}

/// Where robot.toml does not say: acceleration of the wheels' rims, m/s², and turn rate, rad/s.
/// What small and middling robots do.
const ACCELERATION_M_S2: f64 = 0.5;
const TURN_RAD_S: f64 = 1.0;

/// What legs are driven with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Limits {
    acceleration_m_s2: f64,
    turn_rad_s: f64,
    turn_acceleration_rad_s2: f64,
    speed_m_s: f64,
}

impl Limits {
    pub(super) fn of(robot: &Robot) -> Self {
        let given = robot.limits();
        let acceleration_m_s2 = given.acceleration_m_s2.unwrap_or(ACCELERATION_M_S2);
        let half_width = 0.5 * robot.geometry().width_m().unwrap_or(1.0);
        Self {
            acceleration_m_s2,
            turn_rad_s: given.turn_rad_s.unwrap_or(TURN_RAD_S),
            turn_acceleration_rad_s2: acceleration_m_s2 / half_width,
            speed_m_s: given.speed_m_s.unwrap_or(f64::INFINITY),
        }
    }

    /// As a report names them, and whether robot.toml says them.
    pub(super) fn named(robot: &Robot) -> Vec<Limit> {
        let (limits, given) = (Self::of(robot), robot.limits());
        let limit = |name, value, is_given| Limit { name, value, is_given };
        vec![
            limit("max_acceleration_m_s2", limits.acceleration_m_s2, given.acceleration_m_s2.is_some()),
            limit("max_turn_rad_s", limits.turn_rad_s, given.turn_rad_s.is_some()),
        ]
    }
}

/// A stretch of even acceleration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stretch {
    pub(super) leg: usize,
    pub(super) duration_s: f64,
    /// Speed and turn rate at its start and end.
    pub(super) from: [f64; 2],
    pub(super) to: [f64; 2],
    pub(super) slope_rad: f64,
}

/// Ramp up, cruise, ramp down over a way; a short one has no cruise. Durations and the speed
/// reached.
fn ramps(way: f64, speed: f64, acceleration: f64) -> ([f64; 3], f64) {
    let reached = speed.min((way * acceleration).sqrt());
    let ramp = reached / acceleration;
    ([ramp, ((way - reached * ramp) / reached).max(0.0), ramp], reached)
}

/// The stretches of some legs.
pub(super) fn stretches(legs: &[Leg], limits: &Limits) -> Vec<Stretch> {
    let mut all = Vec::new();
    for (leg, wanted) in legs.iter().enumerate() {
        let mut drive = |way: f64, speed: f64, acceleration: f64, axis: usize, slope_rad: f64| {
            if way == 0.0 {
                return;
            }
            let (durations, reached) = ramps(way.abs(), speed, acceleration);
            let at = |share: f64| {
                let mut motion = [0.0; 2];
                motion[axis] = share * reached * way.signum();
                motion
            };
            for (duration_s, from, to) in
                [(durations[0], 0.0, 1.0), (durations[1], 1.0, 1.0), (durations[2], 1.0, 0.0)]
            {
                all.push(Stretch { leg, duration_s, from: at(from), to: at(to), slope_rad });
            }
        };
        drive(wanted.turn_rad, limits.turn_rad_s, limits.turn_acceleration_rad_s2, 1, 0.0);
        let speed = wanted.speed_m_s.min(limits.speed_m_s);
        drive(wanted.distance_m, speed, limits.acceleration_m_s2, 0, wanted.slope_rad);
        let still = Stretch { leg, duration_s: wanted.pause_s, from: [0.0; 2], to: [0.0; 2], slope_rad: 0.0 };
        all.push(still);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2 m at 0.5 m/s and 0.25 m/s²: 2 s and 0.5 m for each ramp, 2 s in between. 0.25 m are no way
    /// to get so fast: √(0.25 · 0.25) m/s.
    #[test]
    fn ramps_take_their_way() {
        assert_eq!(ramps(2.0, 0.5, 0.25), ([2.0, 2.0, 2.0], 0.5));
        assert_eq!(ramps(0.25, 0.5, 0.25), ([1.0, 0.0, 1.0], 0.25));
    }

    #[test]
    fn a_leg_turns_drives_and_pauses() {
        let limits = Limits {
            acceleration_m_s2: 0.25,
            turn_rad_s: 1.0,
            turn_acceleration_rad_s2: 2.0,
            speed_m_s: 0.5,
        };
        let leg = Leg {
            name: "1".to_owned(),
            distance_m: -2.0,
            speed_m_s: 9.0,
            turn_rad: 1.5,
            slope_rad: 0.1,
            pause_s: 3.0,
        };
        let driven = stretches(&[leg], &limits);
        let way = |axis: usize| -> f64 {
            driven.iter().map(|one| 0.5 * (one.from[axis] + one.to[axis]) * one.duration_s).sum()
        };
        assert!((way(0) + 2.0).abs() < 1e-12 && (way(1) - 1.5).abs() < 1e-12, "{driven:?}");
        assert_eq!(driven.iter().map(|one| one.duration_s).sum::<f64>(), 2.0 + 6.0 + 3.0);
        assert!(driven[..3].iter().all(|one| one.slope_rad == 0.0) && driven[4].slope_rad == 0.1);
    }
}
