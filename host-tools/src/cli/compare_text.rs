//! What `gmr compare` prints: the list of models, and the table.

use logs::robot::Robot;
use serde::Serialize;
use study::baselines::{self, Card, Layout};
use study::compare::{Comparison, Entry, HOLD_OUT, Horizon, LeftOut, MassSource, OURS, WeightSeeds};
use support::error::Result;
use support::figure::{figure, number};

/// A model as the list describes it.
#[derive(Serialize)]
struct Listed {
    name: &'static str,
    source: &'static str,
    assumes: &'static str,
    /// How it gets the mass where the payload is not known.
    mass: MassSource,
    network: bool,
    /// Columns that it needs beside speeds and power, for this robot.
    columns: Vec<&'static str>,
    /// Wheel layouts that it is for; any, where none is named.
    layouts: Vec<&'static str>,
    /// Kind of equation; those of one family differ in terms, not in method.
    family: &'static str,
    /// What of its source it leaves out or has otherwise.
    reduced: &'static str,
    /// Whether it predicts from power that was measured on the drive.
    horizon: Horizon,
}

impl Listed {
    fn all(robot: &Robot) -> Vec<Self> {
        let ours = OURS.iter().map(|model| Self {
            name: model.name,
            source: model.source,
            assumes: model.assumes,
            mass: MassSource::Estimated,
            network: false,
            columns: Vec::new(),
            layouts: Vec::new(),
            family: "this project's and the paper's",
            reduced: "",
            horizon: Horizon::Second,
        });
        let baseline = |card: &Card| Self {
            name: card.name,
            source: card.source,
            assumes: card.assumes,
            mass: MassSource::of(card),
            network: card.is_network(),
            columns: card.needs.iter().flat_map(|need| need.columns(robot)).copied().collect(),
            layouts: card.layouts.iter().map(|layout| layout.name()).collect(),
            family: card.family.name(),
            reduced: card.reduced,
            horizon: Horizon::of(card),
        };
        ours.chain(baselines::every().map(baseline)).collect()
    }
}

/// The models of these names: where each comes from, what it assumes and needs.
pub(super) fn print_list(robot: &Robot, names: &[&str], json: bool) -> Result<()> {
    let mut models = Listed::all(robot);
    models.retain(|model| names.contains(&model.name));
    if json {
        return support::output::print_json(&serde_json::json!({ "models": models }));
    }
    for model in models {
        println!("{}", model.name);
        println!("    {}", model.source);
        println!("    assumes: {}", model.assumes);
        println!("    mass: {}", model.mass.words());
        println!("    family: {}", model.family);
        if !model.reduced.is_empty() {
            println!("    reduced: {}", model.reduced);
        }
        if model.horizon == Horizon::Sample {
            println!("    predicts from the power of the sample before");
        }
        if !model.columns.is_empty() {
            println!("    needs: {}", model.columns.join(", "));
        }
        if !model.layouts.is_empty() {
            println!("    for: {}", model.layouts.join(", "));
        }
    }
    println!("{}", counted(robot));
    Ok(())
}

/// How many methods there are, and how many kinds of them.
fn counted(robot: &Robot) -> String {
    let layout = Layout::of(robot);
    let fits = |card: &&&Card| card.layouts.is_empty() || card.layouts.contains(&layout);
    let runs = baselines::ALL.iter().filter(fits).count();
    format!(
        "{} cards of the paper's Table 1, of {} families; {runs} of them are for {}",
        baselines::ALL.len(),
        baselines::families(),
        layout.name()
    )
}

/// Names of the columns; the first and the last two are text.
const HEADS: [&str; 10] = [
    "model",
    "R²",
    "MAPE %",
    "RMSE W",
    "mass error %",
    "samples",
    "fit s",
    "persistence R²",
    "horizon",
    "mass",
];

