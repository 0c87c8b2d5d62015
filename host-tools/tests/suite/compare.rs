//! `gmr compare` from the outside, on the plant and on measured data.

use std::path::{Path, PathBuf};

use crate::common::{Bench, excerpt, keys, number, whole_data};
use serde_json::Value;

fn compare(bench: &Bench, rest: &[&str]) -> Value {
    bench.json(&[&["compare", "--no-perceptron"], rest].concat())
}

fn entry<'a>(report: &'a Value, name: &str) -> &'a Value {
    let models = report["models"].as_array().unwrap();
    models.iter().find(|model| model["name"] == name).unwrap_or_else(|| panic!("no {name} in {models:?}"))
}

fn r2(report: &Value, name: &str) -> f64 {
    number(&entry(report, name)["r2"])
}

/// Training at 1 and 6 kg, test at 3 and 4 kg, by the plant with servo motors.
fn plant() -> Bench {
    let bench = Bench::new();
    bench.simulate("train.csv", &["--mass", "1@0,6@60", "--duration", "120"]);
    bench.simulate(
        "test.csv",
        &["--mass", "3@0,4@30", "--duration", "60", "--profile", "test", "--seed", "2"],
    );
    bench
}

#[test]
fn the_json_has_the_documented_keys_for_every_model() {
    let bench = plant();
    let blocks = compare(&bench, &["--train", "train.csv"]);
    let files = compare(&bench, &["--train", "train.csv", "--test", "test.csv", "--window", "10"]);
    assert_eq!((&blocks["held_out_blocks"], &files["held_out_blocks"]), (&true.into(), &false.into()));
    for report in [&blocks, &files] {
        for model in report["models"].as_array().unwrap() {
            for key in [
                "name",
                "source",
                "mass",
                "horizon",
                "r2",
                "persistence_r2",
                "mape_percent",
                "rmse_w",
                "mass_error_percent",
                "mape_share",
                "samples",
                "fit_s",
            ] {
                assert!(keys(model).contains(&key), "{key} in {model}");
            }
            assert!(number(&model["fit_s"]) >= 0.0 && number(&model["rmse_w"]) >= 0.0);
        }
        for name in ["signed", "eq18", "eq18-published", "linear"] {
            entry(report, name);
        }
    }
    // Where models find the mass themselves, the table says so, and has them with the mass given
    // beside.
    for name in ["signed", "eq18", "eq18-published"] {
        assert_eq!(entry(&files, name)["mass"], "estimated");
        assert_eq!(entry(&files, &format!("{name}, mass given"))["mass"], "given");
    }
    // So has every baseline that takes the mass, and those that find it by themselves say how well.
    for name in ["jaramillo", "linear", "parasuraman"] {
        assert_eq!(entry(&files, name)["mass"], "given");
        let model = entry(&files, &format!("{name}, mass found"));
        assert_eq!((&model["mass"], &model["horizon"]), (&"estimated".into(), &"second".into()));
        assert!(number(&model["mass_error_percent"]) > 0.0, "{model}");
    }
    for name in ["signed", "vahidi", "vahidi-robust"] {
        assert!(number(&entry(&files, name)["mass_error_percent"]) > 0.0);
    }
    // Who has seen the sample before stands beside what that alone is worth.
    let persistence = |name: &str| number(&entry(&files, name)["persistence_r2"]);
    assert!(persistence("pentzer") > persistence("signed") && persistence("signed") > 0.0, "{files}");
    assert!(entry(&files, "linear")["persistence_r2"].is_null());
    assert_eq!(entry(&blocks, "signed")["mass"], "given");
    // All rows but those the filter settles in: two periods of its cutoff.
    let settling_s = 0.01 * (12_001.0 - number(&files["train_rows"]));
    let periods = settling_s * number(&files["cutoff_hz"]);
    assert!((1.8..2.2).contains(&periods), "{settling_s} s, {periods} periods");
}

