//! What there is to say of an effect.

use model_core::effects::Cause;
use support::error;

use super::candidate::{Candidate, Way};
use super::detail::Detail;
use super::fields::{Fields, Read};
use super::physical::Conversion;
use super::plant::{Finding, PlantCause};
use super::regressor::Regressor;
use super::scope::Scope;
use super::sign::Sign;

/// An effect.
#[derive(Debug, Clone, Copy)]
pub struct Entry {
    /// Its name in JSON, files and docs.
    pub id: &'static str,
    /// Its physical meaning, one sentence.
    pub meaning: &'static str,
    /// Unit of its coefficient.
    pub unit: &'static str,
    /// The signs that its coefficient can have.
    pub sign: Sign,
    /// What a log has to have for it, beyond speeds and power.
    pub needs: &'static str,
    /// Whether it may concern single runs.
    pub single_runs: bool,
    /// Drives or columns in which it shows as no other does.
    pub shows_in: &'static str,
    /// The plant's cause in typical strengths, one a kind: benchmarks scale them.
    pub typical: &'static [&'static str],
    /// How its coefficient converts to the world's size, where that differs.
    pub(super) physical: fn(&Detail) -> Option<Conversion>,
    /// The ways in which it may show in some runs, or why these cannot show it.
    pub(super) candidates: fn(&Scope) -> Result<Vec<Way>, String>,
    /// Whether it is what estimator and board know as this.
    pub(super) owns: fn(&Cause<f64>) -> bool,
    /// What estimator and board make of an entry of a coefficients file, with the coefficient of
    /// each.
    pub(super) read: fn(&Fields<'_>) -> Read,
    /// The plant's cause, or why there is none.
    pub(super) cause: fn(&Finding<'_>) -> error::Result<Result<PlantCause, String>>,
}

impl Entry {
    /// A way in which it may show.
    pub fn candidate(
        &self,
        regressors: Vec<Regressor>,
        range: (f64, f64),
        detail: Detail,
        search: f64,
    ) -> Candidate {
        let (id, unit) = (self.id.to_owned(), self.unit.to_owned());
        Candidate { id, regressors, unit, range, least: Vec::new(), detail, search }
    }

    /// The ways in which it may show in some runs.
    ///
    /// # Errors
    /// Why they cannot show it.
    pub fn candidates(&self, scope: &Scope) -> Result<Vec<Candidate>, String> {
        let ways = (self.candidates)(scope)?;
        let of = |Way { regressors, range, detail, search, unit }: Way| {
            let unit = unit.unwrap_or(self.unit).to_owned();
            Candidate { unit, ..self.candidate(regressors, range, detail, search) }
        };
        Ok(ways.into_iter().map(of).collect())
    }
}
