//! `gmr fit` from the outside: what it prints and writes, and that it finds what made the data.

use crate::common::{Bench, NAMES, ROBOT, TRUTH, drive, keys, number};
use serde_json::Value;

const FIT: [&str; 5] = ["fit", "--robot", "robot.toml", "--out", "c.toml"];

/// Two logs of 60 s that the model made, at 1 and 6 kg.
fn two_payloads() -> Bench {
    let bench = Bench::new();
    bench.put("robot.toml", ROBOT);
    bench.put("light.csv", drive(60.0, 100.0, |_| 1.0));
    bench.put("heavy.csv", drive(60.0, 100.0, |_| 6.0));
    bench
}

fn fit(bench: &Bench, rest: &[&str]) -> Value {
    bench.json(&[&FIT[..], rest].concat())
}

fn parameter<'a>(report: &'a Value, name: &str) -> &'a Value {
    let parameters = report["parameters"].as_array().unwrap();
    parameters.iter().find(|parameter| parameter["name"] == name).unwrap_or_else(|| panic!("no {name}"))
}

/// What scripts rely on.
#[test]
fn the_json_has_the_documented_keys() {
    let report = fit(&two_payloads(), &["light.csv", "heavy.csv"]);
    for key in ["r2", "mape_percent", "rmse_w", "condition"] {
        assert!(number(&report[key]).is_finite(), "{key}");
    }
    assert_eq!(report["rows"], 12_000);
    assert_eq!(report["masses_kg"], serde_json::json!([1.0, 6.0]));
    assert!(report["ending"].as_str().unwrap().starts_with("converged-by-"), "{report}");
    let parameters = report["parameters"].as_array().unwrap();
    let names: Vec<&str> = parameters.iter().map(|p| p["name"].as_str().unwrap()).collect();
    assert_eq!(names, NAMES, "wheels that are not dragged sideways have no scrub");
    for parameter in parameters {
        assert_eq!(keys(parameter), ["name", "value", "unit", "std_err", "verdict", "advice"]);
        assert!(number(&parameter["value"]) >= 0.0 && number(&parameter["std_err"]) >= 0.0);
        assert!(parameter["unit"].is_string());
        assert_eq!(parameter["verdict"], "determined", "{parameter}");
    }
}

/// Data made by P = Σ max(0, τ w + κ τ²) give their parameters back. What is left is the filter: it
/// delays tones by 3.24/(2π f_c) = 26 ms, but one of frequency f by a share of some (f/f_c)² more,
/// so a product lags behind its factors. The fastest products run at 2 · 0.68 Hz: 26 ms · (1.4/20)²
/// · 2π · 1.4 Hz = 0.1 %. Kinks, where a wheel turns round or the clamp lets go, cost R², but they
/// lag and lead alike.
#[test]
fn the_model_finds_its_own_parameters() {
    let report = fit(&two_payloads(), &["light.csv", "heavy.csv"]);
    assert!(number(&report["r2"]) > 0.999, "{}", report["r2"]);
    for (name, truth) in NAMES.into_iter().zip(TRUTH) {
        let value = number(&parameter(&report, name)["value"]);
        println!("{name}: {value} {truth}: {:.3} %", 100.0 * (value / truth - 1.0));
        assert!((value / truth - 1.0).abs() < 1e-3, "{name}: found {value}, truth {truth}");
    }
}

/// With two payloads the columns 1, m and m² have rank 2; a third settles them.
#[test]
fn constants_of_eq18_need_three_payloads() {
    let bench = two_payloads();
    let report = fit(&bench, &["--model", "eq18", "light.csv", "heavy.csv"]);
    assert_eq!(report["parameters"].as_array().unwrap().len(), 15);
    assert!(report["condition"].is_null());
    for name in ["beta0", "beta1", "beta2"] {
        let coefficient = parameter(&report, name);
        assert_eq!(coefficient["verdict"], "undetermined", "{coefficient}");
        assert!(coefficient["std_err"].is_null(), "{coefficient}");
        let advice = coefficient["advice"].as_str().unwrap();
        assert!(advice.contains("at least three payloads"), "{advice}");
        for other in ["beta0", "beta1", "beta2"].into_iter().filter(|other| *other != name) {
            assert!(advice.contains(other), "{name} is confused with {other}: {advice}");
        }
    }
}

