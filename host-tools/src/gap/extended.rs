//! The coefficients with the effects that were named, written for estimator and board.

use std::path::Path;

use crate::effects::written::Written;
use crate::fit::file;
use crate::gap::report::Report;

/// Writes the coefficients with the effects that were named, and the base as it moved. What is not written is said in a line each on
/// standard error; where nothing is left, so is the file.
///
/// # Errors
/// The file cannot be written; the effects are more than a board holds.
pub fn write(report: &Report, base: &Path, out: &Path) -> crate::error::Result<()> {
    let mut effects = Vec::new();
    for named in &report.effects {
        match Written::of(&named.candidate, &named.coefficients, &named.std_errs) {
            Ok(effect) => effects.push(effect),
            Err(why) => eprintln!("gmr: {why}"),
        }
    }
    if effects.is_empty() {
        eprintln!("gmr: {}: not written: no effect is to be added", out.display());
        return Ok(());
    }
    if !report.ambiguous_with.is_empty() {
        eprintln!(
            "gmr: {}: its effects cannot be told from {}: power is predicted as well with either, the cause is open",
            out.display(),
            report.ambiguous_with.join(", ")
        );
    }
    file::extend(base, &report.state.torque, &effects, out)
}

#[cfg(test)]
mod tests {
    use model_core::effects::{Cause, Term};
    use model_core::estimator::Sample;
    use model_core::torque::TorqueModel;

    use crate::effects::written::{Written, columns, id_of};
    use crate::effects::{ENTRIES, PITCH, PROCESSOR, Regressor};
    use crate::gap::dictionary::candidates;
    use crate::gap::runs::{RawRun, Runs};
    use crate::robot::Robot;

    /// What the file's words mean is what the workflow fitted, for every candidate of the dictionary.
    #[test]
    fn every_candidate_is_written_as_what_it_was_fitted_as() {
        let runs = with_columns(&[PROCESSOR]);
        let warm = with_columns(&[PITCH, "motor1_temp_c", "motor2_temp_c"]);
        let base = TorqueModel::from_array([0.03, 0.01, 0.01, 0.003, 1.3, 3.0, 0.0]);
        let mut seen = Vec::new();
        for (runs, place) in [(&runs, 0), (&warm, 1)] {
            let (list, _) = candidates(runs, &base, false);
            for candidate in list {
                let coefficients = vec![0.001; candidate.regressors.len()];
                let expected: Vec<Option<Cause<f64>>> = candidate.regressors.iter().map(in_core).collect();
                let Ok(written) = Written::of(&candidate, &coefficients, &coefficients) else {
                    assert_eq!(candidate.id, "payload-mislabel", "{place}");
                    continue;
                };
                let text = toml::to_string(&written).unwrap();
                let read: Written = toml::from_str(&text).unwrap();
                assert_eq!(read, written, "{text}");
                let columns = columns(&[read], 2).unwrap();
                let found: Vec<Option<Cause<f64>>> =
                    columns.iter().map(|column| Some(column.cause)).collect();
                assert_eq!(found, expected, "{text}");
                for column in columns.iter() {
                    assert_eq!(id_of(&column.cause).0, written.id);
                }
                seen.push(written.id);
            }
        }
        // What only appears at times that were found: scan.rs.
        for entry in
            ENTRIES.iter().filter(|entry| !["payload-mislabel", "surface-switch"].contains(&entry.id))
        {
            assert!(seen.iter().any(|id| id == entry.id), "{}", entry.id);
        }
    }

    /// A run of 20 s with further columns.
    fn with_columns(columns: &[&str]) -> Runs<2> {
        let core = Robot::load("burger").unwrap().core::<2>(2.0).unwrap();
        let row = |i: usize| {
            let speed = 3.0 + (0.05 * i as f64).sin();
            let sample = Sample { wheel_speed: [speed, 2.0], wheel_acceleration: None, power: 1.0 };
            (0.05 * i as f64, sample, 2.0, vec![20.0; columns.len()])
        };
        let raw = RawRun {
            name: "run".to_owned(),
            rows: (0..400).map(row).collect(),
            columns: columns.iter().map(|name| (*name).to_owned()).collect(),
            period_s: 0.05,
        };
        Runs::condition(&core, vec![raw]).unwrap()
    }

    /// By the regressors themselves, not by the words about them.
    fn in_core(regressor: &Regressor) -> Option<Cause<f64>> {
        Some(match regressor {
            // A board is not ahead of its time.
            Regressor::Term(Term::WithMotion(hold)) => Cause::Term(Term::WithMotion(hold.max(0.0))),
            Regressor::Term(term) => Cause::Term(*term),
            Regressor::Heat(time) => Cause::Heat(*time),
            Regressor::Hot => Cause::Hot,
            Regressor::Temperature(_, cold) => Cause::Temperature(*cold),
            Regressor::Delay => Cause::Delay,
            Regressor::Scale(side) => Cause::Scale(crate::gap::twin::side_of(*side)),
            Regressor::Column(_) => Cause::Term(Term::Driver),
            _ => return None,
        })
    }
}
