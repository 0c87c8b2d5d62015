//! Dry friction that peaks near standstill: a torque exp(−(w / width)²) along the motion.

use model_core::effects::{Cause, Term};
use support::error;

use super::candidate::Way;
use super::detail::Detail;
use super::entry::Entry;
use super::key;
use super::physical::Conversion;
use super::plant::{Finding, PlantCause};
use super::regressor::Regressor;
use super::scope::Scope;
use super::sign::Sign;

pub(super) const STRIBECK: Entry = Entry {
    id: "stribeck",
    meaning: "friction is greater near standstill",
    unit: "N·m",
    sign: Sign::Positive,
    needs: "",
    single_runs: false,
    shows_in: "creep, stop and start often, then cruise",
    typical: &["stribeck=0.05"],
    physical: |_| Some(Conversion::of_torque("N·m")),
    candidates,
    owns: |cause| matches!(cause, Cause::Term(Term::Stribeck(_))),
    read: |fields| fields.term(Term::Stribeck(fields.number(key::SPEED)?)),
    cause,
};

/// Widths that are tried, as shares of the usual top speed; the best is searched between them.
const WIDTHS: [f64; 4] = [0.05, 0.1, 0.2, 0.35];

fn candidates(scope: &Scope) -> Result<Vec<Way>, String> {
    let way = |share: f64| {
        let speed_rad_s = share * scope.speed;
        let regressor = Regressor::Term(Term::Stribeck(speed_rad_s));
        Way::new(regressor, (0.0, scope.much())).with(Detail::Width { speed_rad_s }).one_of_many()
    };
    Ok(WIDTHS.map(way).into())
}

fn cause(finding: &Finding<'_>) -> error::Result<Result<PlantCause, String>> {
    finding.acting(|effect| match finding.candidate.detail {
        Detail::Width { speed_rad_s } => effect.with("width", speed_rad_s.clamp(0.05, 20.0)),
        _ => Ok(effect),
    })
}
