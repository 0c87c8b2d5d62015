//! The simulation's side of `gmr gap`: the plant along the recorded speeds, without the named
//! effect and with it.

use std::sync::OnceLock;

use crate::common::{Bench, number};
use serde_json::Value;

/// Masses of the field's runs, kg.
const FIELD: [&str; 6] = ["1.2", "5.6", "2.4", "4.1", "3.3", "1.8"];

/// A run of a robot with gear motors: 40 s at 20 Hz, 0.05 W of noise.
fn simulate(bench: &Bench, name: &str, place: usize, mass: &str, seed: usize, more: &[&str]) {
    let profile = if place.is_multiple_of(2) { "training" } else { "test" };
    let seed = seed.to_string();
    let common = ["--plant", "gearmotor", "--sensors", "servo", "--rate", "20", "--power-noise", "0.05"];
    let drive = ["--duration", "40", "--profile", profile, "--mass", mass, "--seed", &seed];
    bench.simulate(name, &[&common[..], &drive, more].concat());
}

/// Four clean runs and the coefficients fitted to them.
fn clean() -> &'static Bench {
    static BENCH: OnceLock<Bench> = OnceLock::new();
    BENCH.get_or_init(|| {
        let bench = Bench::new();
        let names: Vec<String> = (1..=4).map(|k| format!("base_{k}.csv")).collect();
        for (k, (name, mass)) in names.iter().zip(["1", "6", "2.5", "4"]).enumerate() {
            simulate(&bench, name, k, mass, 100 + k, &[]);
        }
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        bench.done(&[&["fit", "--out", "base.toml"], &names[..]].concat());
        bench
    })
}

/// What `gmr gap` says of field runs with an effect that is hidden in them.
fn gap(hidden: &str, more: &[&str]) -> Value {
    let bench = Bench::new();
    for name in clean().files() {
        bench.put(&name, std::fs::read(clean().path(&name)).unwrap());
    }
    let names: Vec<String> = (1..=FIELD.len()).map(|k| format!("field_{k}.csv")).collect();
    for (k, name) in names.iter().enumerate() {
        simulate(&bench, name, k, FIELD[k], 200 + k, &["--effect", hidden]);
    }
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    bench.json(&[&["gap", "--coeffs", "base.toml"], more, &names[..]].concat())
}

/// The plant, which shares no formula with the model, gets the effect as a cause, and its size is
/// that of the hidden one. The calibration knows friction to some ten percent, so a share of the
/// viscous friction is known no better.
#[test]
fn the_simulations_gap_shrinks_when_the_effect_is_added_to_the_plant() {
    for (hidden, id, size, within) in [
        ("grade=0.02:along=travel", "grade", 0.02, 0.05),
        ("viscous-change=0.6", "viscous-change", 0.6, 0.2),
        ("wheel-drag=0.02:side=right", "wheel-drag", 0.02, 0.05),
    ] {
        let report = gap(hidden, &["--plant", "gearmotor"]);
        let simulation = &report["simulation"];
        assert_eq!(simulation["effects"][0]["id"], id, "{report:#}");
        let added = number(&simulation["effects"][0]["size"]);
        assert!((added / size - 1.0).abs() < within, "{id}: {added}");
        let [before, after, closed] =
            ["gap_before_w", "gap_after_w", "gap_closed"].map(|key| number(&simulation[key]));
        assert!(closed >= 0.8 && after < before, "{id}: {before} {after} {closed}");
        // Without any reference to a floor as well: the effect is far above it.
        assert!(1.0 - (after / before).powi(2) >= 0.8, "{id}: {before} {after}");
        // The plant's wheels keep to the recorded speeds, or it would be another drive.
        assert!(number(&simulation["speed_missed"]) < 0.03, "{simulation:#}");
        let runs = simulation["runs"].as_array().unwrap();
        assert_eq!(runs.iter().filter(|run| run["locked"] == true).count(), 2);
        for run in runs.iter().filter(|run| run["locked"] == true) {
            assert!(number(&run["gap_after_w"]) < number(&run["gap_before_w"]), "{id}: {run}");
        }
    }
}

#[test]
fn without_a_plant_nothing_is_simulated() {
    let report = gap("grade=0.02:along=travel", &[]);
    assert!(report["simulation"].is_null());
    assert!(report["manoeuvre"].is_null() && report["suggested_profile"].is_null());
}

/// Servos reach a quarter of the recorded speeds.
#[test]
fn a_plant_that_cannot_follow_says_so() {
    let report = gap("grade=0.02:along=travel", &["--plant", "servo"]);
    assert!(number(&report["simulation"]["speed_missed"]) > 0.05, "{:#}", report["simulation"]);
}
