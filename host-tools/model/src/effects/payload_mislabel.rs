//! A mass that was noted wrongly.

use support::error;

use super::candidate::Way;
use super::detail::{Detail, Runs};
use super::entry::Entry;
use super::plant::{Finding, GREATEST_LOSS, PlantCause};
use super::regressor::Regressor;
use super::scope::Scope;
use super::sign::Sign;

/// See the file's head.
pub const PAYLOAD_MISLABEL: Entry = Entry {
    id: "payload-mislabel",
    meaning: "the mass noted for a run is wrong",
    unit: "kg",
    sign: Sign::Either,
    needs: "2 runs",
    single_runs: true,
    shows_in: "weigh the payload of each run",
    typical: &["payload-mislabel=0.7"],
    physical: |_| None,
    candidates,
    owns: |_| false,
    read: |_| {
        let why = "payload-mislabel is a finding about runs, not about a robot: coefficients hold none";
        Err(("id", why.to_owned()))
    },
    cause,
};

/// In all runs at once; in single ones it is looked for run by run.
fn candidates(scope: &Scope) -> Result<Vec<Way>, String> {
    let all = Detail::InRuns { runs: Runs::All, at_s: None };
    Ok(vec![Way::new(Regressor::Masses, (-scope.lightest, scope.much_mass())).with(all)])
}

/// No robot loses all of its mass.
fn cause(finding: &Finding<'_>) -> error::Result<Result<PlantCause, String>> {
    finding.everywhere_within(|low, high| (low.max(-GREATEST_LOSS * finding.scene.lightest_kg), high))
}
