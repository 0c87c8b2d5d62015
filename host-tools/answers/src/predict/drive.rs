//! Any plan as frames: wheel speeds at even times, as a log would have them.

use logs::SampleReader;
use logs::robot::Robot;
use logs::robot::chassis::PerWheel;
use support::context::Context;
use support::error::{Error, Result};

use super::legs::{Limits, Stretch, stretches};
use super::plan::{Plan, Row};

/// Wheel speeds at an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Frame {
    pub(super) leg: usize,
    pub(super) wheel_speed: PerWheel<f64>,
    /// As planned, rad/s²: no filter is needed. `None` where speeds come from a log, whose noise is
    /// to be filtered as in the fit.
    pub(super) wheel_acceleration: Option<PerWheel<f64>>,
    /// Since the frame before, s; infinite at a start.
    pub(super) elapsed: f64,
    /// Uphill ahead, rad.
    pub(super) slope_rad: f64,
    /// Power without the static one as a log measured it, W.
    pub(super) measured_w: Option<f64>,
}

/// Whoever follows a plan.
pub(super) trait Follow {
    /// The frames are going to be so far apart, s.
    fn start(&mut self, period_s: f64) -> Result<()>;

    fn frame(&mut self, frame: &Frame);
}

/// Frames of planned motion are at most so far apart, s, or closer where the filter of what is
/// measured beside asks for it.
const PERIOD_S: f64 = 0.05;
/// Samples per period of the filter's cutoff.
const PER_CUTOFF: f64 = 8.0;
/// In a log a stop of this length, s, ends a leg.
const STOP_S: f64 = 2.0;
/// More frames than this are no plan: of five days at 20 Hz, and some seconds of work.
const MOST_FRAMES: f64 = 1e7;

/// Hands out the frames of a plan. Gives the legs' names.
pub(super) fn frames(
    context: &Context,
    plan: &Plan,
    robot: &Robot,
    cutoff_hz: f64,
    follow: &mut dyn Follow,
) -> Result<Vec<String>> {
    let stretches = match plan {
        Plan::Log(path) => {
            let mut reader = SampleReader::open(context, path, robot)?;
            follow.start(reader.period_s())?;
            return logged(&mut reader, robot, follow);
        }
        Plan::Legs(legs) => stretches(legs, &Limits::of(robot)),
        Plan::Profile(rows) => pieces(rows),
    };
    let period = PERIOD_S.min(1.0 / (PER_CUTOFF * cutoff_hz));
    let duration: f64 = stretches.iter().map(|stretch| stretch.duration_s).sum();
    if duration / period > MOST_FRAMES {
        return Err(Error::failed(format!(
            "a plan of {duration} s; expected at most {} s",
            MOST_FRAMES * period
        )));
    }
    follow.start(period)?;
    let wheels = robot.wheel_speeds_of_motion();
    let of_wheels = |[ahead, turn]: [f64; 2]| {
        PerWheel::new(robot.wheels(), |wheel| wheels[(wheel, 0)] * ahead + wheels[(wheel, 2)] * turn)
    };
    for stretch in stretches.iter().filter(|stretch| stretch.duration_s > 0.0) {
        // Each frame stands for its own part of the stretch, at the middle of it.
        let parts = (stretch.duration_s / period).ceil();
        let elapsed = stretch.duration_s / parts;
        let gained = [0, 1].map(|axis| stretch.to[axis] - stretch.from[axis]);
        let acceleration = of_wheels(gained.map(|gained| gained / stretch.duration_s));
        for piece in 0..parts as u64 {
            let share = (piece as f64 + 0.5) / parts;
            let wheel_speed = of_wheels([0, 1].map(|axis| stretch.from[axis] + share * gained[axis]));
            follow.frame(&Frame {
                leg: stretch.leg,
                wheel_speed,
                wheel_acceleration: Some(acceleration),
                elapsed,
                slope_rad: stretch.slope_rad,
                measured_w: None,
            });
        }
    }
    Ok(match plan {
        Plan::Legs(legs) => legs.iter().map(|leg| leg.name.clone()).collect(),
        Plan::Profile(rows) => names(rows),
        Plan::Log(_) => Vec::new(),
    })
}

/// Names of a profile's legs, in the order of their first rows.
fn names(rows: &[Row]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for row in rows {
        if !names.contains(&row.leg) {
            names.push(row.leg.clone());
        }
    }
    names
}

fn pieces(rows: &[Row]) -> Vec<Stretch> {
    let names = names(rows);
    let pairs = rows.iter().zip(&rows[1..]);
    let motion = |row: &Row| [row.speed_m_s, row.turn_rad_s];
    let piece = |(from, to): (&Row, &Row)| Stretch {
        leg: names.iter().position(|name| *name == from.leg).unwrap_or(0),
        duration_s: to.time_s - from.time_s,
        from: motion(from),
        to: motion(to),
        slope_rad: from.slope_rad,
    };
    pairs.map(piece).collect()
}

/// The rows of a log, its legs parted by stops.
fn logged(reader: &mut SampleReader, robot: &Robot, follow: &mut dyn Follow) -> Result<Vec<String>> {
    let (mut leg, mut stood, mut has_moved) = (0, 0.0, false);
    while let Some(row) = reader.next_row()? {
        let dead = robot.speed_dead_band_rad_s();
        let is_moving = row.sample.wheel_speed.iter().any(|speed| speed.abs() > dead);
        let is_start = row.elapsed.is_infinite();
        if has_moved && ((is_moving && stood >= STOP_S) || is_start) {
            leg += 1;
            has_moved = false;
        }
        has_moved |= is_moving;
        stood = if is_moving || is_start { 0.0 } else { stood + row.elapsed };
        follow.frame(&Frame {
            leg,
            wheel_speed: row.sample.wheel_speed,
            wheel_acceleration: None,
            elapsed: row.elapsed,
            slope_rad: 0.0,
            measured_w: Some(row.sample.power),
        });
    }
    Ok((1..=leg + 1).map(|number| number.to_string()).collect())
}
