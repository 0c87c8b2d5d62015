//! `gmr gap --sim`: what a robot has that a simulator lacks, by the simulator's own logs or by its
//! columns beside the measured power.

use std::sync::OnceLock;

use crate::common::{Bench, number};
use serde_json::Value;

/// Total masses of the runs, kg; test drives in every second.
const MASSES: [&str; 8] = ["1.2", "5.6", "2.4", "4.1", "3.3", "1.8", "5.0", "2.9"];

/// A drive of 60 s at 20 Hz of the plant with gear motors, which stands for the robot (with noise)
/// or for a simulator of it.
fn simulate(bench: &Bench, name: &str, place: usize, more: &[&str]) {
    let profile = if place.is_multiple_of(2) { "training" } else { "test" };
    let seed = (400 + place).to_string();
    let common = ["--plant", "gearmotor", "--rate", "20", "--duration", "60", "--profile", profile];
    bench.simulate(name, &[&common[..], &["--mass", MASSES[place], "--seed", &seed], more].concat());
}

/// Eight drives of the simulator, `sim_1.csv` and so on, and the same of the robot, whose left
/// wheel drags, `run_1.csv` and so on.
fn drives() -> &'static Bench {
    static BENCH: OnceLock<Bench> = OnceLock::new();
    BENCH.get_or_init(|| {
        let bench = Bench::new();
        for place in 0..MASSES.len() {
            simulate(
                &bench,
                &format!("sim_{}.csv", place + 1),
                place,
                &["--sensors", "exact", "--power-noise", "0"],
            );
            let robot =
                ["--sensors", "servo", "--power-noise", "0.05", "--effect", "wheel-drag=0.03:wheel=1"];
            simulate(&bench, &format!("run_{}.csv", place + 1), place, &robot);
        }
        bench
    })
}

fn names(kind: &str) -> Vec<String> {
    (1..=MASSES.len()).map(|place| format!("{kind}_{place}.csv")).collect()
}

fn copy() -> Bench {
    let bench = Bench::new();
    for name in drives().files() {
        bench.put(&name, std::fs::read(drives().path(&name)).unwrap());
    }
    bench
}

fn gap(bench: &Bench, more: &[&str]) -> Value {
    let runs = names("run");
    let runs: Vec<&str> = runs.iter().map(String::as_str).collect();
    bench.json(&[&["gap"], &runs[..], more].concat())
}

fn check_drag(report: &Value) {
    assert_eq!(report["verdict"], "named", "{report:#}");
    assert_eq!(report["effects"][0]["id"], "wheel-drag");
    assert_eq!(report["effects"][0]["detail"]["wheel"], 1);
    let drag = number(&report["effects"][0]["physical"]["value"]);
    assert!((drag / 0.03 - 1.0).abs() < 0.15, "{drag}");
}

/// The simulator has drives and no noise of its own; what it lacks is written down for its model.
#[test]
fn what_a_simulator_lacks_is_named_by_logs_of_its_own() {
    let bench = copy();
    let sims = names("sim");
    let sims: Vec<&str> = sims.iter().map(String::as_str).collect();
    let report = gap(&bench, &[&["--export", "mjcf", "--sim"], &sims[..]].concat());
    check_drag(&report);
    assert_eq!(report["simulator"]["power_from"], "power_w");
    assert!(report["simulator"]["difference"].is_null(), "drives of its own");
    assert!(number(&report["simulator"]["model_r2"]) > 0.99);
    let change = &report["changes"]["changes"][0];
    assert_eq!(change["element"], "joint/@frictionloss");
    let [low, high] = [0, 1].map(|end| number(&change["interval"][end]));
    assert!(low < number(&change["value"]) && number(&change["value"]) < high);
    let text = bench.text("gap_changes.xml");
    assert!(text.contains("joint/@frictionloss: add 0.0"), "{text}");
}

