//! What a drive shows of the robot: speeds, accelerations, turns, payloads.

use std::collections::{BTreeMap, VecDeque};

use logs::robot::{Geometry, Robot};
use serde::Serialize;

use super::sketch::Sketch;

/// Accelerations are taken over this time, s: over one sample they would be noise.
const ACCELERATION_S: f64 = 0.2;
/// Power below this share of the usual greatest is near 0.
const NEAR_ZERO: f64 = 0.01;
/// Most payloads distinguished; a log with more has a mass that varies.
const MOST_PAYLOADS: usize = 64;

/// What a drive shows.
#[derive(Debug, Clone, Serialize)]
pub struct Excitation {
    /// Share of rows in which a wheel moves.
    pub share_moving: f64,
    /// Least and greatest wheel speed, rad/s.
    pub wheel_speed_range_rad_s: (f64, f64),
    /// Wheel speed of the fastest wheel while moving: 5 %, 50 % and 95 % quantile, rad/s.
    pub speed_quantiles_rad_s: [f64; 3],
    /// Magnitude of wheel accelerations while moving: 50 % and 95 % quantile, rad/s².
    pub acceleration_quantiles_rad_s2: [f64; 2],
    /// Share of moving rows in which the fastest wheel changes its speed by more than a tenth of
    /// the usual in a second.
    pub share_accelerating: f64,
    /// Share of moving rows in which the robot drives straight: the rim turns by less than 5 % of
    /// the way.
    pub share_straight: f64,
    /// Share of moving rows in which it turns: by more than 20 % of the way.
    pub share_turning: f64,
    /// Share of moving rows with power near 0: a drive that cannot feed back hides what happens
    /// there.
    pub share_power_near_zero: f64,
    /// Share of moving rows whose power is negative by more than noise about 0: by 2 % of the
    /// greatest.
    pub share_power_negative: f64,
    /// Total masses in the log, kg, and the share of rows with each; rows without a mass are left
    /// out.
    pub payloads: Vec<PayloadShare>,
    /// Greatest power, 99.9 % quantile of its magnitude, W.
    pub power_high_w: f64,
}

/// One total mass of a log.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PayloadShare {
    /// Total mass, kg.
    pub mass_kg: f64,
    /// Share of rows.
    pub share: f64,
}

pub(super) struct Watch<'a> {
    robot: &'a Robot,
    recent: VecDeque<(f64, Vec<f64>)>,
    rows: u64,
    moving: u64,
    low: f64,
    high: f64,
    speeds: Sketch,
    accelerations: Sketch,
    fastest_changes: Sketch,
    straight: u64,
    turning: u64,
    power: Sketch,
    moving_power: Sketch,
    negative: Sketch,
    masses: BTreeMap<i64, u64>,
}

impl<'a> Watch<'a> {
    pub(super) fn new(robot: &'a Robot) -> Self {
        Self {
            robot,
            recent: VecDeque::new(),
            rows: 0,
            moving: 0,
            low: f64::INFINITY,
            high: f64::NEG_INFINITY,
            speeds: Sketch::new(),
            accelerations: Sketch::new(),
            fastest_changes: Sketch::new(),
            straight: 0,
            turning: 0,
            power: Sketch::new(),
            moving_power: Sketch::new(),
            negative: Sketch::new(),
            masses: BTreeMap::new(),
        }
    }

    pub(super) fn restart(&mut self) {
        self.recent.clear();
    }

