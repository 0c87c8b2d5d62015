//! Ties in logs with further columns, as README invites them: the drive that would part the
//! hypotheses has none of these columns.

use crate::common::{Bench, number};

/// Rolling resistance at one speed and payload only cannot be told from friction that depends on
/// neither: hypotheses tie, and a drive that parts them is looked for.
#[test]
fn a_tie_with_commanded_speeds_in_the_logs_ends_in_a_drive() {
    let bench = Bench::new();
    let masses = ["1", "2", "3", "4", "5", "6"];
    let common = ["--duration", "60", "--columns", "command", "--seed"];
    for mass in masses {
        bench.simulate(&format!("base_{mass}.csv"), &[&common[..], &[mass, "--mass", mass]].concat());
        let field = ["--mass", "3", "--effect", "rolling-resistance-change=0.2", "--profile", "constant"];
        let noise = ["--power-noise", "0.02"];
        let seed = format!("1{mass}");
        let further = [&common[..], &[&seed], &field, &noise].concat();
        bench.simulate(&format!("field_{mass}.csv"), &further);
    }
    let files = |name: &str| masses.map(|mass| format!("{name}_{mass}.csv"));
    let (base, field) = (files("base"), files("field"));
    let base: Vec<&str> = base.iter().map(String::as_str).collect();
    bench.done(&[&["fit", "--out", "base.toml"], &base[..]].concat());
    assert!(bench.text("field_1.csv").starts_with("time_s,"), "a log");
    assert!(bench.text("field_1.csv").lines().next().unwrap().contains("cmd_v_m_s"), "with commanded speeds");
    let field: Vec<&str> = field.iter().map(String::as_str).collect();
    // Parted with a probability, in a room.
    let wish = ["--part", "0.9", "--room", "2x1", "--profile", "room.csv"];
    let report = bench.json(&[&["gap", "--coeffs", "base.toml"], &field[..], &wish].concat());
    assert_eq!(report["verdict"], "ambiguous", "{report:#}");
    let drive = &report["manoeuvre"];
    assert!(drive.is_object(), "{report:#}");
    assert_eq!(number(&drive["wanted_probability"]), 0.9);
    let (reached, runs) = (number(&drive["probability"]), number(&drive["runs"]));
    assert!(reached >= 0.9 || runs == 48.0, "what was asked for, or the most that is tried: {drive:#}");
    assert_eq!(number(&drive["driving_s"]), runs * number(&drive["duration_s"]));
    let [along, across] = box_around(&bench.text("room.csv"));
    assert!((along <= 2.0 && across <= 1.0) || (along <= 1.0 && across <= 2.0), "{along} {across}");
    for (option, value) in [("--part", "1.5"), ("--part", "most"), ("--room", "2"), ("--room", "0x1")] {
        let failed = bench.gmr(&[&["gap", "--coeffs", "base.toml", option, value], &field[..]].concat());
        assert_eq!(failed.code, Some(2), "{option} {value}");
        assert!(failed.stderr.contains("expected"), "{}", failed.stderr);
    }
}

/// Sides of the box around the path of a profile, m, by small steps.
fn box_around(profile: &str) -> [f64; 2] {
    let knots: Vec<Vec<f64>> =
        profile.lines().skip(1).map(|line| line.split(',').map(|x| x.parse().unwrap()).collect()).collect();
    let (mut x, mut y, mut heading) = (0.0_f64, 0.0_f64, 0.0_f64);
    let mut ends = [[0.0_f64; 2]; 2];
    for pair in knots.windows(2) {
        for k in 0..1000 {
            let share = (f64::from(k) + 0.5) / 1000.0;
            let at = |column: usize| pair[0][column] + share * (pair[1][column] - pair[0][column]);
            let step = (pair[1][0] - pair[0][0]) / 1000.0;
            heading += at(2) * step;
            x += at(1) * heading.cos() * step;
            y += at(1) * heading.sin() * step;
            for (end, value) in ends.iter_mut().zip([x, y]) {
                *end = [end[0].min(value), end[1].max(value)];
            }
        }
    }
    ends.map(|[low, high]| high - low)
}