#[test]
fn the_signed_model_is_ahead_of_the_regression_on_the_plant() {
    let bench = plant();
    let blocks = compare(&bench, &["--train", "train.csv"]);
    let files = compare(&bench, &["--train", "train.csv", "--test", "test.csv", "--window", "10"]);
    for report in [&blocks, &files] {
        assert!(r2(report, "signed") > 0.99, "{report}");
        assert!(r2(report, "signed") > r2(report, "linear") + 0.1, "{report}");
        let rmse = |name: &str| number(&entry(report, name)["rmse_w"]);
        assert!(rmse("signed") < rmse("linear"), "{report}");
    }
}

/// A third of the time is held out, in blocks of the length asked for, and nothing of it is fitted.
/// On a floor that takes nearly twice as much, ours and a regression that adapt both beat
/// themselves; a log in which the mass changes has no one mass to tell.
#[test]
fn a_floor_adapts_for_ours_and_for_others() {
    let bench = Bench::new();
    bench.simulate("train.csv", &["--mass", "1@0,6@60", "--duration", "120"]);
    let floor = ["--duration", "120", "--seed", "2", "--effect", "rolling-resistance-change=0.012"];
    bench.simulate("test.csv", &[&["--mass", "3"], &floor[..]].concat());
    bench.simulate("changes.csv", &[&["--mass", "3@0,4@60"], &floor[..]].concat());
    let models = ["--models", "signed,linear", "--train", "train.csv"];
    let report = bench.json(&[&["compare", "--adapt", "--test", "test.csv"], &models[..]].concat());
    for (fixed, adapts) in
        [("signed, mass given", "signed, floor adapts"), ("linear", "linear, floor adapts")]
    {
        assert!(r2(&report, adapts) > r2(&report, fixed) + 0.02, "{report:#}");
        assert_eq!(
            (&entry(&report, adapts)["mass"], &entry(&report, adapts)["horizon"]),
            (&"given".into(), &"second".into())
        );
    }
    assert!(r2(&report, "signed, floor adapts") > r2(&report, "linear, floor adapts"));
    let report = bench.json(&[&["compare", "--adapt", "--test", "changes.csv"], &models[..]].concat());
    let out = &report["left_out"][0];
    assert_eq!(out["name"], "signed, floor adapts", "{report:#}");
    assert!(out["reason"].as_str().unwrap().contains("mass changes"), "{out}");
    let alone = bench.gmr(&["compare", "--adapt", "--train", "train.csv"]);
    assert_eq!(alone.code, Some(2), "{}", alone.stderr);
}

#[test]
fn held_out_blocks_are_a_third() {
    let bench = plant();
    let report = compare(&bench, &["--train", "train.csv", "--block", "4"]);
    let (train, test) = (number(&report["train_rows"]), number(&report["test_rows"]));
    assert!((test / (train + test) - 1.0 / 3.0).abs() < 0.01, "{train} {test}");
    assert_eq!(number(&entry(&report, "linear")["samples"]), test);
}

fn csv_files(folder: &Path, prefix: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> =
        entries.filter(|path| path.file_name().unwrap().to_str().unwrap().starts_with(prefix)).collect();
    files.sort();
    files
}

/// Runs of the Husky on sandy loam in which it kept one speed from before the log began: a fit says
/// so.
const ONE_SPEED: [&str; 9] = ["00", "01", "02", "03", "05", "07", "10", "11", "12"];

#[test]
fn measured_pieces_are_fitted() {
    fit_all(&excerpt("warthog/drive.csv"), &excerpt("husky-currents"));
}

#[test]
fn every_measured_run_is_fitted() {
    let Some(data) = whole_data() else { return };
    fit_all(&data.join("warthog/drive.csv"), &data.join("husky-currents"));
}

