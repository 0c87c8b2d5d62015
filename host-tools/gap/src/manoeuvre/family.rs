//! The profiles that are tried: a rest, then short blocks in turn, each from rest to rest.

use super::limits::Limits;
use residuals::thresholds::manoeuvre::EASY;

/// A stretch of a profile: a ramp to a twist, and the time that it is held.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Leg {
    /// Share of the greatest forward speed.
    speed: f64,
    /// Share of the turn rate of the fastest spin.
    turn: f64,
    /// Share of the greatest acceleration.
    brisk: f64,
    /// s.
    hold_s: f64,
}

/// Some seconds of one kind of motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// In words.
    pub name: String,
    legs: Vec<Leg>,
}

const fn leg(speed: f64, turn: f64, brisk: f64, hold_s: f64) -> Leg {
    Leg { speed, turn, brisk, hold_s }
}

/// A profile of the family.
#[derive(Debug, Clone, PartialEq)]
pub struct Recipe {
    /// Rest before the first motion, s.
    pub lead_s: f64,
    /// Length, s.
    pub duration_s: f64,
    /// Blocks that take turns, by their places in [`blocks`].
    pub blocks: Vec<usize>,
}

/// A commanded motion: time, s, forward speed, m/s, and turn rate, rad/s; straight lines between.
pub type Knots = Vec<(f64, [f64; 2])>;

/// All blocks.
pub fn blocks() -> Vec<Block> {
    let mut all = Vec::new();
    let mut add = |name: String, legs: Vec<Leg>| all.push(Block { name, legs });
    for (direction, way) in [(1.0, "ahead"), (-1.0, "backwards")] {
        for speed in [0.1, 0.3, 0.6, 1.0] {
            add(
                format!("{way} at {:.0} % of the speed", 100.0 * speed),
                vec![leg(direction * speed, 0.0, EASY, 8.0), leg(0.0, 0.0, EASY, 0.5)],
            );
        }
    }
    for speed in [0.4, 1.0] {
        for brisk in [0.3, 1.0] {
            let up = leg(speed, 0.0, brisk, 0.3);
            let stop = leg(0.0, 0.0, brisk, 0.3);
            let back = leg(-speed, 0.0, brisk, 0.3);
            let name =
                format!("at {:.0} % of the speed, {:.0} % of the acceleration", 100.0 * speed, 100.0 * brisk);
            add(format!("stop and go {name}"), [up, stop].repeat(4));
            add(format!("to and fro {name}"), [up, stop, back, stop].repeat(2));
        }
    }
    for brisk in [0.3, 1.0] {
        add(
            format!("between slow and fast, {:.0} % of the acceleration", 100.0 * brisk),
            [
                [leg(0.3, 0.0, brisk, 0.5), leg(1.0, 0.0, brisk, 0.5)].repeat(3),
                vec![leg(0.0, 0.0, brisk, 0.5)],
            ]
            .concat(),
        );
    }
    for (side, way) in [(1.0, "left"), (-1.0, "right")] {
        for rate in [0.2, 0.5, 1.0] {
            add(
                format!("spins to the {way} at {:.0} %", 100.0 * rate),
                vec![leg(0.0, side * rate, EASY, 5.0), leg(0.0, 0.0, EASY, 0.5)],
            );
        }
        for rate in [0.4, 1.0] {
            add(
                format!("turns to the {way} about one wheel at {:.0} %", 100.0 * rate),
                vec![leg(0.5 * rate, 0.5 * side * rate, EASY, 6.0), leg(0.0, 0.0, EASY, 0.5)],
            );
        }
        add(
            format!("wide curves to the {way}"),
            vec![leg(0.8, 0.2 * side, EASY, 6.0), leg(0.0, 0.0, EASY, 0.5)],
        );
    }
    add("rests".to_owned(), vec![leg(0.0, 0.0, EASY, 8.0)]);
    all
}

impl Block {
    /// With holds shortened to this share, then backwards in time: it ends where it began, with the
    /// same heading.
    pub(super) fn there_and_back(&self, share: f64) -> Self {
        let there: Vec<Leg> =
            self.legs.iter().map(|leg| Leg { hold_s: share * leg.hold_s, ..*leg }).collect();
        let ends_at_rest = there.last().is_some_and(|leg| leg.speed == 0.0 && leg.turn == 0.0);
        // The rest at the end stays at the end; the legs before it are driven back, the last first.
        let driven = &there[..there.len() - usize::from(ends_at_rest)];
        let back = driven.iter().rev().map(|leg| Leg { speed: -leg.speed, turn: -leg.turn, ..*leg });
        let rest = there.last().copied().filter(|_| ends_at_rest);
        let legs = there.iter().copied().chain(back).chain(rest).collect();
        let name = if driven.is_empty() { self.name.clone() } else { format!("{} and back", self.name) };
        Self { name, legs }
    }
}