/// A robot that has nothing but its sensors' noise beyond the simulator.
#[test]
fn a_simulator_that_lacks_nothing_is_told_so() {
    let bench = copy();
    for place in 0..MASSES.len() {
        simulate(
            &bench,
            &format!("run_{}.csv", place + 1),
            place,
            &["--sensors", "servo", "--power-noise", "0.05", "--force"],
        );
    }
    let sims = names("sim");
    let sims: Vec<&str> = sims.iter().map(String::as_str).collect();
    let report = gap(&bench, &[&["--sim"], &sims[..]].concat());
    assert_eq!(report["verdict"], "none", "{report:#}");
}

/// Each measured log with a further column: the power of the simulator's log of the same drive.
fn with_column(bench: &Bench, title: &str, value: impl Fn(&[&str]) -> String) {
    for (run, sim) in names("run").iter().zip(names("sim")) {
        let (measured, simulated) = (bench.text(run), bench.text(&sim));
        let mut lines = measured.lines().zip(simulated.lines());
        let (header, _) = lines.next().unwrap();
        let mut text = format!("{header},{title}\n");
        for (measured, simulated) in lines {
            let fields: Vec<&str> = simulated.split(',').collect();
            text += &format!("{measured},{}\n", value(&fields));
        }
        bench.put(run, text);
    }
}

fn place(bench: &Bench, log: &str, column: &str) -> usize {
    let text = bench.text(log);
    text.lines().next().unwrap().split(',').position(|name| name == column).unwrap()
}

/// A column beside the measured power: no clean fit is needed, and the difference of the two needs
/// no model.
#[test]
fn a_simulator_s_column_beside_the_measured_power_is_enough() {
    let bench = copy();
    let power = place(&bench, "sim_1.csv", "power_w");
    with_column(&bench, "sim_power_w", |fields| fields[power].to_owned());
    let report = gap(&bench, &[]);
    check_drag(&report);
    assert_eq!(report["simulator"]["power_from"], "sim_power_w");
    let difference = &report["simulator"]["difference"];
    let [before, after] = ["before_w", "after_w"].map(|key| number(&difference[key]));
    assert!(after < 0.5 * before, "{before} {after}");
}

#[test]
fn what_no_simulator_can_be_is_refused_in_one_line() {
    let bench = copy();
    with_column(&bench, "sim_torque1_nm,sim_torque2_nm", |_| "0.01,0.01".to_owned());
    let runs = names("run");
    let runs: Vec<&str> = runs.iter().map(String::as_str).collect();
    let failed = bench.gmr(&[&["gap", "--robot", "warthog"], &runs[..]].concat());
    assert_eq!(failed.code, Some(1), "{}", failed.stderr);
    assert!(
        failed.stderr.contains("sim_torque1_nm") && failed.stderr.contains("motor_resistance_ohm"),
        "{}",
        failed.stderr
    );
    // One log without the columns that the others have.
    bench.put("run_3.csv", drives().text("run_3.csv"));
    let failed = bench.gmr(&[&["gap"], &runs[..]].concat());
    assert_eq!(failed.code, Some(1));
    assert!(
        failed.stderr.contains("run_3.csv") && failed.stderr.contains("sim_power_w"),
        "{}",
        failed.stderr
    );
    for more in [["--coeffs", "c.toml"], ["--base", "sim_2.csv"], ["--plant", "gearmotor"]] {
        let failed = bench.gmr(&[&["gap"], &runs[..], &more, &["--sim", "sim_1.csv"]].concat());
        assert_eq!(failed.code, Some(2), "{more:?}: {}", failed.stderr);
    }
    // A simulator sampled at a rate whose rows cannot lie as far apart.
    bench.simulate("other.csv", &["--plant", "gearmotor", "--rate", "30", "--duration", "30", "--mass", "2"]);
    let sound: Vec<String> = names("sim");
    let sound: Vec<&str> = sound.iter().map(String::as_str).collect();
    let failed = bench.gmr(&[&["gap"], &sound[..], &["--sim", "other.csv"]].concat());
    assert_eq!(failed.code, Some(1));
    assert!(failed.stderr.contains("sample rate"), "{}", failed.stderr);
}
