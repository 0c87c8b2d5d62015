//! `cargo xtask bench predict`: energy of tasks that nobody has driven yet, by the scripts in host-tools/benches/predict.

use std::process::Command;

use crate::paths::{root, target_folder};
use crate::robots::{DATA, python, text_of};
use crate::steps::{Steps, Stop, command};

const SCRIPT: &str = "host-tools/benches/predict/bench.py";
/// The table as it is committed.
const TABLE: &str = "docs/predict.txt";

/// Prints the table and writes it.
pub(crate) fn run(steps: &mut Steps) -> Result<(), Stop> {
    let python = python()?;
    steps.run("gmr", command("cargo build --quiet --release --package host-tools --bin gmr"))?;
    steps.work("predict", || {
        let mut bench = Command::new(python);
        bench.arg(SCRIPT).arg("--gmr").arg(target_folder().join("release/gmr"));
        bench.args(["--data", DATA, "--work"]).arg(target_folder().join("predict"));
        let text = text_of(bench)?;
        print!("{text}");
        std::fs::write(root().join(TABLE), text).map_err(|error| Stop::new(format!("{TABLE}: {error}")))
    })
}
