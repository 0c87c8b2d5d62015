//! What `gmr gap` does with logs, coefficients and arguments that are wrong: one line that says
//! where and what was allowed, the documented exit code (1 failed, 2 wrong usage), nothing on
//! standard output, no file changed. And no panic, whatever is in a log.

use std::path::PathBuf;
use std::sync::OnceLock;

use gap::investigate::investigate;
use gap::power_only;
use logs::robot::Robot;
use logs::runs::Runs;
use residuals::types::{Base, Options};

use crate::common::{Bench, ROBOT, TRUTH, drive};
use model_core::torque::{Drive, TorqueModel};
use proptest::prelude::{ProptestConfig, any, prop, proptest};
use proptest::strategy::Strategy;
use support::context::Context;

const FIELD: [&str; 4] = ["f1.csv", "f2.csv", "f3.csv", "f4.csv"];
const BASE: [&str; 3] = ["b1.csv", "b2.csv", "b3.csv"];

/// Three clean runs, coefficients fitted to them, and four field runs, all made by the model itself
/// at 100 Hz.
fn good() -> &'static Bench {
    static BENCH: OnceLock<Bench> = OnceLock::new();
    BENCH.get_or_init(|| {
        let bench = Bench::new();
        bench.put("robot.toml", ROBOT);
        for (name, mass) in BASE.iter().zip([1.0, 3.5, 6.0]) {
            bench.put(name, drive(30.0, 100.0, |_| mass));
        }
        for (name, mass) in FIELD.iter().zip([1.5, 2.5, 4.0, 5.5]) {
            bench.put(name, drive(25.0, 100.0, |_| mass));
        }
        bench.done(&[&["fit", "--robot", "robot.toml", "--out", "base.toml"], &BASE[..]].concat());
        bench
    })
}

/// A folder of its own with all of it.
fn bench() -> Bench {
    let bench = Bench::new();
    for name in good().files() {
        bench.put(&name, good().text(&name));
    }
    bench
}

/// The one line of a command that failed, without `gmr: `.
fn refusal(bench: &Bench, arguments: &[&str], code: i32) -> String {
    let before: Vec<(String, String)> =
        bench.files().into_iter().map(|name| (name.clone(), bench.text(&name))).collect();
    let ran = bench.gmr(&[&["gap", "--robot", "robot.toml"], arguments].concat());
    assert_eq!((ran.code, ran.stdout.as_str()), (Some(code), ""), "{arguments:?}: {}", ran.stderr);
    assert_eq!(ran.stderr.lines().count(), 1, "{arguments:?}: {}", ran.stderr);
    for (name, text) in before {
        assert_eq!(bench.text(&name), text, "{arguments:?} leaves {name} alone");
    }
    ran.stderr.trim_end().strip_prefix("gmr: ").unwrap().to_owned()
}

/// With coefficients, and the field's first log replaced.
fn refused_log(content: &str) -> String {
    let bench = bench();
    bench.put("f1.csv", content);
    refusal(&bench, &[&["--coeffs", "base.toml"], &FIELD[..]].concat(), 1)
}

/// The first field log with one of its lines, counted from 1, put differently.
fn with_line(number: usize, change: impl Fn(&str) -> String) -> String {
    let text = good().text("f1.csv");
    let lines = text.lines().enumerate();
    lines.map(|(k, line)| if k + 1 == number { change(line) } else { line.to_owned() } + "\n").collect()
}

/// The first field log with every value of a column put differently.
fn with_column(place: usize, change: impl Fn(f64) -> String) -> String {
    let text = good().text("f1.csv");
    let lines = text.lines().enumerate().map(|(k, line)| {
        let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
        if k > 0 {
            fields[place] = change(fields[place].parse().unwrap());
        }
        fields.join(",") + "\n"
    });
    lines.collect()
}

#[test]
fn what_is_good_is_taken() {
    let bench = bench();
    let ran = bench.done(&[&["gap", "--robot", "robot.toml", "--coeffs", "base.toml"], &FIELD[..]].concat());
    // Clean runs are fewer than six, which is all that is said.
    let said = "gmr: 3 clean runs: how much clean runs differ is not known, so small effects may be named that are none; record 3 more, and \
                fit them all\n";
    assert_eq!(ran.stderr, said);
}

