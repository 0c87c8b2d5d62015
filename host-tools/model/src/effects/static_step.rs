//! Static power that changes its state: with motion, from a time on, or at times of its own.

use model_core::effects::{Cause, Term};
use support::error;

use super::candidate::Way;
use super::detail::{Detail, FROM_MOTION, MOTION};
use super::entry::Entry;
use super::fields::{Fields, Read};
use super::key;
use super::plant::{Finding, PlantCause};
use super::regressor::Regressor;
use super::scope::Scope;
use super::sign::Sign;

/// See the file's head.
pub const STATIC_STEP: Entry = Entry {
    id: "static-step",
    meaning: "the static power changes its state",
    unit: "W",
    sign: Sign::Either,
    needs: "",
    single_runs: true,
    shows_in: "rest for 10 s before, within and after the drive",
    typical: &["static-step=0.1", "static-step=0.1:on=motion"],
    physical: |_| None,
    candidates,
    owns: |cause| matches!(cause, Cause::Term(Term::StepAt(_) | Term::WithMotion(_))),
    read,
    cause,
};

/// How long it stays on after motion, s. With the command the power goes before the wheel stands: a
/// negative hold.
const HOLDS_S: [f64; 5] = [-0.3, 0.0, 1.0, 4.0, f64::INFINITY];

/// With motion; times of its own are looked for run by run.
fn candidates(_: &Scope) -> Result<Vec<Way>, String> {
    let way = |hold_s: f64| {
        let detail = if hold_s.is_finite() { Detail::WithMotion { hold_s } } else { Detail::FromFirstMotion };
        let any = (f64::NEG_INFINITY, f64::INFINITY);
        Way::new(Regressor::Term(Term::WithMotion(hold_s)), any).with(detail).one_of_many()
    };
    Ok(HOLDS_S.map(way).into())
}

fn read(fields: &Fields<'_>) -> Read {
    if fields.text(key::FROM) == Some(FROM_MOTION) {
        return fields.term(Term::WithMotion(f64::INFINITY));
    }
    if fields.text(key::WITH) == Some(MOTION) {
        return fields.term(Term::WithMotion(fields.number(key::HOLD)?));
    }
    fields.term(Term::StepAt(fields.number(key::AT)?))
}

/// The plant's longest hold, s.
const MOST_HOLD_S: f64 = 3600.0;

fn cause(finding: &Finding<'_>) -> error::Result<Result<PlantCause, String>> {
    let hold = match finding.candidate.detail {
        Detail::WithMotion { hold_s } => hold_s,
        Detail::FromFirstMotion => f64::INFINITY,
        _ => return finding.everywhere(),
    };
    finding.acting(|effect| effect.with("on", 1.0)?.with("hold", hold.min(MOST_HOLD_S)))
}
