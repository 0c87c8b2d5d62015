//! `cargo xtask bench gap`: what the gap workflow names of effects that two plants hide, one of
//! ours and one that shares nothing with it.

use std::process::{Command, Stdio};

use crate::paths::target_folder;
use crate::python::pip;
use crate::robots::{keep, python, text_of};
use crate::set_up;
use crate::steps::{Steps, Stop, command};

/// The second judge.
const JUDGE: &str = "host-tools/tests/reference/gap_judge";

/// All 21 effects at half the noise, each with two seeds that no constant was tuned on; effect-free
/// sets; what the dictionary lacks. Pairs. And the coverage of the mass interval
/// once the effects are added.
const OWN: [&str; 3] = [
    "gap-bench --first-seed 1531 --seeds 2 --sizes 0.5 --free 16 --removed 1",
    "gap-bench --first-seed 1541 --seeds 0 --free 0 --pairs 56 --sizes 1",
    "gap-bench --first-seed 501 --seeds 1 --sizes 1 --free 0 --coverage",
];

/// Sets of the second judge, of seeds that no constant was tuned on: effects, none, and what the
/// dictionary lacks.
const KINDS: [(&str, &str); 3] = [
    ("effects", "--kind effects --count 240 --seeds 120002 120010"),
    ("free", "--kind free --count 200 --seeds 120000 120100"),
    ("foreign", "--kind foreign --count 26 --seeds 120002 120003"),
];

/// Writes both tables: docs/results/gap-bench.txt and docs/results/gap-judge.txt. An hour on
/// two cores.
pub(crate) fn run(steps: &mut Steps) -> Result<(), Stop> {
    steps.run("gmr", command("cargo build --quiet --release --package host-tools --bin gmr"))?;
    let gmr = target_folder().join("release/gmr");
    steps.work("own plant", || {
        let tables: Result<Vec<String>, Stop> = OWN
            .iter()
            .map(|arguments| {
                let mut bench = Command::new(&gmr);
                bench.args(arguments.split(' '));
                Ok(format!("$ gmr {arguments}\n{}", text_of(bench)?))
            })
            .collect();
        keep("docs/results/gap-bench.txt", &tables?.join("\n"))
    })?;
    let python = python()?;
    let folder = target_folder().join("gap-judge");
    std::fs::create_dir_all(&folder).map_err(|error| Stop::new(error.to_string()))?;
    let mut results = Vec::new();
    for (name, arguments) in KINDS {
        let result = folder.join(format!("{name}.jsonl"));
        // The judge adds to what is there.
        let _ = std::fs::remove_file(&result);
        let mut batch = Command::new(&python);
        batch.arg(format!("{JUDGE}/batch.py")).arg(&result).arg("--gmr").arg(&gmr).args(arguments.split(' '));
        steps.run(name, batch)?;
        results.push(result);
    }
    steps.work("second judge", || {
        let mut tally = Command::new(&python);
        tally.arg(format!("{JUDGE}/tally.py")).args(&results);
        let lines = KINDS.map(|(name, arguments)| format!("$ batch.py {name}.jsonl {arguments}\n")).concat();
        keep("docs/results/gap-judge.txt", &format!("{lines}{}", text_of(tally)?))
    })
}

/// What other ways to find a gap need from PyPI, beside the judge.
const RIVALS: [&str; 2] = ["pysindy>=2", "scikit-learn>=1.5"];

/// `gmr gap` beside other ways to find what a model lacks, on the same sets:
/// docs/results/gap-leaderboard.txt.
pub(crate) fn leaderboard(steps: &mut Steps) -> Result<(), Stop> {
    steps.run("gmr", command("cargo build --quiet --release --package host-tools --bin gmr"))?;
    let python = python()?;
    let mut probe = Command::new(&python);
    probe.args(["-c", "import pysindy, sklearn"]).stderr(Stdio::null());
    if !probe.status().is_ok_and(|status| status.success()) {
        set_up::obtain(pip(&python).args(RIVALS))?;
    }
    steps.work("leaderboard", || {
        let mut table = Command::new(&python);
        table.arg(format!("{JUDGE}/leaderboard.py")).arg("--gmr").arg(target_folder().join("release/gmr"));
        keep("docs/results/gap-leaderboard.txt", &text_of(table)?)
    })
}
