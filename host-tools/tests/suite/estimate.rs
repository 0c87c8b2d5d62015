//! `gmr estimate` from the outside: windows, changes, schedules and energy.

use crate::common::{Bench, ROBOT, drive, keys, number};
use serde_json::Value;

const ESTIMATE: [&str; 5] = ["estimate", "--robot", "robot.toml", "--coeffs", "c.toml"];

/// Robot, and coefficients of 80 s at 1 and 6 kg that the model made.
fn exact() -> Bench {
    let bench = Bench::new();
    bench.put("robot.toml", ROBOT);
    bench.put("train.csv", drive(80.0, 100.0, |time| if time < 40.0 { 1.0 } else { 6.0 }));
    bench.done(&["fit", "--robot", "robot.toml", "--out", "c.toml", "train.csv"]);
    bench
}

/// Robot, and coefficients of the plant with servo motors and their sensors.
fn plant() -> Bench {
    let bench = Bench::new();
    bench.put("robot.toml", ROBOT.replace("filter_cutoff_hz = 20\n", ""));
    bench.simulate("train.csv", &["--sensors", "servo", "--mass", "1@0,6@100", "--duration", "200"]);
    bench.done(&["fit", "--robot", "robot.toml", "--out", "c.toml", "train.csv"]);
    bench
}

/// The log with white noise of 3 mW in its power.
fn noisy(log: &str) -> String {
    let mut random = 1_u64;
    let mut text = crate::common::HEADER.to_owned();
    for line in log.lines().skip(1) {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        // Uniform within ±√3 standard deviations.
        let noise = 3e-3 * 3_f64.sqrt() * ((random >> 32) as f64 / f64::from(1_u32 << 31) - 1.0);
        let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
        fields[3] = format!("{:.9}", fields[3].parse::<f64>().unwrap() + noise);
        text += &(fields.join(",") + "\n");
    }
    text
}

fn estimate(bench: &Bench, rest: &[&str]) -> Value {
    bench.json(&[&ESTIMATE[..], rest].concat())
}

fn windows(report: &Value) -> &[Value] {
    report["windows"].as_array().unwrap()
}

#[test]
fn the_json_has_the_documented_keys_and_a_window_a_second() {
    let bench = exact();
    bench.put("run.csv", drive(30.0, 100.0, |_| 2.5));
    let report = estimate(&bench, &["--window", "10", "run.csv"]);
    for key in ["r2", "mape_percent", "energy_j"] {
        assert!(number(&report[key]).is_finite(), "{key}");
    }
    assert_eq!(report["changes"], serde_json::json!([]));
    assert_eq!(report["rows"], 3000);
    let ends: Vec<f64> = windows(&report).iter().map(|window| number(&window["t1_s"])).collect();
    // 3000 rows from 0 to 29.99 s: the last second is not over by a sample, which counts as over.
    let expected: Vec<f64> = (10..=30).map(f64::from).collect();
    assert_eq!(ends, expected[..ends.len()]);
    assert!(ends.len() >= 20);
    for window in windows(&report) {
        assert_eq!(keys(window)[..5], ["t0_s", "t1_s", "mass_kg", "low_kg", "high_kg"]);
        assert!((number(&window["t1_s"]) - number(&window["t0_s"]) - 10.0).abs() < 1e-9);
        let [mass, low, high] = ["mass_kg", "low_kg", "high_kg"].map(|key| number(&window[key]));
        assert!(low <= mass && mass <= high && (1.0..=6.0).contains(&low) && high <= 6.0, "{window}");
        // The coefficients are within 0.1 % of the truth (see fit.rs).
        assert!((mass / 2.5 - 1.0).abs() < 5e-3, "{window}");
    }
    assert!(number(&report["r2"]) > 0.999 && number(&report["mape_percent"]) < 1.0, "{report}");
}

