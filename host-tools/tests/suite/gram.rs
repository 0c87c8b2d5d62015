//! `gmr gram` and `gmr fit --grams`: sums say what the rows say, or say that they do not.

use fit::run_gram::How;
use logs::robot::Robot;
use rayon::ThreadPoolBuilder;
use serde_json::Value;
use support::context::Context;

use crate::common::{Bench, NAMES, ROBOT, TRUTH, drive, number};

/// Three logs of 40 s that the model made.
fn bench() -> Bench {
    let bench = Bench::new();
    bench.put("robot.toml", ROBOT);
    for (name, mass) in [("light.csv", 1.0), ("middle.csv", 3.0), ("heavy.csv", 6.0)] {
        bench.put(name, drive(40.0, 50.0, |_| mass));
    }
    bench
}

const LOGS: [&str; 3] = ["light.csv", "middle.csv", "heavy.csv"];

fn gram(bench: &Bench, out: &str, logs: &[&str]) {
    bench.done(&[&["gram", "--robot", "robot.toml", "--out", out], logs].concat());
}

fn fit(bench: &Bench, rest: &[&str]) -> Value {
    bench.json(&[&["fit", "--robot", "robot.toml"], rest].concat())
}

fn values(report: &Value) -> Vec<f64> {
    report["parameters"].as_array().unwrap().iter().map(|one| number(&one["value"])).collect()
}

/// Sums of n numbers in another order differ by n ε of their size, some 1e-12; the condition of Eq.
/// 18's scaled columns, up to 1e6, is what of that reaches the coefficients, in shares of the
/// greatest contribution.
fn assert_same(a: &Value, b: &Value) {
    for (a, b) in values(a).iter().zip(values(b)) {
        assert!((a - b).abs() <= 1e-6 * b.abs().max(1e-6), "{a} {b}");
    }
    assert!(
        (number(&a["rmse_w"]) / number(&b["rmse_w"]) - 1.0).abs() < 1e-9,
        "{} {}",
        a["rmse_w"],
        b["rmse_w"]
    );
}

#[test]
fn eq18_is_the_same_from_sums_as_from_rows() {
    let bench = bench();
    gram(&bench, "g.jsonl", &LOGS);
    for model in ["eq18", "eq18-published"] {
        let rows = fit(&bench, &[&["--model", model, "--method", "nnls"], &LOGS[..]].concat());
        let sums = fit(&bench, &["--model", model, "--grams", "g.jsonl"]);
        assert_same(&sums, &rows);
        assert_eq!(sums["rows"], rows["samples"], "all rows behind the filter are in the sums");
    }
}

/// Whoever summed first, and however they were kept.
#[test]
fn sums_add_up_in_any_order() {
    let bench = bench();
    gram(&bench, "all.jsonl", &LOGS);
    gram(&bench, "one.jsonl", &["heavy.csv"]);
    gram(&bench, "two.jsonl", &["middle.csv", "light.csv"]);
    let together = fit(&bench, &["--model", "eq18", "--grams", "all.jsonl"]);
    for order in [["one.jsonl", "two.jsonl"], ["two.jsonl", "one.jsonl"]] {
        assert_same(&fit(&bench, &["--model", "eq18", "--grams", order[0], order[1]]), &together);
    }
    let line = bench.text("all.jsonl").lines().map(str::len).max().unwrap();
    assert!(line < 20_000, "a run takes {line} bytes");
}

/// Kept as Parquet, a run a row, they are the same; and so are they of a log that is Parquet
/// itself, which is read by its columns.
#[test]
fn parquet_keeps_sums_and_gives_the_same() {
    let bench = bench();
    gram(&bench, "g.jsonl", &LOGS);
    // Its own file it writes over, another's it does not.
    gram(&bench, "g.parquet", &LOGS[..1]);
    gram(&bench, "g.parquet", &LOGS);
    for (model, rest) in [("eq18", &["--leave-one-out"][..]), ("signed", &[])] {
        let of = |grams: &str| fit(&bench, &[&["--model", model, "--grams", grams], rest].concat());
        assert_eq!(of("g.parquet"), of("g.jsonl"));
    }
    bench.done(&["convert", "light.csv", "--out", "light.parquet"]);
    let refused = bench.gmr(&["gram", "--robot", "robot.toml", "--out", "light.parquet", "heavy.csv"]);
    assert_eq!(refused.code, Some(1));
    assert!(refused.stderr.contains("--force"), "{}", refused.stderr);
    bench.done(&["gram", "--robot", "robot.toml", "--cutoff", "5", "--out", "csv.jsonl", "light.csv"]);
    bench.done(&[
        "gram",
        "--robot",
        "robot.toml",
        "--cutoff",
        "5",
        "--out",
        "parquet.jsonl",
        "light.parquet",
    ]);
    assert_eq!(bench.text("parquet.jsonl").replace("light.parquet", "light.csv"), bench.text("csv.jsonl"));
    // A table of something else is named.
    let ran = bench.gmr(&["fit", "--robot", "robot.toml", "--grams", "light.parquet"]);
    assert!(ran.stderr.starts_with("gmr: light.parquet:run: is missing"), "{}", ran.stderr);
}