fn fit_all(warthog: &Path, husky: &Path) {
    let bench = Bench::new();
    let fit = |robot: &str, path: &Path| {
        bench.gmr(&["fit", "--robot", robot, "--json", "--force", "--out", "c.toml", path.to_str().unwrap()])
    };
    let ran = fit("warthog", warthog);
    let report: Value = serde_json::from_str(&ran.stdout).unwrap();
    assert!(number(&report["r2"]) > 0.8, "{}", report["r2"]);
    for path in csv_files(husky, "") {
        let name = path.file_stem().unwrap().to_str().unwrap();
        let ran = fit("husky", &path);
        let one_speed = ONE_SPEED.iter().any(|run| name == format!("sandy_loam_{run}"));
        let says = ran.stderr.contains(":wheel1_rad_s: constant speed only (");
        assert_eq!(one_speed, says, "{name}: {}", ran.stderr);
        assert_eq!(ran.code, Some(0), "{name}: {}", ran.stderr);
        let report: Value = serde_json::from_str(&ran.stdout).unwrap();
        // What the log lacks, then what the fit says against itself.
        let warnings: Vec<&str> = report["warnings"]
            .as_array()
            .unwrap()
            .iter()
            .map(|warning| warning["text"].as_str().unwrap())
            .collect();
        let said: Vec<&str> =
            ran.stderr.lines().skip(1).map(|line| line.strip_prefix("gmr: ").unwrap()).collect();
        assert_eq!(said, warnings, "{name}: {}", ran.stderr);
        assert!(number(&report["r2"]).is_finite() && number(&report["rmse_w"]) > 0.0, "{name}");
        assert_eq!(report["verdict"] == "not-usable", number(&report["r2"]) < 0.0, "{name}: {report}");
        let brings_one = |term: &&Value| {
            let extra = ["unequal-sides", "gear-loss", "bridge-drop"];
            term["taken"] == true && extra.iter().any(|extra| term["term"] == *extra)
        };
        let expected = 7 + report["terms"].as_array().unwrap().iter().filter(brings_one).count();
        assert_eq!(report["parameters"].as_array().unwrap().len(), expected, "{name}: skid steer has scrub");
    }
}

/// Of the Husky the power is computed from its currents, not measured: by a form near the signed
/// model's own.
#[test]
fn the_signed_model_is_ahead_of_the_regression_on_measured_pieces() {
    assert_ahead(&excerpt(""));
}

#[test]
fn the_signed_model_is_ahead_of_the_regression_on_measured_data() {
    let Some(data) = whole_data() else { return };
    assert_ahead(&data);
}

fn assert_ahead(data: &Path) {
    let bench = Bench::new();
    let husky = "husky-currents";
    let cases = [
        ("warthog", "470", "warthog", "drive"),
        ("husky", "75", husky, "flooring"),
        ("husky", "75", husky, "sandy_loam"),
    ];
    for (robot, mass, folder, prefix) in cases {
        let files = csv_files(&data.join(folder), prefix);
        let files: Vec<&str> = files.iter().map(|path| path.to_str().unwrap()).collect();
        let report = compare(&bench, &[&["--robot", robot, "--mass", mass, "--train"], &files[..]].concat());
        let (signed, linear) = (r2(&report, "signed"), r2(&report, "linear"));
        println!("{prefix}: R² signed {signed:.3}, linear {linear:.3}");
        assert!(signed > linear, "{prefix}: {signed} {linear}");
        assert!(signed > 0.5, "{prefix}: {signed}");
    }
}

/// What a plant's log can tell beside speeds and power.
const EVERYTHING: &str = "pitch,slope,command,imu,friction";

/// The list of models with what each needs, as the command gives it.
fn listed(bench: &Bench, robot: &str) -> Vec<Value> {
    bench.json(&["compare", "--list", "--robot", robot])["models"].as_array().unwrap().clone()
}

fn names(list: &Value) -> Vec<&str> {
    list.as_array().unwrap().iter().map(|model| model["name"].as_str().unwrap()).collect()
}

/// Every model says where it comes from, what it assumes and needs; in text as in JSON.
#[test]
fn the_list_describes_every_model() {
    let bench = Bench::new();
    let models = listed(&bench, "burger");
    let text = bench.done(&["compare", "--list"]).stdout;
    let mut seen = std::collections::BTreeSet::new();
    for model in &models {
        assert_eq!(
            keys(model),
            [
                "name", "source", "assumes", "mass", "network", "columns", "layouts", "family", "reduced",
                "horizon"
            ]
        );
        let [name, source, assumes] = ["name", "source", "assumes"].map(|key| model[key].as_str().unwrap());
        assert!(seen.insert(name.to_owned()), "{name} twice");
        assert!(source.len() > 10 && assumes.len() > 10, "{model}");
        assert!(
            text.contains(&format!("{name}\n    {source}\n    assumes: {assumes}\n    mass: ")),
            "{text}"
        );
    }
    for name in ["signed", "linear", "mlp", "liu-perceptron", "gora", "sakayori", "chikushi"] {
        assert!(seen.contains(name), "{name}");
    }
    let gora = models.iter().find(|model| model["name"] == "gora").unwrap();
    assert_eq!(gora["columns"], serde_json::json!(["rolling_friction", "static_friction"]));
    assert_eq!((&gora["mass"], &gora["network"]), (&"given".into(), &true.into()));
}

