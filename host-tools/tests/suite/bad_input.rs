//! What `gmr` does with logs, coefficients and arguments that are wrong: one line that says where
//! and what, the documented exit code, nothing on standard output, and no file changed.

use std::process::Stdio;
use std::sync::OnceLock;

use crate::common::{Bench, HEADER, ROBOT, Ran, drive};
use serde_json::Value;

/// A log that every command takes: 20 s at 1 kg, 20 s at 6 kg.
fn good() -> &'static str {
    static LOG: OnceLock<String> = OnceLock::new();
    LOG.get_or_init(|| drive(40.0, 100.0, |time| if time < 20.0 { 1.0 } else { 6.0 }))
}

/// Coefficients fitted to it.
fn coefficients() -> &'static str {
    static TEXT: OnceLock<String> = OnceLock::new();
    TEXT.get_or_init(|| {
        let bench = Bench::new();
        bench.put("robot.toml", ROBOT);
        bench.put("good.csv", good());
        bench.done(&["fit", "--robot", "robot.toml", "--out", "c.toml", "good.csv"]);
        bench.text("c.toml")
    })
}

/// Every command on `run.csv`, by its name.
const COMMANDS: [(&str, &[&str]); 5] = [
    ("fit", &["fit", "--robot", "robot.toml", "--out", "out.toml", "run.csv"]),
    ("estimate", &["estimate", "--robot", "robot.toml", "--coeffs", "c.toml", "run.csv"]),
    (
        "compare",
        &["compare", "--robot", "robot.toml", "--no-perceptron", "--plot", "out.svg", "--train", "run.csv"],
    ),
    (
        "compare with a test log",
        &["compare", "--robot", "robot.toml", "--no-perceptron", "--train", "good.csv", "--test", "run.csv"],
    ),
    ("inspect", &["inspect", "--robot", "robot.toml", "--plot", "out.svg", "run.csv"]),
];

/// Outputs of earlier commands, by their form: those that may be written over.
const OLD: [(&str, &str); 2] =
    [("out.toml", "format = 1\nmodel = \"old\"\n"), ("out.svg", "<!-- written by gmr --> old")];

/// Robot, good log, coefficients and old outputs.
fn bench() -> Bench {
    let bench = Bench::new();
    bench.put("robot.toml", ROBOT);
    bench.put("good.csv", good());
    bench.put("c.toml", coefficients());
    for (name, old) in OLD {
        bench.put(name, old);
    }
    bench
}

/// The one line of a command that failed, without `gmr: ` and line end; nothing else is to be seen
/// of it.
fn refusal(bench: &Bench, arguments: &[&str], code: i32) -> String {
    let before = bench.files();
    let Ran { code: exit, stdout, stderr } = bench.gmr(arguments);
    assert_eq!(exit, Some(code), "{arguments:?}: {stderr}");
    assert_eq!(stdout, "", "{arguments:?}");
    assert!(stderr.lines().count() == 1 && stderr.ends_with('\n'), "{arguments:?}, one line: {stderr}");
    assert_eq!(bench.files(), before, "{arguments:?} leaves no file behind");
    for (name, old) in OLD {
        assert_eq!(bench.text(name), old, "{arguments:?} leaves {name} alone");
    }
    stderr.trim_end().strip_prefix("gmr: ").unwrap_or_else(|| panic!("{arguments:?}: {stderr}")).to_owned()
}

/// Rows of the good log, without the header.
fn rows(count: usize) -> String {
    good().lines().skip(1).take(count).fold(String::new(), |text, line| text + line + "\n")
}

#[test]
fn the_good_log_is_good() {
    let bench = bench();
    bench.put("run.csv", good());
    for (name, arguments) in COMMANDS {
        let ran = bench.done(arguments);
        assert!(ran.stderr.is_empty() && !ran.stdout.is_empty(), "{name}: {}", ran.stderr);
        if name != "inspect" {
            bench.json(arguments);
        }
    }
    for (name, old) in OLD {
        assert_ne!(bench.text(name), old);
    }
}

