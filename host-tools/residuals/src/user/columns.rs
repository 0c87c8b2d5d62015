//! Formulas as further columns of the runs, and as candidates.

use std::path::Path;

use logs::runs::Runs;
use model::effects::{Candidate, Detail, NotTestable, Regressor};
use support::error::{Error, Result};

use super::{Signals, UserEffect};

/// What the runs can show of a user's effects.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct UserCandidates {
    /// To be tried.
    pub candidates: Vec<Candidate>,
    /// Effects whose columns the runs lack.
    pub not_testable: Vec<NotTestable>,
}

impl UserEffect {
    /// Name of its formula's column.
    fn column(&self) -> String {
        format!("formula of {}", self.id)
    }

    fn candidate(&self, place: usize) -> Candidate {
        let detail = Detail::Formula {
            formula: self.formula.text().to_owned(),
            meaning: self.meaning.clone(),
            sign: self.sign,
            range: self.range,
        };
        Candidate {
            id: self.id.clone(),
            regressors: vec![Regressor::Column(place)],
            unit: self.unit.clone(),
            range: self.range,
            least: Vec::new(),
            detail,
            search: 0.0,
        }
    }
}

impl UserCandidates {
    /// Adds the formulas' values to field runs and clean runs. Clean runs that lack a formula's
    /// columns do without it: it is then new in the field altogether.
    ///
    /// # Errors
    /// A formula has no finite value in some row of a run, with the time.
    pub fn add(
        effects: &[UserEffect],
        file: &Path,
        field: &mut Runs,
        clean: Option<&mut Runs>,
    ) -> Result<Self> {
        let mut outcome = Self::default();
        let mut clean = clean;
        for effect in effects {
            match add_column(effect, file, field)? {
                Ok(place) => outcome.candidates.push(effect.candidate(place)),
                Err(missing) => {
                    let missing: Vec<String> = missing.iter().map(|name| lacking(name, field)).collect();
                    let reason = format!("needs {}", missing.join(", "));
                    outcome.not_testable.push(NotTestable { id: effect.id.clone(), reason });
                    continue;
                }
            }
            if let Some(clean) = &mut clean {
                let _lacks = add_column(effect, file, clean)?;
            }
        }
        Ok(outcome)
    }
}

/// The place of the formula's new column, or the columns that some run lacks.
fn add_column(
    effect: &UserEffect,
    file: &Path,
    runs: &mut Runs,
) -> Result<std::result::Result<usize, Vec<String>>> {
    let known = Signals::known(runs.robot.wheels());
    let mut signals = Vec::new();
    let mut missing = Vec::new();
    for name in effect.formula.variables() {
        let built_in = known.iter().find(|(known, _)| known == name).map(|(_, signal)| *signal);
        match built_in.or_else(|| runs.column(name).map(Signals::Column)) {
            Some(signal) => signals.push(signal),
            None => missing.push(name.clone()),
        }
    }
    if !missing.is_empty() {
        return Ok(Err(missing));
    }
    let mut columns = Vec::new();
    let mut values = vec![0.0; signals.len()];
    for run in &runs.runs {
        let mut column = Vec::with_capacity(run.rows.len());
        for (index, row) in run.rows.iter().enumerate() {
            for (value, signal) in values.iter_mut().zip(&signals) {
                *value = signal.value(run, index, row);
            }
            let result = effect.formula.value(&values);
            if !result.is_finite() {
                let message = format!(
                    "the formula of {} is {result} at {:.2} s of {}; expected a finite value in every row",
                    effect.id, row.time, run.name
                );
                return Err(Error::failed(message).in_file(file).at_line(effect.line));
            }
            column.push(result);
        }
        columns.push(column);
    }
    runs.columns.push(effect.column());
    for (run, column) in runs.runs.iter_mut().zip(columns) {
        run.extras.push(column.into());
    }
    Ok(Ok(runs.columns.len() - 1))
}

/// A column that is missing, with a run that lacks it where others have it.
fn lacking(name: &str, runs: &Runs) -> String {
    let place = runs.columns.iter().position(|column| column == name);
    match place.and_then(|place| runs.runs.iter().find(|run| run.extra(place).is_empty())) {
        Some(run) => format!("{name}, which {} lacks", run.name),
        None => name.to_owned(),
    }
}