/// Only those asked for, in the order of the table; unknown names are refused with what is allowed.
#[test]
fn models_are_chosen_by_name() {
    let bench = plant();
    let asked = |models: &str| bench.json(&["compare", "--train", "train.csv", "--models", models]);
    let report = asked("linear,signed");
    assert_eq!(names(&report["models"]), ["signed", "linear"]);
    assert!(names(&report["left_out"]).is_empty());
    // Asked for and not to be had: named, with the reason; only when nothing else is left it is a
    // failure.
    let report = asked("signed,gora,chikushi");
    assert_eq!(names(&report["models"]), ["signed"]);
    assert_eq!(names(&report["left_out"]), ["gora", "chikushi"]);
    assert_eq!(report["left_out"][0]["reason"], "the logs have no rolling_friction, static_friction");
    let alone = bench.gmr(&["compare", "--train", "train.csv", "--models", "gora", "--json"]);
    assert_eq!((alone.code, alone.stdout.as_str()), (Some(1), ""));
    let reason =
        "gmr: no model is left to compare (gora: the logs have no rolling_friction, static_friction)\n";
    assert_eq!(alone.stderr, reason);
    let unknown = bench.gmr(&["compare", "--train", "train.csv", "--models", "signed,newton"]);
    assert_eq!(unknown.code, Some(2));
    let refusal = "gmr: --models newton: expected some of signed, eq18, eq18-published, ";
    assert!(unknown.stderr.starts_with(refusal) && unknown.stderr.contains("sakayori"), "{}", unknown.stderr);
}

/// A log with every column: no network is left out, and each ends with figures. Networks that know
/// neither the mass nor accelerations know less than the paper's own.
#[test]
fn every_network_runs_on_a_log_of_the_plant() {
    let bench = Bench::new();
    let log = |name: &str, rest: &[&str]| {
        let columns = ["--columns", EVERYTHING, "--effect", "grade=0.05", "--rate", "20", "--duration", "60"];
        bench.simulate(name, &[&columns[..], rest].concat());
    };
    log("train.csv", &["--mass", "1@0,6@30"]);
    log("test.csv", &["--mass", "3@0,4@30", "--profile", "test", "--seed", "2"]);
    let networks = "mlp,liu-perceptron,gora,sakayori,chikushi";
    let run = || bench.json(&["compare", "--train", "train.csv", "--test", "test.csv", "--models", networks]);
    let report = run();
    let mut expected: Vec<String> = networks.split(',').map(str::to_owned).collect();
    // Those that are told the mass have to find it too.
    for told in ["gora", "mlp"] {
        let place = expected.iter().position(|name| name == told).unwrap();
        expected.insert(place + 1, format!("{told}, mass found"));
    }
    assert_eq!(names(&report["models"]), expected);
    for model in report["models"].as_array().unwrap() {
        assert!(number(&model["r2"]) < 1.0 && number(&model["rmse_w"]) > 0.0, "{model}");
    }
    for blind in ["liu-perceptron", "sakayori", "chikushi"] {
        assert_eq!(entry(&report, blind)["mass"], "unused");
    }
    // The same figures whichever core was first.
    let figures = |report: &Value| {
        let models = report["models"].as_array().unwrap();
        models.iter().map(|model| number(&model["rmse_w"])).collect::<Vec<_>>()
    };
    assert_eq!(figures(&report), figures(&run()));
}

/// On measured logs, which tell speeds and power only, every model that needs no more and fits the
/// wheels is in the table, and every other is left out by name.
#[test]
fn every_baseline_is_in_the_table_or_left_out_by_name() {
    assert_all_are_named(&excerpt(""));
}