#[test]
fn a_broken_log_is_refused_with_its_place() {
    let header = good().text("f1.csv").lines().next().unwrap().to_owned() + "\n";
    for (content, expected) in [
        (String::new(), "f1.csv: is empty; expected a run log"),
        (header.clone(), "f1.csv: the log has no row to use; expected at least two"),
        (with_line(2000, |line| line.replacen(',', ",x", 1)), "f1.csv:2000:wheel1_rad_s: \"x"),
        (
            with_line(700, |line| "0.5".to_owned() + &line[line.find(',').unwrap()..]),
            "f1.csv:700:time_s: time 0.5 follows",
        ),
        (with_line(900, |_| "1,2".to_owned()), "f1.csv:900: 2 fields; expected 5 as in the header"),
        (
            with_column(3, |_| "nan".to_owned()),
            "f1.csv: the log has no row to use (excluded 2500 rows with NaN, inf or no value",
        ),
        (
            with_column(4, |mass| (1000.0 * mass).to_string()),
            "f1.csv:2:mass_kg: a total mass of 1500 kg; expected from 0.2 to 30 kg",
        ),
        (with_column(4, |_| "-1".to_owned()), "f1.csv:2:mass_kg: a total mass of -1 kg; expected above 0"),
        (with_column(3, |power| (1000.0 * power).to_string()), "f1.csv: the robot takes 7"),
        (with_column(3, |_| "0".to_owned()), "f1.csv: power_w is 0 while the robot drives"),
        (with_column(0, |time| (1000.0 * time).to_string()), "f1.csv:2:time_s: the median step is 10"),
        (
            good().text("f1.csv").lines().take(8).map(|line| line.to_owned() + "\n").collect(),
            "f1.csv: no usable row: the filter",
        ),
        (
            drive(25.0, 50.0, |_| 1.5),
            "f2.csv: sampled at 100.00 Hz, but f1.csv at 50.00 Hz; expected runs of one sample rate",
        ),
        (
            header.replace("power_w", "watts") + "0,1,1,1,1\n1,1,1,1,1\n",
            "f1.csv:1: column power_w is missing; the log has:",
        ),
        (
            header.replace("wheel2_rad_s", "w2") + "0,1,1,1,1\n1,1,1,1,1\n",
            "f1.csv:1: the log has 1 wheel speed column, but robot exact",
        ),
        ("time_s,power_w\n0,1\n1,1\n".to_owned(), "f1.csv:1: no wheel speeds, but f2.csv has them; expected"),
    ] {
        // Milliseconds up to 10 s a step are taken for a slow log: the filter refuses it.
        let said = refused_log(&content);
        let other = expected.contains("median step") && said.contains("too slow for the filter");
        assert!(said.starts_with(expected) || other, "found {said:?}, expected {expected:?}");
    }
    let bench = bench();
    let said = refusal(&bench, &["--coeffs", "base.toml", "f1.csv", "f2.csv", "f3.csv", "none.csv"], 1);
    assert_eq!(said, "none.csv: No such file or directory (os error 2)");
}

/// Cut files, gaps and single bad fields cost rows, which are counted, not the answer.
#[test]
fn holes_in_a_log_are_stated_and_survived() {
    let bench = bench();
    let holes: String = good()
        .text("f1.csv")
        .lines()
        .enumerate()
        .filter(|(k, _)| !(800..1100).contains(k))
        .map(|(k, line)| if k % 97 == 96 { line.rsplit_once(',').map_or(line, |_| ",,,,").to_owned() } else { line.to_owned() } + "\n")
        .collect();
    let cut = &holes[..holes.len() - 9];
    bench.put("f1.csv", cut);
    let ran = bench.done(&[&["gap", "--robot", "robot.toml", "--coeffs", "base.toml"], &FIELD[..]].concat());
    assert!(ran.stderr.starts_with("gmr: f1.csv: excluded "), "{}", ran.stderr);
    assert!(ran.stderr.contains("1 last line without a line end"), "{}", ran.stderr);
}

#[test]
fn fewer_runs_than_a_step_needs_are_refused() {
    let bench = bench();
    let said = refusal(&bench, &["--coeffs", "base.toml", "f1.csv", "f2.csv", "f3.csv"], 1);
    assert_eq!(said, "3 runs; expected at least 4: 3 to name an effect and 1 to confirm it. Record 1 more");
}

/// A run must not confirm itself: neither by its name, nor by another name or a copy of it.
#[test]
fn a_run_that_is_there_twice_is_refused() {
    let bench = bench();
    let with = |last: &str| {
        ["--coeffs", "base.toml", "f1.csv", "f2.csv", "f3.csv", last].map(str::to_owned).to_vec()
    };
    bench.put("copy.csv", good().text("f2.csv"));
    for (last, expected) in [
        ("f1.csv", "f1.csv: the same log as f1.csv; expected every run once"),
        ("./f3.csv", "./f3.csv: the same log as f3.csv; expected every run once"),
        ("copy.csv", "copy.csv: the same log as f2.csv; expected every run once"),
        (
            "b2.csv",
            "b2.csv: the same log as ./b2.csv, to which the coefficients were fitted; expected runs of the field",
        ),
    ] {
        let arguments = with(last);
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let said = refusal(&bench, &arguments, 2);
        assert!(said.starts_with(expected), "found {said:?}, expected {expected:?}");
    }
    let said =
        refusal(&bench, &[&FIELD[..], &["--coeffs", "base.toml", "--base", "b1.csv", "f4.csv"]].concat(), 2);
    assert!(
        said.starts_with("f4.csv: the same log as f4.csv, to which the coefficients were fitted"),
        "{said}"
    );
}

