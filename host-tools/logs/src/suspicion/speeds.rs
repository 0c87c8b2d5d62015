//! Speeds of wheels in a different unit than rad/s: too fast for the robot, or so slow that driving
//! would cost too much.

use model_core::effects::GRAVITY;
use numerics::robust;

use super::doubt::{Kind, Suspicion, usual_mass_kg};
use super::thinned::Row;
use crate::robot::{Robot, SpeedUnit};

/// Robots whose file does not say how fast they are drive at most so many of their tracks a second:
/// 4.6 the fastest seen (a Warthog at its 5 m/s, and the gear motors of the simulator).
const TRACKS_PER_S: f64 = 6.0;

/// No wheeled robot with these tools in mind is faster, m/s.
const FASTEST_M_S: f64 = 20.0;

/// What is faster than the robot can be by this factor is in a different unit: wheels slip, and
/// data sheets round.
const TOO_FAST: f64 = 1.5;

/// What another unit explains has to be within this factor of what the robot can do.
const EXPLAINED: f64 = 1.1;

/// Power per weight and speed of straight drives beyond which slow ones are suspected: right ones
/// take 0.3 mostly, and m/s for rad/s makes it three (Warthog) to thirty times (Burger) as much.
const DEAR: f64 = 0.5;

/// The same beyond which they are wrong. Chosen: twice what lifting the robot at that speed takes.
/// Right ones take up to 0.7 where they scrub, and 1.3 where gears are stiff (MuJoCo's two robots).
const IMPOSSIBLE: f64 = 2.0;

/// As slow as that share of what it can do, all the time.
const SLOW: f64 = 0.2;

/// The rim turns by less than this share of the way: straight.
const STRAIGHT: f64 = 0.2;

/// Fewest rows of fast straight driving.
const LEAST_ROWS: usize = 20;

/// `standing_w` is the power at standstill, W, where the power is one that says what driving costs.
pub(super) fn suspicion(robot: &Robot, moving: &[&Row], standing_w: Option<f64>) -> Option<Suspicion> {
    let radius = robot.wheel_radius_m()?;
    let mut speeds: Vec<f64> = moving.iter().map(|row| row.fastest()).collect();
    let fast = robust::quantile(&mut speeds, 0.95)?;
    let reach = reach(robot);
    let speed = fast * radius;
    if speed > TOO_FAST * reach {
        return Some(too_fast(robot, fast, speed, reach));
    }
    let standing_w = standing_w?;
    // In m/s, read as rad/s, the robot is slower by its wheel radius.
    let straight: Vec<&&Row> =
        moving.iter().filter(|row| row.fastest() > 0.7 * fast && is_straight(row)).collect();
    if speed < SLOW * reach && fast <= EXPLAINED * reach && straight.len() >= LEAST_ROWS {
        let cost = |row: &&&Row| {
            let mass = if row.mass_kg.is_finite() { row.mass_kg } else { usual_mass_kg(robot) };
            (row.power_w - standing_w) / (GRAVITY * mass * row.fastest() * radius)
        };
        let cost = robust::median(&mut straight.iter().map(cost).collect::<Vec<_>>())?;
        if cost > DEAR {
            let is_sure = cost > IMPOSSIBLE;
            let text = format!(
                "the robot never drives faster than {speed:.3} m/s, and takes {cost:.1} times its weight times its speed for it: \
                 the wheel speeds {} m/s, not rad/s",
                if is_sure { "look like" } else { "may be" }
            );
            let kind = if is_sure { Kind::SpeedUnit } else { Kind::SpeedDear };
            return Some(Suspicion { kind, ..of(text, "read them with --speed-unit m/s") });
        }
    }
    None
}

/// How fast the robot can be, m/s.
fn reach(robot: &Robot) -> f64 {
    let by_track = || robot.geometry().width_m().map(|track| TRACKS_PER_S * track);
    robot.limits().speed_m_s.or_else(by_track).unwrap_or(FASTEST_M_S).min(FASTEST_M_S)
}

fn too_fast(robot: &Robot, fast: f64, speed: f64, reach: f64) -> Suspicion {
    let said = match robot.limits().speed_m_s {
        Some(limit) => format!("robot.toml allows {limit} m/s"),
        None => format!("a robot of this size reaches {reach:.1} m/s"),
    };
    let symptom = format!("wheels turn at {fast:.1} rad/s, which drives at {speed:.1} m/s, but {said}");
    let explains = |unit: &SpeedUnit| {
        let factor = unit.in_rad_s(robot.wheel_radius_m());
        factor.is_some_and(|factor| factor * speed <= EXPLAINED * reach)
    };
    match [SpeedUnit::Rpm, SpeedUnit::DegPerS].iter().find(|unit| explains(unit)) {
        Some(SpeedUnit::Rpm) => of(
            format!("{symptom}: the wheel speeds look like rpm, not rad/s"),
            "read them with --speed-unit rpm",
        ),
        Some(_) => of(
            format!("{symptom}: the wheel speeds look like degrees per second, not rad/s"),
            "read them with --speed-unit deg/s",
        ),
        None => of(
            symptom,
            "check the unit of the wheel speeds, and wheel_radius_m and max_speed_m_s in robot.toml",
        ),
    }
}

/// Whether all wheels agree that the robot drives straight.
fn is_straight(row: &Row) -> bool {
    let wheels = row.wheels();
    let mean = wheels.iter().sum::<f64>() / wheels.len() as f64;
    wheels.iter().all(|speed| (speed - mean).abs() < STRAIGHT * mean.abs())
}

fn of(text: String, remedy: &str) -> Suspicion {
    Suspicion { kind: Kind::SpeedUnit, text, remedy: remedy.to_owned() }
}
