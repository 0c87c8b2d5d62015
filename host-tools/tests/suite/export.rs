//! `gmr export`: what other programs are told of a fit.

use serde_json::Value;

use crate::common::{GYRATION, RADIUS, TRUTH, fitted, near, number, power};

/// Friction: P / (m g v) straight at 0.15 m/s; inertia: m k².
#[test]
fn open_rmf_gets_friction_and_inertia() {
    let bench = fitted();
    let all =
        ["export", "rmf", "--robot", "robot.toml", "--coeffs", "c.toml", "--mass", "3", "--speed", "0.15"];
    let report = bench.json(&all);
    let system = &report["mechanical_system"];
    let expected = power([0.15 / RADIUS; 2], [0.0; 2], 3.0) / (3.0 * 9.81 * 0.15);
    near(&system["friction_coefficient"], expected, 0.005);
    near(&system["moment_of_inertia_kg_m2"], 3.0 * GYRATION * GYRATION, 1e-9);
    assert!(report["ambient_power_w"].is_null());
    let yaml = bench.done(&[&all[..], &["--static-power", "6.4"]].concat()).stdout;
    for line in [
        "mechanical_system:",
        "mass: 3.0000",
        "ambient_system:\n    power: 6.4",
        "capacity: 1.8",
        "cannot express",
        "turning",
    ] {
        assert!(yaml.contains(line), "{line}: {yaml}");
    }
}

#[test]
fn engines_get_joints() {
    let bench = fitted();
    let [a0, a1, g2, g3, ..] = TRUTH;
    let joint = bench.json(&["export", "mjcf", "--robot", "robot.toml", "--coeffs", "c.toml", "--mass", "3"]);
    near(&joint["friction_nm"], a0 + 3.0 * a1, 0.02);
    near(&joint["damping_nm_s_rad"], g2, 0.05);
    near(&joint["armature_kg_m2"], g3, 0.05);
    for (target, tag, attribute) in [("mjcf", "joint", Some("armature")), ("sdf", "friction", None)] {
        let out = format!("{target}.xml");
        let ran =
            ["export", target, "--robot", "robot.toml", "--coeffs", "c.toml", "--mass", "3", "--out", &out];
        bench.done(&ran);
        let text = bench.text(&out);
        let read = roxmltree::Document::parse(&text).unwrap();
        let node = read.descendants().find(|node| node.has_tag_name(tag)).unwrap();
        assert!(attribute.is_none_or(|name| node.attribute(name).is_some()), "{text}");
        assert!(text.contains("winding_loss") && text.contains("rolling resistance"), "{text}");
        // Its own is written over, another's is not.
        bench.done(&ran);
        bench.put(&out, "<mujoco/>");
        assert_eq!(bench.gmr(&ran).code, Some(1));
    }
}

#[test]
fn a_fleet_manager_gets_battery_and_load() {
    let bench = fitted();
    let all = [
        "export",
        "vda5050",
        "--robot",
        "robot.toml",
        "--coeffs",
        "c.toml",
        "--mass",
        "3",
        "--speed",
        "0.15",
    ];
    let state = bench.json(&[&all[..], &["--static-power", "5", "--charge", "0.7"]].concat());
    let battery = &state["batteryState"];
    assert_eq!((number(&battery["batteryCharge"]), &battery["charging"]), (70.0, &Value::Bool(false)));
    // Some 14 W·h at about 5.6 W, at 0.15 m/s.
    assert!((1000.0..1600.0).contains(&number(&battery["reach"])), "{battery}");
    near(&state["loads"][0]["weight"], 2.0, 1e-9);
    let ran = bench.gmr(&all);
    assert!(ran.code == Some(2) && ran.stderr.contains("needs --charge"), "{}", ran.stderr);
}
