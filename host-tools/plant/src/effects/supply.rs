//! Battery, leads, drives.

use super::cause::{Cause, Listed, Onset, onset};
use super::conditions::{Conditions, Now};
use super::entry::Entry;
use super::options::AT;

pub(super) const SAG: Listed = Listed {
    entry: Entry {
        id: "supply-sag",
        meaning: "Leads and connectors between power sensor and drives have a resistance: the drives' voltage sags with \
              the current, and the sensor sees the loss.",
        unit: "resistance, Ω",
        range: (0.0, 2.0),
        options: &[AT],
    },
    build: |effect, _| Ok(Box::new(Sag { resistance: onset(effect) })),
};

#[derive(Debug, Clone)]
struct Sag {
    resistance: Onset,
}

impl Cause for Sag {
    fn act(&mut self, now: &Now, conditions: &mut Conditions) {
        conditions.lead_ohm += self.resistance.at(now.time_s);
    }
}

pub(super) const REGENERATION: Listed = Listed {
    entry: Entry {
        id: "regeneration",
        meaning: "The drives return braking energy to the supply, which the fit knew nothing of.",
        unit: "returned share of the motors' braking power",
        range: (0.0, 1.0),
        options: &[AT],
    },
    build: |effect, setting| {
        if setting.scenario.drive.regeneration {
            return Err(
                effect.refuse("the drives return all of it already; allowed: drives without regeneration")
            );
        }
        Ok(Box::new(Regeneration { share: onset(effect) }))
    },
};

#[derive(Debug, Clone)]
struct Regeneration {
    share: Onset,
}

impl Cause for Regeneration {
    fn act(&mut self, now: &Now, conditions: &mut Conditions) {
        conditions.returned += self.share.at(now.time_s);
    }
}
