//! `gmr reproduce`: the paper's figures and tables from simulation, its method and ours side by side.
//!
//! What is found is a value ([`study`]); what people look at is made from it ([`page`], [`table`]).

mod contender;
mod experiment;
pub mod figures;
pub mod output;
pub mod page;
pub mod price;
pub mod print;
mod rails;
mod recalibration;
mod regime;
mod section6;
mod section7;
mod spread;
pub mod standing;
pub mod study;
pub mod table;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
mod windows;

use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

pub use study::{Settings, Study};
use tempfile::TempDir;

use crate::error::{Error, Result};
use crate::robot::Robot;

/// What one seed gives.
struct Seed {
    section6: section6::Seed,
    section7: section7::Seed,
    recalibration: recalibration::Seed,
}

/// Does all of it, seeds on all cores. `done` hears of every seed that is.
///
/// # Errors
/// A log cannot be written, a contender cannot be fitted, or `stopped` was set meanwhile.
pub fn run(settings: &Settings, stopped: &AtomicBool, done: impl Fn() + Sync) -> Result<Study> {
    let robot = Robot::load("burger")?;
    let folder = temporary_folder()?;
    let seeds = on_all_cores(settings.seeds, stopped, |index| {
        let draw = index == 0;
        let seed = one(folder.path(), &robot, settings, stopped, settings.first_seed + index, draw);
        done();
        seed
    })?;
    let (mut section6, mut section7, mut recalibration) = (Vec::new(), Vec::new(), Vec::new());
    for seed in seeds {
        section6.push(seed.section6);
        section7.push(seed.section7);
        recalibration.push(seed.recalibration);
    }
    Ok(Study {
        settings: settings.clone(),
        simulation: section6::gather(section6),
        experiment: section7::gather(section7, rails::measure(settings.first_seed)?),
        price: price::price(&price::Input {
            points: recalibration::prices(&recalibration),
            ..price::Input::default()
        }),
        recalibration: recalibration::gather(&recalibration),
        print: print::differences(&robot, settings, stopped)?,
    })
}

fn one(
    folder: &Path,
    robot: &Robot,
    settings: &Settings,
    stopped: &AtomicBool,
    seed: u64,
    draw: bool,
) -> Result<Seed> {
    let learned = experiment::learn(folder, robot, seed)?;
    let section6 = section6::seed(folder, robot, seed, draw)?;
    go_on(stopped)?;
    let section7 = section7::seed(&learned, settings, draw)?;
    go_on(stopped)?;
    Ok(Seed { section6, section7, recalibration: recalibration::seed(&learned, &settings.windows_s)? })
}

/// For the logs of the work; goes with it, whatever its end.
fn temporary_folder() -> Result<TempDir> {
    let folder = tempfile::Builder::new().prefix("gmr-").tempdir();
    folder.map_err(|error| Error::io(std::env::temp_dir(), &error))
}

/// Ends the work between two of its parts.
fn go_on(stopped: &AtomicBool) -> Result<()> {
    if stopped.load(Ordering::Relaxed) {
        return Err(Error::failed("stopped before the last seed was done; nothing was written"));
    }
    Ok(())
}

/// `work` for 0 … `count`, as many at a time as there are cores; the results in order, or the first failure. Once `stopped` is set
/// no more is begun.
fn on_all_cores<T: Send>(
    count: u64,
    stopped: &AtomicBool,
    work: impl Fn(u64) -> Result<T> + Sync,
) -> Result<Vec<T>> {
    let next = AtomicU64::new(0);
    let results = Mutex::new(Vec::new());
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    if index >= count {
                        break;
                    }
                    let result = go_on(stopped).and_then(|()| work(index));
                    // Another worker's panic has been reported by the scope already.
                    if let Ok(mut results) = results.lock() {
                        results.push((index, result));
                    }
                }
            });
        }
    });
    let mut results = results.into_inner().map_err(|_| Error::failed("a worker stopped"))?;
    results.sort_by_key(|(index, _)| *index);
    results.into_iter().map(|(_, result)| result).collect()
}

/// A figure over seeds; `None` where a seed has none.
fn spread_of<S>(seeds: &[S], value: impl Fn(&S) -> Option<f64>) -> study::Spread {
    let values: Vec<f64> = seeds.iter().map(|seed| value(seed).unwrap_or(f64::NAN)).collect();
    study::Spread::over(&values)
}
