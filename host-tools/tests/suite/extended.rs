//! Coefficients with effects: what `gmr gap --out` writes, who takes it, and what is refused by
//! name.

use std::sync::OnceLock;

use crate::common::{Bench, number, simulate};
use serde_json::Value;

/// Field runs: masses that the base has not seen.
const FIELD: [&str; 6] = ["1.2", "5.6", "2.4", "4.1", "3.3", "1.8"];

/// Six clean runs with the coefficients fitted to them, and field runs on a slope that rises ahead.
fn sloped() -> &'static Bench {
    static BENCH: OnceLock<Bench> = OnceLock::new();
    BENCH.get_or_init(|| {
        let bench = Bench::new();
        let names: Vec<String> = (1..=6).map(|k| format!("base_{k}.csv")).collect();
        for (k, name) in names.iter().enumerate() {
            simulate(&bench, name, k, &(k + 1).to_string(), 100 + k, &[]);
        }
        bench.done(&with_files(&["fit", "--out", "base.toml"], &names));
        for (k, mass) in FIELD.iter().enumerate() {
            simulate(&bench, &field(k), k, mass, 200 + k, &["--effect", "grade=0.02:along=travel"]);
        }
        bench
    })
}

fn field(k: usize) -> String {
    format!("field_{k}.csv")
}

fn with_files<'a>(arguments: &[&'a str], files: &'a [String]) -> Vec<&'a str> {
    arguments.iter().copied().chain(files.iter().map(String::as_str)).collect()
}

/// A folder of its own with the files of [`sloped`], extended coefficients among them.
fn extended() -> Bench {
    let bench = Bench::new();
    for name in sloped().files() {
        bench.put(&name, std::fs::read(sloped().path(&name)).unwrap());
    }
    let fields: Vec<String> = (0..FIELD.len()).map(field).collect();
    let gap = bench.json(&with_files(&["gap", "--coeffs", "base.toml", "--out", "extended.toml"], &fields));
    assert_eq!(gap["verdict"], "named", "{gap:#}");
    bench
}

fn numbers(row: &toml::Value) -> Vec<f64> {
    row.as_array().unwrap().iter().map(|value| value.as_float().unwrap()).collect()
}

fn estimate(bench: &Bench, coefficients: &str, log: &str) -> Value {
    bench.json(&["estimate", "--coeffs", coefficients, log])
}

/// The line that a refused command says, and nothing on standard output.
fn refusal(bench: &Bench, arguments: &[&str]) -> String {
    let ran = bench.gmr(arguments);
    assert_eq!(ran.code, Some(1), "{arguments:?}: {}", ran.stderr);
    assert_eq!(ran.stdout, "");
    assert_eq!(ran.stderr.lines().count(), 1, "{}", ran.stderr);
    ran.stderr.trim_end().to_owned()
}

/// What is said behind a change of the extended coefficients' text.
fn refused(bench: &Bench, from: &str, to: &str) -> String {
    let text = bench.text("extended.toml");
    assert!(text.contains(from), "{from}: {text}");
    bench.put("changed.toml", text.replacen(from, to, 1));
    refusal(bench, &["estimate", "--coeffs", "changed.toml", &field(0)])
}

#[test]
fn what_gap_writes_estimate_and_flash_take() {
    let bench = extended();
    let (base, written) = (bench.text("base.toml"), bench.text("extended.toml"));
    // The fit's section is kept, and with it who the clean runs are.
    let fit = |text: &str| {
        let document: toml::Table = toml::from_str(text).unwrap();
        document["fit"].clone()
    };
    assert_eq!(fit(&base), fit(&written));
    // What is known of base and slope jointly: eight rows of eight, the base's as they were. Masses
    // are no surer than without a slope.
    let document: toml::Table = toml::from_str(&written).unwrap();
    let rows = |value: &toml::Value| value.as_array().unwrap().iter().map(numbers).collect::<Vec<_>>();
    let joint = rows(&document["extension"]["joint_covariance"]);
    let clean = rows(&fit(&base)["covariance"]);
    assert_eq!(joint.len(), clean.len() + 1);
    for (joint, clean) in joint.iter().zip(&clean) {
        assert_eq!((&joint[..clean.len()], joint[clean.len()]), (&clean[..], 0.0));
    }
    let std_err = document["effects"][0]["std_err"].as_float().unwrap();
    let variance = joint[clean.len()][clean.len()];
    assert!((variance / (std_err * std_err) - 1.0).abs() < 1e-9, "{variance} {std_err}");
    let model_std = |text: &str| {
        let document: toml::Table = toml::from_str(text).unwrap();
        document["noise"]["model_std_w"].as_float().unwrap()
    };
    assert!(model_std(&written) >= model_std(&base), "{} {}", model_std(&written), model_std(&base));
    // On every field run the power's error shrinks by half at least, though its mass is unknown.
    for k in 0..FIELD.len() {
        let [before, after] =
            ["base.toml", "extended.toml"].map(|file| number(&estimate(&bench, file, &field(k))["rmse_w"]));
        assert!(after < 0.5 * before, "{k}: {before} {after}");
    }
    // The base has a gear's loss, with which an image has all traits: ten bytes more a column.
    let flash = |coefficients: &str, out: &str| {
        let report = bench.json(&["flash", "--coeffs", coefficients, "--out", out]);
        let items = report["items"].as_array().unwrap().clone();
        items.iter().find(|item| item["item"] == "coefficients").unwrap()["bytes"].clone()
    };
    assert_eq!(
        (flash("base.toml", "base.bin"), flash("extended.toml", "extended.bin")),
        (168.into(), 178.into())
    );
    let again = refusal(&bench, &["gap", "--coeffs", "extended.toml", "field_0.csv"]);
    assert!(again.starts_with("gmr: extended.toml:effects: they hold the effect grade already"), "{again}");
}

