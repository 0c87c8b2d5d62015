//! `gmr predict`: energy of plans against the model worked out by hand, and what is refused.

use std::f64::consts::TAU;

use serde_json::Value;

use crate::common::{Bench, RADIUS, ROBOT, TRUTH, drive, fitted, near, number, power};

fn arguments<'a>(plan: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&["predict", "--robot", "robot.toml", "--coeffs", "c.toml", "--plan", plan], more].concat()
}

fn predict(bench: &Bench, plan: &str, more: &[&str]) -> Value {
    bench.json(&arguments(plan, more))
}

/// 20 s at 0.12 m/s from the start on: P of both wheels at v/r, nothing accelerating. A slope adds
/// m g sin θ r / 2 to each wheel's torque, times g4; the mass alone is what it is uncertain by.
#[test]
fn an_even_speed_costs_what_the_model_says() {
    let bench = fitted();
    bench.put("flat.csv", "time_s,v_m_s,omega_rad_s\n0,0.12,0\n20,0.12,0\n");
    bench.put("hill.csv", "time_s,v_m_s,omega_rad_s,slope_rad\n0,0.12,0,0.05\n20,0.12,0,0.05\n");
    let speed = 0.12 / RADIUS;
    let flat = predict(&bench, "flat.csv", &["--mass", "3"]);
    let expected = 20.0 * power([speed; 2], [0.0; 2], 3.0);
    near(&flat["energy_j"], expected, 0.005);
    near(&flat["distance_m"], 2.4, 0.005);
    assert!(flat["static_power_w"].is_null() && flat["battery"].is_null() && flat["measured_j"].is_null());

    let [a0, a1, g2, _, g4, kappa] = TRUTH;
    let torque = a0 + 3.0 * a1 + g2 * speed + g4 * 3.0 * 9.81 * 0.05_f64.sin() * RADIUS / 2.0;
    let hill = predict(&bench, "hill.csv", &["--mass", "3"]);
    near(&hill["energy_j"], 20.0 * 2.0 * (torque * speed + kappa * torque * torque), 0.005);

    let wide =
        predict(&bench, "flat.csv", &["--mass", "3", "--mass-interval", "2.5,3.5", "--static-power", "5"]);
    let per_kg = 20.0 * (power([speed; 2], [0.0; 2], 3.1) - power([speed; 2], [0.0; 2], 2.9)) / 0.2;
    near(&wide["std_mass_j"], per_kg * 0.5 / 1.96, 0.01);
    near(&wide["energy_j"], expected + 100.0, 0.005);
    assert!(
        number(&wide["high_j"]) - number(&wide["low_j"]) > number(&flat["high_j"]) - number(&flat["low_j"])
    );
}

/// 1 m at 0.1 m/s with ramps of 0.5 m/s² takes 10.2 s; a half turn on the spot by rims at the same
/// acceleration first.
#[test]
fn legs_are_driven_within_the_limits() {
    let bench = fitted();
    bench.put(
        "legs.csv",
        "leg,distance_m,speed_m_s,turn_rad,pause_s\nthere,1,0.1,0,3\nback,1,0.1,3.14159265,0\n",
    );
    let report = predict(&bench, "legs.csv", &["--mass", "2", "--static-power", "5"]);
    let legs = report["legs"].as_array().unwrap();
    assert_eq!((legs.len(), &legs[0]["leg"], &legs[1]["leg"]), (2, &"there".into(), &"back".into()));
    near(&legs[0]["duration_s"], 13.2, 0.01);
    near(&legs[0]["distance_m"], 1.0, 0.01);
    let driving = |leg: &Value| number(&leg["energy_j"]) - 5.0 * number(&leg["duration_s"]);
    assert!(driving(&legs[1]) > 1.1 * driving(&legs[0]), "{legs:?}");
    let sum: f64 = legs.iter().map(|leg| number(&leg["energy_j"])).sum();
    near(&report["energy_j"], sum, 1e-9);
    assert!(report["limits"].as_array().unwrap().iter().all(|limit| limit["is_given"] == false));
    let text = bench.done(&arguments("legs.csv", &["--mass", "2"]));
    assert!(text.stdout.contains("max_acceleration_m_s2 is taken as 0.5"), "{}", text.stdout);
}