/// The best model and ours, in one line. The best predicts without power that was measured on the
/// drive; of masses as well where any does.
fn answer(comparison: &Comparison) -> Option<String> {
    let ours = comparison.entries.first()?;
    let fair =
        comparison.entries.iter().filter(|entry| entry.horizon != Horizon::Sample && entry.mass == ours.mass);
    let mut fair: Vec<&Entry> = fair.collect();
    fair.sort_by(|a, b| a.rmse_w.total_cmp(&b.rmse_w));
    let place = 1 + fair.iter().position(|entry| entry.name == ours.name)?;
    let error = |entry: &Entry| format!("{} ({} W)", entry.name, figure(entry.rmse_w));
    Some(if place == 1 {
        let next = fair.get(1).map_or(String::new(), |next| format!("; next {}", error(next)));
        format!("Best of {}: ours, {}{next}", fair.len(), error(ours))
    } else {
        format!("Best of {}: {}; ours, {}, is number {place}", fair.len(), error(fair[0]), error(ours))
    })
}

/// Rows shown unless all are asked for: the best, and ours.
const SHOWN: usize = 5;

/// The answer, and the figures of the best models, or of all and why others were left out.
pub(super) fn print_table(robot: &Robot, held_out: bool, comparison: &Comparison, all: bool) {
    if let Some(answer) = answer(comparison) {
        println!("{answer}");
    }
    let split = if held_out {
        format!("one in {HOLD_OUT} blocks held out")
    } else {
        format!("payload window {} s", comparison.window_s)
    };
    println!(
        "{}: {} rows to fit, {} to evaluate ({split})",
        robot.name(),
        comparison.train_rows,
        comparison.test_rows
    );
    let mut entries: Vec<&Entry> = comparison.entries.iter().collect();
    if !all {
        // Ours first, then the best by their error.
        if let Some((_, others)) = entries.split_first_mut() {
            others.sort_by(|a, b| a.rmse_w.total_cmp(&b.rmse_w));
        }
        entries.truncate(1 + SHOWN);
    }
    let mut rows = vec![HEADS.map(str::to_owned)];
    rows.extend(entries.iter().map(|entry| {
        [
            entry.name.clone(),
            number(entry.r2, 5),
            number(entry.mape_percent, 2),
            number(Some(entry.rmse_w), 4),
            number(entry.mass_error_percent, 2),
            entry.samples.to_string(),
            format!("{:.3}", entry.fit_s),
            number(entry.persistence_r2, 5),
            entry.horizon.words().to_owned(),
            entry.mass.words().to_owned(),
        ]
    }));
    let widest = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: [usize; HEADS.len()] = std::array::from_fn(widest);
    for row in &rows {
        let [name, figures @ .., horizon, mass] = row;
        let mut line = format!("  {name:<width$}", width = widths[0]);
        for (figure, width) in figures.iter().zip(&widths[1..]) {
            line += &format!("  {figure:>width$}");
        }
        println!("{line}  {horizon:<width$}  {mass}", width = widths[8]);
    }
    let more = comparison.entries.len() - entries.len();
    if !all {
        if more + comparison.left_out.len() > 0 {
            println!(
                "  {more} more rows, and {} models left out with the reason: --all",
                comparison.left_out.len()
            );
        }
        return;
    }
    for LeftOut { name, reason } in &comparison.left_out {
        println!("  {name:<width$}  left out: {reason}", width = widths[0]);
    }
    for entry in &comparison.entries {
        if let Some(WeightSeeds { count, least_r2, greatest_r2 }) = entry.weight_seeds {
            let name = &entry.name;
            println!(
                "  {name}: the median of {count} seeds of its weights, R² {least_r2:.3} to {greatest_r2:.3}"
            );
        }
    }
    println!(
        "filter {} Hz, power {} s later than speeds, for every model; horizon: power measured on the test drive that a model uses, and what persistence reaches with it",
        comparison.cutoff_hz,
        number(Some(comparison.delay_s), 3)
    );
    if let Some(entry) = comparison.entries.first() {
        println!(
            "MAPE over the {:.0} % of the samples with at least {} W",
            100.0 * entry.mape_share,
            robot.mape_floor_w()
        );
    }
}