#[test]
fn what_no_robot_has_is_refused_by_name_and_line() {
    let bench = extended();
    let text = bench.text("extended.toml");
    let line = |key: &str| {
        let effects = text.lines().position(|line| line == "[[effects]]").unwrap();
        let within = text.lines().skip(effects).position(|line| line.starts_with(key)).unwrap();
        effects + within + 1
    };
    let unknown = refused(&bench, "id = \"grade\"", "id = \"perpetuum\"");
    let expected = format!(
        "gmr: changed.toml:{}:id: effect `perpetuum`; expected one of grade, winding-temperature, ",
        line("id")
    );
    assert!(unknown.starts_with(&expected), "{unknown}");
    let flashed = refusal(&bench, &["flash", "--coeffs", "changed.toml", "--out", "store.bin"]);
    assert_eq!(flashed, unknown);
    assert!(!bench.files().contains(&"store.bin".to_owned()));

    let coefficient = text.lines().find(|line| line.starts_with("coefficient = ")).unwrap().to_owned();
    for (value, says) in [
        ("nan", "grade has a coefficient or a detail that no robot has"),
        ("inf", "grade has a coefficient or a detail that no robot has"),
        ("1e9", "grade with coefficient 1000000000 makes powers that no robot draws"),
    ] {
        let line = format!("gmr: changed.toml:{}:coefficient: {says}", line("coefficient"));
        let said = refused(&bench, &coefficient, &format!("coefficient = {value}"));
        assert!(said.starts_with(&line), "{said}");
    }
    let mislabel = refused(&bench, "id = \"grade\"", "id = \"payload-mislabel\"");
    assert!(mislabel.contains("a finding about runs, not about a robot"), "{mislabel}");
    let detail = refused(&bench, "along = \"the way ahead\"", "along = \"the river\"");
    assert!(detail.contains(":detail: grade without a detail; expected by = \"pitch_rad\""), "{detail}");
    let twice = format!(
        "{text}\n[[effects]]\nid = \"grade\"\n{coefficient}\nunit = \"1\"\nstd_err = 0.1\n\n[effects.detail]\nalong = \"the way ahead\"\n"
    );
    bench.put("twice.toml", twice);
    let twice = refusal(&bench, &["estimate", "--coeffs", "twice.toml", &field(0)]);
    assert!(twice.contains("grade stands here twice"), "{twice}");
    let model = refused(&bench, "model = \"signed\"", "model = \"eq18\"");
    assert!(model.contains("changed.toml"), "{model}");
}

/// A slope by the measured pitch runs on the host, which has the column; a board has not, and is
/// not given it.
#[test]
fn what_a_board_does_not_measure_stays_on_the_host() {
    let bench = extended();
    simulate(
        &bench,
        "pitched.csv",
        1,
        "3.3",
        300,
        &["--effect", "grade=0.03:heading=0.4", "--columns", "pitch"],
    );
    // The weight is multiplied by what multiplies the inertia.
    let text = bench.text("extended.toml");
    let gain = text.lines().find_map(|line| line.strip_prefix("inertia_gain = ")).unwrap().to_owned();
    let coefficient = text.lines().find(|line| line.starts_with("coefficient = ")).unwrap().to_owned();
    let text = text.replace("along = \"the way ahead\"", "by = \"pitch_rad\"");
    bench.put("pitch.toml", text.replace(&coefficient, &format!("coefficient = {gain}")));
    let [before, after] =
        ["base.toml", "pitch.toml"].map(|file| number(&estimate(&bench, file, "pitched.csv")["rmse_w"]));
    assert!(after < 0.5 * before, "{before} {after}");
    let missing = refusal(&bench, &["estimate", "--coeffs", "pitch.toml", &field(0)]);
    assert_eq!(
        missing,
        "gmr: field_0.csv:pitch_rad: no such column; expected one, for the coefficients' effect grade needs it"
    );
    let board = refusal(&bench, &["flash", "--coeffs", "pitch.toml", "--out", "store.bin"]);
    assert!(
        board.starts_with("gmr: pitch.toml: no board would use them: an effect by what the board"),
        "{board}"
    );
    assert!(board.ends_with("grade by pitch_rad"), "{board}");
}

/// Where nothing is named nothing is written, and it is said.
#[test]
fn nothing_named_is_nothing_written() {
    let bench = Bench::new();
    for name in sloped().files() {
        bench.put(&name, std::fs::read(sloped().path(&name)).unwrap());
    }
    let names: Vec<String> = (0..4).map(|k| format!("quiet_{k}.csv")).collect();
    for (k, name) in names.iter().enumerate() {
        simulate(&bench, name, k, FIELD[k], 400 + k, &[]);
    }
    let ran = bench.done(&with_files(&["gap", "--coeffs", "base.toml", "--out", "none.toml"], &names));
    assert!(ran.stderr.contains("none.toml: not written: no effect is to be added"), "{}", ran.stderr);
    assert!(!bench.files().contains(&"none.toml".to_owned()));
    let usage = bench.gmr(&with_files(&["gap", "--out", "none.toml"], &names));
    assert_eq!(usage.code, Some(2), "{}", usage.stderr);
}
