//! A study that nobody has computed: what page, tables and figures are tested with.

use super::price::{self, PricePoint};
use super::print::{Cost, Difference};
use super::study::{
    Course, Experiment, Followed, Knob, ModelRow, Nearness, PublishedSimulation, Rails, Recalibration,
    Settings, Simulation, SimulationRow, Spread, Study, Trace, WindowRow,
};
use crate::compare::{LeftOut, MassSource};

/// Names that tables could have, one of them markup if it were not escaped.
pub(super) const METHODS: [&str; 3] = ["signed", "eq18-published", "eq18 <corrected> & roots"];

/// A mean with an interval of so much on both sides.
pub(super) fn spread(mean: f64, half: f64) -> Spread {
    Spread {
        mean,
        low: mean - half,
        high: mean + half,
        least: mean - 2.0 * half,
        greatest: mean + 2.0 * half,
        count: 20,
    }
}

/// A scatter between −1 and 1 that is the same on every machine.
fn scatter(k: usize, salt: usize) -> f64 {
    ((k * 7919 + salt * 104_729) % 2003) as f64 / 1001.0 - 1.0
}

fn course(seconds: f64, masses: [f64; 2], method_count: usize, noise: f64, settles_s: f64) -> Course {
    let count = (seconds * 20.0) as usize;
    let mut trace = Trace::default();
    for k in 0..count {
        let time = k as f64 / 20.0;
        let speed = [4.0 + 2.0 * (0.3 * time).sin(), 4.0 + 2.0 * (0.4 * time).cos()];
        let mass = masses[usize::from(time >= seconds / 2.0)];
        trace.time_s.push(time);
        trace.wheel_rad_s[0].push(speed[0]);
        trace.wheel_rad_s[1].push(speed[1]);
        let power = 0.5 + 0.15 * mass * (speed[0] + speed[1]) / 2.0;
        trace.measured_w.push(power + noise * scatter(k, 1));
        trace.truth_kg.push(mass);
    }
    let methods = (0..method_count).map(|place| {
        let wrong = 0.02 + 0.1 * place as f64;
        let since = |time: f64| if time >= seconds / 2.0 { time - seconds / 2.0 } else { time };
        let known = |k: usize| since(trace.time_s[k]) > settles_s;
        let or_unknown = |k: usize, value: f64| if known(k) { value } else { f64::NAN };
        let mass = |k: usize| trace.truth_kg[k] * (1.0 + wrong * (0.2 * trace.time_s[k]).sin());
        Followed {
            method: METHODS.get(place).map_or(format!("baseline-{place}"), |name| (*name).to_owned()),
            predicted_w: (0..count)
                .map(|k| or_unknown(k, trace.measured_w[k] * (1.0 + wrong * scatter(k, place))))
                .collect(),
            mass_kg: (0..count).map(|k| or_unknown(k, mass(k))).collect(),
            low_kg: (0..count).map(|k| or_unknown(k, mass(k) - 0.3)).collect(),
            high_kg: (0..count).map(|k| or_unknown(k, mass(k) + 0.3)).collect(),
        }
    });
    let methods = methods.collect();
    Course { trace, methods }
}

fn simulation() -> Simulation {
    let row = |(place, method): (usize, &&str)| {
        let times = 1.0 + 3.0 * place as f64;
        SimulationRow {
            method: (*method).to_owned(),
            mape_percent: spread(times, 0.2),
            r2: spread(1.0 - 0.002 * times, 0.0005),
            after_start_percent: spread(1.5 * times, 0.4),
            after_change_percent: spread(1.4 * times, 0.4),
            worst_start_percent: spread(5.0 * times, 1.0),
        }
    };
    Simulation {
        training: course(200.0, [1.0, 6.0], 2, 0.05, 0.0),
        test: course(100.0, [3.0, 4.0], 3, 0.05, 10.0),
        moving: course(100.0, [3.0, 4.0], 3, 0.05, 3.0),
        rows: METHODS.iter().enumerate().map(row).collect(),
        published: PublishedSimulation {
            mape_percent: 4.3,
            r2: 0.973,
            after_start_percent: 5.6,
            after_change_percent: 5.5,
            worst_start_percent: 22.0,
        },
    }
}

