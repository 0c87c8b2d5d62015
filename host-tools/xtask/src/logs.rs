//! `cargo xtask bench logs`: a gigabyte of the same drive in every format, fitted, by the scripts
//! in host-tools/benches/logs.

use std::process::Command;

use crate::paths::target_folder;
use crate::python;
use crate::robots::{keep, text_of};
use crate::steps::{Steps, Stop, command};

/// The table as it is committed.
const TABLE: &str = "docs/results/logs-bench.txt";

/// Prints the table and writes it.
pub(crate) fn run(steps: &mut Steps) -> Result<(), Stop> {
    let mut python = None;
    steps.work("set-up", || {
        python = Some(python::logs()?);
        Ok(())
    })?;
    let python = python.ok_or_else(|| Stop::new("no Python"))?;
    steps.run("gmr", command("cargo build --quiet --release --package host-tools --bin gmr"))?;
    let mut bench = Command::new(python);
    bench.arg("host-tools/benches/logs/bench.py").arg("--gmr").arg(target_folder().join("release/gmr"));
    bench.arg("--work").arg(target_folder().join("bench-logs"));
    steps.work("logs", || keep(TABLE, &text_of(bench)?))
}
