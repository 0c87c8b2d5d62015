//! Sums add up, as runs and as columns.

use proptest::prelude::{ProptestConfig, Strategy, prop, prop_assert, proptest};

use super::columns::{Flat, Merge, names};
use super::run::{FORMAT, RunGram, Setting};

/// Runs of any sums: counts are whole, numbers from −1e6 to 1e6.
fn run() -> impl Strategy<Value = RunGram> {
    let count = names().len();
    prop::collection::vec(-1e6..1e6_f64, count).prop_map(|mut numbers| {
        for (number, column) in numbers.iter_mut().zip(names()) {
            if column.is_count() {
                *number = number.abs().round();
            }
            // Runs of one robot have bins of one width.
            if column.name.ends_with("_width") {
                *number = 1.0;
            }
        }
        numbers[0] = f64::from(FORMAT);
        let texts = ["r", "{}", &serde_json::to_string(&Setting::default()).unwrap(), "[[1.0,2.0]]"];
        Flat { texts: texts.map(str::to_owned), numbers }.gram().unwrap()
    })
}

fn sum(a: &RunGram, b: &RunGram) -> RunGram {
    let mut sum = a.clone();
    sum.merge(b).unwrap();
    sum
}

/// A sum of three is rounded twice, each time by half a unit of at most 3e6.
fn are_same(a: &RunGram, b: &RunGram) -> bool {
    let (a, b) = (Flat::of(a).unwrap(), Flat::of(b).unwrap());
    let near = |(a, b): (&f64, &f64)| (a - b).abs() <= 2.0 * f64::EPSILON * 3e6 || a.is_nan() && b.is_nan();
    a.texts[1..] == b.texts[1..] && a.numbers.iter().zip(&b.numbers).all(near)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    /// Whoever adds whom first.
    #[test]
    fn sums_add_up_in_any_order(a in run(), b in run(), c in run()) {
        prop_assert!(are_same(&sum(&a, &b), &sum(&b, &a)));
        prop_assert!(are_same(&sum(&sum(&a, &b), &c), &sum(&a, &sum(&b, &c))));
    }

    /// Columns, as a table keeps them, are the run.
    #[test]
    fn columns_give_the_run_back(a in run()) {
        prop_assert!(Flat::of(&a).unwrap().gram().unwrap() == a);
    }
}

/// What engines do with columns is what adding runs does.
#[test]
fn columns_merge_as_runs_do() {
    let made = |factor: f64| {
        let numbers = names().iter().enumerate().map(|(place, column)| {
            let number = factor * (place % 17) as f64 - 3.0;
            if column.is_count() { number.abs().round() } else { number }
        });
        let mut numbers: Vec<f64> = numbers.collect();
        numbers[0] = f64::from(FORMAT);
        let texts = ["r", "{}", &serde_json::to_string(&Setting::default()).unwrap(), "[]"];
        Flat { texts: texts.map(str::to_owned), numbers }
    };
    let (a, b) = (made(1.5), made(-0.25));
    let merged = Flat::of(&sum(&a.gram().unwrap(), &b.gram().unwrap())).unwrap();
    for (place, column) in names().iter().enumerate() {
        let (a, b) = (a.numbers[place], b.numbers[place]);
        let expected = match column.merge {
            Merge::Sum => a + b,
            Merge::Min => a.min(b),
            Merge::Max => a.max(b),
        };
        // Bins have the width of the first: they are of one robot.
        if !column.name.ends_with("_width") {
            assert_eq!(merged.numbers[place], expected, "{}", column.name);
        }
    }
}