/// Data of Eq. 18 itself, its constants among them: three payloads determine β0 to β2, and the
/// values are found.
#[test]
fn three_payloads_determine_the_constants_of_eq18() {
    let bench = Bench::new();
    bench.put("robot.toml", ROBOT);
    let beta = [0.4, 0.3, 0.05];
    for (name, mass) in [("a.csv", 1.0), ("b.csv", 3.0), ("c.csv", 6.0)] {
        // Two wheels, so every constant counts twice; a little viscous power on top.
        let mut text = crate::common::HEADER.to_owned();
        for row in 0..6000 {
            let time = f64::from(row) * 0.01;
            let ([left, right], _) = crate::common::motion(time);
            let constant: f64 = 2.0 * (beta[0] + beta[1] * mass + beta[2] * mass * mass);
            let noise = 1e-3 * (f64::from(row * 7919 % 101) / 50.0 - 1.0);
            let power = constant + 0.01 * (left * left + right * right) + noise;
            text += &format!("{time:.2},{left:.9},{right:.9},{power:.9},{mass}\n");
        }
        bench.put(name, text);
    }
    let three = fit(&bench, &["--model", "eq18", "a.csv", "b.csv", "c.csv"]);
    for (name, truth) in ["beta0", "beta1", "beta2", "beta3"].into_iter().zip([0.4, 0.3, 0.05, 0.01]) {
        let coefficient = parameter(&three, name);
        assert_eq!(coefficient["verdict"], "determined", "{coefficient}");
        assert!((number(&coefficient["value"]) / truth - 1.0).abs() < 0.01, "{coefficient}");
    }
    let two = fit(&bench, &["--model", "eq18", "a.csv", "c.csv"]);
    assert_eq!(parameter(&two, "beta1")["verdict"], "undetermined");
}

/// Wheels that jump from standing to 6 rad/s and back seven times in 0.35 s, and a power that has
/// nothing to do with them: 40,000 rows of what no robot makes. The search is cut short, says so,
/// and has taken no more than all its starts (24, of 200 steps each) and three ends of them.
#[test]
fn a_search_without_end_is_cut_short() {
    let bench = Bench::new();
    // The cutoff is the search's to choose.
    bench.put("robot.toml", ROBOT.replace("filter_cutoff_hz = 20\n", ""));
    let mut text = crate::common::HEADER.to_owned();
    for row in 0..40_000 {
        let (speed, power) = (row % 7, 1 + row % 3);
        let mass = if row < 20_000 { 1 } else { 6 };
        text += &format!("{:.2},{speed},{speed},{power},{mass}\n", f64::from(row) * 0.05);
    }
    bench.put("none.csv", text);
    let refused = bench.gmr(&[&FIT[..], &["none.csv"]].concat());
    assert_eq!(refused.code, Some(1), "{}", refused.stderr);
    assert!(refused.stderr.contains("NOT USABLE ("), "{}", refused.stderr);
    assert!(refused.stderr.contains("no minimum after "), "{}", refused.stderr);
    assert!(refused.stderr.contains("gmr inspect"), "{}", refused.stderr);
    let report = fit(&bench, &["--force", "none.csv"]);
    assert!(number(&report["iterations"]) <= 24.0 * 200.0 + 3.0 * 200.0, "{}", report["iterations"]);
    let warnings = report["warnings"].as_array().unwrap();
    assert!(warnings.iter().any(|warning| warning["kind"] == "long-search"), "{report}");
}

#[test]
fn the_same_logs_give_the_same_bytes() {
    let bench = two_payloads();
    for model in ["signed", "eq18", "eq18-published"] {
        let written = |name: &str| {
            let arguments =
                ["fit", "--robot", "robot.toml", "--model", model, "--out", name, "light.csv", "heavy.csv"];
            bench.done(&arguments);
            bench.text(name)
        };
        assert_eq!(written("one.toml"), written("two.toml"), "{model}");
    }
}

/// `[parameters]` are in the model's order: that of the covariance's rows.
#[test]
fn the_covariance_is_in_the_order_of_the_parameters() {
    let bench = two_payloads();
    let report = fit(&bench, &["light.csv", "heavy.csv"]);
    let text = bench.text("c.toml");
    let section = text.split("[parameters]\n").nth(1).unwrap().split("\n[").next().unwrap();
    let names: Vec<&str> = section.lines().filter_map(|line| Some(line.split_once(" = ")?.0)).collect();
    assert_eq!(names, NAMES);
    let document: toml::Table = text.parse().unwrap();
    let covariance = document["fit"]["covariance"].as_array().unwrap();
    assert_eq!(covariance.len(), NAMES.len());
    for (index, name) in NAMES.into_iter().enumerate() {
        let variance = covariance[index].as_array().unwrap()[index].as_float().unwrap();
        let std_err = number(&parameter(&report, name)["std_err"]);
        assert!((variance.sqrt() / std_err - 1.0).abs() < 1e-9, "{name}: {variance} {std_err}");
    }
}

