//! `cargo xtask demo`: from a simulated robot to its payload, in one folder of results.

use std::process::Command;

use crate::steps::{Steps, Stop, command};

/// Where everything goes, in the workspace's directory.
const FOLDER: &str = "demo-output";

/// Name and arguments of `gmr`; `@` stands for [`FOLDER`].
const STEPS: [(&str, &str); 6] = [
    (
        "simulate the training runs: 1 kg, then 6 kg",
        "simulate --plant servo --profile training --duration 200 --rate 200 --sensors servo --mass 1@0,6@100 \
         --seed 1 --out @/training.csv",
    ),
    (
        "simulate the test run: 3 kg, then 4 kg, unknown to the estimator",
        "simulate --plant servo --profile test --duration 200 --rate 200 --sensors servo --mass 3@0,4@100 \
         --seed 2 --out @/test.csv",
    ),
    ("look at the training runs", "inspect --robot burger --plot @/inspect.png @/training.csv"),
    ("fit the power model", "fit --robot burger --out @/coefficients.toml @/training.csv"),
    (
        "estimate the payload",
        "estimate --robot burger --coeffs @/coefficients.toml --window 25 --plot @/estimate.png @/test.csv",
    ),
    (
        "compare the models",
        "compare --robot burger --train @/training.csv --test @/test.csv --plot @/compare.png",
    ),
];

/// True when every step ended well.
pub(crate) fn run() -> bool {
    let mut steps = Steps::default();
    let result = all(&mut steps);
    steps.print_summary();
    match result {
        Ok(()) => println!("\ndemo: done; the logs, coefficients and plots are in {FOLDER}/"),
        Err(ref stop) => println!("\ndemo: FAILED: {stop}"),
    }
    result.is_ok()
}

fn all(steps: &mut Steps) -> Result<(), Stop> {
    steps.run("build", command("cargo build --release --package host-tools"))?;
    std::fs::create_dir_all(crate::root().join(FOLDER))
        .map_err(|error| Stop::new(format!("{FOLDER}: {error}")))?;
    for (name, arguments) in STEPS {
        steps.run(name, gmr(arguments))?;
    }
    Ok(())
}

fn gmr(arguments: &str) -> Command {
    let mut command = Command::new(crate::target_folder().join("release/gmr"));
    command.args(arguments.split_whitespace().map(in_folder));
    command
}

/// `@/name` becomes a path in [`FOLDER`]; a mass schedule keeps its `@`.
fn in_folder(argument: &str) -> String {
    match argument.strip_prefix("@/") {
        Some(name) => format!("{FOLDER}/{name}"),
        None => argument.to_owned(),
    }
}