/// Rows in which no wheel can be clamped are exact for the model that made them: what is left is
/// the filter, as in `fit`.
#[test]
fn the_signed_model_is_fitted_to_what_its_clamp_leaves_alone_and_says_so() {
    let bench = bench();
    gram(&bench, "g.jsonl", &LOGS);
    let report = fit(&bench, &["--grams", "g.jsonl"]);
    for ((name, truth), value) in NAMES.into_iter().zip(TRUTH).zip(values(&report)) {
        assert!((value / truth - 1.0).abs() < 0.02, "{name}: {value} {truth}");
    }
    let left_out = number(&report["left_out_rows"]);
    assert!(left_out > 0.0);
    let warnings = report["warnings"].to_string();
    assert!(warnings.contains(&format!("the other {left_out} need their rows")), "{warnings}");
    assert!(warnings.contains("no standard errors"), "three runs cannot tell them: {warnings}");
}

/// As fitted to the others alone, and held against the run's own sums: Σ (p − β x)² = pᵀp − 2
/// βᵀXᵀp + βᵀXᵀX β.
#[test]
fn a_run_is_predicted_by_the_others() {
    let bench = bench();
    gram(&bench, "g.jsonl", &LOGS);
    let report = fit(&bench, &["--model", "eq18", "--grams", "g.jsonl", "--leave-one-out"]);
    let left_out = report["left_out"].as_array().unwrap();
    let names: Vec<&str> = left_out.iter().map(|one| one["run"].as_str().unwrap()).collect();
    assert_eq!(names, LOGS);
    for (place, one) in left_out.iter().enumerate() {
        let others: Vec<&str> = LOGS.into_iter().filter(|log| *log != LOGS[place]).collect();
        gram(&bench, "others.jsonl", &others);
        let beta = values(&fit(&bench, &["--model", "eq18", "--grams", "others.jsonl"]));
        gram(&bench, "own.jsonl", &[LOGS[place]]);
        let alone: Value = serde_json::from_str(&bench.text("own.jsonl")).unwrap();
        let sums = &alone["eq18"];
        let products =
            |i: usize, j: usize| number(&sums["products"][i.max(j) * (i.max(j) + 1) / 2 + i.min(j)]);
        let mut squares = number(&sums["power_squares"]);
        for (i, b) in beta.iter().enumerate() {
            squares -= 2.0 * b * number(&sums["with_power"][i]);
            squares += beta.iter().enumerate().map(|(j, c)| b * c * products(i, j)).sum::<f64>();
        }
        let rmse = (squares / number(&sums["rows"])).sqrt();
        // The squares are what is left of sums some thousand times as large.
        assert!((number(&one["rmse_w"]) / rmse - 1.0).abs() < 1e-6, "{one} {rmse}");
        assert_eq!(one["rows"], sums["rows"]);
    }
}

#[test]
fn sums_of_other_settings_are_refused() {
    let bench = bench();
    gram(&bench, "20.jsonl", &["light.csv"]);
    bench.done(&["gram", "--robot", "robot.toml", "--cutoff", "5", "--out", "5.jsonl", "heavy.csv"]);
    let ran =
        bench.gmr(&["fit", "--robot", "robot.toml", "--model", "eq18", "--grams", "20.jsonl", "5.jsonl"]);
    assert_eq!(ran.code, Some(1));
    assert!(ran.stderr.contains("read with other settings than light.csv"), "{}", ran.stderr);
    bench.put("no.jsonl", "{\"format\":1}\n");
    let ran = bench.gmr(&["fit", "--robot", "robot.toml", "--grams", "no.jsonl"]);
    assert!(ran.stderr.starts_with("gmr: no.jsonl:1: is no gram"), "{}", ran.stderr);
    let ran = bench.gmr(&["fit", "--robot", "robot.toml", "--grams", "20.jsonl", "--out", "c.toml"]);
    assert_eq!(ran.code, Some(2), "noise of payload windows needs rows: {}", ran.stderr);
}

