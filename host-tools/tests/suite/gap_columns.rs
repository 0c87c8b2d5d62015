//! Ties in logs with further columns, as README invites them: the drive that would part the hypotheses has none of these columns.

use crate::common::Bench;

/// Rolling resistance at one speed and payload only cannot be told from friction that depends on neither: hypotheses tie, and a drive
/// that parts them is looked for.
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
        let own = [&common[..], &[&seed], &field, &noise].concat();
        bench.simulate(&format!("field_{mass}.csv"), &own);
    }
    let files = |name: &str| masses.map(|mass| format!("{name}_{mass}.csv"));
    let (base, field) = (files("base"), files("field"));
    let base: Vec<&str> = base.iter().map(String::as_str).collect();
    bench.done(&[&["fit", "--out", "base.toml"], &base[..]].concat());
    assert!(bench.text("field_1.csv").starts_with("time_s,"), "a log");
    assert!(bench.text("field_1.csv").lines().next().unwrap().contains("cmd_v_m_s"), "with commanded speeds");
    let field: Vec<&str> = field.iter().map(String::as_str).collect();
    let found = bench.json(&[&["gap", "--coeffs", "base.toml"], &field[..]].concat());
    assert_eq!(found["verdict"], "ambiguous", "{found:#}");
    assert!(found["manoeuvre"].is_object(), "{found:#}");
}
