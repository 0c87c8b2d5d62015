//! Another floor from a time on.

use model_core::effects::{Cause, Term};

use super::entry::Entry;
use super::key;
use super::rolling_resistance_change::{FLOOR, change};
use super::sign::Sign;

/// See the file's head.
pub const SURFACE_SWITCH: Entry = Entry {
    id: "surface-switch",
    meaning: "the floor changes within a run",
    unit: "N·m/kg",
    sign: Sign::Either,
    needs: "",
    single_runs: true,
    shows_in: "keep each floor to runs of its own",
    typical: &["surface-switch=0.01"],
    physical: |_| Some(FLOOR),
    // Its times are looked for run by run.
    candidates: |_| Ok(Vec::new()),
    owns: |cause| matches!(cause, Cause::Term(Term::RollingFrom(_))),
    read: |fields| fields.term(Term::RollingFrom(fields.number(key::AT)?)),
    cause: change,
};