/// Coefficients spoiled by these factors, then passes over the rows and steps: where they end, and
/// the last move in standard errors.
fn stepped(bench: &Bench, coulomb: f64, others: f64) -> (Vec<f64>, f64) {
    let spoiled: Vec<String> = bench
        .text("fitted.toml")
        .lines()
        .map(|line| match line.split_once(" = ") {
            Some((name, value)) if NAMES.contains(&name) => {
                format!(
                    "{name} = {}",
                    value.parse::<f64>().unwrap() * if name == "coulomb" { coulomb } else { others }
                )
            }
            _ => line.to_owned(),
        })
        .collect();
    bench.put("c0.toml", spoiled.join("\n") + "\n");
    let (mut values, mut longest) = (Vec::new(), f64::INFINITY);
    for pass in 0..6 {
        let (near, next, sums) =
            (format!("c{pass}.toml"), format!("c{}.toml", pass + 1), format!("g{pass}.jsonl"));
        bench.done(
            &[&["gram", "--robot", "robot.toml", "--force", "--coeffs", &near, "--out", &sums], &LOGS[..]]
                .concat(),
        );
        let report = fit(bench, &["--grams", &sums, "--coeffs", &near, "--out", &next]);
        values = report["parameters"].as_array().unwrap().iter().map(|one| number(&one["after"])).collect();
        longest = number(&report["longest_std_errs"]);
    }
    (values, longest)
}

/// From coefficients a fifth too high and a tenth too low, and the other way round, clamped wheels
/// included: steps end at one place, the least squares of all rows, which counts those where a
/// clamp lets go within the filter's memory as well.
#[test]
fn steps_from_known_coefficients_lead_to_one_place_near_the_truth() {
    let bench = bench();
    bench.done(&[&["fit", "--robot", "robot.toml", "--out", "fitted.toml"], &LOGS[..]].concat());
    let (one, longest) = stepped(&bench, 1.2, 0.9);
    assert!(longest < 1e-3, "{longest}");
    let (other, longest) = stepped(&bench, 0.85, 1.15);
    assert!(longest < 1e-3, "{longest}");
    for ((one, other), truth) in one.iter().zip(&other).zip(TRUTH) {
        assert!(
            (one / other - 1.0).abs() < 1e-5 && (one / truth - 1.0).abs() < 5e-2,
            "{one} {other} {truth}"
        );
    }
    // The file is one that every command takes.
    bench.done(&["estimate", "--robot", "robot.toml", "--coeffs", "c6.toml", "middle.csv"]);
    // Sums near other coefficients, or none.
    gram(&bench, "plain.jsonl", &LOGS);
    for (sums, said) in [("g0.jsonl", "near other coefficients"), ("plain.jsonl", "near no coefficients")] {
        let failed = bench.gmr(&["fit", "--robot", "robot.toml", "--grams", sums, "--coeffs", "c6.toml"]);
        assert_eq!(failed.code, Some(1));
        assert!(failed.stderr.contains(said), "{}", failed.stderr);
    }
    let failed = bench.gmr(&["fit", "--robot", "robot.toml", "--grams", "g0.jsonl", "--out", "x.toml"]);
    assert_eq!(failed.code, Some(2), "{}", failed.stderr);
}

/// However many cores decode and sum one large log, its sums are those of one core, bit for bit.
#[test]
fn sums_are_those_of_one_core() {
    let bench = Bench::new();
    bench.put("large.csv", drive(800.0, 100.0, |time| 1.0 + (time / 300.0).floor()));
    bench.done(&["convert", "large.csv", "--out", "large.parquet"]);
    let robot = Robot::parse(ROBOT).unwrap();
    let how = How::at(&robot, 5.0, 1.0).unwrap();
    for log in ["large.csv", "large.parquet"] {
        let sums = |threads: usize| {
            let cores = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let summed = cores.install(|| how.of_log(&Context::default(), &robot, &bench.path(log)));
            serde_json::to_string(&summed.unwrap().runs).unwrap()
        };
        let alone = sums(1);
        assert!(alone.contains("\"rows\":80000"), "{alone}");
        assert!([2, 4].into_iter().all(|threads| sums(threads) == alone), "{log}");
    }
}
