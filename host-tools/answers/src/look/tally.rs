//! Sums over a log's rows.

use super::bins::{Bins, Course};

/// A step longer than this, s, is a gap: nothing is said of the time within.
const LONGEST_STEP_S: f64 = 2.0;

/// Slower than this the robot stands: m/s, rad/s of the body, rad/s of the wheels.
const STANDING: [f64; 3] = [0.01, 0.02, 0.05];

/// One row; NaN where the log has nothing.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moment {
    pub(super) time_s: f64,
    pub(super) speed_m_s: f64,
    pub(super) turn_rad_s: f64,
    /// Mean of the wheels' speeds without their signs.
    pub(super) wheels_rad_s: f64,
    pub(super) power_w: f64,
    pub(super) current_a: f64,
    pub(super) charge: f64,
    pub(super) mass_kg: f64,
}

/// Seconds and joules of one state.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Share {
    pub(super) seconds: f64,
    pub(super) joules: f64,
}

impl Share {
    pub(super) fn mean_w(self) -> Option<f64> {
        (self.seconds > 0.0).then(|| self.joules / self.seconds)
    }
}

#[derive(Debug, Clone)]
pub(super) struct Tally {
    pub(super) rows: u64,
    pub(super) gaps: u64,
    pub(super) longest_gap_s: f64,
    last: Option<f64>,
    pub(super) duration_s: f64,
    pub(super) moving: Share,
    pub(super) resting: Share,
    pub(super) distance_m: f64,
    pub(super) turned_rad: f64,
    pub(super) rolled_rad: f64,
    /// All energy, of motion known or not, J.
    pub(super) joules: f64,
    pub(super) powered_rows: u64,
    /// Rows with power that is not exactly 0: what is not measured is often 0.
    pub(super) drawn_rows: u64,
    pub(super) negative_rows: u64,
    pub(super) has_wheels: bool,
    pub(super) has_speed: bool,
    pub(super) charge: Option<(f64, f64)>,
    pub(super) ampere_seconds: f64,
    /// Least and greatest.
    pub(super) mass_kg: Option<(f64, f64)>,
    pub(super) over_speed: Bins,
    pub(super) over_turn: Bins,
    pub(super) over_wheels: Bins,
    pub(super) power: Course,
    pub(super) speed: Course,
}

impl Tally {
    pub(super) fn new() -> Self {
        Self {
            rows: 0,
            gaps: 0,
            longest_gap_s: 0.0,
            last: None,
            duration_s: 0.0,
            moving: Share::default(),
            resting: Share::default(),
            distance_m: 0.0,
            turned_rad: 0.0,
            rolled_rad: 0.0,
            joules: 0.0,
            powered_rows: 0,
            drawn_rows: 0,
            negative_rows: 0,
            has_wheels: false,
            has_speed: false,
            charge: None,
            ampere_seconds: 0.0,
            mass_kg: None,
            over_speed: Bins::new(0.05),
            over_turn: Bins::new(0.1),
            over_wheels: Bins::new(0.5),
            power: Course::new(),
            speed: Course::new(),
        }
    }

    pub(super) fn add(&mut self, moment: &Moment) {
        self.rows += 1;
        self.has_wheels |= moment.wheels_rad_s.is_finite();
        self.has_speed |= moment.speed_m_s.is_finite();
        if moment.charge.is_finite() {
            let first = self.charge.map_or(moment.charge, |(first, _)| first);
            self.charge = Some((first, moment.charge));
        }
        if moment.mass_kg.is_finite() {
            let (least, most) = self.mass_kg.unwrap_or((moment.mass_kg, moment.mass_kg));
            self.mass_kg = Some((least.min(moment.mass_kg), most.max(moment.mass_kg)));
        }
        let has_power = moment.power_w.is_finite();
        self.powered_rows += u64::from(has_power);
        self.drawn_rows += u64::from(has_power && moment.power_w != 0.0);
        self.negative_rows += u64::from(moment.power_w < 0.0);
        let step = self.last.replace(moment.time_s).map_or(0.0, |last| moment.time_s - last);
        if step <= 0.0 {
            return;
        }
        if step > LONGEST_STEP_S {
            self.gaps += 1;
            self.longest_gap_s = self.longest_gap_s.max(step);
            return;
        }
        self.duration_s += step;
        self.add_step(moment, step);
    }

    /// The share of the rows with negative power, where it is most of them: no robot feeds back for
    /// more of the time than it draws.
    pub(super) fn negative_share(&self) -> Option<f64> {
        let share = self.negative_rows as f64 / self.drawn_rows.max(1) as f64;
        (share > 0.5).then_some(share)
    }

    fn add_step(&mut self, moment: &Moment, step: f64) {
        let motions = [moment.speed_m_s, moment.turn_rad_s, moment.wheels_rad_s];
        let is_known = motions.iter().any(|motion| motion.is_finite());
        let is_moving = motions.iter().zip(STANDING).any(|(motion, least)| motion.abs() > least);
        let add = |sum: &mut f64, rate: f64| *sum += if rate.is_finite() { rate.abs() * step } else { 0.0 };
        add(&mut self.distance_m, moment.speed_m_s);
        add(&mut self.turned_rad, moment.turn_rad_s);
        add(&mut self.rolled_rad, moment.wheels_rad_s);
        if moment.speed_m_s.is_finite() {
            self.speed.add(moment.time_s, moment.speed_m_s, step);
        }
        if moment.current_a.is_finite() {
            self.ampere_seconds += moment.current_a * step;
        }
        if !moment.power_w.is_finite() {
            return;
        }
        let joules = moment.power_w * step;
        self.joules += joules;
        self.power.add(moment.time_s, moment.power_w, step);
        if !is_known {
            return;
        }
        let share = if is_moving { &mut self.moving } else { &mut self.resting };
        share.seconds += step;
        share.joules += joules;
        // Turns on the spot say nothing of driving, and the other way round.
        let [speed, turn, wheels] = motions;
        let turns = turn.abs() > STANDING[1];
        if speed.is_finite() && !turns {
            self.over_speed.add(speed, moment.power_w, step);
        }
        if turn.is_finite() && speed.abs() <= 0.05 {
            self.over_turn.add(turn, moment.power_w, step);
        }
        if wheels.is_finite() {
            self.over_wheels.add(wheels, moment.power_w, step);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 10 s at rest at 5 W, 10 s at 0.5 m/s and 9 W, and a gap of a minute: 5 m for 90 J.
    #[test]
    fn energy_is_split_into_rest_and_motion() {
        let mut tally = Tally::new();
        for row in 0..=200 {
            let rests = row <= 100;
            let moment = Moment {
                time_s: f64::from(row) * 0.1,
                speed_m_s: if rests { 0.0 } else { 0.5 },
                turn_rad_s: 0.0,
                wheels_rad_s: f64::NAN,
                power_w: if rests { 5.0 } else { 9.0 },
                current_a: 0.5,
                charge: 0.8 - 0.001 * f64::from(row),
                mass_kg: f64::NAN,
            };
            tally.add(&moment);
            if row == 200 {
                tally.add(&Moment { time_s: 80.0, ..moment });
            }
        }
        let near = |mean: f64, expected: f64| assert!((mean - expected).abs() < 1e-9, "{mean} {expected}");
        near(tally.resting.joules, 50.0);
        near(tally.moving.joules, 90.0);
        near(tally.joules, 140.0);
        near(tally.distance_m, 5.0);
        near(tally.ampere_seconds, 10.0);
        near(tally.longest_gap_s, 60.0);
        assert_eq!((tally.gaps, tally.charge), (1, Some((0.8, 0.8 - 0.2))));
    }
}
