//! Section 6's table.

use super::{Mark, Row, Table, error, number, r2};
use crate::reproduce::study::{PublishedSimulation, Simulation, SimulationRow};

pub(super) fn table(simulation: &Simulation) -> Table {
    let PublishedSimulation {
        mape_percent,
        r2,
        after_start_percent,
        after_change_percent,
        worst_start_percent,
    } = simulation.published;
    let published = Row {
        cells: vec![
            "published".to_owned(),
            number(mape_percent, 1),
            number(r2, 3),
            number(after_start_percent, 1),
            number(after_change_percent, 1),
            number(worst_start_percent, 1),
        ],
        mark: Mark::None,
    };
    let rows = simulation.rows.iter().enumerate().map(|(place, row)| {
        let mut cells = vec![row.method.clone()];
        cells.extend(figures(row));
        Row { cells, mark: if place == 0 { Mark::Ours } else { Mark::None } }
    });
    Table {
        name: "simulation",
        title: "Section 6: simulation of Tables 2 and 3, windows of 10 s".to_owned(),
        head: vec![
            "method",
            "#MAPE %",
            "#R²",
            "#mass error after start %",
            "#after change %",
            "#worst start %",
        ],
        rows: std::iter::once(published).chain(rows).collect(),
        note: "power with the mass of each task's first 10 s; worst start: the worst of both payloads; published: Section 6 and Section 8".to_owned(),
    }
}

fn figures(row: &SimulationRow) -> [String; 5] {
    [
        error(&row.mape_percent, 2),
        r2(&row.r2, 4),
        error(&row.after_start_percent, 2),
        error(&row.after_change_percent, 2),
        error(&row.worst_start_percent, 2),
    ]
}
