//! `cargo xtask test-fleet`: sums on engines of many machines, Spark and Ray, as processes of their
//! own on this one, and logs in a bucket. Minutes, and no part of `cargo xtask test`.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::fleet;
use crate::paths::{root, target_folder};
use crate::python;
use crate::set_up::{self, Consent};
use crate::steps::{Steps, Stop, carried_out, command};

/// The tests, and what they run with.
const ENGINES: &str = "host-tools/python/engines";

/// True when everything passed. With `rows`, how fast the engines sum so many is measured behind
/// that, beside `gmr fleet`.
pub(crate) fn run(consent: Consent, rows: Option<usize>) -> bool {
    carried_out(|steps| {
        let python = engines(steps, consent)?;
        steps.run("engines", tests(&python))?;
        rows.map_or(Ok(()), fleet::run_engines)
    })
}

/// A Python with the engines and the wheel, and gmr beside it.
///
/// # Errors
/// What cannot be had or built.
pub(crate) fn engines(steps: &mut Steps, consent: Consent) -> Result<PathBuf, Stop> {
    let mut python = None;
    steps.work("set-up", || {
        set_up::java(consent)?;
        python = Some(python::engines()?);
        Ok(())
    })?;
    let python = python.ok_or_else(|| Stop::new("no Python"))?;
    steps.run(
        "gmr",
        command("cargo build --quiet --release --package host-tools --features bucket --bin gmr"),
    )?;
    steps.work("wheel", || {
        let wheel = python::build()?;
        set_up::obtain(python::pip(&python).args(["--force-reinstall", "--no-deps"]).arg(wheel))
    })?;
    Ok(python)
}

fn tests(python: &Path) -> Command {
    let mut tests = Command::new(python);
    tests.args(["-m", "pytest", "-q", "-s", "-p", "no:cacheprovider", "--rootdir", ENGINES, ENGINES]);
    tests.env("GMR", target_folder().join("release/gmr"));
    tests.env("FLEET", target_folder().join("test-fleet"));
    tests.env("PYTHONDONTWRITEBYTECODE", "1");
    tests.current_dir(root());
    tests
}
