//! `gmr look`: logs at a glance, without a robot.toml.

use std::path::Path;

use serde_json::Value;

use crate::common::Bench;

fn copy(bench: &Bench, name: &str) -> String {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("formats/tests/data").join(name);
    bench.put(name, std::fs::read(from).unwrap());
    name.to_owned()
}

fn look(bench: &Bench, log: &str) -> Value {
    let ran = bench.gmr(&["look", "--json", log]);
    assert_eq!(ran.code, Some(0), "{log}: {}", ran.stderr);
    serde_json::from_str(&ran.stdout).unwrap()
}

fn near(found: &Value, expected: f64, share: f64) {
    let found = found.as_f64().unwrap();
    assert!((found - expected).abs() <= share * expected.abs(), "{found} {expected}");
}

/// Summed here from the rows that the bag was made of: its odometry is v = r (w1 + w2) / 2, its power comes with every row.
#[test]
fn energy_and_way_are_those_of_the_drive() {
    let bench = Bench::new();
    let log = copy(&bench, "odometry.mcap");
    copy(&bench, "drive.csv");
    let drive = bench.text("drive.csv");
    let rows: Vec<Vec<f64>> = drive
        .lines()
        .skip(1)
        .take(400)
        .map(|line| line.split(',').map(|field| field.parse().unwrap()).collect())
        .collect();
    let (mut way, mut energy) = (0.0, 0.0);
    for row in &rows[1..] {
        way += 0.05 * (0.033 * 0.5 * (row[1] + row[2])).abs();
        energy += 0.05 * row[3];
    }
    let found = look(&bench, &log);
    near(&found["distance_m"], way, 1e-9);
    // Power bears no stamp: it comes 20 ms behind the odometry's, and the first row is before it.
    near(&found["energy_j"], energy, 0.02);
    assert_eq!(found["rows"], 400);
    assert_eq!(found["longest_gap_s"], 0.0);
    let cells = found["power_over_speed"].as_array().unwrap();
    assert!(cells.len() >= 2, "{cells:?}");
}

/// Each robot's bag, and what would make more of it.
#[test]
fn the_cheapest_sensor_is_named() {
    let bench = Bench::new();
    let next = |log: &str| look(&bench, &copy(&bench, log))["next"].as_str().unwrap().to_owned();
    assert!(
        next("turtlebot3.mcap").starts_with("one INA219 in the motors' wire"),
        "{}",
        next("turtlebot3.mcap")
    );
    assert!(next("clearpath.mcap").starts_with("no sensor: a second log with the full payload"));
    assert!(next("husarion.db3").starts_with("no sensor: a second log with the full payload"));
    assert!(next("odometry.mcap").starts_with("no sensor: record /joint_states"));
    assert!(next("drive.parquet").starts_with("nothing"));
    let turtle = look(&bench, "turtlebot3.mcap");
    assert!(turtle["energy_j"].is_null() && turtle["charge"]["drawn_ah"].is_null());
    near(&turtle["charge"]["first"], 0.9, 1e-6);
    assert!(turtle["impossible"][0].as_str().unwrap().contains("current is 0 in every message"));
}

/// Self-contained, well-formed, and in the colours and width of whoever looks.
#[test]
fn the_page_stands_alone() {
    let bench = Bench::new();
    let log = copy(&bench, "clearpath.mcap");
    let ran = bench.gmr(&["look", &log, "--page", "look.html"]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert!(ran.stdout.contains("It can tell") && ran.stdout.contains("W in motion"), "{}", ran.stdout);
    let page = bench.text("look.html");
    let body = page.strip_prefix("<!DOCTYPE html>\n").unwrap();
    let read = roxmltree::Document::parse(body).unwrap();
    assert!(read.descendants().filter(|node| node.has_tag_name("figure")).count() >= 2);
    assert!(!page.contains("http") && !page.contains("<script"));
    assert!(page.contains("width=device-width") && page.contains("light dark"));
    // Its own page is written over, a log is not.
    assert_eq!(bench.gmr(&["look", &log, "--page", "look.html"]).code, Some(0));
    assert_eq!(bench.gmr(&["look", &log, "--page", &log]).code, Some(2));
}

/// The folder that ROS 2's recorder leaves is its file.
#[test]
fn a_folder_of_a_bag_is_looked_at_as_its_file() {
    let bench = Bench::new();
    std::fs::create_dir(bench.path("bag")).unwrap();
    let file = copy(&bench, "clearpath.mcap");
    std::fs::copy(bench.path(&file), bench.path("bag/bag_0.mcap")).unwrap();
    bench
        .put("bag/metadata.yaml", "rosbag2_bagfile_information:\n  relative_file_paths:\n    - bag_0.mcap\n");
    let (mut whole, mut folder) = (look(&bench, &file), look(&bench, "bag"));
    for answer in [&mut whole, &mut folder] {
        answer.as_object_mut().unwrap().retain(|key, _| key != "log" && key != "file" && key != "bytes");
    }
    assert_eq!(whole, folder);
    bench.done(&["convert", "--robot", "husky", "bag", "--out", "rows.csv"]);
    assert!(bench.text("rows.csv").lines().count() > 100);
    let ran = bench.gmr(&["look", "."]);
    assert!(ran.code == Some(1) && ran.stderr.contains("metadata.yaml"), "{}", ran.stderr);
}
