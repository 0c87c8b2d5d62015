//! Static power that follows the processor's load.

use model_core::effects::{Cause, Term};

use super::candidate::Way;
use super::column::PROCESSOR;
use super::entry::Entry;
use super::regressor::Regressor;
use super::scope::Scope;
use super::sign::Sign;

pub(super) const COMPUTE_LOAD: Entry = Entry {
    id: "compute-load",
    meaning: "the static power follows the processor's load",
    unit: "W/%",
    sign: Sign::Positive,
    needs: PROCESSOR,
    single_runs: false,
    shows_in: "log cpu_percent, and load the processor at rest",
    typical: &["compute-load=0.2"],
    physical: |_| None,
    candidates,
    owns: |cause| matches!(cause, Cause::Term(Term::Driver)),
    read: |fields| fields.term(Term::Driver),
    cause: |_| Ok(Err("the plant's computer has a load of its own".to_owned())),
};

fn candidates(scope: &Scope) -> Result<Vec<Way>, String> {
    match scope.column(PROCESSOR) {
        Some(column) => Ok(vec![Way::new(Regressor::Column(column.place), (0.0, f64::INFINITY))]),
        None => Err(format!("needs {PROCESSOR}")),
    }
}
