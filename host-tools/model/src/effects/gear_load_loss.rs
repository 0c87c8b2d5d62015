//! A gear that loses more of what passes it: a share of the torque T, or T², a loss that grows
//! faster than the torque.

use model_core::effects::{Cause, Term};

use super::candidate::Way;
use super::detail::Detail;
use super::entry::Entry;
use super::fields::{Fields, Read};
use super::key;
use super::physical::Conversion;
use super::regressor::Regressor;
use super::scope::Scope;
use super::sign::Sign;

pub(super) const GEAR_LOAD_LOSS: Entry = Entry {
    id: "gear-load-loss",
    meaning: "gears lose more of the torque that passes them",
    unit: "1/(N·m)",
    sign: Sign::Positive,
    needs: "",
    single_runs: false,
    shows_in: "start and brake hard at low speed, fully loaded",
    typical: &["gear-load-loss=1"],
    physical: |detail| (*detail != Detail::InProportion).then_some(FALL),
    candidates,
    owns: |cause| matches!(cause, Cause::Term(Term::GearLoad | Term::GearShare)),
    read,
    cause: |finding| finding.everywhere(),
};

/// Fall of the efficiency per torque at the wheel: the motor's torque is G t (1 + c t) for a
/// wheel's t, G being the inertia gain, and the model's k (G t)² is its second part.
const FALL: Conversion =
    Conversion { unit: "1/(N·m)", of: |coefficient, world| Some(coefficient * world.torque.load_gain()) };

/// The greatest share more. Chosen: the motor supplies twice as much.
const MOST_SHARE: f64 = 1.0;

fn candidates(scope: &Scope) -> Result<Vec<Way>, String> {
    let growing = Way::new(Regressor::Term(Term::GearLoad), (0.0, scope.much_per_torque()));
    let share = Way::new(Regressor::Term(Term::GearShare), (0.0, MOST_SHARE));
    Ok(vec![growing.one_of_many(), share.in_unit("1").with(Detail::InProportion).one_of_many()])
}

fn read(fields: &Fields<'_>) -> Read {
    let in_proportion = fields.flag(key::IN_PROPORTION) == Some(true);
    fields.term(if in_proportion { Term::GearShare } else { Term::GearLoad })
}