/// A speed that swings once a second, as rows at even times tell it: ten a second lose some of its
/// accelerations, and the interval says about how much. Rows at other times are corners.
#[test]
fn what_rows_leave_out_is_in_the_interval() {
    let bench = fitted();
    let row = |time: f64| format!("{time:.6},{:.9},0\n", 0.12 + 0.05 * (TAU * time).sin());
    let plan = |step: f64, late: f64| {
        let count = (20.0 / step).round() as u32;
        let time = |place: u32| step * f64::from(place) + if place % 2 == 1 { late } else { 0.0 };
        let rows: String = (0..=count).map(|place| row(time(place))).collect();
        format!("time_s,v_m_s,omega_rad_s\n{rows}")
    };
    bench.put("fine.csv", plan(0.002, 0.0));
    bench.put("even.csv", plan(0.1, 0.0));
    bench.put("corners.csv", plan(0.1, 0.04));
    let [fine, even, corners] =
        ["fine.csv", "even.csv", "corners.csv"].map(|plan| predict(&bench, plan, &["--mass", "3"]));
    let lost = number(&fine["driving_j"]) - number(&even["driving_j"]);
    let told = number(&even["std_rows_j"]);
    assert!(lost > 0.0 && told > 0.5 * lost && told < 5.0 * lost, "{lost} J lost, {told} told");
    let reach = 0.5 * (number(&even["high_j"]) - number(&even["low_j"]));
    assert!(reach >= 1.9 * told, "{reach}");
    assert!(number(&fine["std_rows_j"]) < 0.01 * told);
    assert_eq!(number(&corners["std_rows_j"]), 0.0);
}

/// What a log measured is shown beside, and it is what the same model made.
#[test]
fn a_log_is_a_plan_with_its_truth() {
    let bench = fitted();
    bench.put("other.csv", drive(40.0, 100.0, |_| 4.0));
    let report = predict(&bench, "other.csv", &["--mass", "4"]);
    near(&report["energy_j"], number(&report["measured_j"]), 0.01);
    let summary = bench.done(&arguments("other.csv", &["--mass", "4"]));
    assert!(summary.stdout.contains("Open-RMF's formula"), "{}", summary.stdout);
}

/// 1.8 A·h of three cells hold some 20 W·h; an hour at 5 W static takes a quarter, ten do not fit.
#[test]
fn the_battery_has_it_or_not() {
    let bench = fitted();
    for (name, pause) in [("short.csv", 3600), ("long.csv", 36_000)] {
        bench.put(name, format!("distance_m,speed_m_s,pause_s\n1,0.1,{pause}\n"));
    }
    let ask = |plan: &str, charge: &str| {
        let more = ["--mass", "2", "--static-power", "5", "--charge", charge];
        predict(&bench, plan, &more)["battery"].clone()
    };
    let short = ask("short.csv", "0.8");
    assert!(number(&short["fits_probability"]) > 0.999, "{short}");
    let after = number(&short["charge_after"]);
    assert!((0.5..0.6).contains(&after), "{short}");
    assert!(number(&short["charge_after_low"]) < after && after < number(&short["charge_after_high"]));
    assert!(number(&ask("long.csv", "1")["fits_probability"]) < 0.001);
    // As much as there is: a coin's throw.
    let even = number(&short["available_j"]) / 5.0;
    bench.put("even.csv", format!("distance_m,speed_m_s,pause_s\n0,0.1,{even}\n"));
    assert!((0.2..0.8).contains(&number(&ask("even.csv", "0.8")["fits_probability"])));
}

