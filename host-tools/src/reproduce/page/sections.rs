//! The sections below the summary, in the order of the paper.

use maud::{Markup, html};

use super::Content;
use crate::error::Result;
use crate::report::html::drawing;
use crate::reproduce::price::Best;
use crate::reproduce::study::Study;
use crate::reproduce::table::{INTERVALS, Mark, Table, number, seeds};

impl Content {
    /// The figures of these names, below each other.
    fn figures(&self, names: &[&str]) -> Result<Markup> {
        let found = names.iter().filter_map(|name| self.figures.iter().find(|figure| figure.name == *name));
        let drawn = found.map(|figure| {
            let about = format!("{}. {}", figure.title, figure.caption);
            let drawing = drawing(&figure.page, &figure.title, &about)?;
            Ok(html! { div id=(figure.name) { (drawing) } })
        });
        let drawn = drawn.collect::<Result<Vec<_>>>()?;
        Ok(html! { @for figure in drawn { (figure) } })
    }

    /// The table of this name.
    fn table(&self, name: &str) -> Markup {
        html! { @for found in self.tables.iter().filter(|table| table.name == name) { (table(found)) } }
    }
}

fn table(table: &Table) -> Markup {
    let columns: Vec<_> = table.columns().collect();
    let class = |place: usize| columns.get(place).is_some_and(|column| column.1).then_some("number");
    html! {
        h3 id=(format!("table-{}", table.name)) { (table.title) }
        @if table.rows.is_empty() { p { "None." } } @else {
            div class="wide" { table {
                tr { @for (name, number) in &columns { th class=[number.then_some("number")] { (name) } } }
                @for row in &table.rows {
                    tr class=[mark(row.mark)] {
                        @for (place, cell) in row.cells.iter().enumerate() { td class=[class(place)] { (cell) } }
                    }
                }
            } }
        }
        @if !table.note.is_empty() { p class="soft" { (table.note) "." } }
    }
}

fn mark(mark: Mark) -> Option<&'static str> {
    match mark {
        Mark::None => None,
        Mark::Ours => Some("ours"),
        Mark::Against => Some("against"),
    }
}

pub(super) fn settings(study: &Study) -> Markup {
    let settings = &study.settings;
    let windows: Vec<String> = settings.windows_s.iter().map(ToString::to_string).collect();
    html! {
        h2 { "Settings" }
        p {
            (seeds(settings)) ". Figures over time show the first, tables " (INTERVALS) ". Windows of the sweep: " (windows.join(", ")) " s. Baselines: " (settings.baselines.len()) "."
        }
        p class="soft" { "gmr " (env!("CARGO_PKG_VERSION")) ". The same seeds give the same page, byte for byte, on the same machine." }
    }
}

pub(super) fn simulation(content: &Content) -> Result<Markup> {
    Ok(html! {
        h2 { "Simulation (Section 6)" }
        (content.table("simulation"))
        (content.figures(&["fig05", "fig06", "fig07"])?)
    })
}

pub(super) fn experiment(content: &Content) -> Result<Markup> {
    Ok(html! {
        h2 { "Experiment's regime (Section 7)" }
        (content.table("goals"))
        (content.table("knobs"))
        (content.table("nearness"))
        (content.figures(&["fig09", "fig10", "fig11", "fig12"])?)
        (content.table("windows"))
        (content.figures(&["fig13", "fig14", "fig15"])?)
        (content.table("models"))
        (content.figures(&["models"])?)
        (content.table("left-out"))
    })
}

pub(super) fn recalibration(content: &Content) -> Markup {
    html! {
        h2 { "Recalibration (Fig. 4)" }
        (content.table("recalibration"))
    }
}

pub(super) fn price(study: &Study, content: &Content) -> Result<Markup> {
    Ok(html! {
        h2 { "Price of sensing and computing" }
        @for best in &study.price.best { p { (finding(best)) } }
        (content.figures(&["price"])?)
        (content.table("price"))
    })
}

/// The window that costs least, and why.
fn finding(best: &Best) -> String {
    let end = if best.at_end { ", the end of those tried," } else { "" };
    format!(
        "A task of {} s is cheapest with {} s of {}{end} at {} J; the greatest part is {}. Sensors and computing take {} mJ.",
        number(best.task_s, 0),
        number(best.window_s, 1),
        best.method,
        number(best.total_j, 2),
        best.dominant,
        number(1e3 * best.split.spent_j(), 1)
    )
}

pub(super) fn print(study: &Study, content: &Content) -> Markup {
    html! {
        h2 { "Print against derivation (Eq. 18)" }
        div class="wide" { table {
            tr { th { "difference" } th { "print" } th { "derivation" } th { "remark" } }
            @for difference in &study.print {
                tr {
                    td { (difference.what) }
                    td { (difference.print) }
                    td { (difference.derivation) }
                    td { (difference.remark) }
                }
            }
        } }
        (content.table("print"))
    }
}
