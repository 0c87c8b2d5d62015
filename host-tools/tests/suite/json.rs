//! What `--json` prints is documented, command by command, and has a version. That every key is
//! named is checked wherever a test reads a command's JSON (`Bench::json`).

use crate::common::{Bench, ROBOT, documentation, drive, is_documented};
use crate::shell::commands;

#[test]
fn every_command_with_json_is_documented() {
    let bench = Bench::new();
    let help = bench.done(&["--help"]).stdout;
    let mut documented = 0;
    for command in commands(&help) {
        if bench.done(&[command, "--help"]).stdout.contains("--json") {
            assert!(documentation(command).is_some(), "docs/json.md does not have gmr {command}");
            documented += 1;
        }
    }
    assert!(documented >= 18, "{documented}");
}

/// Those whose JSON no other test reads whole.
#[test]
fn lists_and_what_is_several_have_a_version() {
    let bench = Bench::new();
    bench.put("robot.toml", ROBOT);
    for (name, mass) in [("empty.csv", 1.0), ("full.csv", 6.0)] {
        bench.put(name, drive(40.0, 50.0, |_| mass));
    }
    let coefficients = ["--robot", "robot.toml", "--coeffs", "coefficients.toml"];
    let with = |more: &[&'static str]| [&more[..1], &coefficients, &more[1..]].concat();
    bench.json(&["fit", "--robot", "robot.toml", "--out", "coefficients.toml", "empty.csv", "full.csv"]);
    assert_eq!(bench.json(&["look", "empty.csv", "full.csv"])["logs"].as_array().unwrap().len(), 2);
    bench.json(&["look", "empty.csv"]);
    assert!(bench.json(&["simulate", "--effects"])["effects"].as_array().unwrap().len() > 20);
    bench.json(&["compare", "--list"]);
    bench.json(&["convert", "--robot", "robot.toml", "--out", "log.mcap", "empty.csv"]);
    bench.json(&with(&["gram", "--out", "grams.jsonl", "empty.csv", "full.csv"]));
    bench.json(&["fit", "--robot", "robot.toml", "--model", "eq18", "--grams", "grams.jsonl"]);
    bench.json(&with(&["estimate", "full.csv"]));
    bench.json(&with(&["export", "sdf", "--mass", "3"]));
    std::fs::create_dir_all(bench.path("logs/7/2026-11-02")).unwrap();
    bench.put("logs/7/2026-11-02/log.csv", bench.text("full.csv"));
    bench.json(&with(&["fleet", "logs", "--out", "fleet"]));
    // The file is for scripts as well.
    is_documented("fleet", &serde_json::from_str(&bench.text("fleet/fleet.json")).unwrap());
}
