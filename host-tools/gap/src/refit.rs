//! The base first: where its clean runs need a term that it lacks, a named effect would only
//! disguise that term.

use std::path::PathBuf;

use fit::form::{Judged, TERMS, Term};
use fit::lacking;
use fit::physical::FreeTerms;
use logs::robot::Robot;
use logs::robot::chassis::Chassis;
use support::context::Context;
use support::error::Result;

use super::report::Report;
use residuals::types::{Base, Verdict};

/// Terms that a fit of the clean logs would have and the base lacks. Judged only where something is
/// to be named or explained: it takes as long as a fit.
///
/// # Errors
/// A log that cannot be read.
pub fn asked_for(
    context: &Context,
    robot: &Robot,
    core: &Chassis,
    base: &Base,
    clean_logs: &[PathBuf],
    mass_kg: f64,
    report: &Report,
) -> Result<Vec<Judged>> {
    if report.verdict == Verdict::None || clean_logs.is_empty() {
        return Ok(Vec::new());
    }
    let form = FreeTerms::of(&base.torque);
    let has = |term: &Term| match term {
        Term::UnequalSides => form.unequal_sides,
        Term::GearLoss => form.gear_loss.is_some(),
        Term::BridgeDrop => form.bridge_drop,
        Term::Delay | Term::SlipMemory | Term::TrueSlip => false,
    };
    let terms: Vec<Term> = TERMS.into_iter().filter(|term| !has(term)).collect();
    lacking(context, robot, core, &base.torque, &terms, clean_logs, mass_kg)
}

impl Report {
    /// Withdraws the names if the base lacks terms.
    #[must_use]
    pub fn withheld(self, refit: Vec<Judged>) -> Self {
        let report = Self { refit, ..self };
        match report.refit[..] {
            [_, ..] if report.verdict.stands() => report.without_names(Verdict::Unexplained),
            _ => report,
        }
    }
}

/// What to do, in words: one a term.
pub fn words(refit: &[Judged]) -> Vec<String> {
    let one = |judged: &Judged| {
        let term = match judged.term {
            Term::Delay => "another delay of the power behind the speeds",
            Term::SlipMemory => "the slip memory of turns",
            Term::UnequalSides => "sides that differ",
            Term::GearLoss => "a gear's loss by what passes it",
            Term::BridgeDrop => "a bridge's drop",
            Term::TrueSlip => "true slip by the gyro",
        };
        format!(
            "refit with gmr fit before anything is named: {term} takes away {:.0} % of the error on unseen blocks of the clean runs, and these \
             coefficients lack it",
            100.0 * judged.gain
        )
    };
    refit.iter().map(one).collect()
}
