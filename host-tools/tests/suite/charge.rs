//! The gauge on a simulated battery that shares no formula with it; `cargo xtask bench charge` has
//! the figures over many seeds.

#[path = "../../benches/charge/run.rs"]
#[allow(dead_code, reason = "the bench has use for all of it")]
mod run;

use model_core::charge::{Gauge, Pack, Start};

use run::{Setting, discharge};

use crate::common::Bench;

/// Started 20 points off and with an unknown resistance: 2 points once settled, no jump over one at
/// a load step. Of six runs one may be worse: where the curve is flat, 10 mV between two makes are
/// 3 points.
#[test]
fn a_discharge_is_followed_within_two_points() {
    let runs: Vec<_> = (1..=6).map(|seed| discharge(seed, Setting::Known)).collect();
    assert!(runs.iter().filter(|run| run.worst <= 2.0).count() >= 5, "{runs:?}");
    for run in &runs {
        assert!(run.jump <= 1.0 && run.worst < 5.0, "{run:?}");
        // What it is there for: the map from voltage lies under load.
        assert!(run.stock > 20.0 && run.stock_jump > 10.0, "{run:?}");
        assert!(run.resistance.abs() < 0.25, "{run:?}");
    }
}

/// Told nothing, a gauge says nothing until a voltage has come.
#[test]
fn unknown_until_known() {
    let mut gauge = Gauge::<f32>::new(Pack::turtlebot3(), Start::Unknown);
    assert_eq!((gauge.charge(), gauge.resistance(), gauge.remaining()), (None, None, None));
    for spoiled in [
        (f32::NAN, 12.0, 0.1),
        (1.0, f32::INFINITY, 0.1),
        (1.0, 12.0, -1.0),
        (1.0, 0.0, 0.1),
        (f32::MAX, 12.0, 9.0),
    ] {
        gauge.update(spoiled.0, spoiled.1, spoiled.2);
    }
    assert_eq!(gauge.charge(), None);
    // At rest, at the voltage of the curve at 60 %.
    let at_rest = 3.0 * Pack::<f32>::turtlebot3().curve.voltage(0.6);
    for _ in 0..600 {
        gauge.update(0.0, at_rest, 0.5);
    }
    let charge = gauge.charge().unwrap();
    assert!((charge.share - 0.6).abs() < 0.03 && charge.std < 0.05, "{charge:?}");
    // Nothing is drawn: nobody can say how long it lasts, nor what the resistance is.
    assert_eq!(gauge.remaining().and_then(|battery| battery.time), None);
    assert_eq!(gauge.resistance(), None);
    let before = charge.std;
    for _ in 0..60 {
        gauge.update(1.0, at_rest - 0.2, 1.0);
    }
    gauge.update(1.0, at_rest, 1800.0);
    assert!(gauge.charge().unwrap().std > before + 0.02, "half an hour unseen at an ampere");
}

/// The firmware's gauge behind its sensor's shunt, on a robot that never rests and told nothing at
/// the start: as good from 20 minutes on, but for two runs of six, and no jump either. Its
/// resistance is the pack's alone: 0.1 Ω of shunt would be 70 % more.
#[test]
fn the_board_follows_a_discharge_that_it_was_not_told_of() {
    let runs: Vec<_> = (1..=6).map(|seed| discharge(seed, Setting::Board)).collect();
    assert!(runs.iter().filter(|run| run.worst <= 2.0).count() >= 4, "{runs:?}");
    for run in &runs {
        assert!(run.jump <= 1.0 && run.worst < 5.0 && run.covered > 0.8, "{run:?}");
        assert!(run.resistance.abs() < 0.25, "{run:?}");
    }
}

#[test]
fn a_battery_that_is_none_is_refused_by_line() {
    let bench = Bench::new();
    bench.put("log.csv", "time_s,wheel1_rad_s,wheel2_rad_s,power_w\n0,0,0,0\n");
    for (battery, expected) in [
        ("capacity_ah = 0\ncells = 3", "capacity_ah; expected 0.01 to 100000"),
        ("capacity_ah = 1.8\ncells = 0", "cells; expected 1 to 400"),
        ("capacity_ah = 1.8", "missing field `cells`"),
        ("capacity_ah = 1.8\ncells = 3\nvolts = 4", "unknown field `volts`"),
        ("capacity_ah = 1.8\ncells = 3\nopen_circuit_v = [[0, 3.0], [0.9, 4.0]]", "rising from 0 to 1"),
    ] {
        bench.put("robot.toml", format!("{}[battery]\n{battery}\n", crate::common::ROBOT));
        let ran = bench.gmr(&["inspect", "--robot", "robot.toml", "log.csv"]);
        assert_eq!(ran.code, Some(1), "{battery}");
        assert!(ran.stderr.contains(expected) && ran.stderr.contains("robot.toml:"), "{}", ran.stderr);
    }
}
