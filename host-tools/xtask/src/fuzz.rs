//! `cargo xtask fuzz`: libFuzzer over the readers of files and packets, on the stable toolchain.
//!
//! The counters at the branches are LLVM's, by flags that stable rustc takes; no sanitizer: safe
//! Rust's own checks find what there is to find, and overflow counts as a fault. Not part of `cargo
//! xtask test`: the counters mean another build of everything, minutes. That has
//! `host-tools/tests/suite/fuzz.rs`, over the same targets.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::paths::{root, target_folder};
use crate::steps::{Steps, Stop, answer, command};

/// As `host-tools/tests/fuzz/targets.rs` has them.
const TARGETS: [&str; 14] = [
    "log",
    "robot",
    "coefficients",
    "effects",
    "image",
    "link",
    "servo",
    "mcap",
    "sqlite",
    "ulog",
    "ros1",
    "dataflash",
    "vesc_tool",
    "parquet",
];

/// Executions of each target unless the caller says otherwise.
const RUNS: u64 = 1_000_000;

/// Bytes of the longest input.
const LONGEST: &str = "-max_len=4096";

const FLAGS: &str = "-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
                     -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
                     -Cllvm-args=-sanitizer-coverage-trace-compares";

/// What to fuzz, and how long.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Request<'a> {
    /// All without.
    target: Option<&'a str>,
    runs: u64,
}