#[test]
fn a_broken_log_is_refused_by_every_command_with_its_place() {
    let two = rows(2);
    let deep = good().replacen("\n39.5000,", "\n39.5000,x", 1);
    let cases = [
        (
            "time_s,wheel1_rad_s,wheel2_rad_s\n0,1,1\n1,1,1\n".to_owned(),
            "run.csv:1: column power_w is missing; the log has: time_s, wheel1_rad_s, wheel2_rad_s",
        ),
        (
            format!("{HEADER}{two}0.03,1,1,high,1\n"),
            "run.csv:4:power_w: \"high\" is not a number; expected a number",
        ),
        (
            format!("{HEADER}{two}0.005,1,1,1,1\n"),
            "run.csv:4:time_s: time 0.005 follows 0.01; expected time to increase from row to row (sort the rows, or tell runs apart by a column run)",
        ),
        (format!("{HEADER}{two}0.03,1,1\n"), "run.csv:4: 3 fields; expected 5 as in the header"),
        // Behind the rows that are read ahead for the sample rate.
        (deep, "run.csv:3952:wheel1_rad_s: \"x"),
        (String::new(), "run.csv: is empty; expected a run log: a CSV header and at least two rows"),
        (HEADER.to_owned(), "run.csv: the log has no row to use; expected at least two"),
        (
            "time_s,power".to_owned(),
            "run.csv:1: ends within its header; expected a CSV header and at least two rows",
        ),
        (format!("{HEADER}{}", rows(1)), "run.csv: the log has only one row to use; expected at least two"),
        (
            format!("{HEADER}{}0.01,1,1,nan,1\n0.02,1,1", rows(1)),
            "run.csv: the log has only one row to use (excluded 1 row with NaN, inf or no value (first: line 3) and 1 \
             last line without a line end (the file was cut there)); expected at least two",
        ),
        (
            "time_s,wheel1_rad_s,power_w\n0,1,1\n1,1,1\n".to_owned(),
            "run.csv:1: the log has 1 wheel speed column, but robot exact has 2 wheels: wrong robot?",
        ),
        (
            "time_s,wheel1_rad_s,wheel2_rad_s,wheel3_rad_s,power_w\n0,1,1,1,1\n1,1,1,1,1\n".to_owned(),
            "run.csv:1: the log has 3 wheel speed columns, but robot exact has 2 wheels: wrong robot?",
        ),
    ];
    let bench = bench();
    for (content, expected) in &cases {
        bench.put("run.csv", content);
        for (name, arguments) in COMMANDS {
            let said = refusal(&bench, arguments, 1);
            // A column quoted only in part: the case's last characters are the quoted field's
            // beginning.
            let matches =
                if expected.ends_with("\"x") { said.starts_with(expected) } else { said == *expected };
            assert!(matches, "{name}: found {said:?}, expected {expected:?}");
        }
    }
}

#[test]
fn a_log_that_is_not_there_is_named() {
    let bench = bench();
    for (name, arguments) in COMMANDS {
        let said = refusal(&bench, arguments, 1);
        assert_eq!(said, "run.csv: No such file or directory (os error 2)", "{name}");
    }
    std::fs::create_dir(bench.path("run.csv")).unwrap();
    for (name, arguments) in COMMANDS {
        assert_eq!(
            refusal(&bench, arguments, 1),
            "run.csv: is a folder; expected a run log (a file: CSV, MCAP, db3, ULog or Parquet), or the folder of a bag with its metadata.yaml",
            "{name}"
        );
    }
}

#[test]
fn a_mass_that_is_none_is_refused() {
    let bench = bench();
    bench.put("run.csv", good().replacen(",1\n", ",-1\n", 1));
    for (name, arguments) in &COMMANDS[..4] {
        let said = refusal(&bench, arguments, 1);
        assert_eq!(said, "run.csv:2:mass_kg: a total mass of -1 kg; expected above 0", "{name}");
    }
}

#[test]
fn rows_that_are_left_out_are_counted_once() {
    let bench = bench();
    // NaN on line 12, nothing on line 13, and half of the last line.
    let mut lines: Vec<String> = good().lines().map(str::to_owned).collect();
    for (line, value) in [(12, "NaN"), (13, "")] {
        let mut fields: Vec<&str> = lines[line - 1].split(',').collect();
        fields[3] = value;
        lines[line - 1] = fields.join(",");
    }
    let mut text = lines.join("\n");
    text.truncate(text.len() - 10);
    bench.put("run.csv", text);
    let expected = "gmr: run.csv: excluded 2 rows with NaN, inf or no value (first: line 12) and 1 last line without a \
                    line end (the file was cut there)\n";
    for (name, arguments) in &COMMANDS[..4] {
        assert_eq!(bench.done(arguments).stderr, expected, "{name}");
    }
    let report = bench.json(COMMANDS[4].1);
    assert_eq!(
        (&report["exclusions"]["non_finite"], &report["exclusions"]["cut_line"]),
        (&2.into(), &1.into())
    );
}