/// The plant's wheel speeds of a twist give the twist back: both count the wheels alike. (A fit
/// alone would not tell for the omni robot, whose mass matrix is the same in every order.)
#[test]
fn plant_and_model_count_the_wheels_alike() {
    use model_core::kinematics::Kinematics;
    use plant::{Geometry, Kinematics as Layout};
    fn check<const N: usize>(layout: Layout, model: &Kinematics<f64, N>, twist: [f64; 3]) {
        let geometry = Geometry { kinematics: layout, wheel_radius_m: 0.05, track_m: 0.4, wheelbase_m: 0.3 };
        let all = geometry.wheel_speeds(twist);
        let back = model.twist(&std::array::from_fn(|wheel| all[wheel]));
        for (value, expected) in [back.vx, back.vy, back.omega].into_iter().zip(twist) {
            // A dozen roundings of numbers near 1.
            assert!((value - expected).abs() < 1e-14, "{layout:?}: {value} {expected}");
        }
    }
    check(Layout::Differential, &Kinematics::differential(0.05, 0.4).unwrap(), [0.3, 0.0, 0.7]);
    check(Layout::Skid, &Kinematics::skid_steer(0.05, 0.4).unwrap(), [0.3, 0.0, 0.7]);
    check(Layout::Omni, &Kinematics::omni(0.05, 0.2).unwrap(), [0.3, -0.2, 0.7]);
    check(Layout::Mecanum, &Kinematics::mecanum(0.05, 0.15, 0.2).unwrap(), [0.3, -0.2, 0.7]);
}

/// Every kinematics from the plant's logs to a mass: the plant shares no formula with the model. 10
/// % is no test of the wheels' order (see above), but of the whole way.
#[test]
fn every_kinematics_fits_the_plant_and_finds_the_payload() {
    let lengths =
        "wheel_radius_m = 0.033\ngyration_radius_m = 0.06\nmass_no_load_kg = 1\nmass_full_load_kg = 6\n";
    // The plant's omni wheels by hand: a wheel at φ drives along (−sin φ, cos φ); φ = 60°, 180°,
    // 300°. R is the inverse.
    let (r, arm) = (0.033, 0.08);
    let (side, third) = (r / 3.0_f64.sqrt(), r / 3.0);
    let turn = third / arm;
    let matrix = format!(
        "matrix = [[{}, 0.0, {side}], [{third}, {}, {third}], [{turn}, {turn}, {turn}]]",
        -side,
        -2.0 * third
    );
    let cases = [
        ("differential", "differential", "track_m = 0.16".to_owned()),
        ("skid", "skid-steer", "track_m = 0.16\nwheels = 4".to_owned()),
        ("omni", "omni3", "arm_m = 0.08".to_owned()),
        ("mecanum", "mecanum", "half_length_m = 0.08\nhalf_width_m = 0.08".to_owned()),
        ("omni", "matrix", matrix),
    ];
    let bench = Bench::new();
    for (plant, kinematics, rest) in cases {
        bench.put("robot.toml", format!("name = \"r\"\nkinematics = \"{kinematics}\"\n{lengths}{rest}\n"));
        bench.simulate("train.csv", &["--kinematics", plant, "--duration", "120", "--mass", "1@0,6@60"]);
        bench.simulate(
            "test.csv",
            &["--kinematics", plant, "--duration", "60", "--mass", "4.5", "--seed", "2", "--profile", "test"],
        );
        let report = fit(&bench, &["train.csv"]);
        let r2 = number(&report["r2"]);
        assert!(r2 > 0.95, "{kinematics}: R² {r2}");
        let replay = bench.json(&[
            "estimate",
            "--robot",
            "robot.toml",
            "--coeffs",
            "c.toml",
            "--window",
            "25",
            "test.csv",
        ]);
        let windows = replay["windows"].as_array().unwrap();
        let masses: Vec<f64> = windows.iter().filter_map(|window| window["mass_kg"].as_f64()).collect();
        assert!(masses.len() > 25, "{kinematics}: {} of {} windows", masses.len(), windows.len());
        let mean = masses.iter().sum::<f64>() / masses.len() as f64;
        println!("{kinematics}: R² {r2:.5}, mass {mean:.3} kg of 4.5 kg");
        assert!((mean / 4.5 - 1.0).abs() < 0.1, "{kinematics}: mean mass {mean} kg of 4.5 kg");
    }
}
