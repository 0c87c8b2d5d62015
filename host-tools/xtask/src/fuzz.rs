//! `cargo xtask fuzz`: libFuzzer over the readers of files and packets, on the stable toolchain.
//!
//! The counters at the branches are LLVM's, by flags that stable rustc takes; no sanitizer: safe Rust's own checks find what there is to
//! find, and overflow counts as a fault. Not part of `cargo xtask test`: the counters mean another build of everything, minutes. That
//! has `host-tools/tests/suite/fuzz.rs`, over the same targets.

use std::fs;
use std::process::Command;

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

fn all(steps: &mut Steps, request: &Request<'_>) -> Result<(), Stop> {
    let host = answer("rustc --print host-tuple")
        .ok_or_else(|| Stop::new("rustc --print host-tuple says nothing"))?;
    let folder = target_folder().join("fuzz");
    let mut build =
        command(&format!("cargo build --release --manifest-path fuzz/Cargo.toml --target {host}"));
    // Only with an explicit --target are programs that run during the build left without counters.
    build.env("CARGO_TARGET_DIR", &folder).env("RUSTFLAGS", FLAGS);
    steps.run("build", build)?;
    for target in TARGETS.into_iter().filter(|target| request.target.is_none_or(|chosen| chosen == *target)) {
        // New inputs go to the first folder; the kept ones are only read.
        let found = folder.join("corpus").join(target);
        fs::create_dir_all(&found).map_err(|error| Stop::new(format!("{}: {error}", found.display())))?;
        let mut fuzz = Command::new(folder.join(&host).join("release/fuzz"));
        fuzz.env("FUZZ_TARGET", target)
            .arg(&found)
            .arg(root().join("host-tools/tests/fuzz/corpus").join(target));
        fuzz.arg(format!("-runs={}", request.runs)).args([
            LONGEST,
            "-timeout=10",
            "-rss_limit_mb=1000",
            "-print_final_stats=1",
        ]);
        fuzz.arg(format!("-artifact_prefix={}/", folder.display()));
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

    /// The same list as the targets' own.
    #[test]
    fn every_target_is_known() {
        let targets = fs::read_to_string(root().join("host-tools/tests/fuzz/targets.rs")).unwrap();
        let listed: Vec<&str> =
            targets.lines().filter_map(|line| line.strip_prefix("    (\"")?.split('"').next()).collect();
        assert_eq!(listed, TARGETS);
    }
}