impl Recipe {
    /// The profile: it begins and ends at rest, and keeps the limits.
    pub fn knots(&self, all: &[Block], limits: &Limits) -> Knots {
        let mut knots = vec![(0.0, [0.0; 2])];
        let (mut now, mut twist) = (self.lead_s, [0.0; 2]);
        knots.push((now, twist));
        for &place in self.blocks.iter().cycle() {
            let Some(block) = all.get(place) else { break };
            let before = (knots.len(), now);
            for leg in &block.legs {
                let wanted = [leg.speed * limits.speed_m_s, leg.turn * limits.spin_rad_s()];
                let target = limits.hold(wanted);
                let ramp = limits.ramp_s(twist, target) / leg.brisk;
                if ramp > 0.0 {
                    now += ramp;
                    knots.push((now, target));
                }
                twist = target;
                now += leg.hold_s;
                knots.push((now, twist));
            }
            // Blocks begin and end at rest. One that is too long is left out, and the robot rests
            // for the remaining time.
            if now > self.duration_s || now <= before.1 {
                knots.truncate(before.0);
                break;
            }
        }
        if knots.last().is_some_and(|(time, _)| *time < self.duration_s) {
            knots.push((self.duration_s, [0.0; 2]));
        }
        knots
    }

    /// In words.
    pub fn words(&self, all: &[Block]) -> String {
        let mut names: Vec<&str> =
            self.blocks.iter().filter_map(|&place| all.get(place)).map(|b| &b.name[..]).collect();
        names.dedup();
        format!("{:.0} s of rest, then by turns: {}", self.lead_s, names.join(", "))
    }
}

/// The twist at a time.
pub fn at(knots: &Knots, time: f64) -> [f64; 2] {
    let next = knots.partition_point(|(knot, _)| *knot <= time).clamp(1, knots.len().max(2) - 1);
    let ((from, a), (to, b)) = (knots[next - 1], knots[next]);
    let share = if to > from { ((time - from) / (to - from)).clamp(0.0, 1.0) } else { 1.0 };
    [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])]
}

#[cfg(test)]
mod tests {
    use logs::motions::Step;
    use logs::robot::Robot;
    use logs::robot::chassis::Chassis;
    use logs::runs::{Cutoffs, Runs};

    use super::super::super::bench::sets::CUTOFF_HZ;
    use super::*;

    const ROBOT: &str = "kinematics = \"differential\"\nwheel_radius_m = 0.033\ntrack_m = 0.16\nmass_no_load_kg = 1\n\
                         mass_full_load_kg = 6\nmax_speed_m_s = 0.5\nmax_turn_rad_s = 2.0\nmax_acceleration_m_s2 = 0.8\n";

    /// Limits of a robot whose file gives them all: no runs are needed.
    fn limits() -> Limits {
        let robot = Robot::parse(ROBOT).unwrap();
        let core = robot.core::<2>(CUTOFF_HZ).unwrap();
        let (columns, runs, step) = (Vec::new(), Vec::new(), Step::default());
        let (chassis, cutoff) = (Chassis::new(&core), core.cutoff_hz);
        let cutoffs = Cutoffs { speed: cutoff, power: cutoff };
        let runs = Runs { robot: chassis, columns, runs, period_s: 0.1, step, cutoffs, smoothing: None };
        Limits::new(&robot, &runs)
    }

    #[test]
    fn profiles_keep_the_limits_of_the_robots_file_and_begin_and_end_at_rest() {
        let (limits, all) = (limits(), blocks());
        for block in 0..all.len() {
            let recipe = Recipe { lead_s: 2.0, duration_s: 60.0, blocks: vec![block, 3] };
            let knots = recipe.knots(&all, &limits);
            assert_eq!((knots[0].1, knots[knots.len() - 1].1), ([0.0; 2], [0.0; 2]), "{}", all[block].name);
            assert!(knots.windows(2).all(|pair| pair[1].0 > pair[0].0), "{}", all[block].name);
            let mut last: Option<Vec<f64>> = None;
            for k in 0..=600 {
                let [speed, turn] = at(&knots, f64::from(k) * 0.1);
                assert!(speed.abs() <= 0.5 + 1e-9 && turn.abs() <= 2.0 + 1e-9, "{}", all[block].name);
                // Wheels by hand: (v ∓ ω 0.08 m) / 0.033 m.
                let rims = vec![speed - 0.08 * turn, speed + 0.08 * turn];
                for (place, rim) in rims.iter().enumerate() {
                    assert!(rim.abs() <= 0.5 + 1e-9);
                    let before = last.as_ref().map_or(0.0, |last| last[place]);
                    assert!((rim - before).abs() <= 0.08 + 1e-9, "{} {k} {rim} {before}", all[block].name);
                }
                last = Some(rims);
            }
            let end = knots[knots.len() - 1].0;
            assert!((end - 60.0).abs() < 1e-9, "{} {end}", all[block].name);
        }
    }
}
