//! The Python package: what its tests need, and its wheel.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::paths;
use crate::set_up::obtain;
use crate::steps::{Stop, command};

/// Packages with their versions.
const REQUIREMENTS: &str = "host-tools/python/requirements.txt";

/// Packages of the engines, and of what the bench `fleet` compares with.
const ENGINES: &str = "host-tools/python/engines/requirements.txt";

/// What the DDS peer needs.
const PEER: &str = "host-tools/tests/node/requirements.txt";

/// What writes the logs of `cargo xtask bench logs`.
const LOGS: &str = "host-tools/benches/logs/requirements.txt";

/// What the clients of a live view need.
const LIVE: &str = "host-tools/tests/live/requirements.txt";

/// The environment that `host-tools/python/tests/pytest.rs` looks for; made anew where the
/// requirements have changed.
///
/// # Errors
/// No Python, or packages that cannot be had.
pub(crate) fn environment() -> Result<PathBuf, Stop> {
    environment_of("python/venv", REQUIREMENTS)
}

/// The environment that the DDS peer of `host-tools/tests/suite/node.rs` runs in.
///
/// # Errors
/// As [`environment`].
pub(crate) fn peer() -> Result<PathBuf, Stop> {
    environment_of("node-python/venv", PEER)
}

/// The environment that the clients of `host-tools/tests/suite/live_view.rs` run in.
///
/// # Errors
/// As [`environment`].
pub(crate) fn live() -> Result<PathBuf, Stop> {
    environment_of("live-python/venv", LIVE)
}

/// The environment of the bench `logs`.
///
/// # Errors
/// As [`environment`].
pub(crate) fn logs() -> Result<PathBuf, Stop> {
    environment_of("logs-python/venv", LOGS)
}

/// The environment of `cargo xtask test-fleet` and of the bench `fleet`.
///
/// # Errors
/// As [`environment`].
pub(crate) fn engines() -> Result<PathBuf, Stop> {
    environment_of("fleet-python/venv", ENGINES)
}

fn environment_of(folder: &str, requirements: &str) -> Result<PathBuf, Stop> {
    let folder = paths::target_folder().join(folder);
    let python = folder.join("bin/python");
    let (file, made_from) = (paths::root().join(requirements), folder.join("requirements.txt"));
    let wanted = std::fs::read(&file).map_err(|error| Stop::new(format!("{requirements}: {error}")))?;
    if python.exists() && std::fs::read(&made_from).is_ok_and(|installed| installed == wanted) {
        return Ok(python);
    }
    let made = fresh(&folder).and_then(|python| {
        obtain(pip(&python).arg("--requirement").arg(&file))?;
        std::fs::write(&made_from, &wanted).map_err(|error| Stop::new(error.to_string()))?;
        Ok(python)
    });
    if made.is_err() {
        // Half an environment would fail the tests; without one they are skipped.
        let _ = std::fs::remove_dir_all(&folder);
    }
    made
}

/// An environment with nothing in it; its Python.
pub(crate) fn fresh(folder: &Path) -> Result<PathBuf, Stop> {
    let mut make = command("python3 -m venv --clear");
    obtain(make.arg(folder))?;
    Ok(folder.join("bin/python"))
}

/// `pip install`, without what to install.
pub(crate) fn pip(python: &Path) -> Command {
    let mut pip = Command::new(python);
    pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]);
    pip
}

/// Builds the wheel, optimised, into `target/wheels`.
///
/// # Errors
/// It cannot be built.
pub(crate) fn build() -> Result<PathBuf, Stop> {
    let python = environment()?;
    let folder = paths::target_folder().join("wheels");
    let _ = std::fs::remove_dir_all(&folder);
    let mut build = Command::new(&python);
    build.args([
        "-m",
        "maturin",
        "build",
        "--release",
        "--manifest-path",
        "host-tools/python/Cargo.toml",
        "--out",
    ]);
    // maturin needs nothing of the environment but its own folder on the path.
    obtain(build.arg(&folder))?;
    let files = folder.read_dir().map_err(|error| Stop::new(format!("{}: {error}", folder.display())))?;
    let wheel =
        files.flatten().map(|file| file.path()).find(|file| file.extension().is_some_and(|is| is == "whl"));
    wheel.ok_or_else(|| Stop::new(format!("{}: no wheel", folder.display())))
}

/// Builds the wheel, installs it into an environment that has nothing else, and runs the example of
/// the README there.
pub(crate) fn wheel() -> Result<(), Stop> {
    let wheel = build()?;
    let elsewhere = fresh(&paths::target_folder().join("python/fresh"))?;
    obtain(pip(&elsewhere).arg(&wheel))?;
    let mut example = Command::new(&elsewhere);
    obtain(example.args(["-c", &readme_example()?]))?;
    println!("   {}", wheel.display());
    Ok(())
}

/// The block of Python in the README.
fn readme_example() -> Result<String, Stop> {
    let readme = paths::root().join("README.md");
    let text = std::fs::read_to_string(&readme).map_err(|error| Stop::new(format!("README.md: {error}")))?;
    let example = text.split_once("```python\n").and_then(|(_, rest)| rest.split_once("```"));
    example
        .map(|(example, _)| example.to_owned())
        .ok_or_else(|| Stop::new("README.md has no example in Python"))
}
