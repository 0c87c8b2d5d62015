//! The floor: slope, rolling resistance, scrub.

use support::error::Result;

use super::super::body::GRAVITY;
use super::cause::{Cause, Listed, Onset, Setting, onset, onset_drawn};
use super::conditions::{Conditions, Now};
use super::entry::{Choice, Effect, Entry, Values};
use super::options::{AT, DRAWN_AT};

pub(super) const GRADE: Listed = Listed {
    entry: Entry {
        id: "grade",
        meaning: "The robot drives on an inclined plane: gravity pulls along the way and presses less to the floor.",
        unit: "slope angle, rad",
        range: (-0.3, 0.3),
        options: &[
            Choice {
                name: "along",
                values: Values::Word(&["world", "travel"]),
                default: Some(0.0),
                meaning: "where it rises: in a fixed direction, or always ahead of the robot's nose",
            },
            Choice {
                name: "heading",
                values: Values::Number(-std::f64::consts::PI, std::f64::consts::PI),
                default: Some(0.0),
                meaning: "that direction, rad counter-clockwise from the robot's heading at the start",
            },
            AT,
        ],
    },
    build: |effect, setting| {
        Ok(Box::new(Grade {
            slope: onset(effect),
            world: effect.number("along") == 0.0,
            heading_rad: effect.number("heading"),
            holonomic: setting.scenario.robot.geometry.holonomic(),
        }))
    },
};

#[derive(Debug, Clone)]
struct Grade {
    slope: Onset,
    world: bool,
    heading_rad: f64,
    holonomic: bool,
}

impl Cause for Grade {
    fn act(&mut self, now: &Now, conditions: &mut Conditions) {
        let (sin, cos) = self.slope.at(now.time_s).sin_cos();
        // From the way uphill to the robot's nose.
        let bearing = if self.world { now.heading_rad - self.heading_rad } else { 0.0 };
        let (across, ahead) = bearing.sin_cos();
        let weight = (now.mass_kg + conditions.unnoted_kg) * GRAVITY;
        conditions.loads.force[0] -= weight * sin * ahead;
        if self.holonomic {
            // Wheels that cannot roll sideways take this part themselves.
            conditions.loads.force[1] += weight * sin * across;
        }
        conditions.loads.normal_gravity *= cos;
        conditions.rise[0] += sin * ahead;
        conditions.rise[1] -= sin * across;
    }
}

pub(super) const ROLLING: Listed = Listed {
    entry: Entry {
        id: "rolling-resistance-change",
        meaning: "The floor is another than in the fit: wheels roll harder or more easily.",
        unit: "change of the coefficient of rolling resistance (force per normal force)",
        range: (-0.03, 0.3),
        options: &[AT],
    },
    build: |effect, setting| rolling(effect, setting, onset(effect)),
};

pub(super) const SURFACE: Listed = Listed {
    entry: Entry {
        id: "surface-switch",
        meaning: "The robot comes onto another floor within the run.",
        unit: "change of the coefficient of rolling resistance (force per normal force)",
        range: (-0.03, 0.3),
        options: &[DRAWN_AT],
    },
    build: |effect, setting| rolling(effect, setting, onset_drawn(effect, setting)),
};

fn rolling(effect: &Effect, setting: &Setting<'_>, change: Onset) -> Result<Box<dyn Cause>> {
    let wheels = setting.scenario.robot.wheels;
    let least = wheels.iter().map(|wheel| wheel.rolling_resistance).fold(f64::INFINITY, f64::min);
    if least + change.size < 0.0 {
        return Err(
            effect.refuse(format_args!("the robot's coefficient is {least}; allowed: down to -{least}"))
        );
    }
    Ok(Box::new(Rolling { change }))
}

#[derive(Debug, Clone)]
struct Rolling {
    change: Onset,
}

impl Cause for Rolling {
    fn act(&mut self, now: &Now, conditions: &mut Conditions) {
        let change = self.change.at(now.time_s);
        for wheel in &mut conditions.wheels {
            wheel.rolling_resistance += change;
        }
    }
}

pub(super) const SCRUB: Listed = Listed {
    entry: Entry {
        id: "turning-scrub",
        meaning: "Tyres slide sideways in turns: dry friction with the floor resists every turn.",
        unit: "coefficient of friction of the sliding contact (force per normal force)",
        range: (0.0, 1.0),
        options: &[
            Choice {
                name: "arm",
                values: Values::Number(0.0, 10.0),
                default: None,
                meaning: "lever of the friction about the turning centre, m [default: half of the wheelbase]",
            },
            AT,
        ],
    },
    build: |effect, setting| {
        let arm_m = effect.option("arm").unwrap_or(setting.scenario.robot.geometry.wheelbase_m / 2.0);
        Ok(Box::new(Scrub { friction: onset(effect), arm_m }))
    },
};

#[derive(Debug, Clone)]
struct Scrub {
    friction: Onset,
    arm_m: f64,
}

impl Cause for Scrub {
    fn act(&mut self, now: &Now, conditions: &mut Conditions) {
        let weight = (now.mass_kg + conditions.unnoted_kg) * conditions.loads.normal_gravity;
        let friction = self.friction.at(now.time_s);
        conditions.sliding_friction += friction;
        conditions.loads.turning_friction += friction * weight * self.arm_m;
    }
}
