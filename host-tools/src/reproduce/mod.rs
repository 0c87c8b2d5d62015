//! `gmr reproduce`: the paper's figures and tables from simulation, its method and ours side by side.
//!
//! Each section drives and judges its seeds, and makes tables and figures of them: data that [`output`] and `page` render.

mod ablation;
mod contender;
mod course;
mod figures;
pub mod output;
mod page;
mod parts;
mod price;
mod print;
mod recalibration;
mod regime;
mod section6;
mod section7;
mod spread;
mod standing;
mod table;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;
mod windows;

use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use serde::Serialize;
use serde_json::{Value, json};
use tempfile::TempDir;

use self::figures::{Figure, Sources};
use self::price::Price;
use self::print::Difference;
use self::regime::Rails;
use self::spread::Spread;
use self::standing::{Goal, Standings};
use self::table::{Column, Format, Mark, Row, Table, column};
use crate::error::{Error, Result};
use crate::robot::Robot;

/// What was asked for.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Settings {
    /// The first seed; figures over time show this one.
    pub first_seed: u64,
    /// Number of seeds that figures with a spread are over.
    pub seeds: u64,
    /// Payload windows of the sweep, in s.
    pub windows_s: Vec<u32>,
    /// Names of the baselines.
    pub baselines: Vec<&'static str>,
}

/// What a reproduction finds: everything that its tables, figures and page show.
pub struct Study {
    settings: Settings,
    goals: Vec<Goal>,
    standings: Standings,
    /// In the order of the paper.
    tables: Vec<Table>,
    figures: Vec<Figure>,
    price: Price,
    differences: Vec<Difference>,
    share_known: Spread,
    static_power_w: (f64, f64),
}

/// What the seeds gave, in their order; the first one is drawn.
struct Found {
    section6: Vec<section6::Seed>,
    section7: Vec<section7::Seed>,
    recalibration: Vec<recalibration::Seed>,
    rails: Rails,
    differences: Vec<Difference>,
}

/// Does all of it, seeds on all cores. `done` hears of every seed that is.
///
/// # Errors
/// A log cannot be written, a contender cannot be fitted, or `stopped` was set meanwhile.
pub fn run(settings: &Settings, stopped: &AtomicBool, done: impl Fn() + Sync) -> Result<Study> {
    let robot = Robot::load("burger")?;
    let folder = temporary_folder()?;
    let seeds = on_all_cores(settings.seeds, stopped, |index| {
        let seed = one(folder.path(), &robot, settings, stopped, settings.first_seed + index, index == 0);
        done();
        seed
    })?;
    let (section6, (section7, recalibration)) = seeds.into_iter().unzip();
    let rails = Rails::measure(settings.first_seed)?;
    let differences = print::differences(&robot, settings, stopped)?;
    Ok(Study::of(settings, Found { section6, section7, recalibration, rails, differences }))
}

fn one(
    folder: &Path,
    robot: &Robot,
    settings: &Settings,
    stopped: &AtomicBool,
    seed: u64,
    draw: bool,
) -> Result<(section6::Seed, (section7::Seed, recalibration::Seed))> {
    let learned = section7::learn(folder, robot, seed)?;
    let section6 = section6::seed(folder, robot, seed, draw)?;
    go_on(stopped)?;
    let section7 = section7::seed(&learned, settings, draw)?;
    go_on(stopped)?;
    Ok((section6, (section7, recalibration::seed(&learned, &settings.windows_s)?)))
}

const LEFT_OUT: [Column; 2] =
    [column("name", "model", Format::Words), column("reason", "why", Format::Words)];

impl Study {
    fn of(settings: &Settings, mut found: Found) -> Self {
        let simulation = section6::rows(&found.section6);
        let windows = windows::rows(&found.section7);
        let models = section7::models(&found.section7);
        let known: Vec<f64> = found.section7.iter().map(|seed| 100.0 * seed.known_share).collect();
        let share_known = Spread::over(&known);
        let goals = standing::goals(&windows, &models);
        let points = recalibration::prices(&found.recalibration);
        let price = price::price(&price::Input { points, ..price::Input::default() });
        let left_out = found.section7.first().map_or(&[][..], |seed| &seed.left_out);
        let left_out = left_out
            .iter()
            .map(|left| Row::new(Mark::None, [left.name.clone().into(), left.reason.clone().into()]));
        let tables = vec![
            standing::goals_table(&goals),
            section6::table(&simulation),
            regime::knobs(),
            regime::nearness(&windows, &models, &share_known),
            windows::table(&windows),
            standing::models(&models),
            Table {
                name: "left-out",
                title: "Baselines that these logs do not allow",
                columns: &LEFT_OUT,
                rows: left_out.collect(),
                note: String::new(),
            },
            recalibration::table(&found.recalibration),
            price::table(&price),
            print::table(&found.differences),
        ];
        let figures = figures::all(&Sources {
            simulation: &simulation,
            section6: &found.section6.iter_mut().find_map(|seed| seed.courses.take()).unwrap_or_default(),
            rails: &found.rails,
            section7: &found.section7.iter_mut().find_map(|seed| seed.courses.take()).unwrap_or_default(),
            windows: &windows,
            models: &models,
            price: &price,
        });
        Self {
            settings: settings.clone(),
            standings: Standings::of(&models),
            goals,
            tables,
            figures,
            price,
            differences: found.differences,
            share_known,
            static_power_w: found.rails.gaussian_w,
        }
    }

    /// All tables as text.
    pub fn text(&self) -> String {
        let tables: Vec<String> = self.tables.iter().map(ToString::to_string).collect();
        format!("{}. Figures are {INTERVALS}.\n\n{}", seeds(&self.settings), tables.join("\n"))
    }

    /// The figures for scripts, with all their digits; without what is drawn over time.
    pub fn json(&self) -> Value {
        let table = |name: &str| self.tables.iter().find(|table| table.name == name).map(Table::json);
        json!({
            "settings": self.settings,
            "goals": table("goals"),
            "standings": self.standings,
            "published_simulation": section6::published(),
            "simulation": table("simulation"),
            "knobs": table("knobs"),
            "nearness": table("nearness"),
            "static_power_w": self.static_power_w,
            "windows": table("windows"),
            "models": table("models"),
            "left_out": table("left-out"),
            "share_known": self.share_known,
            "recalibration": table("recalibration"),
            "price": self.price,
            "print": self.differences,
        })
    }
}

/// How to read a figure with an interval.
const INTERVALS: &str = "means over seeds with the 95 % intervals of the means [low, high]; an end that few seeds would put \
                         beyond what a figure can be (an error below 0, R² above 1) is shown at that limit";

/// Which seeds.
fn seeds(settings: &Settings) -> String {
    let first = settings.first_seed;
    match settings.seeds {
        1 => format!("Seed {first}"),
        count => format!("Seeds {first} to {}", first + count.saturating_sub(1)),
    }
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
