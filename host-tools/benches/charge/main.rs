//! The gauge of `model_core::charge` on full discharges of a simulated battery, beside turtlebot3's
//! map from voltage on the same runs.
//!
//!     cargo bench -p host-tools --bench charge [-- SEEDS]
//!
//! Ends with exit code 1 where a jump is over one point, or the worst of the median run with known
//! sensors is over two.

mod run;

use std::process::ExitCode;

use run::{Discharge, SETTLED_S, Setting, discharge};

/// What of a run is compared.
type Figure = fn(&Discharge) -> f64;

fn main() -> ExitCode {
    let seeds = std::env::args().filter_map(|argument| argument.parse().ok()).next().unwrap_or(100_u64);
    println!(
        "{seeds} discharges of a battery of three cells from 85 to 100 % down to 3 %, load steps of 0 to 2 A; the gauge starts 20 points low,\n\
         knows no resistance, and has the curve of another make. Points of charge, from {SETTLED_S} s on; jumps from the start on, within 10 s\n\
         of a load step. stock: turtlebot3's map, 10.5 V = 0, 12.3 V = 100 %.\n"
    );
    let mut good = true;
    for (name, setting) in [
        ("sensor and capacity known, 15-30 °C", Setting::Known),
        ("the same, with the curve of the battery's own make", Setting::OwnCurve),
        ("the same, but from 65 to 80 % on and told 20 points too much", Setting::TooHigh),
        ("the board's firmware, told nothing, 0.5 A and more", Setting::Board),
        ("harsh: capacity ±3 %, gains 0.3 and 0.1 %, 5-35 °C", Setting::Harsh),
    ] {
        let runs: Vec<Discharge> = (1..=seeds).map(|seed| discharge(seed, setting)).collect();
        let of = |what: Figure| {
            let mut values: Vec<f64> = runs.iter().map(what).filter(|value| !value.is_nan()).collect();
            values.sort_by(f64::total_cmp);
            values
        };
        let at = |values: &[f64], share: f64| values[((values.len() - 1) as f64 * share).round() as usize];
        println!("{name}");
        println!("  {:<38} {:>8} {:>8} {:>8}", "", "median", "90 %", "worst");
        let rows: [(&str, Figure); 6] = [
            ("worst error of a run", |run| run.worst),
            ("root mean square", |run| run.rms),
            ("jump at a load step", |run| run.jump),
            ("within 2 points for good from, s", |run| run.within_s),
            ("stock: worst error", |run| run.stock),
            ("stock: jump at a load step", |run| run.stock_jump),
        ];
        for (what, value) in rows {
            let values = of(value);
            println!(
                "  {what:<38} {:>8.2} {:>8.2} {:>8.2}",
                at(&values, 0.5),
                at(&values, 0.9),
                at(&values, 1.0)
            );
        }
        let within = runs.iter().filter(|run| run.worst <= 2.0).count();
        let covered = runs.iter().map(|run| run.covered).sum::<f64>() / runs.len() as f64;
        let resistances = of(|run| run.resistance.abs());
        println!("  runs within 2 points                   {within} of {seeds}");
        println!("  95 % interval holds the truth          {:.1} % of the time", 100.0 * covered);
        println!(
            "  error of the resistance at the end     {:.0} % median, {:.0} % at 90 %\n",
            100.0 * at(&resistances, 0.5),
            100.0 * at(&resistances, 0.9)
        );
        good &= at(&of(|run| run.jump), 1.0) <= 1.0;
        good &= setting != Setting::Known || at(&of(|run| run.worst), 0.5) <= 2.0;
    }
    if good { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
