//! Air or a fan at the rotor: a torque w |w|.

use model_core::effects::{Cause, Term};

use super::candidate::Way;
use super::entry::Entry;
use super::regressor::Regressor;
use super::sign::Sign;

pub(super) const WINDAGE: Entry = Entry {
    id: "windage",
    meaning: "air or a fan brakes with the square of the speed",
    unit: "N·m·s²/rad²",
    sign: Sign::Positive,
    needs: "",
    single_runs: false,
    shows_in: "hold the top speed and half of it for a while each",
    typical: &["windage=0.0005"],
    physical: |_| None,
    candidates: |scope| {
        Ok(vec![Way::new(Regressor::Term(Term::Windage), (0.0, scope.much() / scope.speed.powi(2)))])
    },
    owns: |cause| matches!(cause, Cause::Term(Term::Windage)),
    read: |fields| fields.term(Term::Windage),
    cause: |finding| finding.everywhere(),
};
