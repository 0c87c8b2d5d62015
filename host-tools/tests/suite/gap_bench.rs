//! A small version of the bench whose whole table is docs/results/gap-bench.txt: effects that the
//! plant hides, and sets without any.

use crate::common::Bench;

/// The share of a figure, %, and the counts behind it.
fn figure(table: &str, name: &str) -> (f64, String) {
    let line = table.lines().find(|line| line.starts_with(name)).unwrap_or_else(|| panic!("{name}: {table}"));
    let rest = line[name.len()..].trim();
    let (share, counts) = rest.split_once('%').unwrap();
    (share.trim().parse().unwrap(), counts.trim().to_owned())
}

/// At size 1, where the noise leaves little doubt, a seed beside those of the table: every name is
/// right, and where there is no effect there is no alarm.
#[test]
fn what_is_hidden_is_named_and_nothing_else() {
    let bench = Bench::new();
    let only = "grade,rolling-resistance-change,compute-load,lubricant-warm-up";
    let table = bench.done(&[
        "gap-bench",
        "--first-seed",
        "7",
        "--seeds",
        "1",
        "--sizes",
        "1",
        "--free",
        "2",
        "--only",
        only,
    ]);
    let right = figure(&table.stdout, "alone: right single name, true twins in a tie counted");
    assert_eq!(right, (100.0, "5 of 5".to_owned()), "{}", table.stdout);
    assert_eq!(figure(&table.stdout, "no effect: an alarm").0, 0.0, "{}", table.stdout);
    assert_eq!(figure(&table.stdout, "alone: wrong single name").0, 0.0, "{}", table.stdout);
}

/// The same figures for scripts, on standard output alone.
#[test]
fn the_json_holds_every_set_and_the_figures() {
    let bench = Bench::new();
    let arguments = ["gap-bench", "--seeds", "1", "--sizes", "2", "--free", "1", "--only", "compute-load"];
    let report = bench.json(&arguments);
    let sets = report["sets"].as_array().unwrap();
    assert_eq!(sets.len(), 2, "{report:#}");
    let hidden = sets.iter().find(|set| set["hidden"][0]["id"] == "compute-load").unwrap();
    assert_eq!((&hidden["verdict"], &hidden["counted"]), (&"named".into(), &"right".into()), "{report:#}");
    let figure =
        |name: &str| report["figures"].as_array().unwrap().iter().find(|figure| figure["name"] == name);
    let right = figure("alone: right single name, true twins in a tie counted").unwrap();
    assert_eq!((&right["count"], &right["of"]), (&1.into(), &1.into()), "{report:#}");
    assert!(
        figure("no effect: an alarm").is_some()
            && figure("pairs: both named, or one named and the other in a tie").is_none()
    );
    assert!(report["gap_closed"]["median"].as_f64().unwrap() > 0.5, "{report:#}");
}
