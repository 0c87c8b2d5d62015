//! The top of the page: what came out, good or bad.

use maud::{Markup, html};

use crate::report::html::tile;
use crate::reproduce::standing::{Goal, Standing, Standings, goals};
use crate::reproduce::study::Study;
use crate::reproduce::table::{number, with_unit};

pub(super) fn header(study: &Study) -> Markup {
    let goals = goals(&study.experiment);
    let standings = Standings::of(&study.experiment.models);
    html! {
        header {
            p class="kind" { "gmr reproduce" }
            h1 id="verdict" { (headline(&standings, &goals, study.settings.seeds)) }
            @if Standing::can_be_told(study.settings.seeds) {
                @for sentence in sentences(&standings) { p { (sentence) } }
            }
            div class="tiles" {
                @for goal in &goals { (goal_tile(goal)) }
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
    let found =
        goal.found.map_or("–".to_owned(), |found| number(found.mean, if goal.at_least { 3 } else { 2 }));
    let (verdict, class) = match goal.is_reached() {
        Some(true) => ("reached", "good"),
        Some(false) => ("missed", "bad"),
        None => ("not measured", ""),
    };
    tile(&with_unit(found, goal.unit), &format!("{}; {sign} {limit}: {verdict}", goal.what), class)
}

pub(super) fn headline(standings: &Standings, goals: &[Goal], seeds: u64) -> String {
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
    use super::headline;
    use crate::reproduce::standing::Standings;

    #[test]
    fn the_headline_does_not_hide_a_loss() {
        let all = Standings { ahead: 3, ..Standings::default() };
        assert_eq!(
            headline(&all, &[], 20),
            "Ours is ahead of all 3 models that are not told the mass; 0 of 0 goals reached"
        );
        let lost = Standings { ahead: 3, behind: vec!["quann".to_owned()], ..Standings::default() };
        assert!(
            headline(&lost, &[], 20).starts_with("Ours is ahead of 3 of 4 models"),
            "{}",
            headline(&lost, &[], 20)
        );
        let said = [1, 5, 6].map(|seeds| headline(&all, &[], seeds));
        assert_eq!(said[0], "One seed: no intervals, nothing can be told apart; 0 of 0 goals reached");
        assert_eq!(said[1], "5 seeds are too few to tell models apart; 0 of 0 goals reached");
        assert!(said[2].starts_with("Ours is ahead of all"), "{}", said[2]);
    }
}
