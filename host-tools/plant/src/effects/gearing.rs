//! A gear that loses more under load.

use super::super::gear::Gear;
use super::cause::{Cause, Listed, Onset, onset};
use super::conditions::{Conditions, Now};
use super::entry::{Choice, Entry, Values};
use super::options::AT;

pub(super) const GEAR_LOAD: Listed = Listed {
    entry: Entry {
        id: "gear-load-loss",
        meaning: "Teeth rub harder under load: the gear's efficiency falls with the torque, and more so when back-driven.",
        unit: "fall of the efficiency per torque at the wheel, as a share of it, 1/(N·m)",
        range: (0.0, 10.0),
        options: &[
            Choice {
                name: "back",
                values: Values::Number(0.0, 10.0),
                default: Some(2.0),
                meaning: "how many times as much when the wheel drives the motor",
            },
            AT,
        ],
    },
    build: |effect, _| Ok(Box::new(GearLoad { fall: onset(effect), back: effect.number("back") })),
};

#[derive(Debug, Clone)]
struct GearLoad {
    fall: Onset,
    back: f64,
}

impl Cause for GearLoad {
    fn act(&mut self, now: &Now, conditions: &mut Conditions) {
        for (wheel, last) in conditions.wheels.iter_mut().zip(now.last) {
            let Gear { ratio, efficiency } = &mut wheel.gear;
            let direction = if last.torque_gain > *ratio { self.back } else { 1.0 };
            let torque = (last.torque_gain * last.shaft_torque).abs();
            // A fall of c T while c T is small; never to nothing.
            *efficiency /= 1.0 + self.fall.at(now.time_s) * direction * torque;
        }
    }
}
