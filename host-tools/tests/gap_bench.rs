//! A small version of the bench whose whole table is docs/gap-bench.txt: effects that the plant hides, and sets without any.

mod common;

use common::Bench;

/// The share of a figure, %, and the counts behind it.
fn figure(table: &str, name: &str) -> (f64, String) {
    let line = table.lines().find(|line| line.starts_with(name)).unwrap_or_else(|| panic!("{name}: {table}"));
    let rest = line[name.len()..].trim();
    let (share, counts) = rest.split_once('%').unwrap();
    (share.trim().parse().unwrap(), counts.trim().to_owned())
}

/// At size 1 and 2, where the noise leaves no doubt, seeds beside those of the table: every name is right, and where there is no effect
/// there is no alarm.
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
        "1,2",
        "--free",
        "4",
        "--only",
        only,
    ]);
    let right = figure(&table.stdout, "alone: right single name, true twins in a tie counted");
    assert_eq!(right, (100.0, "10 of 10".to_owned()), "{}", table.stdout);
    assert_eq!(figure(&table.stdout, "no effect: an alarm").0, 0.0, "{}", table.stdout);
    assert_eq!(figure(&table.stdout, "alone: wrong single name").0, 0.0, "{}", table.stdout);
}