    pub(super) fn add(&mut self, time_s: f64, wheels: &[f64], power_w: f64, mass_kg: f64) {
        self.rows += 1;
        self.power.add(power_w);
        if mass_kg.is_finite() && self.masses.len() <= MOST_PAYLOADS {
            *self.masses.entry((mass_kg * 1000.0).round() as i64).or_default() += 1;
        }
        for &speed in wheels {
            self.low = self.low.min(speed);
            self.high = self.high.max(speed);
        }
        let mut spare = Vec::new();
        while self.recent.len() > 1 && time_s - self.recent[1].0 >= ACCELERATION_S {
            if let Some((_, wheels)) = self.recent.pop_front() {
                spare = wheels;
            }
        }
        let fastest = wheels.iter().fold(0.0, |fastest: f64, speed| fastest.max(speed.abs()));
        if fastest > self.robot.speed_dead_band_rad_s() {
            self.moving += 1;
            if power_w < 0.0 {
                self.negative.add(power_w);
            }
            self.speeds.add(fastest);
            self.moving_power.add(power_w);
            if let Some((from_s, before)) = self.recent.front() {
                let accelerations =
                    wheels.iter().zip(before).map(|(now, then)| (now - then) / (time_s - from_s));
                let greatest = accelerations.fold(0.0, |greatest: f64, a| {
                    self.accelerations.add(a);
                    greatest.max(a.abs())
                });
                self.fastest_changes.add(greatest);
            }
            let (way, rim) = way_and_rim(self.robot, wheels);
            self.straight += u64::from(rim.abs() < 0.05 * way.abs());
            self.turning += u64::from(rim.abs() > 0.2 * way.abs());
        }
        spare.clear();
        spare.extend_from_slice(wheels);
        self.recent.push_back((time_s, spare));
    }

    pub(super) fn finish(self) -> Excitation {
        let of_rows = |count: u64| count as f64 / self.rows.max(1) as f64;
        let of_moving = |count: u64| count as f64 / self.moving.max(1) as f64;
        let power_high_w = self.power.quantile(0.999);
        let near = self.moving_power.count() - self.moving_power.above(NEAR_ZERO * self.power.quantile(0.95));
        let usual_speed = self.speeds.quantile(0.95);
        let accelerating = self.fastest_changes.above(0.1 * usual_speed);
        Excitation {
            share_moving: of_rows(self.moving),
            wheel_speed_range_rad_s: (self.low, self.high),
            speed_quantiles_rad_s: [0.05, 0.5, 0.95].map(|share| self.speeds.quantile(share)),
            acceleration_quantiles_rad_s2: [0.5, 0.95].map(|share| self.accelerations.quantile(share)),
            share_accelerating: accelerating as f64 / self.fastest_changes.count().max(1) as f64,
            share_straight: of_moving(self.straight),
            share_turning: of_moving(self.turning),
            share_power_near_zero: of_moving(near),
            share_power_negative: of_moving(self.negative.above(2.0 * NEAR_ZERO * power_high_w)),
            payloads: self
                .masses
                .iter()
                .map(|(&grams, &count)| PayloadShare {
                    mass_kg: grams as f64 / 1000.0,
                    share: of_rows(count),
                })
                .collect(),
            power_high_w,
        }
    }
}

/// Speed of the centre and of a point on the wheels' circle by the turn alone, in the same unit.
fn way_and_rim(robot: &Robot, w: &[f64]) -> (f64, f64) {
    let mean = w.iter().sum::<f64>() / w.len().max(1) as f64;
    match (robot.geometry(), w) {
        (Geometry::DifferentialDrive { .. } | Geometry::SkidSteer { .. }, [left, right]) => {
            (mean, 0.5 * (right - left))
        }
        (Geometry::SkidSteer { .. }, [front_left, front_right, rear_left, rear_right]) => {
            (mean, 0.25 * (front_right + rear_right - front_left - rear_left))
        }
        (Geometry::ThreeWheelOmni { .. }, _) => {
            let way = w.iter().map(|speed| (speed - mean).powi(2)).sum::<f64>() * 2.0 / 3.0;
            (way.sqrt(), mean)
        }
        (Geometry::FourMecanum { .. }, [front_left, front_right, rear_left, rear_right]) => {
            let aside = 0.25 * (front_right + rear_left - front_left - rear_right);
            (mean.hypot(aside), 0.25 * (front_right + rear_right - front_left - rear_left))
        }
        (Geometry::Matrix { rows, .. }, _) => {
            let of = |row: &[f64]| row.iter().zip(w).map(|(entry, speed)| entry * speed).sum::<f64>();
            let Some((turn, ways)) = rows.split_last() else { return (0.0, 0.0) };
            (ways.iter().map(|row| of(row).powi(2)).sum::<f64>().sqrt(), of(turn) * robot.gyration_radius_m())
        }
        _ => (mean, 0.0),
    }
}
