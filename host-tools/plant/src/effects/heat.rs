//! Copper that heats.

use super::super::kinematics::MAX_WHEELS;
use super::cause::{Cause, Listed, Onset, onset};
use super::conditions::{Conditions, Now};
use super::entry::{Choice, Entry, Values};
use super::options::AT;

/// Temperature coefficient of copper's resistance at 20 °C, 1/K (IEC 60028).
const COPPER_PER_K: f64 = 0.0039;

pub(super) const WINDING: Listed = Listed {
    entry: Entry {
        id: "winding-temperature",
        meaning: "The windings get hotter than in the fit, and copper's resistance rises by 0.39 % per kelvin.",
        unit: "rise of the winding's temperature once settled, K",
        range: (-40.0, 120.0),
        options: &[
            Choice {
                name: "heat",
                values: Values::Word(&["load", "room"]),
                default: Some(0.0),
                meaning: "what heats: the windings' own i²R, or warmth from outside",
            },
            Choice {
                name: "loss",
                values: Values::Number(0.001, 1000.0),
                default: Some(0.1),
                meaning: "i²R of one winding that settles at that rise, W: rise over loss is the thermal resistance, K/W",
            },
            Choice {
                name: "tau",
                values: Values::Number(1.0, 3600.0),
                default: Some(30.0),
                meaning: "thermal time constant, s",
            },
            AT,
        ],
    },
    build: |effect, _| {
        let load = effect.number("heat") == 0.0;
        if load && effect.size() < 0.0 {
            return Err(
                effect.refuse("its own loss cannot cool a winding; allowed: 0 and more, or heat=room")
            );
        }
        Ok(Box::new(Winding {
            settled: onset(effect),
            per_watt: load.then_some(1.0 / effect.number("loss")),
            tau_s: effect.number("tau"),
            rise_k: [0.0; MAX_WHEELS],
        }))
    },
};

#[derive(Debug, Clone)]
struct Winding {
    settled: Onset,
    /// 1/W; none where the heat comes from outside.
    per_watt: Option<f64>,
    tau_s: f64,
    rise_k: [f64; MAX_WHEELS],
}

impl Cause for Winding {
    fn act(&mut self, now: &Now, conditions: &mut Conditions) {
        let settled = self.settled.at(now.time_s);
        for (i, rise) in self.rise_k.iter_mut().enumerate() {
            let loss = now.winding_ohm[i] * now.last[i].current.mean_square;
            let target = settled * self.per_watt.map_or(1.0, |per_watt| loss * per_watt);
            *rise += (target - *rise) * now.step_s / self.tau_s;
            conditions.winding_rise_k[i] += *rise;
            conditions.wheels[i].motor.resistance_ohm *= 1.0 + COPPER_PER_K * *rise;
        }
    }
}