/// The same drive in a log whose clock has run for a while. A floor with half as much again of
/// rolling resistance: to the fit's model it is another mass. With ground that adapts it is not,
/// and the interval holds the mass.
#[test]
fn on_another_floor_the_ground_adapts_and_the_mass_stays() {
    let bench = plant();
    let field = [
        "--sensors",
        "servo",
        "--duration",
        "150",
        "--mass",
        "4.5",
        "--seed",
        "13",
        "--effect",
        "rolling-resistance-change=0.012",
    ];
    bench.simulate("floor.csv", &field);
    let ask = |more: &[&str]| estimate(&bench, &[&["floor.csv"], more].concat());
    let error = |report: &Value, key: &str| number(&report["mass_error"][key]);
    let (fixed, adapted) = (ask(&[]), ask(&["--adapt"]));
    assert!(error(&fixed, "mean_percent") > 15.0, "{}", fixed["mass_error"]);
    assert!(error(&adapted, "mean_percent") < 5.0, "{}", adapted["mass_error"]);
    assert!(error(&adapted, "interval_contains_truth") >= 0.9, "{}", adapted["mass_error"]);
    assert!(fixed["ground"].as_array().unwrap().is_empty());
    let ground = adapted["ground"].as_array().unwrap();
    let [first, last] = [&ground[0], ground.last().unwrap()].map(|at| number(&at["rolling_nm_kg"]));
    assert!(last > 1.2 * first, "the floor is found to be harder: {first} {last}");
    // Told the mass, all that is missing is the floor's: nothing is found, and the power comes out.
    let (told, adapting) = (ask(&["--mass", "4.5"]), ask(&["--adapt", "--mass", "4.5"]));
    let r2 = |report: &Value| number(&report["told"]["r2"]);
    assert!(r2(&adapting) > 0.98 && r2(&told) < 0.95, "{} {}", told["told"], adapting["told"]);
    assert!(windows(&adapting).is_empty() && !windows(&told).is_empty());
    for more in [["--adapt", "--payload", "roots"], ["--adapt", "--schedule", "periodic"]] {
        let refused = bench.gmr(&[&ESTIMATE[..], &["floor.csv"], &more[..]].concat());
        assert_eq!(refused.code, Some(2), "{more:?}");
    }
}

#[test]
fn windows_are_on_the_clock_of_the_log() {
    let bench = exact();
    let log = drive(20.0, 100.0, |_| 2.5);
    let later = log.lines().enumerate().map(|(index, line)| match line.split_once(',') {
        Some((time, rest)) if index > 0 => format!("{:.4},{rest}\n", time.parse::<f64>().unwrap() + 1000.25),
        _ => format!("{line}\n"),
    });
    bench.put("late.csv", later.collect::<String>());
    bench.put("run.csv", log);
    let (now, late) =
        (estimate(&bench, &["--window", "10", "run.csv"]), estimate(&bench, &["--window", "10", "late.csv"]));
    assert_eq!(windows(&now).len(), windows(&late).len());
    for (now, late) in windows(&now).iter().zip(windows(&late)) {
        assert!((number(&late["t1_s"]) - number(&now["t1_s"]) - 1000.25).abs() < 1e-9, "{late}");
        assert!((number(&late["mass_kg"]) - number(&now["mass_kg"])).abs() < 1e-6, "{late} {now}");
    }
}

/// Masses of the log are for reporting: without them all is as it was.
#[test]
fn the_logged_mass_is_not_used() {
    let bench = exact();
    let log = drive(40.0, 100.0, |time| if time < 20.0 { 3.0 } else { 4.0 });
    let without = log.lines().map(|line| line.rsplit_once(',').unwrap().0.to_owned() + "\n");
    bench.put("without.csv", without.collect::<String>());
    bench.put("wrong.csv", log.replace(",3\n", ",5\n").replace(",4\n", ",1\n"));
    bench.put("with.csv", log);
    let with = estimate(&bench, &["--window", "10", "with.csv"]);
    assert!(with["mass_error"].is_object());
    for other in ["without.csv", "wrong.csv"] {
        let other = estimate(&bench, &["--window", "10", other]);
        for key in ["windows", "changes", "energy_j", "r2", "mape_percent", "known_share"] {
            assert_eq!(other[key], with[key], "{key}");
        }
    }
}

#[test]
fn standing_still_says_nothing_about_the_mass() {
    let bench = plant();
    bench.simulate("still.csv", &["--sensors", "servo", "--profile", "standstill", "--duration", "40"]);
    let report = estimate(&bench, &["--window", "10", "still.csv"]);
    assert!(windows(&report).len() >= 30);
    for window in windows(&report) {
        assert!(window["mass_kg"].is_null() && window["low_kg"].is_null() && window["high_kg"].is_null());
        assert_eq!(window["unknown"], "the robot stood still or its drives were clamped");
    }
    assert!(report["r2"].is_null() && report["mape_percent"].is_null());
}

