//! `cargo xtask bench robots`, `floors` and `gap-mujoco`: the models and the gap workflow on robots
//! that are not ours, by the scripts in host-tools/benches/robots.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::paths::{root, target_folder};
use crate::python;
use crate::set_up;
use crate::steps::{Steps, Stop, answer, command, command_line};

const SCRIPTS: &str = "host-tools/benches/robots";
/// What an answer of `gmr gap` is worth.
const JUDGE: &str = "host-tools/tests/reference/gap_judge";
/// What the scripts need from PyPI.
const PACKAGES: [&str; 4] = ["mujoco>=3.2", "numpy>=2", "scipy>=1.13", "numba>=0.61"];
/// The table as it is committed.
const TABLE: &str = "docs/results/robots.txt";
/// The table of simulators that were closed.
const CLOSED: &str = "docs/results/gap-simulator.txt";
/// What is named of the effects in the MuJoCo robots.
const MUJOCO: &str = "docs/results/gap-mujoco.txt";
/// What is named between floors and within each.
const FLOORS: &str = "docs/results/gap-floors.txt";
/// How well the sizes of named effects are known.
const SIZES: &str = "docs/results/gap-sizes.txt";
/// Measured logs. Beside the project, not part of it.
pub(crate) const DATA: &str = "../shared/data";

/// Prints the table, or its figures as JSON.
pub(crate) fn run(steps: &mut Steps, json: bool) -> Result<(), Stop> {
    let mut bench = script(steps, &format!("{SCRIPTS}/bench.py"))?;
    bench.args(["--data", DATA, "--work"]).arg(target_folder().join("robots"));
    if json {
        bench.arg("--json");
        return steps.run("robots", bench);
    }
    steps.work("robots", || keep(TABLE, &text_of(bench)?))
}

/// Effects in the MuJoCo robots, hidden in sets of runs, and what `gmr gap` makes of them.
pub(crate) fn gap(steps: &mut Steps) -> Result<(), Stop> {
    let python = python()?;
    steps.run("gmr", command("cargo build --quiet --release --package host-tools --bin gmr"))?;
    let work = target_folder().join("gap-mujoco");
    std::fs::create_dir_all(&work).map_err(|error| Stop::new(format!("{}: {error}", work.display())))?;
    let mut scores = String::new();
    // Seeds that no constant was tuned on.
    for (name, arguments) in [
        ("effects", "--seeds 33 36 --free 30 --free-other 10"),
        ("causes off the list", "--seeds 33 35 --free 0 --free-other 0 --foreign"),
    ] {
        let answers = work.join("answers.jsonl");
        let mut sets = Command::new(&python);
        sets.arg(format!("{SCRIPTS}/gap_sets.py")).arg(&answers).args(arguments.split(' '));
        sets.arg("--gmr").arg(target_folder().join("release/gmr")).arg("--work").arg(&work);
        steps.run(name, sets)?;
        let mut score = Command::new(&python);
        score.arg(format!("{SCRIPTS}/gap_score.py")).arg(JUDGE).arg(&answers);
        scores += &format!("$ gap_sets.py {arguments}\n{}", text_of(score)?);
    }
    steps.work("score", || keep(MUJOCO, &scores))
}

/// Simulators that lack an effect: found, written into their model, and driven again.
pub(crate) fn simulator(steps: &mut Steps) -> Result<(), Stop> {
    let mut bench = script(steps, &format!("{SCRIPTS}/closing.py"))?;
    bench.arg("--work").arg(target_folder().join("gap-mujoco"));
    bench.args(["--robots", "two-wheeled", "skid-steered"]);
    steps.work("simulators", || keep(CLOSED, &text_of(bench)?))
}

/// What `gmr gap` names between two floors of a measured robot, and within each.
pub(crate) fn floors(steps: &mut Steps) -> Result<(), Stop> {
    let mut bench = script(steps, &format!("{SCRIPTS}/floors.py"))?;
    bench.args(["--data", DATA]);
    steps.work("floors", || keep(FLOORS, &text_of(bench)?))
}

/// How often the interval of a named effect's size holds the truth.
pub(crate) fn sizes(steps: &mut Steps) -> Result<(), Stop> {
    let bench = script(steps, &format!("{SCRIPTS}/gap_sizes.py"))?;
    steps.work("sizes", || keep(SIZES, &text_of(bench)?))
}

/// A script with the command `gmr`, built for it.
pub(crate) fn script(steps: &mut Steps, path: &str) -> Result<Command, Stop> {
    let python = python()?;
    steps.run("gmr", command("cargo build --quiet --release --package host-tools --bin gmr"))?;
    let mut bench = Command::new(python);
    bench.arg(path).arg("--gmr").arg(target_folder().join("release/gmr"));
    Ok(bench)
}

/// Prints a table, and writes it where it is committed.
pub(crate) fn keep(file: &str, text: &str) -> Result<(), Stop> {
    print!("{text}");
    std::fs::write(root().join(file), text).map_err(|error| Stop::new(format!("{file}: {error}")))
}

/// What a command prints; its progress is shown meanwhile.
pub(crate) fn text_of(mut bench: Command) -> Result<String, Stop> {
    let line = command_line(&bench);
    println!("   {line}");
    let output = bench.current_dir(root()).stderr(Stdio::inherit()).output();
    let output = output.map_err(|error| Stop::new(format!("{line}\n   {error}")))?;
    if !output.status.success() {
        return Err(Stop::new(format!("{line}\n   {}", output.status)));
    }
    String::from_utf8(output.stdout).map_err(|error| Stop::new(error.to_string()))
}

/// A Python with the packages, in a virtual environment below the target folder.
pub(crate) fn python() -> Result<PathBuf, Stop> {
    let folder = target_folder().join("robots-python");
    let known = folder.join("bin/python");
    if has_packages(&known) {
        return Ok(known);
    }
    if answer("python3 --version").is_none() {
        return Err(Stop::new("python3 is missing: nothing is measured without it"));
    }
    let python = python::fresh(&folder)?;
    set_up::obtain(python::pip(&python).args(PACKAGES))?;
    Ok(python)
}

fn has_packages(python: &Path) -> bool {
    let mut probe = Command::new(python);
    probe.args(["-c", "import mujoco, numpy, scipy, numba"]).stderr(Stdio::null());
    probe.status().is_ok_and(|status| status.success())
}