#[test]
#[ignore = "forty seconds: cargo test -p host-tools --test suite -- --ignored on_whole_logs; the excerpts are asked above"]
fn on_whole_logs_every_baseline_is_in_the_table_or_left_out_by_name() {
    let Some(data) = whole_data() else { return };
    assert_all_are_named(&data);
}

fn assert_all_are_named(data: &Path) {
    let bench = Bench::new();
    for (robot, folder, prefix) in
        [("warthog", "warthog", "drive"), ("husky", "husky-currents", "flooring_0")]
    {
        let files = csv_files(&data.join(folder), prefix);
        let files: Vec<&str> = files.iter().map(|path| path.to_str().unwrap()).collect();
        let options = ["compare", "--robot", robot, "--mass", "75", "--train"];
        let report = bench.json(&[&options[..], &files[..]].concat());
        let skid_steer = |model: &Value| {
            let layouts = model["layouts"].as_array().unwrap();
            layouts.is_empty() || layouts.iter().any(|layout| layout == "skid steer")
        };
        let (mut expected, mut left_out) = (Vec::new(), Vec::new());
        for model in listed(&bench, robot) {
            let allowed = model["columns"].as_array().unwrap().is_empty() && skid_steer(&model);
            let list = if allowed { &mut expected } else { &mut left_out };
            list.push(model["name"].as_str().unwrap().to_owned());
        }
        assert_eq!(names(&report["models"]), expected, "{robot}: {}", report["left_out"]);
        assert_eq!(names(&report["left_out"]), left_out, "{robot}");
        for model in report["models"].as_array().unwrap() {
            assert!(number(&model["samples"]) > 100.0 && number(&model["rmse_w"]) > 0.0, "{robot}: {model}");
        }
    }
}

/// The log without the values of a column in rows whose time passes; header and rows keep their
/// fields.
fn emptied(log: &str, column: &str, empty: impl Fn(f64) -> bool) -> String {
    let header = log.lines().next().unwrap();
    let at = header.split(',').position(|name| name == column).unwrap();
    let row = |line: &str| {
        let mut fields: Vec<&str> = line.split(',').collect();
        if fields[0].parse().is_ok_and(&empty) {
            fields[at] = "";
        }
        fields.join(",") + "\n"
    };
    log.lines().map(row).collect()
}

/// Rows without a reading are left out for the models that need it, and for those only; where they
/// are most, so is the model.
#[test]
fn empty_fields_of_a_column_cost_their_rows_only() {
    let bench = Bench::new();
    let columns = ["--columns", "command", "--rate", "20", "--duration", "60"];
    bench.simulate("train.csv", &[&columns[..], &["--mass", "1@0,6@30"]].concat());
    bench
        .simulate("test.csv", &[&columns[..], &["--mass", "3", "--profile", "test", "--seed", "2"]].concat());
    let run = |train: &str, test: &str| {
        bench.json(&["compare", "--train", train, "--test", test, "--models", "linear,liu-linear"])
    };
    let whole = run("train.csv", "test.csv");
    // Empty from 20 s to 40 s, known over the first five rows of it: 395 rows of 20 Hz are left
    // out.
    bench.put("gap.csv", emptied(&bench.text("test.csv"), "cmd_v_m_s", |time| (20.0..39.99).contains(&time)));
    let gapped = run("train.csv", "gap.csv");
    let samples = |report: &Value, name: &str| number(&entry(report, name)["samples"]);
    assert_eq!(samples(&whole, "liu-linear") - samples(&gapped, "liu-linear"), 395.0);
    assert_eq!(entry(&gapped, "linear")["rmse_w"], entry(&whole, "linear")["rmse_w"]);
    assert_eq!(names(&gapped["left_out"]).len(), 0, "{gapped}");
    // The same in training: 395 of 1193 rows are not fitted, and the model stays near what it was.
    bench.put(
        "half.csv",
        emptied(&bench.text("train.csv"), "cmd_v_m_s", |time| (20.0..39.99).contains(&time)),
    );
    let half = run("half.csv", "test.csv");
    let rmse = |report: &Value| number(&entry(report, "liu-linear")["rmse_w"]);
    assert!(rmse(&half) != rmse(&whole) && rmse(&half) < 2.0 * rmse(&whole), "{half}");
    // Known in 10 s of 60: refused by name.
    bench.put("most.csv", emptied(&bench.text("train.csv"), "cmd_v_m_s", |time| time > 10.0));
    let most = run("most.csv", "test.csv");
    let rows = number(&most["train_rows"]);
    let reason = format!("cmd_v_m_s has no value in 995 of {rows} training rows");
    assert_eq!(most["left_out"][0], serde_json::json!({ "name": "liu-linear", "reason": reason }));
}

