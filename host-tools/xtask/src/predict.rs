//! `cargo xtask bench predict`: energy of tasks that nobody has driven yet, by the scripts in
//! host-tools/benches/predict.

use crate::paths::target_folder;
use crate::robots::{DATA, keep, script, text_of};
use crate::steps::{Steps, Stop};

const SCRIPT: &str = "host-tools/benches/predict/bench.py";
/// The table as it is committed.
const TABLE: &str = "docs/results/predict.txt";

/// Prints the table and writes it.
pub(crate) fn run(steps: &mut Steps) -> Result<(), Stop> {
    let mut bench = script(steps, SCRIPT)?;
    bench.args(["--data", DATA, "--work"]).arg(target_folder().join("predict"));
    steps.work("predict", || keep(TABLE, &text_of(bench)?))
}
