//! `gmr reproduce`: the paper's figures and tables from simulation, its method and ours side by
//! side.
//!
//! Each section drives and judges its seeds, and returns tables and figures as data, which
//! [`output`] and `page` render.

mod ablation;
mod colours;
mod contender;
mod course;
mod electronics;
mod figures;
pub mod output;
mod page;
mod price;
mod print;
mod recalibration;
mod regime;
mod section6;
mod section7;
mod settings;
mod spread;
mod standing;
mod study;
mod table;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
mod windows;
mod work;

use std::path::Path;

pub use self::settings::Settings;
pub use self::study::Study;

use logs::robot::Robot;
use support::context::Context;
use support::error::Result;

use self::regime::Rails;
use self::study::Outcomes;
use self::work::{Folder, on_all_cores};

/// Runs all seeds on all cores. `done` is called after every seed.
///
/// # Errors
/// A log cannot be written, or a contender cannot be fitted.
pub fn run(context: &Context, settings: &Settings, done: &(dyn Fn() + Sync)) -> Result<Study> {
    let robot = Robot::named("burger")?;
    let folder = Folder::new()?;
    let seeds = on_all_cores(settings.seeds, |index| {
        let seed = one(context, folder.path(), &robot, settings, settings.first_seed + index, index == 0);
        done();
        seed
    })?;
    let (section6, (section7, recalibration)) = seeds.into_iter().unzip();
    let rails = Rails::measure(settings.first_seed)?;
    let differences = print::differences(context, &robot, settings)?;
    Ok(Study::of(settings, Outcomes { section6, section7, recalibration, rails, differences }))
}

fn one(
    context: &Context,
    folder: &Path,
    robot: &Robot,
    settings: &Settings,
    seed: u64,
    draw: bool,
) -> Result<(section6::Seed, (section7::Seed, recalibration::Seed))> {
    let learned = section7::learn(context, folder, robot, seed)?;
    let section6 = section6::seed(context, folder, robot, seed, draw)?;
    let section7 = section7::seed(&learned, settings, draw)?;
    Ok((section6, (section7, recalibration::seed(&learned, &settings.windows_s)?)))
}