/// A mass that nobody told, and one that no training log knows, are named; the figures are there
/// all the same.
#[test]
fn masses_that_are_taken_or_extrapolated_are_said() {
    let bench = Bench::new();
    let short = ["--rate", "20", "--duration", "30"];
    bench.simulate("blind.csv", &[&short[..], &["--no-mass"]].concat());
    bench.simulate("two.csv", &[&short[..], &["--mass", "2.5", "--seed", "2"]].concat());
    let said = |rest: &[&str]| bench.done(&[&["compare", "--json"], rest].concat()).stderr;
    let pair = ["--train", "blind.csv", "--test", "two.csv"];
    let taken = "gmr: blind.csv: no mass_kg: 1.5 kg taken (--mass)\n";
    let extrapolated =
        "gmr: training at 1.5 kg only, test at 2.5 kg: models that take the mass extrapolate\n";
    let with = |models: &str| said(&[&pair[..], &["--mass", "1.5", "--models", models]].concat());
    for takes in ["linear", "signed", "mei,signed"] {
        assert_eq!(with(takes), [taken, extrapolated].concat());
    }
    assert_eq!(with("mei"), taken, "it has no use for the mass");
    assert_eq!(said(&["--train", "two.csv", "--models", "linear"]), "");
    assert_eq!(said(&["--train", "two.csv", "--test", "two.csv", "--models", "linear"]), "");
}

/// The list holds those asked for; numbers below 0 are refused by value, and blocks where no block
/// is held out.
#[test]
fn arguments_that_do_not_go_together_are_refused() {
    let bench = Bench::new();
    let asked = bench.json(&["compare", "--list", "--models", "mei,signed"]);
    assert_eq!(names(&asked["models"]), ["signed", "mei"]);
    let refused = |rest: &[&str], expected: &str| {
        let ran = bench.gmr(&[&["compare", "--train", "a.csv"], rest].concat());
        assert_eq!((ran.code, ran.stdout.as_str()), (Some(2), ""), "{rest:?}: {}", ran.stderr);
        assert!(ran.stderr.contains(expected), "{rest:?}: {}", ran.stderr);
    };
    bench.simulate("a.csv", &["--duration", "5"]);
    refused(&["--block", "4", "--test", "b.csv"], "cannot be used with");
    refused(&["--block", "-4"], "--block -4: expected a length above 0 s");
    refused(&["--mass", "-1"], "--mass -1: expected a mass above 0 kg");
    refused(&["--window", "-5"], "--window -5: expected 0.8 s");
}

/// A power and a speed that no robot has are refused where they stand, not fitted.
#[test]
fn values_beyond_any_robot_are_refused_by_line_and_column() {
    let bench = Bench::new();
    bench.simulate("a.csv", &["--duration", "5"]);
    let log = bench.text("a.csv");
    for (column, position, value, expected) in [
        ("power_w", 3, "-1e9", "-1e9 is beyond any robot; expected below 1e9"),
        ("wheel2_rad_s", 2, "2e6", "2e6 is beyond any robot; expected below 1e6"),
    ] {
        let mut lines: Vec<String> = log.lines().map(str::to_owned).collect();
        let mut fields: Vec<&str> = lines[99].split(',').collect();
        fields[position] = value;
        lines[99] = fields.join(",");
        bench.put("b.csv", lines.join("\n") + "\n");
        let ran = bench.gmr(&["compare", "--train", "b.csv", "--models", "linear"]);
        assert_eq!((ran.code, ran.stderr), (Some(1), format!("gmr: b.csv:100:{column}: {expected}\n")));
    }
}
