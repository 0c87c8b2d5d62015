//! The reproduction as one page: the result first, then tables and figures in the order of the
//! paper.

use maud::{Markup, html};
use report::html::{document, drawing, tile};
use support::error::Result;

use super::figures::Figure;
use super::price::Best;
use super::standing::{Goal, Standing, Standings};
use super::study::{INTERVALS, Study};
use super::table::{Mark, Table, number, with_unit};

/// An item of the page, by its name.
enum Item {
    Table(&'static str),
    Figure(&'static str),
    /// Where print and derivation differ, in words.
    Differences,
    /// The price of sensing, in words.
    Findings,
}

/// Headings, and what stands below each.
const SECTIONS: [(&str, &[Item]); 5] = [
    (
        "Simulation (Section 6)",
        &[Item::Table("simulation"), Item::Figure("fig05"), Item::Figure("fig06"), Item::Figure("fig07")],
    ),
    (
        "Experiment's regime (Section 7)",
        &[
            Item::Table("goals"),
            Item::Table("knobs"),
            Item::Table("nearness"),
            Item::Figure("fig09"),
            Item::Figure("fig10"),
            Item::Figure("fig11"),
            Item::Figure("fig12"),
            Item::Table("windows"),
            Item::Figure("fig13"),
            Item::Figure("fig14"),
            Item::Figure("fig15"),
            Item::Table("models"),
            Item::Figure("models"),
            Item::Table("left-out"),
        ],
    ),
    ("Recalibration (Fig. 4)", &[Item::Table("recalibration")]),
    ("Price of sensing and computing", &[Item::Findings, Item::Figure("price"), Item::Table("price")]),
    ("Print against derivation (Eq. 18)", &[Item::Differences, Item::Table("print")]),
];

/// The page.
///
/// # Errors
/// A figure cannot be drawn.
pub(super) fn text(study: &Study) -> Result<String> {
    let settings = &study.settings;
    let windows: Vec<String> = settings.windows_s.iter().map(ToString::to_string).collect();
    let mut sections = Vec::new();
    for (title, items) in SECTIONS {
        let items = items.iter().map(|item| shown(study, item)).collect::<Result<Vec<_>>>()?;
        sections.push(html! { h2 { (title) } @for item in items { (item) } });
    }
    let body = html! {
        (header(study))
        h2 { "Settings" }
        p {
            (settings.words()) ". Figures over time show the first, tables " (INTERVALS) ". Windows of the sweep: " (windows.join(", ")) " s. Baselines: " (settings.baselines.len()) "."
        }
        p class="soft" { "gmr " (env!("CARGO_PKG_VERSION")) ". The same seeds give the same page, byte for byte, on the same machine." }
        @for section in sections { (section) }
    };
    Ok(document("gmr reproduce", body))
}

fn shown(study: &Study, item: &Item) -> Result<Markup> {
    Ok(match item {
        Item::Table(name) => {
            html! { @for wanted in study.tables.iter().filter(|table| table.name == *name) { (table(wanted)) } }
        }
        Item::Figure(name) => match study.figures.iter().find(|figure| figure.name == *name) {
            Some(Figure { title, caption, page, .. }) => {
                let drawn = drawing(page, title, &format!("{title}. {caption}"), None)?;
                html! { div id=(name) { (drawn) } }
            }
            None => html! {},
        },
        Item::Findings => html! { @for best in &study.price.best { p { (finding(best)) } } },
        Item::Differences => html! {
            div class="wide" { table {
                tr { @for head in ["difference", "print", "derivation", "remark"] { th { (head) } } }
                @for difference in &study.differences {
                    tr { @for cell in [difference.what, difference.print, difference.derivation, difference.remark] { td { (cell) } } }
                }
            } }
        },
    })
}

fn table(table: &Table) -> Markup {
    let heads: Vec<_> = table.heads().map(|(name, right)| (name, right.then_some("number"))).collect();
    let mark = |mark: Mark| match mark {
        Mark::None | Mark::Published => None,
        Mark::Ours => Some("ours"),
        Mark::Against => Some("against"),
    };
    html! {
        h3 id=(format!("table-{}", table.name)) { (table.title) }
        @if table.rows.is_empty() { p { "None." } } @else {
            div class="wide" { table {
                tr { @for (name, class) in &heads { th class=[class] { (name) } } }
                @for row in &table.rows {
                    tr class=[mark(row.mark)] {
                        @for (cell, (_, class)) in table.texts(row).zip(&heads) { td class=[class] { (cell) } }
                    }
                }
            } }
        }
        @if !table.note.is_empty() { p class="soft" { (table.note) "." } }
    }
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

/// The top of the page: the result, good or bad.
fn header(study: &Study) -> Markup {
    let (standings, seeds) = (&study.standings, study.settings.seeds);
    html! {
        header {
            p class="kind" { "gmr reproduce" }
            h1 id="verdict" { (headline(standings, &study.goals, seeds)) }
            @if Standing::can_be_told(seeds) {
                @for sentence in sentences(standings) { p { (sentence) } }
            }
            div class="tiles" {
                @for goal in &study.goals { (goal_tile(goal)) }
            }
            p class="soft" {
                "Everything here is simulated: the paper's logs are not public. The experiment's regime is a plant whose sensors and noise were set "
                "until the paper's own methods came near their published figures; ours then ran on exactly those logs."
            }
        }
    }
}

fn goal_tile(goal: &Goal) -> Markup {
    let sign = if goal.at_least { "at least" } else { "at most" };
    let limit = with_unit(goal.limit.to_string(), goal.unit);
    let digits = if goal.at_least { 3 } else { 2 };
    let measured = goal.measured.map_or("–".to_owned(), |spread| number(spread.mean, digits));
    let class = match goal.is_reached() {
        Some(true) => "good",
        Some(false) => "bad",
        None => "",
    };
    tile(&with_unit(measured, goal.unit), &format!("{}; {sign} {limit}: {}", goal.what, goal.words()), class)
}

fn headline(standings: &Standings, goals: &[Goal], seeds: u64) -> String {
    let reached = goals.iter().filter(|goal| goal.is_reached() == Some(true)).count();
    let order = match (standings.behind.len(), standings.level.len()) {
        _ if seeds == 1 => "One seed: no intervals, nothing can be told apart".to_owned(),
        _ if !Standing::can_be_told(seeds) => format!("{seeds} seeds are too few to tell models apart"),
        (0, 0) if standings.ahead == 0 => "No baseline was run".to_owned(),
        (0, 0) => format!("Ours is ahead of all {} models that are not told the mass", standings.ahead),
        (behind, level) => format!(
            "Ours is ahead of {} of {} models that are not told the mass",
            standings.ahead,
            standings.ahead + behind + level
        ),
    };
    format!("{order}; {reached} of {} goals reached", goals.len())
}

/// Which models are not behind, by name.
fn sentences(standings: &Standings) -> Vec<String> {
    let about = [
        ("Ahead of ours in MAPE or R²", &standings.behind),
        ("Not told apart from ours by these seeds", &standings.level),
        ("Ahead of ours in MAPE or R², with the true mass as an input", &standings.behind_with_mass),
    ];
    let named = about.into_iter().filter(|(_, names)| !names.is_empty());
    named.map(|(what, names)| format!("{what}: {}.", names.join(", "))).collect()
}

#[cfg(test)]
mod tests {
    use super::{Standings, headline};

    #[test]
    fn the_headline_does_not_hide_a_loss() {
        let all = Standings { ahead: 3, ..Standings::default() };
        assert_eq!(
            headline(&all, &[], 20),
            "Ours is ahead of all 3 models that are not told the mass; 0 of 0 goals reached"
        );
        let lost = Standings { ahead: 3, behind: vec!["quann".to_owned()], ..Standings::default() };
        let text = headline(&lost, &[], 20);
        assert!(text.starts_with("Ours is ahead of 3 of 4 models"), "{text}");
        let said = [1, 5, 6].map(|seeds| headline(&all, &[], seeds));
        assert_eq!(said[0], "One seed: no intervals, nothing can be told apart; 0 of 0 goals reached");
        assert_eq!(said[1], "5 seeds are too few to tell models apart; 0 of 0 goals reached");
        assert!(said[2].starts_with("Ours is ahead of all"), "{}", said[2]);
    }
}
