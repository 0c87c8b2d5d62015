//! Logs of power only: steps of the static power are named, pulses are not, and the measured ones
//! are those of the data's page.

use gap::power_only::{PowerRun, investigate};
use gap::report::Report;
use residuals::types::Verdict;

use crate::common::{Bench, keys, number, whole_data};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal, StudentT};
use serde_json::Value;

const RATE_HZ: f64 = 200.0;
const SECONDS: f64 = 140.0;

/// The noise of a set: its autocorrelation from sample to sample, and whether it has heavy tails.
#[derive(Clone, Copy)]
struct Noise {
    rho: f64,
    heavy: bool,
    /// Slow change over the run, W.
    drift: f64,
}

/// The measured robot's: 0.52 W with 0.21 from sample to sample.
const MEASURED: Noise = Noise { rho: 0.21, heavy: false, drift: 0.0 };

/// A run of 8.6 W at rest with 0.52 W of noise.
fn run(name: &str, seed: u64, noise: Noise, more: impl Fn(f64) -> f64) -> PowerRun {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut value = 0.0;
    let rows = (SECONDS * RATE_HZ) as u32;
    let times: Vec<f64> = (0..rows).map(|row| f64::from(row) / RATE_HZ).collect();
    let power: Vec<f64> = times
        .iter()
        .map(|&time| {
            let fresh: f64 = if noise.heavy {
                // Three degrees of freedom: variance 3.
                StudentT::new(3.0).unwrap().sample(&mut rng) / 3.0_f64.sqrt()
            } else {
                Normal::new(0.0, 1.0).unwrap().sample(&mut rng)
            };
            value = noise.rho * value + (1.0 - noise.rho * noise.rho).sqrt() * fresh;
            8.6 + 0.52 * value + noise.drift * time / SECONDS + more(time)
        })
        .collect();
    PowerRun::new(name.to_owned(), &times, &power)
}

/// A spin of 8 s every 20 s from `first` on takes 2 W more.
fn pulses(time: f64, first: f64) -> f64 {
    if time > first && (time - first) % 30.0 < 8.0 { 2.0 } else { 0.0 }
}

/// Four runs whose first pulse comes at different times.
fn set(seed: u64, noise: Noise, more: impl Fn(f64, f64) -> f64) -> Report {
    let runs: Vec<PowerRun> = (0_u8..4)
        .map(|k| {
            let first = 24.0 + 3.0 * f64::from(k);
            run(&format!("run_{k}"), 4 * seed + u64::from(k), noise, |time| more(time, first))
        })
        .collect();
    investigate(&runs).unwrap()
}

/// Power that rises with the first motion, by as much as torque enabled takes, and is held: found
/// with size and time, within four of its stated errors. Where the noise wanders by 0.16 W over two
/// seconds (0.95 from sample to sample), a single rest before the step is worth that error, and a
/// set may end without a name, but not with another size.
#[test]
fn a_step_with_the_first_motion_is_named() {
    for (noise, least) in
        [(MEASURED, 20), (Noise { heavy: true, ..MEASURED }, 20), (Noise { rho: 0.95, ..MEASURED }, 10)]
    {
        let mut count = 0;
        for seed in 0..20 {
            let step = |time: f64, first: f64| if time > first { 1.1 } else { 0.0 };
            let report = set(seed, noise, |time, first| pulses(time, first) + step(time, first));
            if report.verdict != Verdict::Named {
                continue;
            }
            count += 1;
            assert_eq!(report.effects.len(), 1);
            let effect = &report.effects[0];
            assert_eq!(effect.candidate.id, "static-step");
            let (size, error) = (effect.coefficients[0], effect.std_errs[0]);
            assert!((size - 1.1).abs() < 4.0 * error && error < 0.2, "{size} ± {error}");
            // The pulse hides the step itself: it lies between the pulse's beginning and end.
            let fields = effect.candidate.detail.fields();
            let times = |key: &str| fields[key].as_array().unwrap().iter().map(number).collect::<Vec<_>>();
            let names = fields["runs"].as_array().unwrap().iter().map(|name| name.as_str().unwrap());
            for ((name, after), before) in names.zip(times("after_s")).zip(times("before_s")) {
                let first = 24.0 + 3.0 * name["run_".len()..].parse::<f64>().unwrap();
                assert!(
                    (after - first).abs() < 1.5 && (before - first - 8.0).abs() < 1.5,
                    "{name}: {after} {before}"
                );
            }
            assert_eq!(report.confirmed.runs, ["run_1"]);
            // A locked run that wanders may show no step of its own: then nothing is confirmed, and
            // null said.
            let Some(closed) = report.confirmed.closed else {
                assert!(noise.rho > 0.9);
                continue;
            };
            assert!(closed > 0.95, "{:?}", report.confirmed);
            assert!(report.confirmed.after_w < 1.05 * report.confirmed.floor_w, "{:?}", report.confirmed);
        }
        println!("correlation {}, heavy tails {}: {count} of 20 named", noise.rho, noise.heavy);
        assert!(count >= least, "{count}");
    }
}

/// A camera that goes off in the middle of each run.
#[test]
fn a_step_down_is_named() {
    for seed in 0..10 {
        let report = set(seed, MEASURED, |time, first| {
            pulses(time, first) - if time > first + 45.0 { 0.8 } else { 0.0 }
        });
        assert_eq!(report.verdict, Verdict::Named, "{seed}: {:#?}", report.rounds);
        let (size, error) = (report.effects[0].coefficients[0], report.effects[0].std_errs[0]);
        assert!((size + 0.8).abs() < 4.0 * error, "{size} ± {error}");
    }
}

