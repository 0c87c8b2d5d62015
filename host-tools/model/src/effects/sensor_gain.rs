//! A power sensor that reads a factor off.

use model_core::effects::{Cause, Term};

use super::candidate::Way;
use super::entry::Entry;
use super::regressor::Regressor;
use super::sign::Sign;

pub(super) const SENSOR_GAIN: Entry = Entry {
    id: "sensor-gain",
    meaning: "the power sensor reads a factor off",
    unit: "1",
    sign: Sign::Either,
    needs: "",
    single_runs: false,
    shows_in: "hold the sensor against a reference load",
    typical: &["sensor-gain=0.05"],
    physical: |_| None,
    candidates: |scope| {
        Ok(Way::with_static_power(scope, |with| Way::new(Regressor::Term(Term::Gain(with)), RANGE)))
    },
    owns: |cause| matches!(cause, Cause::Term(Term::Gain(_))),
    read: |fields| fields.term(Term::Gain(fields.static_power())),
    cause: |finding| finding.everywhere(),
};

/// From a tenth to five times the power.
const RANGE: (f64, f64) = (-0.9, 4.0);
