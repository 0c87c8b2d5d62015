//! A gear that loses more than in proportion to its torque: a torque T², T being what passes it.

use model_core::effects::{Cause, Term};

use super::candidate::Way;
use super::entry::Entry;
use super::physical::Conversion;
use super::regressor::Regressor;
use super::sign::Sign;

pub(super) const GEAR_LOAD_LOSS: Entry = Entry {
    id: "gear-load-loss",
    meaning: "gears lose more than in proportion to their torque",
    unit: "1/(N·m)",
    sign: Sign::Positive,
    needs: "",
    single_runs: false,
    shows_in: "start and brake hard at low speed, fully loaded",
    typical: &["gear-load-loss=1"],
    physical: |_| Some(FALL),
    candidates: |scope| Ok(vec![Way::new(Regressor::Term(Term::GearLoad), (0.0, scope.much_per_torque()))]),
    owns: |cause| matches!(cause, Cause::Term(Term::GearLoad)),
    read: |fields| fields.term(Term::GearLoad),
    cause: |finding| finding.everywhere(),
};

/// Fall of the efficiency per torque at the wheel: the motor's torque is G t (1 + c t) for a wheel's t, G being the inertia gain, and the
/// model's k (G t)² is its second part.
const FALL: Conversion =
    Conversion { unit: "1/(N·m)", of: |coefficient, world| Some(coefficient * world.torque.inertia_gain) };
