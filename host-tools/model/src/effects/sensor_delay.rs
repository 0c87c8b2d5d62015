//! Power and speed that are not of the same time.

use model_core::effects::Cause;

use super::candidate::Way;
use super::entry::Entry;
use super::regressor::Regressor;
use super::sign::Sign;

pub(super) const SENSOR_DELAY: Entry = Entry {
    id: "sensor-delay",
    meaning: "power and speed are shifted in time",
    unit: "s",
    sign: Sign::Either,
    needs: "",
    single_runs: false,
    shows_in: "start and stop sharply, ten times",
    typical: &["sensor-delay=0.1"],
    physical: |_| None,
    candidates: |_| Ok(vec![Way::new(Regressor::Delay, RANGE_S)]),
    owns: |cause| matches!(cause, Cause::Delay),
    read: |fields| fields.one(Cause::Delay),
    cause: |finding| finding.everywhere(),
};

/// Longer delays are no sensor's.
const RANGE_S: (f64, f64) = (-1.0, 1.0);