/// At constant speed only rolling friction tells the mass: unknown below the dead band, and where a
/// number is given, it is an honest one.
#[test]
fn constant_low_speed_gives_no_false_mass() {
    let bench = plant();
    let constant = ["--sensors", "servo", "--profile", "constant", "--duration", "60"];
    let later = |report: &Value| -> Vec<Value> {
        // The first windows hold the start, which tells the mass.
        windows(report).iter().filter(|window| number(&window["t0_s"]) >= 5.0).cloned().collect()
    };
    // 0.0005 m/s is 0.015 rad/s at the wheels, below 0.02 rad/s.
    bench.simulate("creep.csv", &[&constant[..], &["--speed", "0.0005", "--mass", "3"]].concat());
    let creeping = later(&estimate(&bench, &["--window", "10", "creep.csv"]));
    assert!(creeping.len() > 30);
    for window in creeping {
        assert!(window["mass_kg"].is_null() && window["unknown"].is_string(), "{window}");
    }
    let (mut known, mut right) = (0, 0);
    for mass in ["1.5", "3", "5.5"] {
        bench.simulate("slow.csv", &[&constant[..], &["--speed", "0.01", "--mass", mass]].concat());
        let truth: f64 = mass.parse().unwrap();
        for window in later(&estimate(&bench, &["--window", "10", "slow.csv"])) {
            if let (Some(low), Some(high)) = (window["low_kg"].as_f64(), window["high_kg"].as_f64()) {
                known += 1;
                right += i32::from(low <= truth && truth <= high);
            }
        }
    }
    println!("{right} of {known} intervals contain the mass");
    // 95 % is stated; three runs of five windows' length each are some 15 independent windows.
    assert!(f64::from(right) >= 0.8 * f64::from(known), "{right} of {known}");
}

#[test]
fn a_change_of_payload_is_noticed_and_no_window_straddles_it() {
    let bench = plant();
    for seed in ["2", "3", "4"] {
        let options = ["--sensors", "servo", "--profile", "test", "--duration", "120", "--mass", "3@0,4@60"];
        bench.simulate("run.csv", &[&options[..], &["--seed", seed]].concat());
        let report = estimate(&bench, &["--window", "10", "run.csv"]);
        let changes = report["changes"].as_array().unwrap();
        println!("seed {seed}: {changes:?}");
        assert_eq!(changes.len(), 1, "seed {seed}: {changes:?}");
        let (time, noticed) = (number(&changes[0]["time_s"]), number(&changes[0]["noticed_s"]));
        assert!((60.0..70.0).contains(&noticed), "seed {seed}: {changes:?}");
        assert!((time - 60.0).abs() <= 5.0, "seed {seed}: {changes:?}");
        let mut straddling = 0;
        for window in windows(&report) {
            if number(&window["t0_s"]) < time && time < number(&window["t1_s"]) {
                straddling += 1;
                assert!(window["mass_kg"].is_null() && window["low_kg"].is_null(), "{window}");
                assert_eq!(window["unknown"], "the payload changed within this window");
            }
        }
        assert!((9..=10).contains(&straddling), "a window of 10 s a second: {straddling}");
        for (from, to, truth) in [(0.0, 55.0, 3.0), (66.0, 120.0, 4.0)] {
            let inside: Vec<f64> = windows(&report)
                .iter()
                .filter(|window| number(&window["t0_s"]) >= from && number(&window["t1_s"]) <= to)
                .filter_map(|window| window["mass_kg"].as_f64())
                .collect();
            let mean = inside.iter().sum::<f64>() / inside.len() as f64;
            assert!(
                inside.len() > 25 && (mean / truth - 1.0).abs() < 0.05,
                "seed {seed}: {mean} of {truth} kg"
            );
        }
    }
}

