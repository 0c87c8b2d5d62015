//! Effects of the user's own: what the dictionary lacks is named with a formula for it, and is
//! `unexplained` without.

use std::fmt::Write as _;
use std::sync::OnceLock;

use crate::common::{Bench, number, simulate};
use serde_json::Value;

/// Masses of the field runs, kg.
const FIELD: [&str; 8] = ["1.2", "5.6", "2.4", "4.1", "3.3", "1.8", "5.0", "2.9"];

/// An arm at 12 V that draws up to 0.1 A.
const ARM: &str = "[[effect]]\nid = \"arm\"\nmeaning = \"the arm's motor\"\nformula = \"12 * arm_a\"\nunit = \"1\"\n\
                   sign = \"positive\"\nrange = [0, 3]\n";

/// A door that brakes in proportion to the left wheel's speed while it is open.
const DOOR: &str = "[[effect]]\nname = \"door\"\nformula = \"0.5 * abs(wheel1_rad_s) * door_open\"\nunit = \"N·m\"\n\
                    sign = \"either\"\nrange = [-5, 5]\n";

/// Runs of a robot with gear motors, 60 s at 20 Hz with 0.05 W of noise: six without any effect,
/// and those of the field.
fn plain() -> &'static Bench {
    static BENCH: OnceLock<Bench> = OnceLock::new();
    BENCH.get_or_init(|| {
        let bench = Bench::new();
        let masses: Vec<String> = (1..=6).map(|mass| mass.to_string()).collect();
        let clean = masses.iter().map(String::as_str).enumerate().map(|(k, mass)| ("base", k, mass));
        let field = FIELD.into_iter().enumerate().map(|(k, mass)| ("field", k, mass));
        for (kind, k, mass) in clean.chain(field) {
            let seed = if kind == "base" { 100 + k } else { 200 + k };
            simulate(&bench, &format!("{kind}_{}.csv", k + 1), k, mass, seed, &[]);
        }
        bench
    })
}

/// A run with a further column, and with the power that comes with it; `of` gives both from time
/// and speed of the left wheel.
fn with_column(text: &str, name: &str, of: impl Fn(f64, f64) -> (f64, f64)) -> String {
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let place = |name: &str| header.iter().position(|column| *column == name).unwrap();
    let (time, speed, power) = (place("time_s"), place("wheel1_rad_s"), place("power_w"));
    let mut out = format!("{},{name}\n", header.join(","));
    for line in lines {
        let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
        let value = |place: usize| fields[place].parse::<f64>().unwrap();
        let (column, more) = of(value(time), value(speed));
        fields[power] = (value(power) + more).to_string();
        writeln!(out, "{},{column}", fields.join(",")).unwrap();
    }
    out
}

/// A further column and the power that comes with it, from time and speed of the left wheel.
type More = fn(f64, f64) -> (f64, f64);

/// A folder with the runs; what their further column holds is given for clean runs and for those of
/// the field.
fn set(name: &str, clean: Option<More>, field: More) -> Bench {
    let bench = Bench::new();
    for file in plain().files() {
        let text = plain().text(&file);
        let text = match (file.starts_with("field"), clean) {
            (true, _) => with_column(&text, name, field),
            (false, Some(clean)) => with_column(&text, name, clean),
            (false, None) => text,
        };
        bench.put(&file, text);
    }
    let base = ["base_1.csv", "base_2.csv", "base_3.csv", "base_4.csv", "base_5.csv", "base_6.csv"];
    bench.done(&[&["fit", "--out", "base.toml"], &base[..]].concat());
    bench.put("arm.toml", ARM);
    bench.put("door.toml", DOOR);
    bench
}

