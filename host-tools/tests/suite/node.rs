//! `gmr node`: what it says is what `gmr estimate` says; a DDS peer that is not ours hears and
//! feeds it.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::common::skipped::skipped;
use crate::common::{Bench, ROBOT, drive, is_documented, number};

/// Drawn besides driving, W: the sensor is in the battery's wire.
const STATIC_W: f64 = 2.0;

/// A robot with two fitted drives, and a third of 3 kg with the battery's voltage.
fn bench() -> Bench {
    let bench = Bench::new();
    let battery = "[battery]\ncapacity_ah = 1.8\ncells = 3\ncutoff_v = 9\n";
    let robot = format!("{ROBOT}static_power_w = {STATIC_W}\n");
    bench.put("robot.toml", format!("{robot}{battery}"));
    bench.put("odometry.toml", format!("{robot}{battery}[node]\nodometry = \"/odom\"\n"));
    let product = |side: &str, unit: &str, scale: f64| {
        let field = |of: &str| format!("\"/{side}/odrive_status:bus_{of}\"");
        format!(
            "{{ voltage = {{ field = {}, unit = \"{unit}\" }}, current = {{ field = {}, scale = {scale} }} }}",
            field("voltage"),
            field("current")
        )
    };
    let power = format!("power = [{}, {}]\n", product("left", "V", 1.0), product("right", "mV", -1.0));
    bench.put("drivers.toml", format!("{robot}{battery}[node]\nsensor = \"topics\"\n[topics]\n{power}"));
    for (name, seconds, mass) in [("empty.csv", 40.0, 1.0), ("full.csv", 40.0, 6.0), ("log.csv", 100.0, 3.0)]
    {
        bench.put(name, with_battery(&drive(seconds, 50.0, |_| mass)));
    }
    bench.done(&["fit", "--robot", "robot.toml", "--out", "coefficients.toml", "empty.csv", "full.csv"]);
    bench
}

/// The same with the static power, and 12 V. The log tells the mass, which nobody may use.
fn with_battery(log: &str) -> String {
    let mut lines = log.lines();
    let mut text = format!("{},bus_v\n", lines.next().unwrap());
    for line in lines {
        let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
        fields[3] = format!("{:.9}", fields[3].parse::<f64>().unwrap() + STATIC_W);
        text += &format!("{},12\n", fields.join(","));
    }
    text
}