impl<'a> Request<'a> {
    /// `[target] [--runs N]`; `None` for anything else.
    pub(crate) fn parse(mut arguments: &[&'a str]) -> Option<Self> {
        let mut request = Self { target: None, runs: RUNS };
        if let [target, rest @ ..] = arguments
            && TARGETS.contains(target)
        {
            request.target = Some(target);
            arguments = rest;
        }
        match arguments {
            [] => Some(request),
            ["--runs", runs] => Some(Self { runs: runs.parse().ok()?, ..request }),
            _ => None,
        }
    }
}

/// True when no input made a target fail.
pub(crate) fn run(request: &Request<'_>) -> bool {
    let mut steps = Steps::default();
    let result = all(&mut steps, request);
    steps.print_summary();
    if let Err(stop) = &result {
        println!("\nfuzz: {stop}\n   keep what was found: add the input to host-tools/tests/fuzz/corpus");
    }
    result.is_ok()
}

/// Each of these targets, its executions dealt to as many processes as there are cores. They share
/// what they find, and begin at seeds of their own; what each says stands in a file.
///
/// # Errors
/// An input made a target fail; it cannot be built or started.
pub(crate) fn on_all_cores(steps: &mut Steps, targets: &[&str], executions: u64) -> Result<(), Stop> {
    let (program, folder) = built(steps)?;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    for target in targets {
        let name = format!("{target}, {executions} executions on {cores} cores");
        steps.work(&name, || {
            let mut running = Vec::new();
            for core in 1..=cores {
                let said = folder.join(format!("{target}-{core}.log"));
                let file = fs::File::create(&said)
                    .map_err(|error| Stop::new(format!("{}: {error}", said.display())))?;
                let mut fuzz = fuzzer(&program, &folder, target, executions.div_ceil(cores as u64))?;
                let child = fuzz.arg(format!("-seed={core}")).stderr(file).stdout(Stdio::null()).spawn();
                running.push((said, child.map_err(|error| Stop::new(format!("fuzz: {error}")))?));
            }
            let mut all = Ok(());
            let mut done = 0;
            for (said, mut child) in running {
                let status = child.wait().map_err(|error| Stop::new(format!("fuzz: {error}")))?;
                let text = fs::read_to_string(&said).unwrap_or_default();
                done += executed(&text).unwrap_or(0);
                if !status.success() {
                    all = Err(Stop::new(format!("{status}; see {}", said.display())));
                }
            }
            println!("   {done} executions");
            all
        })?;
    }
    Ok(())
}

/// What libFuzzer says at its end of how many inputs it ran.
fn executed(text: &str) -> Option<u64> {
    text.lines().find_map(|line| line.strip_prefix("stat::number_of_executed_units:")?.trim().parse().ok())
}

/// The program with its counters, and the folder of what it finds.
fn built(steps: &mut Steps) -> Result<(PathBuf, PathBuf), Stop> {
    let host = answer("rustc --print host-tuple")
        .ok_or_else(|| Stop::new("rustc --print host-tuple says nothing"))?;
    let folder = target_folder().join("fuzz");
    let mut build =
        command(&format!("cargo build --release --manifest-path fuzz/Cargo.toml --target {host}"));
    // Only with an explicit --target are programs that run during the build left without counters.
    build.env("CARGO_TARGET_DIR", &folder).env("RUSTFLAGS", FLAGS);
    steps.run("build", build)?;
    Ok((folder.join(&host).join("release/fuzz"), folder))
}

/// The program on a target, so many times.
fn fuzzer(program: &Path, folder: &Path, target: &str, runs: u64) -> Result<Command, Stop> {
    // New inputs go to the first folder; the kept ones are only read.
    let fresh = folder.join("corpus").join(target);
    fs::create_dir_all(&fresh).map_err(|error| Stop::new(format!("{}: {error}", fresh.display())))?;
    let mut fuzz = Command::new(program);
    fuzz.env("FUZZ_TARGET", target).arg(&fresh).arg(root().join("host-tools/tests/fuzz/corpus").join(target));
    fuzz.arg(format!("-runs={runs}")).args([
        LONGEST,
        "-timeout=10",
        "-rss_limit_mb=1000",
        "-print_final_stats=1",
    ]);
    fuzz.arg(format!("-artifact_prefix={}/", folder.display()));
    Ok(fuzz)
}

fn all(steps: &mut Steps, request: &Request<'_>) -> Result<(), Stop> {
    let (program, folder) = built(steps)?;
    for target in TARGETS.into_iter().filter(|target| request.target.is_none_or(|chosen| chosen == *target)) {
        let fuzz = fuzzer(&program, &folder, target, request.runs)?;
        steps.run(&format!("{target}, {} executions", request.runs), fuzz)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_and_runs_are_understood() {
        assert_eq!(Request::parse(&[]), Some(Request { target: None, runs: RUNS }));
        assert_eq!(Request::parse(&["log", "--runs", "7"]), Some(Request { target: Some("log"), runs: 7 }));
        assert_eq!(Request::parse(&["--runs", "9"]), Some(Request { target: None, runs: 9 }));
        assert!(
            [&["logs"][..], &["--runs"], &["log", "--runs", "many"]]
                .iter()
                .all(|wrong| Request::parse(wrong).is_none())
        );
    }

    #[test]
    fn executions_are_read_from_what_it_says() {
        let said = "Done 7 runs\nstat::number_of_executed_units: 1234\nstat::slowest_unit_time_sec: 0\n";
        assert_eq!((executed(said), executed("Done")), (Some(1234), None));
    }

    /// The same list as the targets' own.
    #[test]
    fn every_target_is_known() {
        let targets = fs::read_to_string(root().join("host-tools/tests/fuzz/targets.rs")).unwrap();
        let listed: Vec<&str> =
            targets.lines().filter_map(|line| line.strip_prefix("    (\"")?.split('"').next()).collect();
        assert_eq!(listed, TARGETS);
    }

    /// The program is not of the workspace: nothing else would say that it no longer builds.
    #[test]
    fn the_program_has_every_crate_that_targets_use() {
        let read = |path: &str| fs::read_to_string(root().join(path)).unwrap();
        let (targets, manifest) = (read("host-tools/tests/fuzz/targets.rs"), read("fuzz/Cargo.toml"));
        let missing: Vec<&str> = targets
            .lines()
            .filter_map(|line| line.strip_prefix("use ")?.split("::").next())
            .filter(|name| *name != "std")
            .filter(|name| !manifest.contains(&format!("\n{} = ", name.replace('_', "-"))))
            .collect();
        assert_eq!(missing, Vec::<&str>::new());
    }
}