fn gap(bench: &Bench, more: &[&str]) -> Value {
    let names: Vec<String> = (1..=FIELD.len()).map(|k| format!("field_{k}.csv")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    bench.json(&[&["gap", "--coeffs", "base.toml"], &names[..], more].concat())
}

/// Current of an arm that moves for 3 s of 11, in two strengths, A.
fn arm_current(time: f64) -> f64 {
    if time % 11.0 < 3.0 { if time % 22.0 < 11.0 { 0.02 } else { 0.01 } } else { 0.0 }
}

fn arm(time: f64, _: f64) -> (f64, f64) {
    (arm_current(time), 12.0 * arm_current(time))
}

fn only_named(report: &Value, id: &str) -> f64 {
    assert_eq!(report["verdict"], "named", "{report:#}");
    assert_eq!(report["effects"].as_array().unwrap().len(), 1, "{report:#}");
    let effect = &report["effects"][0];
    assert_eq!(effect["id"], id);
    assert!(number(&report["gap_closed"]) > 0.8, "{report:#}");
    number(&effect["coefficient"])
}

#[test]
fn what_the_dictionary_lacks_is_named_by_its_formula_and_unexplained_without() {
    let bench = set("arm_a", None, arm);
    let report = gap(&bench, &["--effects", "arm.toml"]);
    let coefficient = only_named(&report, "arm");
    assert!((coefficient - 1.0).abs() < 0.1, "{coefficient}");
    let effect = &report["effects"][0];
    assert_eq!(effect["unit"], "1");
    assert_eq!(effect["detail"]["formula"], "12 * arm_a");
    assert_eq!(effect["detail"]["meaning"], "the arm's motor");
    assert_eq!(effect["detail"]["sign"], "positive");
    assert_eq!(effect["detail"]["range"], serde_json::json!([0.0, 3.0]));
    // The residual is mapped by the formula, too.
    let axes = report["localisation"].as_array().unwrap().iter();
    assert!(axes.filter(|cell| cell["axis"] == "formula of arm").count() > 0, "{report:#}");

    let without = gap(&bench, &[]);
    assert_eq!(without["verdict"], "unexplained", "{without:#}");
    assert_eq!(without["effects"], Value::Array(Vec::new()));
}

/// Door open in every second third of a minute; the drag is 0.5 · 0.4 N·m on the left wheel.
#[test]
fn a_formula_of_motion_and_a_column_is_named() {
    fn open(time: f64) -> f64 {
        f64::from(u8::from(time % 20.0 < 8.0))
    }
    let bench = set("door_open", Some(|_, _| (0.0, 0.0)), |time, speed| {
        (open(time), 0.2 * 0.5 * speed.abs() * open(time))
    });
    let coefficient = only_named(&gap(&bench, &["--effects", "door.toml"]), "door");
    assert!((coefficient - 0.2).abs() < 0.03, "{coefficient}");
}

/// A sign that is not allowed is no name.
#[test]
fn a_formula_of_the_wrong_sign_explains_nothing() {
    let bench = set("arm_a", None, arm);
    bench.put("arm.toml", ARM.replace("positive", "negative").replace("[0, 3]", "[-3, 0]"));
    let report = gap(&bench, &["--effects", "arm.toml"]);
    assert_eq!(report["verdict"], "unexplained", "{report:#}");
}

/// Also a coefficient beyond the range.
#[test]
fn a_coefficient_beyond_the_range_is_no_name() {
    let bench = set("arm_a", None, arm);
    bench.put("arm.toml", ARM.replace("[0, 3]", "[0, 0.5]"));
    let report = gap(&bench, &["--effects", "arm.toml"]);
    assert_eq!(report["verdict"], "unexplained", "{report:#}");
}

/// The arm took its power in the clean runs already: nothing is new in the field.
#[test]
fn what_the_clean_runs_have_already_is_no_gap() {
    let bench = set("arm_a", Some(arm), arm);
    let report = gap(&bench, &["--effects", "arm.toml"]);
    assert_eq!(report["verdict"], "none", "{report:#}");
}

#[test]
fn a_formula_over_a_column_that_runs_lack_is_not_testable() {
    let bench = set("arm_a", None, |time, _| (arm_current(time), 0.0));
    let both = format!("{ARM}{}", DOOR.replace("door_open", "door_open * door_angle"));
    bench.put("arm.toml", both);
    // One of the runs lacks the arm's current.
    bench.put("field_3.csv", plain().text("field_3.csv"));
    let report = gap(&bench, &["--effects", "arm.toml"]);
    let reason = |id: &str| {
        let missing = report["not_testable"].as_array().unwrap();
        missing.iter().find(|entry| entry["id"] == id).unwrap()["reason"].clone()
    };
    assert_eq!(reason("arm"), "needs arm_a, which field_3.csv lacks");
    assert_eq!(reason("door"), "needs door_angle, door_open");
    assert_eq!(report["verdict"], "none", "{report:#}");
}

/// A power of a part of the robot may be named, though powers are no columns to look at otherwise.
#[test]
fn a_formula_may_name_a_power() {
    let bench = set("arm_w", None, |time, _| (12.0 * arm_current(time), 12.0 * arm_current(time)));
    bench.put("arm.toml", ARM.replace("12 * arm_a", "arm_w"));
    let coefficient = only_named(&gap(&bench, &["--effects", "arm.toml"]), "arm");
    assert!((coefficient - 1.0).abs() < 0.1, "{coefficient}");
}

#[test]
fn a_file_that_is_wrong_is_refused_in_one_line() {
    let bench = set("arm_a", None, arm);
    let refused = |content: &str| {
        bench.put("mine.toml", content);
        let logs = ["field_1.csv", "field_2.csv", "field_3.csv", "field_4.csv"];
        let ran =
            bench.gmr(&[&["gap", "--coeffs", "base.toml", "--effects", "mine.toml"], &logs[..]].concat());
        assert_eq!((ran.code, ran.stdout.as_str()), (Some(1), ""), "{}", ran.stderr);
        assert_eq!(ran.stderr.lines().count(), 1, "{}", ran.stderr);
        ran.stderr.trim_end().to_owned()
    };
    let taken = refused(&ARM.replace("\"arm\"", "\"sensor-gain\""));
    assert!(taken.starts_with("gmr: mine.toml:2:6: the id \"sensor-gain\" is in the dictionary"), "{taken}");
    let formula = refused(&ARM.replace("12 *", "12 +*"));
    assert!(formula.starts_with("gmr: mine.toml:4:11: \"12 +* arm_a\": "), "{formula}");
    let infinite = refused(&ARM.replace("12 * arm_a", "ln(arm_a - 1)"));
    assert!(
        infinite.starts_with("gmr: mine.toml:4: the formula of arm is NaN at ")
            && infinite.contains("field_1.csv"),
        "{infinite}"
    );
    let nothing = refused("");
    assert!(nothing.starts_with("gmr: mine.toml:1:1: missing field `effect`"), "{nothing}");
}
