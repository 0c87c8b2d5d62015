//! Power beside the drives'.

use super::cause::{Cause, Listed, Onset, onset, onset_drawn};
use super::conditions::{Conditions, Now};
use super::entry::{Choice, Entry, Values};
use super::options::{AT, DRAWN_AT};

/// Wheel speed, rad/s, above which the robot counts as moving.
const MOVING_RAD_S: f64 = 0.02;

pub(super) const STEP: Listed = Listed {
    entry: Entry {
        id: "static-step",
        meaning: "The static power changes its state: a camera is switched on, torque is enabled.",
        unit: "power in the other state, W",
        range: (-10.0, 10.0),
        options: &[
            Choice {
                name: "on",
                values: Values::Word(&["time", "motion"]),
                default: Some(0.0),
                meaning: "when: from a time on, or while the robot moves",
            },
            Choice {
                name: "hold",
                values: Values::Number(0.0, 3600.0),
                default: Some(1.0),
                meaning: "with motion: for how long afterwards, s",
            },
            DRAWN_AT,
        ],
    },
    build: |effect, setting| {
        let on_motion = effect.number("on") == 1.0;
        let power = if on_motion { onset(effect) } else { onset_drawn(effect, setting) };
        let hold_s = if on_motion { effect.number("hold") } else { f64::INFINITY };
        Ok(Box::new(Step { power, hold_s, still_s: if on_motion { f64::INFINITY } else { 0.0 } }))
    },
};

#[derive(Debug, Clone)]
struct Step {
    power: Onset,
    hold_s: f64,
    /// How long the robot has not moved, s.
    still_s: f64,
}

impl Cause for Step {
    fn act(&mut self, now: &Now, conditions: &mut Conditions) {
        let moving = now.wheel_rad_s.iter().any(|speed| speed.abs() > MOVING_RAD_S);
        self.still_s = if moving { 0.0 } else { self.still_s + now.step_s };
        if self.still_s <= self.hold_s {
            conditions.static_w += self.power.at(now.time_s);
        }
    }
}

pub(super) const COMPUTE: Listed = Listed {
    entry: Entry {
        id: "compute-load",
        meaning: "The computer draws more the more it works.",
        unit: "additional power at full load, W",
        range: (0.0, 50.0),
        options: &[AT],
    },
    build: |effect, _| Ok(Box::new(Compute { full: onset(effect) })),
};

#[derive(Debug, Clone)]
struct Compute {
    full: Onset,
}

impl Cause for Compute {
    fn act(&mut self, now: &Now, conditions: &mut Conditions) {
        conditions.static_w += self.full.at(now.time_s) * now.cpu_percent / 100.0;
    }
}
