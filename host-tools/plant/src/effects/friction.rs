//! Bearings, grease and air.

use super::cause::{Cause, Listed, Onset, onset, wheel_of_side};
use super::conditions::{Conditions, Now};
use super::entry::{Choice, Entry, Values};
use super::options::{AT, SIDE};

pub(super) const WINDAGE: Listed = Listed {
    entry: Entry {
        id: "windage",
        meaning: "Air drags at the rotor or its fan, with the square of the speed.",
        unit: "drag torque per squared speed, referred to the wheel, N·m/(rad/s)²",
        range: (0.0, 0.01),
        options: &[AT],
    },
    build: |effect, _| Ok(Box::new(Windage { drag: onset(effect) })),
};

#[derive(Debug, Clone)]
struct Windage {
    drag: Onset,
}

impl Cause for Windage {
    fn act(&mut self, now: &Now, conditions: &mut Conditions) {
        for wheel in &mut conditions.wheels {
            // The same power at the rotor, which turns n times as fast.
            wheel.motor.windage += self.drag.at(now.time_s) / wheel.gear.ratio.powi(3);
        }
    }
}

pub(super) const STRIBECK: Listed = Listed {
    entry: Entry {
        id: "stribeck",
        meaning: "At low speed the lubricant's film breaks down, and dry friction peaks.",
        unit: "additional dry friction torque of every wheel at rest, N·m",
        range: (0.0, 0.5),
        options: &[
            Choice {
                name: "width",
                values: Values::Number(0.05, 20.0),
                default: Some(1.0),
                meaning: "wheel speed at which the peak has fallen to 1/e, rad/s",
            },
            Choice {
                name: "exponent",
                values: Values::Number(0.5, 2.0),
                default: Some(2.0),
                meaning: "its decay exp(-(speed/width)^exponent): 2 Gaussian, 1 exponential",
            },
            AT,
        ],
    },
    build: |effect, _| {
        let (width, exponent) = (effect.number("width"), effect.number("exponent"));
        Ok(Box::new(Stribeck { peak: onset(effect), width, exponent }))
    },
};

#[derive(Debug, Clone)]
struct Stribeck {
    peak: Onset,
    width: f64,
    exponent: f64,
}

impl Cause for Stribeck {
    fn act(&mut self, now: &Now, conditions: &mut Conditions) {
        let peak = self.peak.at(now.time_s);
        for (friction, speed) in conditions.loads.wheel_friction.iter_mut().zip(now.wheel_rad_s) {
            *friction += peak * (-(speed.abs() / self.width).powf(self.exponent)).exp();
        }
    }
}

pub(super) const VISCOUS: Listed = Listed {
    entry: Entry {
        id: "viscous-change",
        meaning: "The grease is thicker or thinner than in the fit.",
        unit: "change of viscous friction, as a share of it",
        range: (-0.9, 10.0),
        options: &[AT],
    },
    build: |effect, _| Ok(Box::new(Viscous { change: onset(effect), fades_s: f64::INFINITY })),
};

pub(super) const WARM_UP: Listed = Listed {
    entry: Entry {
        id: "lubricant-warm-up",
        meaning: "Grease is thick at the start of the run and thins while the gears warm.",
        unit: "additional viscous friction at the start, as a share of it",
        range: (0.0, 10.0),
        options: &[Choice {
            name: "tau",
            values: Values::Number(1.0, 3600.0),
            default: Some(60.0),
            meaning: "time constant of warming, s",
        }],
    },
    build: |effect, _| {
        let change = Onset { size: effect.size(), at_s: 0.0 };
        Ok(Box::new(Viscous { change, fades_s: effect.number("tau") }))
    },
};

#[derive(Debug, Clone)]
struct Viscous {
    change: Onset,
    /// Time constant with which the change fades, s.
    fades_s: f64,
}

impl Cause for Viscous {
    fn act(&mut self, now: &Now, conditions: &mut Conditions) {
        let remaining = (-now.time_s / self.fades_s).exp();
        let factor = 1.0 + self.change.at(now.time_s) * remaining;
        for wheel in &mut conditions.wheels {
            wheel.motor.viscous *= factor;
            wheel.viscous *= factor;
        }
    }
}

pub(super) const DRAG: Listed = Listed {
    entry: Entry {
        id: "wheel-drag",
        meaning: "One wheel drags: a brake that rubs, hair round its axle, a worn bearing.",
        unit: "additional dry friction torque at that wheel, N·m",
        range: (0.0, 0.5),
        options: &[
            SIDE,
            Choice {
                name: "wheel",
                values: Values::Number(1.0, 4.0),
                default: None,
                meaning: "that wheel, counted as in the log [default: the front wheel of the side]",
            },
            AT,
        ],
    },
    build: |effect, setting| {
        let geometry = setting.scenario.robot.geometry;
        let wheel = match effect.option("wheel") {
            Some(wheel) if wheel.fract() == 0.0 && wheel as usize <= geometry.wheels() => wheel as usize - 1,
            Some(wheel) => {
                let allowed = format!("wheel={wheel}; allowed: 1 to {}", geometry.wheels());
                return Err(effect.refuse(allowed));
            }
            None => wheel_of_side(effect, &geometry),
        };
        Ok(Box::new(Drag { torque: onset(effect), wheel }))
    },
};

#[derive(Debug, Clone)]
struct Drag {
    torque: Onset,
    wheel: usize,
}

impl Cause for Drag {
    fn act(&mut self, now: &Now, conditions: &mut Conditions) {
        conditions.loads.wheel_friction[self.wheel] += self.torque.at(now.time_s);
    }
}
