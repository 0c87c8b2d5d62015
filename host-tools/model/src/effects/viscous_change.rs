//! Thicker or thinner grease: a torque in proportion to the speed, beyond the fitted one.

use model_core::effects::{Cause, Term};

use super::candidate::Way;
use super::entry::Entry;
use super::regressor::Regressor;
use super::sign::Sign;

pub(super) const VISCOUS_CHANGE: Entry = Entry {
    id: "viscous-change",
    meaning: "the grease is thicker or thinner than in the fit",
    unit: "N·m·s/rad",
    sign: Sign::Either,
    needs: "",
    single_runs: false,
    shows_in: "hold several speeds with the gears warm",
    typical: &["viscous-change=0.5"],
    physical: |_| None,
    candidates: |scope| {
        Ok(vec![Way::new(
            Regressor::Term(Term::Viscous),
            (-scope.base.supplied_viscous(), scope.much_per_speed()),
        )])
    },
    owns: |cause| matches!(cause, Cause::Term(Term::Viscous)),
    read: |fields| fields.term(Term::Viscous),
    cause: |finding| finding.everywhere(),
};
