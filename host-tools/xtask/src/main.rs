//! `cargo xtask demo | test | bench | size`: sets up what it needs, then runs a list of commands.

mod bench;
mod circles;
mod demo;
mod images;
mod instructions;
mod paths;
mod robots;
mod set_up;
mod size;
mod steps;
mod test;

use std::process::ExitCode;

const USAGE: &str = "\
usage: cargo xtask <command>

  test   formatting, lints, documentation, tests on the host and on an emulated Cortex-M7, licences
  demo   record, fit, flash and estimate on the virtual board; plots go to demo-output/
  bench [accuracy | fit-speed | instructions | robots]
         the figures of the README, measured again; minutes
  bench robots --json
         the figures of docs/robots.txt
  circles
         files of a crate that need each other, and rooms that need those above them: part of test
  size [--json]
         flash, static RAM and stack of the firmware's images, against their limits

All add the Rust target and QEMU when they are missing.";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let done = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["test"] => test::run(),
        ["demo"] => demo::run(),
        ["bench"] => bench::run(None).unwrap_or(false),
        ["bench", name] => {
            let Some(reached) = bench::run(Some(name)) else {
                eprintln!("there is no bench {name}\n\n{USAGE}");
                return ExitCode::from(2);
            };
            reached
        }
        ["circles"] => {
            let result = circles::check();
            if let Err(stop) = &result {
                println!("   {stop}");
            }
            result.is_ok()
        }
        ["bench", "robots", "--json"] => bench::robots_json(),
        ["size"] => size::run(false),
        ["size", "--json"] => size::run(true),
        ["help" | "--help" | "-h"] => {
            println!("{USAGE}");
            true
        }
        _ => {
            eprintln!("{USAGE}");
            return ExitCode::from(2);
        }
    };
    if done { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
