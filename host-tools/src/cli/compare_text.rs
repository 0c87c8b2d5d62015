//! What `gmr compare` prints: the list of models, and the table.

use serde::Serialize;

use crate::baselines::{self, Card};
use crate::compare::{Comparison, HOLD_OUT, LeftOut, MassSource, OWN};
use crate::error::Result;
use crate::robot::Robot;

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
}

impl Listed {
    fn all(robot: &Robot) -> Vec<Self> {
        let own = OWN.iter().map(|own| Self {
            name: own.name,
            source: own.source,
            assumes: own.assumes,
            mass: MassSource::Estimated,
            network: false,
            columns: Vec::new(),
            layouts: Vec::new(),
        });
        let baseline = |card: &&Card| Self {
            name: card.name,
            source: card.source,
            assumes: card.assumes,
            mass: if card.takes_mass { MassSource::Given } else { MassSource::Unused },
            network: card.network,
            columns: card.needs.iter().flat_map(|need| need.columns(robot)).copied().collect(),
            layouts: card.layouts.iter().map(|layout| layout.name()).collect(),
        };
        own.chain(baselines::ALL.iter().map(baseline)).collect()
    }
}

/// The models of these names: where each comes from, what it assumes and needs.
pub(super) fn print_list(robot: &Robot, names: &[&str], json: bool) -> Result<()> {
    let mut models = Listed::all(robot);
    models.retain(|model| names.contains(&model.name));
    if json {
        return crate::output::print_json(&models);
    }
    for model in models {
        println!("{}", model.name);
        println!("    {}", model.source);
        println!("    assumes: {}", model.assumes);
        println!("    mass: {}", model.mass.words());
        if !model.columns.is_empty() {
            println!("    needs: {}", model.columns.join(", "));
        }
        if !model.layouts.is_empty() {
            println!("    for: {}", model.layouts.join(", "));
        }
    }
    Ok(())
}

/// Names of the columns; the first and the last are text.
const HEADS: [&str; 7] = ["model", "R²", "MAPE %", "RMSE W", "samples", "fit s", "mass"];

/// The figures of every model, and which models were left out.
pub(super) fn print_table(robot: &Robot, held_out: bool, comparison: &Comparison) {
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
    let mut rows = vec![HEADS.map(str::to_owned)];
    rows.extend(comparison.entries.iter().map(|entry| {
        [
            entry.name.clone(),
            number(entry.r2, 5),
            number(entry.mape_percent, 2),
            number(Some(entry.rmse_w), 4),
            entry.samples.to_string(),
            format!("{:.3}", entry.fit_s),
            entry.mass.words().to_owned(),
        ]
    }));
    let widest = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: [usize; HEADS.len()] = std::array::from_fn(widest);
    for row in &rows {
        let [name, figures @ .., mass] = row;
        let mut line = format!("  {name:<width$}", width = widths[0]);
        for (figure, width) in figures.iter().zip(&widths[1..]) {
            line += &format!("  {figure:>width$}");
        }
        println!("{line}  {mass}");
    }
    for LeftOut { name, reason } in &comparison.left_out {
        println!("  {name:<width$}  left out: {reason}", width = widths[0]);
    }
    if let Some(entry) = comparison.entries.first() {
        println!(
            "MAPE over the {:.0} % of the samples with at least {} W",
            100.0 * entry.mape_share,
            robot.mape_floor_w()
        );
    }
}

/// With so many digits; a figure that has grown absurd by its power of ten, so that the columns stay narrow.
fn number(value: Option<f64>, digits: usize) -> String {
    match value {
        Some(value) if value.abs() >= 1e4 => format!("{value:.1e}"),
        Some(value) if value.is_finite() => format!("{value:.digits$}"),
        _ => "–".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::number;

    #[test]
    fn figures_stay_narrow() {
        let cells = [Some(0.123_456), Some(-123_456.0), Some(f64::NAN), None].map(|value| number(value, 4));
        assert_eq!(cells, ["0.1235", "-1.2e5", "–", "–"]);
    }
}
