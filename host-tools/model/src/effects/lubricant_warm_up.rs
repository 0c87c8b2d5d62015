//! Grease that is thick at first and thins as the gears warm: viscous torque that fades.

use model_core::effects::{Cause, Term};
use support::error;

use super::candidate::Way;
use super::detail::Detail;
use super::entry::Entry;
use super::key;
use super::plant::{Finding, PlantCause};
use super::regressor::Regressor;
use super::scope::Scope;
use super::sign::Sign;

pub(super) const LUBRICANT_WARM_UP: Entry = Entry {
    id: "lubricant-warm-up",
    meaning: "viscous friction falls as the gears warm",
    unit: "N·m·s/rad",
    sign: Sign::Positive,
    needs: "",
    single_runs: false,
    shows_in: "drive ten minutes from cold at one speed",
    typical: &["lubricant-warm-up=0.5:tau=30"],
    physical: |_| None,
    candidates,
    owns: |cause| matches!(cause, Cause::Term(Term::WarmUp(_))),
    read: |fields| fields.term(Term::WarmUp(fields.number(key::TIME_CONSTANT)?)),
    cause,
};

/// Time constants that are tried, as shares of the longest run; the best is searched between them.
const TIMES: [f64; 3] = [0.25, 0.75, 2.0];

fn candidates(scope: &Scope) -> Result<Vec<Way>, String> {
    let way = |share: f64| {
        let time_s = share * scope.duration;
        let regressor = Regressor::Term(Term::WarmUp(time_s));
        let range = (0.0, scope.much_per_speed());
        Way::new(regressor, range).with(Detail::TimeConstant { time_s }).one_of_many()
    };
    Ok(TIMES.map(way).into())
}

fn cause(finding: &Finding<'_>) -> error::Result<Result<PlantCause, String>> {
    finding.acting(|effect| match finding.candidate.detail {
        Detail::TimeConstant { time_s } => effect.with("tau", time_s.clamp(1.0, 3600.0)),
        _ => Ok(effect),
    })
}
