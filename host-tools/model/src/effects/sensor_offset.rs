//! A power sensor that reads a constant off.

use model_core::effects::{Cause, Term};

use super::candidate::Way;
use super::entry::Entry;
use super::regressor::Regressor;
use super::sign::Sign;

pub(super) const SENSOR_OFFSET: Entry = Entry {
    id: "sensor-offset",
    meaning: "the power sensor reads a constant off",
    unit: "W",
    sign: Sign::Either,
    needs: "",
    single_runs: false,
    shows_in: "rest for 10 s with the drives off",
    typical: &["sensor-offset=0.05"],
    physical: |_| None,
    candidates: |_| Ok(vec![Way::new(Regressor::Term(Term::Constant), (f64::NEG_INFINITY, f64::INFINITY))]),
    owns: |cause| matches!(cause, Cause::Term(Term::Constant)),
    read: |fields| fields.term(Term::Constant),
    cause: |finding| finding.everywhere(),
};
