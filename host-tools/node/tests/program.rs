//! `gmr-node` as a program of its own.

use std::process::{Command, Output};

fn gmr_node(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_gmr-node")).args(arguments).output().unwrap()
}

/// It says its own name, refuses what `gmr node` refuses, and ends with the same codes.
#[test]
fn it_ends_as_gmr_node_does() {
    let refused = gmr_node(&["--every", "0"]);
    assert_eq!(refused.status.code(), Some(2));
    let said = String::from_utf8(refused.stderr).unwrap();
    assert_eq!(said, "gmr-node: --every 0: expected 0.01 to 3600 s\n");
    let missing = gmr_node(&["--robot", "burger", "--replay", "none.csv", "--no-ros", "--speed", "max"]);
    assert_eq!(missing.status.code(), Some(1));
    assert!(String::from_utf8(missing.stderr).unwrap().starts_with("gmr-node: none.csv: "));
    assert!(missing.stdout.is_empty());
}

/// A log in the sensor's place gives lines of JSON.
#[test]
fn a_log_gives_states() {
    let folder = std::env::temp_dir().join(format!("gmr-node-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let log = folder.join("rest.csv");
    let mut rows = "time_s,wheel1_rad_s,wheel2_rad_s,power_w,bus_v\n".to_owned();
    for row in 0..300 {
        rows += &format!("{},0,0,6.4,12\n", f64::from(row) / 100.0);
    }
    std::fs::write(&log, rows).unwrap();
    let log = log.to_str().unwrap();
    let done = gmr_node(&["--robot", "burger", "--replay", log, "--no-ros", "--speed", "max", "--json"]);
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
    let said = String::from_utf8(done.stdout).unwrap();
    assert!(said.lines().count() >= 2 && said.lines().all(|line| line.starts_with('{')), "{said}");
}

/// The service of systemd calls it as it is called: it knows the options, and lacks the files.
#[test]
fn the_service_calls_it_as_it_is_called() {
    let unit = include_str!("../../../docs/gmr-node.service");
    let called = unit.lines().find_map(|line| line.strip_prefix("ExecStart=")).unwrap();
    let words: Vec<&str> = called.split(' ').collect();
    assert_eq!(words[0], "/usr/local/bin/gmr-node");
    let ran = gmr_node(&words[1..]);
    let said = String::from_utf8_lossy(&ran.stderr).into_owned();
    assert!(ran.status.code() == Some(1) && said.contains("/etc/gmr/robot.toml"), "{said}");
}