fn replayed(bench: &Bench, more: &[&str]) -> Vec<Value> {
    let replay =
        ["node", "--robot", "robot.toml", "--replay", "log.csv", "--no-ros", "--speed", "max", "--json"];
    let ran = bench.done(&[&replay, more].concat());
    ran.stdout.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// Bit for bit, at every second.
#[test]
fn says_what_estimate_says() {
    let bench = bench();
    let states = replayed(&bench, &["--coeffs", "coefficients.toml"]);
    bench.done(&[
        "estimate",
        "--robot",
        "robot.toml",
        "--coeffs",
        "coefficients.toml",
        "--power",
        "power.csv",
        "log.csv",
    ]);
    let text = bench.text("power.csv");
    let rows: Vec<Vec<&str>> = text.lines().skip(1).map(|line| line.split(',').collect()).collect();
    let mut compared = 0;
    for state in &states {
        let time = number(&state["time_s"]);
        let Some(row) = rows.iter().find(|row| row[0].parse() == Ok(time)) else { continue };
        let written = |value: &Value| value.as_f64().map_or(String::new(), |value| value.to_string());
        let shown = ["measured_w", "predicted_w", "mass_kg"].map(|key| written(&state[key]));
        assert_eq!(shown, [row[1], row[2], row[4]], "{state}");
        if let Some(mass) = state["mass_kg"].as_f64() {
            assert!((mass - 3.0).abs() < 0.05, "{state}");
            assert!((number(&state["payload_kg"]) - (mass - 1.0)).abs() < 1e-12, "{state}");
            compared += 1;
        }
    }
    assert!(states.len() >= 99 && compared > 70, "{} {compared}", states.len());
}

/// A sensor in the motors' wire reads below 0 W every other time while the robot stands: no reading
/// is left out.
#[test]
fn noise_at_rest_is_no_fault() {
    let bench = Bench::new();
    bench.put("robot.toml", ROBOT);
    for (name, mass, seed) in [("empty.csv", "1", "1"), ("full.csv", "6", "2"), ("log.csv", "3", "3")] {
        let drive = ["--sensors", "servo", "--duration", "60", "--mass", mass, "--seed", seed];
        bench.simulate(name, &drive);
    }
    let below = bench.text("log.csv").lines().filter(|line| line.contains(",-0.")).count();
    assert!(below > 50, "{below}");
    bench.done(&["fit", "--robot", "robot.toml", "--out", "coefficients.toml", "empty.csv", "full.csv"]);
    let states = replayed(&bench, &["--coeffs", "coefficients.toml"]);
    let last = states.last().unwrap();
    assert_eq!(last["faults"].as_object().map(serde_json::Map::len), Some(0), "{last}");
    let estimate = ["estimate", "--robot", "robot.toml", "--coeffs", "coefficients.toml", "log.csv"];
    let windows = bench.json(&estimate)["windows"].clone();
    assert_eq!(windows.as_array().unwrap().last().unwrap()["mass_kg"], last["mass_kg"]);
}

/// All that flows out of the battery flows through the sensor, as far as robot.toml says so.
#[test]
fn current_and_charge_only_where_the_sensor_sees_them() {
    let bench = bench();
    let states = replayed(&bench, &["--charge", "0.7"]);
    let last = states.last().unwrap();
    assert_eq!(last["state"], "unknown");
    is_documented("node", last);
    assert!(last["why"].as_str().unwrap().contains("--coeffs"), "{last}");
    assert!((number(&last["current_a"]) - number(&last["power_w"]) / 12.0).abs() < 1e-12);
    assert!((0.5..0.75).contains(&number(&last["charge"])) && number(&last["remaining_j"]) > 0.0);
    // Without a voltage there is power, and no more.
    let log = bench.text("log.csv");
    bench.put("log.csv", log.replace("bus_v", "other_v"));
    for state in replayed(&bench, &["--charge", "0.7"]) {
        let unknown = ["voltage_v", "current_a", "remaining_s"].map(|key| state[key].is_null());
        assert!(unknown == [true; 3] && number(&state["power_w"]) >= STATIC_W, "{state}");
    }
    bench.put("log.csv", log);
    bench.put("robot.toml", format!("{ROBOT}[battery]\ncapacity_ah = 1.8\ncells = 3\n"));
    let states = replayed(&bench, &["--charge", "0.7"]);
    let last = states.last().unwrap();
    assert!(
        last["current_a"].is_null() && last["charge"].is_null() && last["remaining_j"].is_null(),
        "{last}"
    );
    assert!(
        last["no_charge"].as_str().unwrap().contains("static_power_w") && last["voltage_v"] == 12.0,
        "{last}"
    );
}

/// A log's pace is a clock's: 3 s at 10 times its speed take 0.3 s at least.
#[test]
fn keeps_the_logs_pace() {
    let bench = bench();
    let head: Vec<String> = bench.text("log.csv").lines().take(151).map(str::to_owned).collect();
    bench.put("log.csv", head.join("\n") + "\n");
    let began = std::time::Instant::now();
    bench.done(&["node", "--robot", "robot.toml", "--replay", "log.csv", "--no-ros", "--speed", "10"]);
    assert!(began.elapsed().as_secs_f64() > 0.29, "{:?}", began.elapsed());
}

#[test]
fn what_does_not_fit_together_is_refused() {
    let bench = bench();
    let refused = |arguments: &[&str], code: i32, said: &str| {
        let ran = bench.gmr(&[&["node", "--robot", "robot.toml"], arguments].concat());
        assert_eq!(ran.code, Some(code), "{arguments:?}: {}", ran.stderr);
        assert!(ran.stderr.contains(said), "{arguments:?}: {}", ran.stderr);
    };
    let replay = ["--replay", "log.csv", "--no-ros"];
    let with = |more: &[&'static str]| [&replay, more].concat();
    refused(&with(&["--wheels", "topic"]), 2, "--no-ros");
    refused(&with(&["--speed", "0"]), 2, "--speed 0");
    refused(&with(&["--every", "0"]), 2, "--every 0");
    refused(&with(&["--charge", "70"]), 2, "0 to 1");
    refused(&["--no-ros"], 2, "--replay");
    refused(&["--bus", "/dev/no-such-bus", "--domain", "77"], 1, "/dev/no-such-bus: ");
    refused(&["--domain", "233"], 2, "0 to 232");
    bench.put("robot.toml", format!("{ROBOT}[node]\npayload = \"load\"\n"));
    refused(&replay, 1, "robot.toml:9:1: [node]: payload = \"load\"; expected an absolute topic");
    bench.put("robot.toml", format!("{ROBOT}[node]\nsensor = \"ina3221\"\n"));
    refused(&replay, 1, "ina219");
    bench.put("robot.toml", ROBOT);
    refused(&["--sensor", "topics", "--domain", "77"], 2, "names no power; expected power as a field");
}

/// PyPI's cyclonedds, in an environment of its own: `tests/node/peer.py`.
#[test]
fn a_peer_that_is_not_ours_hears_and_feeds_it() {
    let gmr = Path::new(env!("CARGO_BIN_EXE_gmr"));
    let python = gmr.ancestors().nth(2).unwrap().join("node-python/venv/bin/python");
    if !python.exists() {
        return skipped(
            "no virtual environment in target/node-python: cargo xtask test-node makes it, of PyPI's cyclonedds",
        );
    }
    let bench = bench();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/node/peer.py");
    let output = Command::new(python)
        .arg(script)
        .args([gmr, &bench.path("")])
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
    println!("{said}");
    assert!(output.status.success(), "{}\n{said}", output.status);
}

/// A sensor the other way round, or a number that no robot draws, is left out, counted, and no
/// power.
#[test]
fn a_power_that_no_robot_draws_is_left_out() {
    let bench = bench();
    let good = bench.text("log.csv");
    for (power, said) in
        [("-5000", "power below 0 W without regeneration"), ("1e8", "power that no robot draws")]
    {
        let wrong = good.lines().enumerate().map(|(place, line)| {
            let mut fields: Vec<&str> = line.split(',').collect();
            if place > 0 {
                fields[3] = power;
            }
            fields.join(",") + "\n"
        });
        bench.put("log.csv", wrong.collect::<String>());
        let states = replayed(&bench, &["--coeffs", "coefficients.toml"]);
        let last = states.last().unwrap();
        assert_eq!(last["state"], "no-power", "{last}");
        assert!(last["power_w"].is_null() && last["mass_kg"].is_null(), "{last}");
        let faults = last["faults"].as_object().unwrap();
        let count = faults.iter().find(|(what, _)| what.starts_with(said)).map(|(_, count)| count.as_u64());
        assert!(count.flatten().is_some_and(|count| count > 1000), "{faults:?}");
    }
}
