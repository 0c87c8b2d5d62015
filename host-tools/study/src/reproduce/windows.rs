//! The value of a payload window of a given length: its worst start, as in the paper's Fig. 12, and
//! all starts.

use answers::estimate::WindowMass;
use support::error::Result;
use support::metrics::Metrics;

use super::contender::{CONTENDERS, Fitted, Log, moving};
use super::settings::Settings;
use super::spread::Spread;
use super::table::{Cell, Column, Format, Mark, Row, Table, column};

/// Worst-case windows (Section 8): length in s, mass error and MAPE in %, R².
pub(super) const PUBLISHED_WORST: [[f64; 4]; 2] = [[12.5, 19.8, 11.1, 0.68], [50.0, 11.6, 8.6, 0.79]];

/// One method at one window: mass error of the worst window of each payload, mean of the payloads
/// (%); that of all windows (%); MAPE (%) and R² of the power predicted with the worst windows'
/// masses; share of the windows in which the mass is known (%).
pub(super) type AtWindow<T> = [T; 5];

/// The lengths of the sweep, and the published ones, s.
pub(super) fn lengths(settings: &Settings) -> Vec<f64> {
    let asked = settings.windows_s.iter().map(|length| f64::from(*length));
    asked.chain(PUBLISHED_WORST.map(|published| published[0])).collect()
}

/// Step two done once a payload, at the worst moment; step three with that mass until the payload
/// changes.
pub(super) fn at_window(
    fitted: &Fitted<'_>,
    log: &Log,
    window_s: f64,
    floor_w: f64,
) -> Result<AtWindow<f64>> {
    // Every window is judged by itself: without restarts.
    let (replayed, _) = fitted.follow(log, &moving(window_s, false))?;
    let mut metrics = Metrics::new(floor_w);
    let (mut worst_sum, mut all, mut inside) = (0.0, Vec::new(), 0);
    let tasks = log.tasks();
    for task in &tasks {
        let within = |window: &&WindowMass| window.truth_kg == Some(task.mass_kg);
        let windows: Vec<&WindowMass> = replayed.windows.iter().filter(within).collect();
        inside += windows.len();
        let error = |mass: f64| 100.0 * (mass / task.mass_kg - 1.0).abs();
        let masses: Vec<f64> = windows.iter().filter_map(|window| window.mass_kg).collect();
        all.extend(masses.iter().map(|mass| error(*mass)));
        let worst = masses.into_iter().max_by(|a, b| error(*a).total_cmp(&error(*b))).unwrap_or(f64::NAN);
        worst_sum += error(worst);
        for row in &log.rows[task.from..task.to] {
            let predicted = fitted.power(row, worst);
            if predicted.is_finite() {
                metrics.add(row.power, predicted);
            }
        }
    }
    let quality = metrics.quality();
    Ok([
        worst_sum / tasks.len() as f64,
        all.iter().sum::<f64>() / all.len() as f64,
        quality.and_then(|quality| quality.mape_percent).unwrap_or(f64::NAN),
        quality.and_then(|quality| quality.r2).unwrap_or(f64::NAN),
        100.0 * (all.len() as f64 / inside as f64),
    ])
}

/// One method at one window, over seeds.
#[derive(Debug, Clone)]
pub(super) struct WindowRow {
    /// s
    pub(super) window_s: f64,
    /// The method.
    pub(super) method: &'static str,
    /// Over seeds.
    pub(super) figures: AtWindow<Spread>,
}

/// A seed's figures: length in s, method.
pub(super) type Swept = (f64, &'static str, AtWindow<f64>);

/// By window, then in the order of the contenders.
pub(super) fn rows<'a>(seeds: impl Iterator<Item = &'a [Swept]> + Clone) -> Vec<WindowRow> {
    let mut lengths: Vec<f64> = seeds.clone().flatten().map(|(length, ..)| *length).collect();
    lengths.sort_by(f64::total_cmp);
    lengths.dedup();
    let row = |window_s: f64, method| {
        let of = |seed: &[Swept]| {
            let swept = seed.iter().find(|(length, name, _)| *length == window_s && *name == method);
            swept.map_or([f64::NAN; 5], |(.., figures)| *figures)
        };
        WindowRow { window_s, method, figures: Spread::of_each(seeds.clone().map(of)) }
    };
    lengths
        .iter()
        .flat_map(|length| CONTENDERS.iter().map(|contender| row(*length, contender.name)))
        .collect()
}

/// Meaning of the worst window's mass error (Section 8 calls the published ones averages).
pub(super) const WORST_MASS: &str = "of each of the two payloads the worst start, the mean of both (an average, as Section 8 words it; the worst start of Section 6's \
                                     table is the worst of both)";

const COLUMNS: [Column; 8] = [
    column("window_s", "window s", Format::Number(1)),
    column("method", "method", Format::Words),
    column("worst_mass_percent", "mass error, worst %", Format::Error(2)),
    column("mean_mass_percent", "mean %", Format::Error(2)),
    column("", "known %", Format::Share(1)),
    column("mape_percent", "MAPE %", Format::Error(2)),
    column("r2", "R²", Format::R2(3)),
    column("known_percent", "", Format::Share(1)),
];

/// Fig. 12 as a table.
pub(super) fn table(rows: &[WindowRow]) -> Table {
    let ours = |row: &WindowRow| if row.method == CONTENDERS[0].name { Mark::Ours } else { Mark::None };
    let cells = |row: &WindowRow| -> [Cell; 8] {
        let [worst, mean, mape, r2, known] = row.figures.map(Cell::from);
        [row.window_s.into(), row.method.into(), worst, mean, known.clone(), mape, r2, known]
    };
    let published = PUBLISHED_WORST.map(|[window_s, mass, mape, r2]| {
        format!("at {window_s} s the paper has {mass} %, {mape} % and {r2}")
    });
    Table {
        name: "windows",
        title: "Fig. 12: error against window, worst-case start",
        columns: &COLUMNS,
        rows: rows.iter().map(|row| Row::new(ours(row), cells(row))).collect(),
        note: format!(
            "mass error, worst: {WORST_MASS}; MAPE and R² with the worst window's mass; worst mass error, MAPE and R²: {}",
            published.join(", ")
        ),
    }
}
