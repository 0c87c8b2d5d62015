//! Prices by hand.

use super::instructions::Counts;
use super::{COUNTED, Input, PricePoint, hardware, price};

fn point(window_s: f64, method: &str, new_mass_w: f64) -> PricePoint {
    PricePoint { window_s, method: method.to_owned(), old_mass_w: 0.5, new_mass_w, actuation_a: 0.4 }
}

/// Samples that all take 300 instructions, 200 of them a second.
fn input(tasks_s: Vec<f64>, points: Vec<PricePoint>) -> Input {
    let counts = Counts { sample: 300, closing: 300 };
    Input { tasks_s, points, rate_hz: 200.0, instructions: vec![("ours", counts), ("paper", counts)] }
}

/// By hand: 3.3 V · 0.7 mA + 12 V · 77.5 µA = 2.31 + 0.93 mW; 3.3 V · 102 mA ∕ 216 MHz = 1.55833 nJ.
#[test]
fn the_parts_draw_what_their_data_sheets_say() {
    assert!((hardware::sensors_w() - 3.24e-3).abs() < 1e-9, "{}", hardware::sensors_w());
    assert!((hardware::INSTRUCTION_J - 1.55833e-9).abs() < 1e-14, "{}", hardware::INSTRUCTION_J);
}

/// 60 s with 10 s of estimating at 200 Hz, by hand: sensors 3.24 mW · 10 s; shunt 0.1 Ω · 0.16 A² · 60 s = 0.96 J; computing
/// 300 · 1.55833 nJ · 200 Hz · 10 s = 0.935 mJ; errors 0.5 W · 10 s and 0.1 W · 50 s. All are products of a few numbers: what rounding
/// leaves is far below a nanojoule but for computing's constant, whose sixth digit is 5e-9 J here.
#[test]
fn a_task_is_priced_part_by_part() {
    let price = price(&input(vec![60.0], vec![point(10.0, "ours", 0.1)]));
    let split = price.priced[0].split;
    let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-8, "{found} {expected}");
    near(split.sensors_j, 0.0324);
    near(split.shunt_j, 0.96);
    near(split.computing_j, 9.35e-4);
    near(split.before_j, 5.0);
    near(split.after_j, 5.0);
    near(price.priced[0].total_j, 10.993_335);
    near(price.best[0].break_even, 0.033_335 / 10.0);
}

/// Errors of 0.5 W before and 2 ∕ T W behind: 60 s cost 5 + 10, 10 + 4 and 20 + 1 J beside the same shunt and little else.
#[test]
fn the_best_window_is_the_cheapest_of_its_task_and_method() {
    let points = [10.0, 20.0, 40.0].map(|t| point(t, "ours", 2.0 / t)).to_vec();
    let points = [points, vec![point(10.0, "paper", 0.3), point(40.0, "paper", f64::NAN)]].concat();
    let price = price(&input(vec![60.0, 15.0], points));
    let best: Vec<_> = price.best.iter().map(|best| (best.task_s, &*best.method, best.window_s)).collect();
    assert_eq!(
        best,
        [(60.0, "ours", 20.0), (60.0, "paper", 10.0), (15.0, "ours", 10.0), (15.0, "paper", 10.0)]
    );
    assert!(!price.best[0].at_end && price.best[1].at_end);
    assert_eq!(price.best[0].dominant, "error before the estimate");
    // Windows of 20 and 40 s do not fit into 15 s.
    assert_eq!(price.priced.iter().filter(|priced| priced.task_s == 15.0).count(), 2);
}

#[test]
fn the_bench_has_counted_every_method() {
    let default = Input::default();
    assert_eq!(default.instructions.len(), COUNTED.len());
    assert!(
        default.instructions.iter().all(|(_, counts)| counts.closing > counts.sample && counts.sample > 0)
    );
}

/// A method that nobody has counted has no price, rather than that of free computing.
#[test]
fn a_method_without_a_count_has_no_price() {
    let price = price(&input(vec![60.0], vec![point(10.0, "other", 0.1)]));
    assert!(price.priced[0].total_j.is_nan() && price.best.is_empty());
}