/// Pulses, motion at two speeds, drift and noise of any memory are no steps: of 8 × 100 sets none
/// is named, and at most 2 % raise any alarm.
#[test]
fn nothing_is_named_without_a_step() {
    let mut alarms = 0;
    let mut sets = 0;
    for rho in [0.0, 0.21, 0.95, 0.995] {
        for (heavy, drift) in [(false, 0.0), (true, 0.3)] {
            let noise = Noise { rho, heavy, drift };
            let mut wrong = 0;
            for seed in 0..100 {
                // Every other set drives at two speeds.
                let report = set(1000 + seed, noise, |time, first| {
                    pulses(time, first) + if seed % 2 == 0 { 0.7 * pulses(time, first + 12.0) } else { 0.0 }
                });
                assert_ne!(report.verdict, Verdict::Named, "{rho} {heavy} {seed}: {:#?}", report.effects);
                wrong += u32::from(report.verdict != Verdict::None);
                sets += 1;
            }
            println!("correlation {rho}, heavy tails {heavy}, drift {drift} W: {wrong} alarms in 100 sets");
            alarms += wrong;
        }
    }
    assert!(50 * alarms <= sets, "{alarms} alarms in {sets} sets");
}

/// A step in one run only may be motion: said, but not named.
#[test]
fn a_step_of_one_run_is_not_named() {
    let runs: Vec<PowerRun> = (0_u8..4)
        .map(|k| {
            let lifted = |time: f64| if k == 0 && time > 30.0 { 1.1 } else { 0.0 };
            run(&format!("run_{k}"), u64::from(k), MEASURED, |time| pulses(time, 30.0) + lifted(time))
        })
        .collect();
    let report = investigate(&runs).unwrap();
    assert_eq!(report.verdict, Verdict::Unexplained, "{:#?}", report.rounds);
    assert!(report.rounds[0].outcome.contains("in one run only"), "{}", report.rounds[0].outcome);
    assert!(report.effects.is_empty());
}

/// A robot that stands, and then drives at two speeds until the log ends: no rest is returned to,
/// and noise grows.
#[test]
fn motion_for_the_rest_of_a_run_is_no_step() {
    for seed in 0..20 {
        let drive = |time: f64, first: f64| {
            let speeds = if (time - first) % 25.0 < 14.0 { 3.0 } else { 2.0 };
            if time > first { speeds + 0.8 * (9.0 * time).sin() } else { 0.0 }
        };
        let report = set(seed, MEASURED, drive);
        assert_ne!(report.verdict, Verdict::Named, "{:#?}", report.effects);
    }
}

#[test]
fn too_few_runs_are_refused() {
    let runs: Vec<PowerRun> = (0..3).map(|k| run("a", k, MEASURED, |_| 0.0)).collect();
    let message = investigate(&runs).unwrap_err().to_string();
    assert!(message.starts_with("3 runs; expected at least 4"), "{message}");
}

/// The four measured logs: torque enabled takes 9.74 − 8.62 = 1.12 W, the camera 0.8 W (SOURCES.md,
/// levels over ten runs with a spread of 0.04 to 0.09 W each). The drive has no rest to speak of,
/// and the spins with the camera all the time are locked in turn.
#[test]
fn the_measured_steps_are_found() {
    let names = ["drive_baseline_1", "spin_baseline_1", "spin_baseline_2", "spin_camera_switched_1"];
    let Some(data) = whole_data() else { return };
    let files = names.map(|name| data.join(format!("turtlebot3/{name}.csv")));
    let files: Vec<&str> = files.iter().map(|file| file.to_str().unwrap()).collect();
    let bench = Bench::new();
    let report = bench.json(&[&["gap"], &files[..]].concat());
    assert_eq!(report["verdict"], "named", "{report:#}");
    let effect = &report["effects"][0];
    assert_eq!(
        keys(effect),
        ["id", "coefficient", "unit", "std_err", "physical", "detail", "meaning", "sign"]
    );
    assert_eq!((&effect["id"], &effect["unit"]), (&Value::from("static-step"), &Value::from("W")));
    let (size, error) = (number(&effect["coefficient"]), number(&effect["std_err"]));
    assert!((size - 1.12).abs() < 0.1 && error < 0.15, "{size} ± {error}");
    let detail = |key: &str| effect["detail"][key].as_array().unwrap().iter().map(number).collect::<Vec<_>>();
    // The first spins begin 24 to 26 s into the runs (the logs' one-second means).
    assert!(detail("after_s").iter().all(|at| (22.0..27.0).contains(at)), "{effect:#}");
    let (from, to) = (detail("from_w"), detail("to_w"));
    assert!((from[0] - 8.62).abs() < 0.1 && (to[0] - 9.74).abs() < 0.1, "{from:?} {to:?}");
    assert!((from[1] - 7.82).abs() < 0.1 && (to[1] - 8.95).abs() < 0.1, "{from:?} {to:?}");
    // Both states lie lower by the camera's power in the run that switches it.
    let camera = &report["effects"][1];
    assert_eq!(camera["detail"]["between"], "runs");
    assert!((number(&camera["coefficient"]) + 0.8).abs() < 0.1, "{camera:#}");
    assert!(camera["detail"]["runs"][0].as_str().unwrap().contains("camera"), "{camera:#}");
    assert!(report["confirm_runs"][0].as_str().unwrap().contains("spin_baseline_1"));
    assert!(number(&report["gap_closed"]) > 0.9, "{report:#}");
    let missing = report["not_testable"].as_array().unwrap();
    assert_eq!(missing.len(), 20, "all others: {missing:#?}");
    assert!(missing.iter().all(|entry| entry["reason"].as_str().unwrap().starts_with("needs wheel1_rad_s")));
}