#[test]
fn what_is_no_plan_is_refused_in_one_line() {
    let bench = fitted();
    bench.put("robot2.toml", ROBOT);
    bench.put("flat.csv", "time_s,v_m_s,omega_rad_s\n0,0.12,0\n20,0.12,0\n");
    let refused = |plan: &str, more: &[&str], code: i32, expected: &str| {
        let all = ["predict", "--robot", "robot.toml", "--coeffs", "c.toml", "--plan", plan];
        let ran = bench.gmr(&[&all[..], more].concat());
        assert_eq!(ran.code, Some(code), "{plan}: {}", ran.stderr);
        assert!(ran.stderr.contains(expected) && ran.stderr.lines().count() == 1, "{}", ran.stderr);
    };
    for (plan, expected) in [
        ("x,y\n1,2\n", "expected a plan"),
        ("time_s,v_m_s,omega_rad_s\n0,0.1,0\n", "has 1 rows; expected 2"),
        ("time_s,v_m_s,omega_rad_s\n0,0.1,0\n0,0.1,0\n", "plan.csv:3"),
        ("time_s,v_m_s\n0,0.1\n1,0.1\n", "omega_rad_s"),
        ("distance_m,speed_m_s\n1,0\n", "m/s above 0 where the leg has a distance"),
        ("distance_m,speed_m_s,slope_rad\n1,1,2\n", "-0.8 to 0.8"),
        ("distance_m,speed_m_s,pause_s\n1,0.1,1000000\n", "s; expected at most"),
        ("distance_m,speed_m_s\n1,1e-9\n", "s; expected at most"),
    ] {
        bench.put("plan.csv", plan);
        refused("plan.csv", &["--mass", "2"], 1, expected);
    }
    refused("flat.csv", &["--mass", "0"], 2, "expected a mass above 0 kg");
    refused("flat.csv", &["--mass", "2", "--mass-interval", "3,4"], 2, "about the mass of 2 kg");
    refused("flat.csv", &["--mass", "2", "--charge", "80"], 2, "expected a share of 0 to 1");
    refused("flat.csv", &["--mass", "2", "--charge", "0.8"], 1, "expected --static-power");
}

/// Two wheels of 0.1 m straight ahead, speeding up and slowing down, on drives that return what
/// they brake.
fn regenerating(mass: f64, seconds: f64) -> (String, [f64; 2]) {
    let (mut text, mut net, mut drawn) =
        ("time_s,wheel1_rad_s,wheel2_rad_s,power_w,mass_kg\n".to_owned(), 0.0, 0.0);
    for i in 0..(seconds * 50.0) as u32 {
        let t = f64::from(i) / 50.0;
        // Fast and slow, so that every parameter is told apart.
        let (rate, fast) = (0.9 + 0.4 * (0.03 * t).sin(), 5.0 + 2.0 * (0.011 * t).sin());
        let (speed, acceleration) = (fast + 4.0 * (rate * t).sin(), 4.0 * rate * (rate * t).cos());
        let torque = 0.3 + 0.004 * mass + 0.01 * speed + (0.02 + 1.3 * mass * 0.005) * acceleration;
        let power = 2.0 * torque * (speed + 0.2 * torque);
        (net, drawn) = (net + power / 50.0, drawn + power.max(0.0) / 50.0);
        text += &format!("{t},{speed},{speed},{power},{mass}\n");
    }
    (text, [net, drawn])
}

/// One energy: what `estimate` measures, what it predicts and what `predict` says are what the
/// battery gives less what it takes.
#[test]
fn energy_is_one_where_drives_return_power() {
    let bench = Bench::new();
    bench.put(
        "robot.toml",
        "name = \"r\"\nkinematics = \"differential\"\nwheel_radius_m = 0.1\ntrack_m = 0.4\ngyration_radius_m = 0.2\n\
         mass_no_load_kg = 10\nmass_full_load_kg = 60\nregeneration = true\nfilter_cutoff_hz = 8\n",
    );
    bench.put("empty.csv", regenerating(10.0, 150.0).0);
    bench.put("full.csv", regenerating(60.0, 150.0).0);
    let (log, [net, drawn]) = regenerating(45.0, 150.0);
    bench.put("log.csv", log);
    assert!(drawn > 1.1 * net, "{drawn} {net}");
    bench.done(&["fit", "--robot", "robot.toml", "--out", "c.toml", "empty.csv", "full.csv"]);
    let report = bench.json(&["estimate", "--robot", "robot.toml", "--coeffs", "c.toml", "log.csv"]);
    near(&report["energy_j"], net, 0.01);
    near(&report["told"]["predicted_j"], net, 0.01);
    let planned = predict(&bench, "log.csv", &["--mass", "45"]);
    near(&planned["driving_j"], net, 0.01);
    near(&planned["measured_j"], net, 0.01);
}