#[test]
fn clean_runs_that_changed_or_went_are_noticed() {
    let bench = bench();
    let arguments = [&["--coeffs", "base.toml"], &FIELD[..]].concat();
    // One row less.
    let text = good().text("b2.csv");
    bench.put("b2.csv", &text[..text.trim_end().rfind('\n').unwrap() + 1]);
    let said = refusal(&bench, &arguments, 1);
    assert!(
        said.starts_with(
            "./b2.csv: has changed since the coefficients of base.toml were fitted to it; expected"
        ),
        "{said}"
    );
    // As many bytes, another digit.
    bench.put("b2.csv", text.replacen("0.01", "0.02", 1));
    assert!(refusal(&bench, &arguments, 1).starts_with("./b2.csv: has changed"));
    std::fs::remove_file(bench.path("b2.csv")).unwrap();
    let ran = bench.done(&[&["gap", "--robot", "robot.toml"], &arguments[..]].concat());
    assert!(ran.stderr.contains("1 of the 3 clean runs are no longer where they were"), "{}", ran.stderr);
}

#[test]
fn coefficients_that_do_not_fit_are_refused() {
    let bench = bench();
    let with = |text: String| {
        bench.put("c.toml", text);
        refusal(&bench, &[&["--coeffs", "c.toml"], &FIELD[..]].concat(), 1)
    };
    let base = good().text("base.toml");
    let older = with(base.replace("format = 1", "format = 0"));
    assert_eq!(older, "c.toml:format: format 0; expected 1, 2, 3 or 4");
    let other = with(base.replace("name = \"exact\"", "name = \"other\""));
    assert!(
        other.ends_with(": exact differs from other, which they were fitted for, in the name"),
        "{other}"
    );
    let cut = with(base[..base.find("covariance").unwrap() + 20].to_owned());
    assert!(
        cut.starts_with("c.toml:") && cut.contains("expected coefficients as gmr fit writes them"),
        "{cut}"
    );
    let negative = with(base.replace("coulomb = ", "coulomb = -"));
    assert!(
        negative.starts_with("c.toml:") && negative.contains("expected a finite number not below 0"),
        "{negative}"
    );
    let line = 1 + base.lines().position(|line| line.starts_with("covariance = ")).unwrap();
    let covariance = with(base.replace("covariance = [[", "covariance = [[1.0, "));
    let expected = format!("c.toml:{line}:covariance: expected 6 rows of 6 finite numbers");
    assert!(covariance.starts_with(&expected), "{covariance}");
    bench.done(
        &[&["fit", "--robot", "robot.toml", "--model", "eq18", "--out", "eq18.toml"], &BASE[..]].concat(),
    );
    let eq18 = refusal(&bench, &[&["--coeffs", "eq18.toml"], &FIELD[..]].concat(), 1);
    assert_eq!(eq18, "eq18.toml:model: model eq18; expected signed: effects act on its torques");
    let none = refusal(&bench, &[&["--coeffs", "none.toml"], &FIELD[..]].concat(), 1);
    assert_eq!(none, "none.toml: No such file or directory (os error 2)");
}

#[test]
fn arguments_that_make_no_sense_are_wrong_usage() {
    let bench = bench();
    for (mass, expected) in [
        ("0", "--mass: a total mass of 0 kg; expected above 0"),
        ("nan", "--mass: a total mass of NaN kg; expected above 0"),
        (
            "2500",
            "--mass: a total mass of 2500 kg; expected from 0.2 to 30 kg for robot exact (is this another unit?)",
        ),
    ] {
        assert_eq!(refusal(&bench, &[&["--mass", mass], &FIELD[..]].concat(), 2), expected);
    }
    bench.put("p.csv", "time_s,power_w\n0,1\n1,1\n");
    let power = refusal(&bench, &["--coeffs", "base.toml", "p.csv"], 2);
    assert!(
        power.starts_with("--coeffs with logs without wheel speeds: nothing can be predicted"),
        "{power}"
    );
}

/// Runs in which nothing moves: said, and nothing is named.
#[test]
fn runs_without_motion_are_said_to_show_nothing() {
    let bench = bench();
    for (k, name) in FIELD.iter().enumerate() {
        let rows = (0..2000).map(|row| {
            let noise = f64::from((row * (7919 + k as u32)) % 101) / 1000.0 - 0.05;
            format!("{:.2},0,0,{noise},2\n", f64::from(row) / 100.0)
        });
        bench.put(name, crate::common::HEADER.to_owned() + &rows.collect::<String>());
    }
    for coefficients in [&["--coeffs", "base.toml"][..], &[]] {
        let ran = bench.done(&[&["gap", "--robot", "robot.toml"], coefficients, &FIELD[..]].concat());
        assert!(ran.stderr.contains("the robot moves in none of these runs"), "{}", ran.stderr);
        assert!(ran.stdout.starts_with("NONE: "), "{}", ran.stdout);
    }
}