fn experiment(baselines: usize) -> Experiment {
    let windows =
        [5.0, 10.0, 12.5, 15.0, 20.0, 25.0, 30.0, 40.0, 50.0, 60.0].into_iter().flat_map(|window_s: f64| {
            METHODS[..2].iter().enumerate().map(move |(place, method)| {
                let times = 1.0 + 2.0 * place as f64;
                WindowRow {
                    window_s,
                    method: (*method).to_owned(),
                    worst_mass_percent: spread(times * 60.0 / window_s, 0.5 * times),
                    mean_mass_percent: spread(times * 20.0 / window_s, 0.2),
                    mape_percent: spread(times * (3.0 + 10.0 / window_s), 0.2 * times),
                    r2: spread(0.97 - 0.1 * times / window_s, 0.004),
                    known_percent: spread(99.0, 0.5),
                }
            })
        });
    let model = |name: &str, mass, mape: f64, r2: f64, published| ModelRow {
        name: name.to_owned(),
        source: "somebody".to_owned(),
        mass,
        mape_percent: spread(mape, 0.3),
        r2: spread(r2, 0.01),
        rmse_w: spread(0.04 * mape, 0.01),
        ours_ahead: if mape > 4.0 { 20 } else { 0 },
        ours_behind: 0,
        published,
    };
    let mut models = vec![
        model(METHODS[0], MassSource::Estimated, 4.0, 0.95, None),
        model(METHODS[1], MassSource::Estimated, 9.3, 0.77, Some((9.12, 0.78))),
        model("perceptron", MassSource::Unused, 10.4, 0.68, Some((10.2, 0.69))),
        model("leng-mass", MassSource::Given, 12.5, 0.45, Some((12.7, 0.44))),
    ];
    models.extend((models.len()..baselines).map(|k| {
        let mass = if k % 3 == 0 { MassSource::Given } else { MassSource::Unused };
        model(&format!("baseline-{k}"), mass, 2.0 + 1.7 * k as f64, 0.97 - 0.06 * k as f64, None)
    }));
    let mut test = course(200.0, [3.0, 4.0], 2, 0.4, 5.0);
    for (name, salt) in [("perceptron", 11), ("leng-mass", 12)] {
        let wrong = |(k, power): (usize, &f64)| power * (1.0 + 0.3 * scatter(k, salt)) + 0.1;
        let predicted_w = test.trace.measured_w.iter().enumerate().map(wrong).collect();
        test.methods.push(Followed { method: name.to_owned(), predicted_w, ..Followed::default() });
    }
    let static_samples_w: Vec<f64> =
        (0..4000).map(|k| 6.4 + 0.17 * (scatter(k, 1) + scatter(k, 2) + scatter(k, 3))).collect();
    Experiment {
        knobs: vec![Knob {
            name: "power noise",
            value: "0.3 W".to_owned(),
            reason: "sets the perceptron's R²",
        }],
        nearness: vec![Nearness {
            what: "proposed, MAPE at 25 s".to_owned(),
            published: 9.12,
            here: spread(9.3, 0.4),
            ours: spread(4.0, 0.2),
            unit: "%",
        }],
        rails: Rails {
            time_s: (0..2000).map(|k| k as f64 / 20.0).collect(),
            battery_w: (0..2000).map(|k| 9.0 + 0.3 * scatter(k, 4)).collect(),
            actuation_w: (0..2000).map(|k| 2.6 + 0.3 * scatter(k, 5)).collect(),
            static_w: static_samples_w[..2000].to_vec(),
            static_samples_w,
            gaussian_w: (6.4, 0.17),
        },
        training: course(200.0, [1.0, 6.0], 2, 0.4, 0.0),
        test,
        cumulative: course(200.0, [3.0, 4.0], 2, 0.4, 1.0),
        moving: [12.5, 50.0].map(|window| (window, course(200.0, [3.0, 4.0], 2, 0.4, window / 4.0))).to_vec(),
        windows: windows.collect(),
        models,
        left_out: vec![LeftOut {
            name: "sakayori".to_owned(),
            reason: "the logs have no pitch_rad".to_owned(),
        }],
        share_known: spread(97.0, 1.0),
    }
}

/// With so many models.
pub(super) fn study(baselines: usize) -> Study {
    let points = [5.0, 10.0, 12.5, 25.0, 50.0].into_iter().flat_map(|window_s: f64| {
        METHODS[..2].iter().enumerate().map(move |(place, method)| PricePoint {
            window_s,
            method: (*method).to_owned(),
            old_mass_w: 0.2,
            new_mass_w: (0.4 + 0.8 * place as f64) / window_s,
            actuation_a: 0.25,
        })
    });
    let input = price::Input { points: points.collect(), ..price::Input::default() };
    let policy = |policy: &str, delay| Recalibration {
        policy: policy.to_owned(),
        method: METHODS[0].to_owned(),
        delay_s: spread(delay, 2.0),
        never: (0, 40),
        false_restarts_per_hour: spread(0.4, 0.2),
        energy_error_percent: spread(1.2, 0.3),
        absolute_energy_error_percent: spread(3.4, 0.3),
        unknown_percent: spread(5.0, 0.5),
    };
    let cost = Cost {
        plant: "servo",
        figure: "R² at the true mass",
        unit: "",
        print: spread(0.99, 0.001),
        derivation: spread(0.995, 0.001),
        difference: spread(-0.005, 0.0005),
    };
    let difference = Difference {
        what: "gates of β4 and β5",
        print: "(2 + s) a²",
        derivation: "(1 + s) a²",
        cost: vec![cost],
        remark: "braking costs",
    };
    Study {
        settings: Settings {
            first_seed: 1,
            seeds: 20,
            windows_s: vec![5, 10, 15, 20, 25, 30, 40, 50, 60],
            baselines: vec!["perceptron", "leng-mass"],
        },
        simulation: simulation(),
        experiment: experiment(baselines),
        recalibration: vec![policy("known time", 9.0), policy("periodic", 31.0), policy("detector", 14.0)],
        price: price::price(&input),
        print: vec![difference.clone(), Difference { what: "symbols", cost: Vec::new(), ..difference }],
    }
}
