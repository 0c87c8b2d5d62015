//! Invented seeds, for tests of page, tables and figures.

use super::course::{Course, Followed, Trace};
use super::print::{Cost, Difference};
use super::regime::Rails;
use super::section7::{Courses, Judged};
use super::settings::Settings;
use super::spread::Spread;
use super::study::{Outcomes, Study};
use super::{recalibration, section6, section7};
use crate::compare::{Horizon, LeftOut, MassSource};

/// Names that tables have, the last of them markup if it were not escaped.
pub(super) const METHODS: [&str; 3] = ["signed", "eq18-published", "eq18 <corrected> & roots"];

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
            interval_kg: (0..count)
                .map(|k| (or_unknown(k, mass(k) - 0.3), or_unknown(k, mass(k) + 0.3)))
                .collect(),
        }
    });
    let methods = methods.collect();
    Course { trace, methods }
}

/// A little more in odd seeds than in even ones.
fn jitter<const N: usize>(seed: u64, figures: [f64; N]) -> [f64; N] {
    figures.map(|figure| figure * (1.0 + if seed % 2 == 1 { 1e-3 } else { -1e-3 }))
}

fn simulated(seed: u64) -> section6::Seed {
    let outcome = |place: usize| {
        let times = 1.0 + 3.0 * place as f64;
        jitter(seed, [times, 0.999 - 0.002 * times, 1.5 * times, 1.4 * times, 5.0 * times])
    };
    let courses = (seed == 0).then(|| {
        [
            course(200.0, [1.0, 6.0], 2, 0.05, 0.0),
            course(100.0, [3.0, 4.0], 3, 0.05, 10.0),
            course(100.0, [3.0, 4.0], 3, 0.05, 3.0),
        ]
    });
    section6::Seed { outcomes: (0..6).map(outcome).collect(), courses }
}

/// With so many models, of which so many beat ours.
fn experiment(seed: u64, count: usize, better: usize) -> section7::Seed {
    let windows = [5.0, 10.0, 12.5, 15.0, 20.0, 25.0, 30.0, 40.0, 50.0, 60.0];
    let windows = windows.into_iter().flat_map(|window_s: f64| {
        METHODS[..2].iter().enumerate().map(move |(place, method)| {
            let times = 1.0 + 2.0 * place as f64;
            let (mass, mape) = (times * 60.0 / window_s, times * (3.0 + 10.0 / window_s));
            let figures = [mass, mass / 3.0, mape, 0.97 - 0.1 * times / window_s, 99.0];
            (window_s, *method, jitter(seed, figures))
        })
    });
    let name = |place: usize| match place {
        0 | 1 => METHODS[place],
        2 => "linear",
        _ => Box::leak(format!("baseline-{}", place - 1).into_boxed_str()),
    };
    let model = |place: usize| {
        let worse = if (2..2 + better).contains(&place) { -0.5 } else { 0.8 * place as f64 };
        let mass = [MassSource::Unused, MassSource::Given][place % 2];
        Judged {
            name: name(place).to_owned(),
            source: "somebody",
            mass: if place < 2 { MassSource::Estimated } else { mass },
            horizon: Horizon::Plan,
            weight_seeds: None,
            // Where some beat ours, a goal is missed as well.
            quality: jitter(
                seed,
                [
                    4.0 + 2.0 * worse,
                    if better > 0 { 0.90 } else { 0.95 } - 0.02 * worse,
                    0.16 + 0.08 * worse,
                    1.0,
                ],
            ),
        }
    };
    let courses = (seed == 0).then(|| {
        let mut test = course(200.0, [3.0, 4.0], 2, 0.4, 0.5);
        for place in 2..count {
            let predicted_w = test.trace.measured_w.iter().enumerate();
            let predicted_w = predicted_w.map(|(k, power)| power * (1.0 + 0.1 * scatter(k, place))).collect();
            test.methods.push(Followed {
                method: name(place).to_owned(),
                predicted_w,
                ..Followed::default()
            });
        }
        let moving = [12.5, 50.0].map(|window| (window, course(200.0, [3.0, 4.0], 2, 0.4, window / 4.0)));
        Courses { test, cumulative: course(200.0, [3.0, 4.0], 2, 0.4, 1.0), moving: moving.to_vec() }
    });
    let left_out =
        vec![LeftOut { name: "sakayori".to_owned(), reason: "the logs have no pitch_rad".to_owned() }];
    let models = (0..count).map(model).collect();
    section7::Seed {
        models,
        windows: windows.collect(),
        left_out,
        known_share: 0.97,
        persistence_r2: [0.9, 0.5],
        courses,
    }
}

fn errands(seed: u64) -> recalibration::Seed {
    let outcome = |place: usize| {
        let delay_s = 9.0 + 5.0 * place as f64;
        (jitter(seed, [delay_s, 0.4, 1.2, 3.4, 5.0]), 0, 2)
    };
    let prices = [5.0, 10.0, 12.5, 25.0, 50.0].into_iter().flat_map(|window_s: f64| {
        (0..2).map(move |place| (window_s, place, 0.2, (0.4 + 0.8 * place as f64) / window_s))
    });
    recalibration::Seed {
        outcomes: (0..7).map(outcome).collect(),
        prices: prices.collect(),
        rms_current_a: 0.25,
    }
}

fn rails() -> Rails {
    let static_samples_w: Vec<f64> =
        (0..4000).map(|k| 6.4 + 0.17 * (scatter(k, 1) + scatter(k, 2) + scatter(k, 3))).collect();
    let about = |mean: f64, salt| (0..2000).map(|k| mean + 0.3 * scatter(k, salt)).collect();
    Rails {
        time_s: (0..2000).map(|k| k as f64 / 20.0).collect(),
        powers_w: [about(9.0, 4), about(2.6, 5), static_samples_w[..2000].to_vec()],
        static_samples_w,
        gaussian_w: (6.4, 0.17),
    }
}

/// Of so many seeds and models, of which so many beat ours.
pub(super) fn study_with(seeds: u64, models: usize, better: usize) -> Study {
    let spread = |mean: f64, half: f64| Spread::over(&[mean - half, mean, mean + half]);
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
    let settings = Settings {
        first_seed: 1,
        seeds,
        windows_s: vec![5, 10, 15, 20, 25, 30, 40, 50, 60],
        baselines: vec!["mlp", "leng"],
    };
    let outcomes = Outcomes {
        section6: (0..seeds).map(simulated).collect(),
        section7: (0..seeds).map(|seed| experiment(seed, models, better)).collect(),
        recalibration: (0..seeds).map(errands).collect(),
        rails: rails(),
        differences: vec![difference.clone(), Difference { what: "symbols", cost: Vec::new(), ..difference }],
    };
    Study::of(&settings, outcomes)
}

/// Of twenty seeds, with so many models that do not beat ours.
pub(super) fn study(models: usize) -> Study {
    study_with(20, models, 0)
}