/// One thing that goes wrong with a log.
#[derive(Debug, Clone)]
enum Damage {
    Cut(usize),
    Byte(usize, u8),
    Field(usize, usize, &'static str),
    Line(usize),
    Twice(usize),
    Column(usize, &'static str),
}

fn damage() -> impl Strategy<Value = Damage> {
    let field = prop::sample::select(
        &[
            "", "nan", "inf", "-inf", "0", "-0", "1e308", "-1e308", "1e-320", "1e400", "x", "\"", "1,1",
            "\n", "9999999",
        ][..],
    );
    proptest::prop_oneof![
        any::<usize>().prop_map(Damage::Cut),
        (any::<usize>(), any::<u8>()).prop_map(|(at, byte)| Damage::Byte(at, byte)),
        (any::<usize>(), 0..5_usize, field.clone())
            .prop_map(|(line, place, text)| Damage::Field(line, place, text)),
        any::<usize>().prop_map(Damage::Line),
        any::<usize>().prop_map(Damage::Twice),
        (0..5_usize, field).prop_map(|(place, text)| Damage::Column(place, text)),
    ]
}

fn damaged(text: &str, damage: &Damage) -> Vec<u8> {
    let mut lines: Vec<String> = text.lines().map(|line| line.to_owned() + "\n").collect();
    let count = lines.len();
    let put = |line: &str, place: usize, text: &str| {
        let mut fields: Vec<&str> = line.trim_end().split(',').collect();
        let last = fields.len() - 1;
        fields[place.min(last)] = text;
        fields.join(",") + "\n"
    };
    match damage {
        Damage::Cut(at) => return text.as_bytes()[..at % text.len()].to_vec(),
        Damage::Byte(at, byte) => {
            let mut bytes = text.as_bytes().to_vec();
            bytes[at % text.len()] = *byte;
            return bytes;
        }
        Damage::Field(line, place, text) => lines[line % count] = put(&lines[line % count], *place, text),
        Damage::Line(line) => drop(lines.remove(line % count)),
        Damage::Twice(line) => lines.insert(line % count, lines[line % count].clone()),
        Damage::Column(place, text) => {
            for line in &mut lines[1..] {
                *line = put(line, *place, text);
            }
        }
    }
    lines.concat().into_bytes()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

    /// Through reading, conditioning and the whole workflow: an answer or an error with a text,
    /// never a panic.
    #[test]
    fn nothing_in_a_log_panics(damages in prop::collection::vec(damage(), 1..4)) {
        let folder = tempfile::tempdir().unwrap();
        let robot = Robot::parse(ROBOT).unwrap();
        let mut files: Vec<PathBuf> = Vec::new();
        for (k, mass) in [1.5, 2.5, 4.0, 5.5].into_iter().enumerate() {
            let mut text = drive(6.0, 100.0, |_| mass).into_bytes();
            if k == 1 {
                for damage in &damages {
                    if let Ok(whole) = std::str::from_utf8(&text)
                        && !whole.is_empty()
                    {
                        text = damaged(whole, damage);
                    }
                }
            }
            files.push(folder.path().join(format!("{k}.csv")));
            std::fs::write(&files[k], text).unwrap();
        }
        let [coulomb, rolling, viscous, rotor, gain, loss] = TRUTH;
        let torque = TorqueModel::from_array([coulomb, rolling, viscous, rotor, gain, loss, 0.0]);
        let base = Base { torque, covariance: None, drive: Drive::Dissipative, masses_kg: Vec::new(), of_simulator: false };
        let chassis = robot.chassis(5.0).unwrap();
        match Runs::read(&Context::default(), &robot, &chassis, &files, 2.0).and_then(|runs| investigate(&runs, None, &base, &Options::default())) {
            Ok(report) => {
                let json = gap::report::json::json(&report, gap::report::json::Beside::default());
                assert!(json["verdict"].is_string());
                gap::report::summary::text(&report);
            }
            Err(error) => assert!(!error.to_string().is_empty() && !error.to_string().contains('\n'), "{error}"),
        }
        match power_only::read(&Context::default(), &files, 1.0).and_then(|runs| power_only::investigate(&runs)) {
            Ok(report) => drop(gap::report::json::json(&report, gap::report::json::Beside::default())),
            Err(error) => assert!(!error.to_string().contains('\n'), "{error}"),
        }
    }
}
