//! `gmr record --foxglove`: clients that are not ours see the very messages of the log
//! (`tests/live/client.py`). The feature is off by default, so this is part of `cargo xtask
//! test-live` only.

use std::path::Path;
use std::process::Command;

use crate::common::Bench;
use crate::common::board::TestBoard;
use crate::common::board::terminal::Terminal;
use crate::common::skipped::skipped;

#[test]
fn clients_that_are_not_ours_see_the_log() {
    let gmr = Path::new(env!("CARGO_BIN_EXE_gmr"));
    let python = gmr.ancestors().nth(2).unwrap().join("live-python/venv/bin/python");
    if !python.exists() {
        return skipped("no virtual environment in target/live-python: cargo xtask test-live makes it");
    }
    let (bench, terminal) = (Bench::new(), Terminal::new(TestBoard::new()));
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/live/client.py");
    let output = Command::new(python)
        .arg(script)
        .arg(gmr)
        .arg(terminal.name())
        .arg(bench.path(""))
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
    println!("{said}");
    assert!(output.status.success(), "{}\n{said}", output.status);
}
