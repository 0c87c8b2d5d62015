//! Drives that feed braking power back, which the fit knew nothing of.

use model_core::effects::{Cause, Term};

use super::candidate::Way;
use super::entry::Entry;
use super::regressor::Regressor;
use super::scope::Scope;
use super::sign::Sign;

pub(super) const REGENERATION: Entry = Entry {
    id: "regeneration",
    meaning: "braking energy returns to the supply",
    unit: "1",
    sign: Sign::Positive,
    needs: "",
    single_runs: false,
    shows_in: "brake hard from top speed, fully loaded",
    typical: &["regeneration=0.5"],
    physical: |_| None,
    candidates,
    owns: |cause| matches!(cause, Cause::Term(Term::Return)),
    read: |fields| fields.term(Term::Return),
    cause: |finding| finding.everywhere(),
};

fn candidates(scope: &Scope) -> Result<Vec<Way>, String> {
    if scope.regenerative {
        return Err("the robot's file says that the drives feed back already".to_owned());
    }
    Ok(vec![Way::new(Regressor::Term(Term::Return), (0.0, 1.0))])
}
