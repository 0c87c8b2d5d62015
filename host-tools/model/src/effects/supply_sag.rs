//! Resistance of battery and leads: a loss with the square of the power.

use model_core::effects::{Cause, Term};

use super::candidate::Way;
use super::entry::Entry;
use super::regressor::Regressor;
use super::scope::Scope;
use super::sign::Sign;

pub(super) const SUPPLY_SAG: Entry = Entry {
    id: "supply-sag",
    meaning: "battery and leads have a resistance",
    unit: "1/W",
    sign: Sign::Positive,
    needs: "",
    single_runs: false,
    shows_in: "log bus_v, or draw much power at high speed with little torque",
    typical: &["supply-sag=1"],
    physical: |_| None,
    candidates,
    owns: |cause| matches!(cause, Cause::Term(Term::Sag(_))),
    read: |fields| fields.term(Term::Sag(fields.static_power())),
    cause: |finding| finding.everywhere(),
};

/// Twice the usual power is lost at most, as a share of it.
const MOST: f64 = 2.0;

fn candidates(scope: &Scope) -> Result<Vec<Way>, String> {
    let way = |with: f64| {
        let most = MOST / (scope.power + with).max(1e-9);
        Way::new(Regressor::Term(Term::Sag(with)), (0.0, most))
    };
    Ok(Way::with_static_power(scope, way))
}
