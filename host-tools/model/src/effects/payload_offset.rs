//! A load off centre: the wheels of one side carry more of it.

use model_core::effects::{Cause, Term};
use support::error;

use super::candidate::Way;
use super::detail::Detail;
use super::entry::Entry;
use super::fields::{Fields, Read};
use super::key;
use super::physical::Conversion;
use super::plant::{Finding, PlantCause};
use super::regressor::Regressor;
use super::scope::Scope;
use super::sign::Sign;

pub(super) const PAYLOAD_OFFSET: Entry = Entry {
    id: "payload-offset",
    meaning: "the load is off centre: one side carries more",
    unit: "N·m/kg",
    sign: Sign::Either,
    needs: "",
    single_runs: false,
    shows_in: "put the load on the other side",
    typical: &["payload-offset=0.03"],
    physical: |detail| (*detail == Detail::Plain).then_some(TO_THE_RIGHT),
    candidates,
    owns: |cause| matches!(cause, Cause::Term(Term::Offset | Term::OffCentre(_))),
    read,
    cause,
};

/// How far the centre of the total mass lies to the right, m: rolling resistance is in proportion
/// to the weight on a wheel, which the offset over half the track changes by that share of itself.
const TO_THE_RIGHT: Conversion = Conversion {
    unit: "m",
    of: |coefficient, world| {
        let half_track = world.forward? / world.turn;
        Some(coefficient / world.torque.supplied_rolling() * half_track).filter(|offset| offset.is_finite())
    },
};

fn candidates(scope: &Scope) -> Result<Vec<Way>, String> {
    if !scope.has_sides() {
        return Err("needs wheels on two sides".to_owned());
    }
    let range = (-scope.much_per_kg(), scope.much_per_kg());
    let unlike = Way::new(Regressor::Term(Term::Offset), range);
    let mut ways = vec![unlike];
    if scope.base.scrub > 0.0 {
        // At worst nothing of the scrub is left.
        let off_centre =
            Way::new(Regressor::Term(Term::OffCentre(scope.empty)), (-scope.base.supplied_scrub(), 0.0));
        ways.push(off_centre.with(Detail::OffCentre { empty_kg: scope.empty }));
    }
    Ok(ways)
}

fn read(fields: &Fields<'_>) -> Read {
    if fields.has(key::EMPTY) {
        fields.term(Term::OffCentre(fields.number(key::EMPTY)?))
    } else {
        fields.term(Term::Offset)
    }
}

/// Shares of the plant's range that a cause may fill: loads on the edge would lift a wheel.
const LEVER: f64 = 0.6;

fn cause(finding: &Finding<'_>) -> error::Result<Result<PlantCause, String>> {
    finding.everywhere_within(|low, high| (LEVER * low, LEVER * high))
}