/// Algorithm 2's policies on exact data, 3 kg and from 40 s on 5 kg: who is told of the change
/// predicts the power behind it, who is not keeps the old mass.
#[test]
fn schedules_do_what_they_say() {
    let bench = exact();
    // Without noise a tenth of a gram would be a change of the payload.
    bench.put("train.csv", noisy(&drive(80.0, 100.0, |time| if time < 40.0 { 1.0 } else { 6.0 })));
    bench.done(&["fit", "--robot", "robot.toml", "--force", "--out", "c.toml", "train.csv"]);
    bench.put("run.csv", noisy(&drive(80.0, 100.0, |time| if time < 40.0 { 3.0 } else { 5.0 })));
    let run = |rest: &[&str]| estimate(&bench, &[&["--window", "10", "run.csv"], rest].concat());
    let mape = |report: &Value| number(&report["mape_percent"]);
    let share = |report: &Value| number(&report["known_share"]);

    let known = run(&["--schedule", "known", "--changes", "40"]);
    // Unknown until the first bucket of a second is full, at the start and at the change: 2 of 80 s
    // at most.
    assert!(share(&known) > 78.0 / 80.0 && mape(&known) < 1.0, "{} {}", share(&known), mape(&known));
    let untold = run(&["--schedule", "known"]);
    assert!(mape(&untold) > 5.0, "3 kg for 5 kg: {}", mape(&untold));
    assert!(share(&untold) > share(&known), "without a change the mass is held");

    let cumulative = run(&["--schedule", "cumulative", "--changes", "40"]);
    assert!(mape(&cumulative) < 1.0, "{}", mape(&cumulative));
    let mixed = run(&["--schedule", "cumulative"]);
    assert!(mape(&mixed) > 3.0, "both payloads in one sum: {}", mape(&mixed));
    assert!(mape(&mixed) < mape(&untold), "which in time is better than the old mass");

    // Rounds of 40 s begin with the log and with the change; of 70 s, 30 s behind it.
    let periodic = run(&["--schedule", "periodic", "--every", "40"]);
    assert!(mape(&periodic) < 1.0, "{}", mape(&periodic));
    let late = run(&["--schedule", "periodic", "--every", "70"]);
    assert!(mape(&late) > 5.0 && mape(&late) < mape(&untold), "{}", mape(&late));

    // The windows are those of the schedule.
    let times = |report: &Value| -> Vec<[f64; 2]> {
        windows(report)
            .iter()
            .map(|window| ["t0_s", "t1_s"].map(|key| number(&window[key]).round()))
            .collect()
    };
    assert_eq!(times(&known), [[0.0, 10.0], [40.0, 50.0]]);
    assert_eq!(times(&periodic), [[0.0, 10.0], [40.0, 50.0]]);
    let cumulative_times = times(&cumulative);
    assert_eq!((cumulative_times[0], cumulative_times.last()), ([0.0, 10.0], Some(&[40.0, 79.0])));

    for report in [&known, &cumulative] {
        for window in windows(report) {
            let straddles = number(&window["t0_s"]) < 40.0 && 40.0 < number(&window["t1_s"]);
            assert_eq!(straddles, window["mass_kg"].is_null(), "{window}");
        }
    }

    let moving = run(&[]);
    assert_eq!(moving["changes"].as_array().unwrap().len(), 1, "{}", moving["changes"]);
    let blind = run(&["--no-detection"]);
    assert_eq!(blind["changes"], serde_json::json!([]));
    assert!(mape(&moving) < mape(&blind), "{} {}", mape(&moving), mape(&blind));
}

/// Eq. 9: ∫ max(0, P) dt by the trapezium rule over the log, static power included where the robot
/// has it.
#[test]
fn energy_is_the_integral_of_positive_power() {
    let bench = exact();
    let log = drive(50.0, 100.0, |_| 3.0);
    bench.put("run.csv", &log);
    let rows: Vec<Vec<f64>> = log
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|field| field.parse().unwrap()).collect())
        .collect();
    let energy: f64 = rows
        .windows(2)
        .map(|pair| (pair[1][0] - pair[0][0]) * (pair[0][3].max(0.0) + pair[1][3].max(0.0)) / 2.0)
        .sum();
    let estimated = number(&estimate(&bench, &["run.csv"])["energy_j"]);
    assert!((estimated / energy - 1.0).abs() < 0.02, "{estimated} J, {energy} J");
    // The same with 6 W of static power in the log.
    bench.put("robot.toml", format!("{ROBOT}static_power_w = 6\n"));
    let total = rows.iter().fold(crate::common::HEADER.to_owned(), |text, row| {
        text + &format!("{:.4},{:.9},{:.9},{:.9},{}\n", row[0], row[1], row[2], row[3] + 6.0, row[4])
    });
    bench.put("total.csv", total);
    let estimated = number(&estimate(&bench, &["total.csv"])["energy_j"]);
    let energy = energy + 6.0 * (rows[rows.len() - 1][0] - rows[0][0]);
    assert!((estimated / energy - 1.0).abs() < 0.02, "{estimated} J, {energy} J");
}
