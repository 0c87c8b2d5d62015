//! `cargo xtask demo | test | bench | size`: sets up what it needs, then runs a list of commands.

mod bench;
mod bloat;
mod demo;
mod docs;
mod fleet;
mod fuzz;
mod gap;
mod images;
mod instructions;
mod kinds;
mod logs;
mod long;
mod paths;
mod predict;
mod python;
mod robots;
mod set_up;
mod size;
mod steps;
mod test;
mod test_fleet;
mod test_live;
mod test_node;

use std::process::ExitCode;

use set_up::Consent;

const USAGE: &str = "\
usage: cargo xtask <command>

  test [--yes]
         formatting, lints, documentation, tests on the host and on an emulated Cortex-M7, licences
  test-fleet [--yes | --rows N]
         sums on Spark and Ray, executors and workers as processes of their own, and logs in a
         bucket; needs Java, and a gigabyte from PyPI. --rows: then bench engines, too
  test-live
         gmr record --foxglove beside WebSocket clients that are not ours (PyPI's websockets)
  test-node
         gmr node beside a DDS peer that is not ours (PyPI's cyclonedds), in real time
  demo [--yes]
         record, fit, flash and estimate on the virtual board; plots go to demo-output/
  bench [accuracy | charge | coverage | fit-speed | fleet | floors | gap | gap-mujoco |
         gap-simulator | gap-sizes | instructions | kinds | leaderboard | logs | predict |
         robots]
         the figures of the README, measured again; minutes. gap, gap-mujoco and
         leaderboard: ten minutes to an hour, only by name
  bench fleet --rows N
         the figures of docs/results/fleet-bench.txt, by 100000000: a quarter of an hour to simulate,
         4 GB; beside Polars, NumPy and SciPy
  bench engines --rows N
         the figures of docs/results/engines-bench.txt, on the same rows: Spark and Ray beside gmr
         fleet, half an hour; needs what test-fleet does
  bench robots --json
         the figures of docs/results/robots.txt
  bloat
         machine code of ours in the release build of gmr, and what of it stands there in four
         copies or more; needs nm, of binutils
  docs   links, length of sentences and of README, and the book: part of test
  fuzz [log | robot | coefficients | effects | image | link | servo | mcap | sqlite | ulog |
        parquet] [--runs N]
         libFuzzer over the readers of files and packets; a C++ compiler is needed
  mutate [COUNT [SEED]]
         spoiled inputs, COUNT (500) of each kind, each to the command that reads it, within
         5 s and 2 GB: 11,500 in three quarters of an hour
  long fuzz [EXECUTIONS] | soak [HOURS] | cuts [CUTS] | client [MINUTES]
         what takes a night: the parsers of link and servo bus on all cores (100,000,000 each);
         the virtual board with faults and changing payloads (4 h of its time), its masses and
         energies against the plant's; power cuts on the real image (1,000; STM32EMU names
         the emulator); ROBOTIS's client on the virtual board (60, in real time)
  wheel
         the Python package, optimised, into target/wheels; installed afresh, and the
         README's example run with it
  size [--json]
         flash, static RAM and stack of the firmware's images, against their limits

All add the Rust target where it is missing, and ask before they install QEMU, Java or a browser; --yes answers.";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let done = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["test"] => test::run(Consent::Ask),
        ["test", "--yes"] => test::run(Consent::Given),
        ["test-fleet"] => test_fleet::run(Consent::Ask, None),
        ["test-fleet", "--yes"] => test_fleet::run(Consent::Given, None),
        ["test-fleet", "--rows", rows] if rows.parse::<usize>().is_ok_and(|rows| rows >= 1_000_000) => {
            test_fleet::run(Consent::Ask, rows.parse().ok())
        }
        ["test-live"] => test_live::run(),
        ["test-node"] => test_node::run(),
        ["demo"] => demo::run(Consent::Ask),
        ["demo", "--yes"] => demo::run(Consent::Given),
        ["bench"] => bench::run(None).unwrap_or(false),
        ["bench", name] => {
            let Some(reached) = bench::run(Some(name)) else {
                eprintln!("there is no bench {name}\n\n{USAGE}");
                return ExitCode::from(2);
            };
            reached
        }
        ["bloat"] => bloat::run(),
        ["docs"] => {
            let result = docs::check();
            if let Err(stop) = &result {
                println!("   {stop}");
            }
            result.is_ok()
        }
        ["fuzz", ref rest @ ..] if let Some(request) = fuzz::Request::parse(rest) => fuzz::run(&request),
        ["bench", "fleet", "--rows", rows] if rows.parse::<usize>().is_ok_and(|rows| rows >= 1_000_000) => {
            bench::fleet_of(rows.parse().unwrap_or_default())
        }
        ["bench", "engines", "--rows", rows] if rows.parse::<usize>().is_ok_and(|rows| rows >= 1_000_000) => {
            bench::engines_of(rows.parse().unwrap_or_default())
        }
        ["bench", "robots", "--json"] => bench::robots_json(),
        ["mutate", ref numbers @ ..]
            if numbers.len() <= 2 && numbers.iter().all(|n| n.parse::<u64>().is_ok()) =>
        {
            bench::mutants(numbers)
        }
        ["long", ref rest @ ..] if let Some(what) = long::Long::parse(rest) => {
            steps::carried_out(|steps| long::run(steps, what))
        }
        ["wheel"] => match python::wheel() {
            Ok(()) => true,
            Err(stop) => {
                println!("   {stop}");
                false
            }
        },
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