#[test]
fn constant_speed_and_standstill_are_said() {
    let bench = bench();
    let log = |speed: f64, power: f64| {
        (0..2000).fold(HEADER.to_owned(), |text, row| {
            text + &format!("{:.2},{speed},{speed},{power},1\n", f64::from(row) * 0.01)
        })
    };
    // Fitted, with a word on what it is worth, and no payload ever told from it.
    bench.put("run.csv", log(3.0, 0.4));
    let ran = bench.gmr(&["fit", "--robot", "burger", "--out", "one-speed.toml", "run.csv"]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let expected = "gmr: run.csv:wheel1_rad_s: constant speed only (3.000 to 3.000 rad/s): friction, inertia and losses \
                    cannot be told apart";
    assert!(ran.stderr.starts_with(expected) && ran.stderr.lines().count() == 1, "{}", ran.stderr);
    let report = bench.json(&[
        "estimate",
        "--robot",
        "burger",
        "--coeffs",
        "one-speed.toml",
        "--window",
        "5",
        "run.csv",
    ]);
    assert!(report["windows"].as_array().unwrap().iter().all(|window| window["mass_kg"].is_null()));
    let cases = [(log(0.0, 0.0), "the robot never moves (no wheel above the dead band of 0.02 rad/s)")];
    for (content, expected) in cases {
        bench.put("run.csv", content);
        for (name, arguments) in &COMMANDS[..3] {
            if *name == "estimate" {
                // Such a log is no mistake there: its masses are unknown.
                let report = bench.json(&[*arguments, &["--window", "5"]].concat());
                let windows = report["windows"].as_array().unwrap();
                assert!(windows.len() >= 10 && windows.iter().all(|window| window["mass_kg"].is_null()));
            } else {
                let said = refusal(&bench, arguments, 1);
                assert!(said.starts_with(&format!("run.csv:wheel1_rad_s: {expected}")), "{name}: {said}");
            }
        }
    }
}

/// One payload gives a model of the power, never a mass, and that is said.
#[test]
fn one_payload_only_is_said_and_gives_no_mass() {
    let bench = bench();
    bench.put("run.csv", drive(40.0, 100.0, |_| 1.0));
    let ran = bench.done(COMMANDS[0].1);
    assert!(ran.stderr.starts_with("gmr: run.csv: one payload only (1 kg): "), "{}", ran.stderr);
    assert!(ran.stderr.contains("add a run with another payload") && ran.stderr.lines().count() == 1);
    let report = bench.json(&["estimate", "--robot", "robot.toml", "--coeffs", "out.toml", "good.csv"]);
    let windows = report["windows"].as_array().unwrap();
    assert!(windows.len() > 10 && windows.iter().all(|window| window["mass_kg"].is_null()), "{windows:?}");
    let why = "the coefficients come from one payload or one speed only";
    assert!(windows.iter().all(|window| window["unknown"] == why), "{windows:?}");
    assert!(report["mape_percent"].is_null(), "without a mass there is no power");
    // It is a state of its own in the file, no error in W, and boards take it as one.
    let text = bench.text("out.toml");
    assert!(text.contains("mass = \"not-identifiable\"") && !text.contains("model_std_w"), "{text}");
    bench.done(&["flash", "--robot", "robot.toml", "--coeffs", "out.toml", "--out", "store.bin"]);
    // As it was written before there was such a state; and both estimators heed it.
    let old = text.replace("mass = \"not-identifiable\"", "model_std_w = 1000000.0");
    bench.put("old.toml", old);
    bench.done(&["fit", "--robot", "robot.toml", "--model", "eq18", "--out", "eq18.toml", "run.csv"]);
    for coefficients in ["old.toml", "eq18.toml"] {
        let again = bench.json(&["estimate", "--robot", "robot.toml", "--coeffs", coefficients, "good.csv"]);
        let windows = again["windows"].as_array().unwrap();
        assert!(windows.iter().all(|window| window["unknown"] == why), "{coefficients}: {windows:?}");
    }
    bench.put("neither.toml", text.replace("mass = \"not-identifiable\"", ""));
    // What `refusal` compares with.
    bench.put(OLD[0].0, OLD[0].1);
    let arguments = ["estimate", "--robot", "robot.toml", "--coeffs", "neither.toml", "good.csv"];
    let said = refusal(&bench, &arguments, 1);
    assert!(said.starts_with("neither.toml: missing field `model_std_w`; expected "), "{said}");
    let report = bench.json(COMMANDS[2].1);
    assert!(report["models"].as_array().unwrap().len() >= 4);
}

#[test]
fn runs_of_one_row_have_no_sample_rate() {
    let bench = bench();
    let log = (0..50).fold("time_s,wheel1_rad_s,wheel2_rad_s,power_w,run\n".to_owned(), |text, row| {
        text + &format!("{row},1,1,1,r{row}\n")
    });
    bench.put("run.csv", log);
    for (name, arguments) in &COMMANDS[..4] {
        let said = refusal(&bench, arguments, 1);
        assert_eq!(said, "run.csv:run: no two rows belong to one run; expected runs of many rows", "{name}");
    }
}

#[test]
fn a_log_too_slow_for_the_filter_says_which_would_do() {
    let bench = bench();
    bench.put("run.csv", drive(100.0, 10.0, |time| if time < 50.0 { 1.0 } else { 6.0 }));
    let expected = "run.csv: sampled at 10.00 Hz, too slow for the filter's cutoff of 20 Hz; expected a cutoff below \
                    4.50 Hz (filter_cutoff_hz in robot.toml)";
    for (name, arguments) in &COMMANDS[..4] {
        assert_eq!(refusal(&bench, arguments, 1), expected, "{name}");
    }
}

#[test]
fn too_short_a_log_says_how_long_it_has_to_be() {
    let bench = bench();
    bench.put("run.csv", format!("{HEADER}{}", rows(8)));
    let said = refusal(&bench, COMMANDS[0].1, 1);
    let expected = "run.csv: no usable row: the filter (cutoff 20 Hz) needs 0.1 s to settle after each start and gap; \
                    expected a longer log";
    assert_eq!(said, expected);
    assert_eq!(refusal(&bench, COMMANDS[2].1, 1), expected);
    assert_eq!(refusal(&bench, COMMANDS[3].1, 1), "run.csv: no usable row to evaluate on");
    let report = bench.json(COMMANDS[1].1);
    assert_eq!(report["windows"].as_array().unwrap().len(), 0);
    bench.put("run.csv", format!("{HEADER}{}", rows(900)));
    let said = refusal(&bench, &[COMMANDS[2].1, &["--block", "5"]].concat(), 1);
    assert_eq!(said, "run.csv: the log is too short to hold out blocks of 5 s; expected at least 15 s");
}

fn estimate(bench: &Bench, text: &str) -> String {
    bench.put("wrong.toml", text);
    refusal(bench, &["estimate", "--robot", "robot.toml", "--coeffs", "wrong.toml", "good.csv"], 1)
}

/// `coefficients()` with the line of `key` replaced.
fn with(key: &str, line: &str) -> String {
    let replaced = coefficients().lines().map(|old| {
        let is_it = old.split_once('=').is_some_and(|(name, _)| name.trim() == key);
        if is_it { line } else { old }
    });
    replaced.collect::<Vec<_>>().join("\n")
}

#[test]
fn wrong_coefficients_are_named_with_their_line() {
    let bench = bench();
    let line = |key: &str| {
        1 + coefficients().lines().position(|line| line.starts_with(&format!("{key} = "))).unwrap()
    };
    for (key, value, shown) in [
        ("viscous", "-0.001", "-0.001"),
        ("coulomb", "-1", "-1"),
        ("rolling", "nan", "NaN"),
        ("winding_loss", "inf", "inf"),
        ("density_w2_s", "-1.0", "-1"),
        ("filter_cutoff_hz", "nan", "NaN"),
    ] {
        let expected =
            format!("wrong.toml:{}:{key}: found {shown}; expected a finite number not below 0", line(key));
        assert_eq!(estimate(&bench, &with(key, &format!("{key} = {value}"))), expected);
    }
    let slow = format!(
        "wrong.toml:{}:filter_cutoff_hz: found 0.001; expected 0.1 or more: a slower filter settles too late for any mass",
        line("filter_cutoff_hz")
    );
    assert_eq!(estimate(&bench, &with("filter_cutoff_hz", "filter_cutoff_hz = 0.001")), slow);
    assert_eq!(
        estimate(&bench, &with("format", "format = 5")),
        "wrong.toml:format: format 5; expected 1, 2, 3 or 4"
    );
    let missing = estimate(&bench, &with("viscous", ""));
    assert_eq!(missing, "wrong.toml:parameters: viscous is missing or not a number");
    let text = estimate(&bench, &with("viscous", "viscous = \"much\""));
    assert_eq!(text, "wrong.toml:parameters: viscous is missing or not a number");
    let model = estimate(&bench, &with("model", "model = \"signd\""));
    assert!(model.starts_with("wrong.toml:2: unknown variant `signd`"), "{model}");
    let said = refusal(&bench, &["estimate", "--coeffs", "lost.toml", "good.csv"], 1);
    assert_eq!(said, "lost.toml: No such file or directory (os error 2)");
    assert_eq!(
        refusal(&bench, &["estimate", "good.csv"], 2),
        "the following required arguments were not provided: --coeffs <C.toml>"
    );
}

/// A covariance that none can be is refused where it is read, whoever reads it.
#[test]
fn a_covariance_that_is_none_is_named() {
    let bench = bench();
    let text = coefficients();
    let line = 1 + text.lines().position(|line| line.starts_with("covariance = ")).unwrap();
    let document: toml::Table = text.parse().unwrap();
    let rows = document["fit"]["covariance"].as_array().unwrap();
    let entry = |row: usize, column: usize| rows[row].as_array().unwrap()[column].as_float().unwrap();
    let with = |row: usize, column: usize, value: f64| {
        let mut document = document.clone();
        let fit = document["fit"].as_table_mut().unwrap();
        let row = fit["covariance"].as_array_mut().unwrap()[row].as_array_mut().unwrap();
        row[column] = toml::Value::Float(value);
        estimate(&bench, &toml::to_string(&document).unwrap())
    };
    let first = |said: String, says: &str| {
        let expected = format!("wrong.toml:{line}:covariance: {says}");
        assert!(said.starts_with(&expected), "{said}");
    };
    first(with(1, 2, f64::NAN), "expected 6 rows of 6 finite numbers");
    first(with(2, 2, -1.0), "the variance in row 3 is -1; expected 0 or more");
    let skewed = entry(0, 1) + 0.1 * (entry(0, 0) * entry(1, 1)).sqrt();
    first(with(0, 1, skewed), "");
    assert!(with(0, 1, skewed).contains("in row 1, column 2, but "), "{}", with(0, 1, skewed));
}

/// However much of the file a copy lost, it is refused.
#[test]
fn coefficients_cut_anywhere_are_refused() {
    let bench = bench();
    let text = coefficients().trim_end();
    for length in (0..text.len()).step_by(41) {
        let Some(cut) = text.get(..length) else { continue };
        let said = estimate(&bench, cut);
        assert!(said.starts_with("wrong.toml:") && said.contains("expected"), "{length}: {said}");
    }
}

#[test]
fn coefficients_of_another_robot_are_refused() {
    let bench = bench();
    let other = |robot: &str| {
        bench.put("other.toml", robot);
        refusal(&bench, &["estimate", "--robot", "other.toml", "--coeffs", "c.toml", "good.csv"], 1)
    };
    let cases = [
        ("\"exact\"", "\"inexact\"", "the name"),
        ("track_m = 0.16", "track_m = 0.17", "the wheels' geometry"),
        ("gyration_radius_m = 0.06", "gyration_radius_m = 0.07", "the gyration radius"),
        ("full_load_kg = 6", "full_load_kg = 7", "the masses"),
        ("\"differential\"", "\"skid-steer\"", "the kind of steering"),
    ];
    for (old, new, difference) in cases {
        let said = other(&ROBOT.replace(old, new));
        assert!(said.starts_with("c.toml:robot: these coefficients are for another robot: "), "{said}");
        let expected = format!(" differs from exact, which they were fitted for, in {difference}");
        assert!(said.ends_with(&expected), "{said}");
    }
    // What decides what counts as motion and as power says both values.
    for (key, here) in [("regeneration", "true"), ("speed_dead_band_rad_s", "0.5")] {
        let there = coefficients().lines().find_map(|line| line.strip_prefix(&format!("{key} = "))).unwrap();
        let said = other(&format!("{key} = {here}\n{ROBOT}"));
        let expected = format!(
            "c.toml:robot: these coefficients are for another robot: {key} = {here} of exact, but fitted with {there}"
        );
        assert_eq!(said, expected);
    }
    let said = other(&ROBOT.replace("\"differential\"", "\"skid-steer\"\nwheels = 4"));
    assert_eq!(said, "c.toml:robot: fitted for a robot with 2 wheels; expected 4: wrong robot?");
}

#[test]
fn wrong_usage_is_one_line_and_exit_code_2() {
    let bench = bench();
    let estimate = |rest: &[&'static str]| {
        [&["estimate", "--robot", "robot.toml", "--coeffs", "c.toml", "good.csv"], rest].concat()
    };
    let compare =
        |rest: &[&'static str]| [&["compare", "--robot", "robot.toml", "--train", "good.csv"], rest].concat();
    let fit = |rest: &[&'static str]| [&["fit", "--robot", "robot.toml", "good.csv"], rest].concat();
    let allowed = "expected 0.8 s to 512 s, a multiple of 0.1 s";
    let cases = [
        (estimate(&["--window", "0"]), allowed),
        (estimate(&["--window=-5"]), allowed),
        (estimate(&["--window", "nan"]), allowed),
        (estimate(&["--window", "1e9"]), allowed),
        (estimate(&["--window", "0.85"]), allowed),
        (
            estimate(&["--schedule", "periodic", "--every", "5"]),
            "--every 5: expected at least the window of 25 s",
        ),
        (estimate(&["--changes=-3"]), "--changes -3: expected times in s since the start of the log"),
        (
            estimate(&["--schedule", "never"]),
            "invalid value 'never' for '--schedule <SCHEDULE>' [possible values: moving,",
        ),
        (compare(&["--window", "0"]), allowed),
        (compare(&["--block", "0"]), "--block 0: expected a length above 0 s"),
        (compare(&["--mass", "0"]), "--mass 0: expected a mass above 0 kg"),
        (compare(&["--window", "-5"]), "--window -5: expected 0.8 s"),
        (compare(&["--block", "-1"]), "--block -1: expected a length above 0 s"),
        (compare(&["--mass", "-1"]), "--mass -1: expected a mass above 0 kg"),
        (compare(&["--block", "4", "--test", "good.csv"]), "'--block <S>' cannot be used with '--test"),
        (compare(&["--plot", "out.pdf"]), "out.pdf"),
        (
            fit(&["--model", "newton"]),
            "invalid value 'newton' for '--model <MODEL>' [possible values: signed, eq18, eq18-published]",
        ),
        (fit(&["--method", "guess"]), "[possible values: physical, nnls, pgd]"),
        (fit(&["--method", "nnls"]), "--model signed is fitted with --method physical"),
        (fit(&["--model", "eq18", "--method", "physical"]), "--method physical fits --model signed"),
        (fit(&["--mass", "nan"]), "--mass NaN: expected a mass above 0 kg"),
        (fit(&["--learning-rate", "0", "--model", "eq18"]), "--learning-rate 0: expected a number above 0"),
        (fit(&["--momentum", "1"]), "--momentum 1: expected 0 to below 1"),
        (fit(&["--robot", "burgr"]), "the argument '--robot <ROBOT>' cannot be used multiple times"),
        (vec!["fit", "--robot", "burgr", "good.csv"], "no robot is called burgr"),
        (vec!["fit"], "the following required arguments were not provided: <LOG[=KG]>..."),
        (vec!["fot"], "unrecognized subcommand 'fot'"),
    ];
    for (arguments, expected) in cases {
        let said = refusal(&bench, &arguments, 2);
        assert!(said.contains(expected), "{arguments:?}: {said}");
    }
}

#[test]
fn an_output_that_cannot_be_written_is_named() {
    let bench = bench();
    let missing = "the folder nowhere does not exist; expected one to write into";
    let fit = ["fit", "--robot", "robot.toml", "good.csv", "--out"];
    let said = refusal(&bench, &[&fit[..], &["nowhere/c.toml"]].concat(), 1);
    assert_eq!(said, format!("nowhere/c.toml: {missing}"));
    for (name, start) in [("compare", "--train"), ("inspect", "--robot=robot.toml")] {
        let arguments = match name {
            "compare" => vec![name, "--no-perceptron", "--robot", "robot.toml", start, "good.csv"],
            _ => vec![name, start, "good.csv"],
        };
        let said = refusal(&bench, &[&arguments[..], &["--plot", "nowhere/a.svg"]].concat(), 1);
        assert_eq!(said, format!("nowhere/a.svg: {missing}"));
    }
    std::fs::create_dir(bench.path("folder")).unwrap();
    let said = refusal(&bench, &[&fit[..], &["folder"]].concat(), 1);
    assert!(said.starts_with("folder: "), "{said}");
}

/// What is written has the usual permissions, goes through links, and is the same on every run.
#[cfg(unix)]
#[test]
fn files_are_written_as_other_programs_write_them() {
    use std::os::unix::fs::{PermissionsExt as _, symlink};
    let bench = bench();
    let fit = ["fit", "--robot", "robot.toml", "good.csv", "--out"];
    bench.done(&[&fit[..], &["new.toml"]].concat());
    let mode = |name: &str| bench.path(name).metadata().unwrap().permissions().mode();
    assert_eq!(mode("new.toml"), mode("robot.toml"), "what the umask leaves");
    symlink(bench.path("out.toml"), bench.path("link.toml")).unwrap();
    bench.done(&[&fit[..], &["link.toml"]].concat());
    assert!(bench.path("link.toml").is_symlink());
    assert_eq!(bench.text("out.toml"), bench.text("new.toml"));
    symlink("/dev/null", bench.path("null")).unwrap();
    bench.done(&[&fit[..], &["null"]].concat());
    assert!(bench.path("null").is_symlink(), "a device is no file to replace");
}

/// `gmr … | head -1`: whoever reads has seen enough, and that is no failure.
#[test]
fn a_closed_pipe_is_a_quiet_end() {
    let bench = bench();
    bench.put("run.csv", good());
    let log = ["simulate", "--duration", "20", "--out", "-"];
    for (name, arguments) in COMMANDS.into_iter().chain([("simulate", &log[..])]) {
        for json in [false, true] {
            if json && name == "simulate" {
                continue;
            }
            let mut child = std::process::Command::new(assert_cmd::cargo::cargo_bin!("gmr"))
                .current_dir(bench.path(""))
                .args(arguments)
                .args(json.then_some("--json"))
                .stdout(Stdio::piped())
                .stderr(Stdio::piped())
                .spawn()
                .unwrap();
            drop(child.stdout.take());
            let output = child.wait_with_output().unwrap();
            let text = String::from_utf8(output.stderr).unwrap();
            assert_eq!((output.status.code(), text.as_str()), (Some(0), ""), "{name}");
        }
    }
}

/// A full disk behind standard output is a failure that is told.
#[cfg(target_os = "linux")]
#[test]
fn standard_output_that_takes_nothing_is_an_error() {
    let bench = bench();
    bench.put("run.csv", good());
    for (name, arguments) in COMMANDS {
        let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
        let output = std::process::Command::new(assert_cmd::cargo::cargo_bin!("gmr"))
            .current_dir(bench.path(""))
            .args(arguments)
            .stdout(full)
            .output()
            .unwrap();
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{name}");
        assert_eq!(text, "gmr: standard output: No space left on device (os error 28)\n", "{name}");
    }
}

/// JSON is all that is on standard output, also where something was left out.
#[test]
fn exclusions_do_not_disturb_the_json() {
    let bench = bench();
    bench.put("run.csv", format!("{}40.00,1,1,nan,6\n", good()));
    for (name, arguments) in &COMMANDS[..4] {
        let report: Value = bench.json(arguments);
        assert!(report.is_object(), "{name}");
    }
}
