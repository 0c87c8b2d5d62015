//! `cargo xtask bench kinds`: mass and energy on robots that are not ours, by kind of driving and
//! by sensors: host-tools/benches/kinds.

use crate::paths::target_folder;
use crate::robots::{keep, script, text_of};
use crate::steps::{Steps, Stop};

const SCRIPT: &str = "host-tools/benches/kinds/bench.py";
/// The table as it is committed.
const TABLE: &str = "docs/results/kinds.txt";
/// Of the committed table. Nothing was chosen by looking at them, but for friction that passes the
/// gear.
const SEEDS: [&str; 4] = ["--seed", "31", "--sets", "3"];

/// Prints the table and writes it.
pub(crate) fn run(steps: &mut Steps) -> Result<(), Stop> {
    let mut bench = script(steps, SCRIPT)?;
    bench.args(SEEDS).arg("--work").arg(target_folder().join("kinds"));
    steps.work("kinds", || keep(TABLE, &text_of(bench)?))
}
