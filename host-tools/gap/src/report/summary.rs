//! The answer on one screen: at most [`LINES`] lines of [`COLUMNS`] columns.

use super::advice;
use super::localise::Cell;
use crate::likelihood::Gate;
use crate::report::Report;
use crate::words;
use residuals::types::{Named, Verdict};

/// Lines of a small terminal, less the one of the next prompt.
pub const LINES: usize = 23;

/// Its columns.
pub const COLUMNS: usize = 96;

/// Cells with the greatest mean residual that are said.
const CELLS: usize = 3;

/// Effects that are said in full.
const EFFECTS: usize = 3;

/// Ties that are listed with what would distinguish them.
const PARTED: usize = 4;

/// The summary.
pub fn text(report: &Report) -> String {
    let mut out: Vec<String> = Vec::new();
    let mut say = |indent: usize, text: &str| out.extend(wrapped(indent, text));
    say(0, &headline(report));
    for named in report.effects.iter().take(EFFECTS) {
        say(2, &effect(named));
    }
    if let Some(probabilities) = probabilities(report) {
        say(0, &probabilities);
    }
    if let Some(gate) = report.relabelled {
        say(0, &relabelled(gate));
    }
    for note in &report.notes {
        say(2, note);
    }
    say(0, &gap(report));
    say(2, &format!("noise floor: {}", report.confirmed.floor_how));
    if report.verdict != Verdict::None {
        for (place, cell) in advice::worst_cells(report, CELLS).into_iter().enumerate() {
            if place == 0 {
                say(0, "Measured less predicted, mean of the runs' means:");
            }
            say(2, &cell_words(cell));
        }
    }
    let steps = advice::next_steps(report);
    match report.verdict {
        Verdict::Ambiguous => {
            say(0, "What would part them (an effect, and where it shows):");
            for step in steps.iter().take(PARTED) {
                say(2, step);
            }
            if let Some(more @ 1..) = steps.len().checked_sub(PARTED) {
                say(2, &format!("and {more} more, in --json and --report"));
            }
        }
        _ => say(0, &format!("Next: {}.", steps.join("; "))),
    }
    if !report.not_testable.is_empty() {
        let all = report.not_testable.iter().map(|missing| format!("{} ({})", missing.id, missing.reason));
        say(0, &format!("Not testable here: {}.", words::some_of(all)));
    }
    cut(&mut out);
    out.join("\n") + "\n"
}

/// How probable each effect is; `None` where it is not known.
fn probabilities(report: &Report) -> Option<String> {
    let each = report.rivals.iter();
    let each = each.map(|(id, probability)| format!("{id} {}", words::probability(*probability)));
    let known = if report.effects.len() > 1 { ", the other names being known" } else { "" };
    let all = each.collect::<Vec<_>>().join(", ");
    (!all.is_empty()).then(|| format!("Probability among the listed effects{known}: {all}."))
}

/// How often other labels of the runs show as much.
pub(super) fn relabelled(gate: Gate) -> String {
    let [share, level] = [gate.share, gate.level].map(|share| 100.0 * share);
    let so = if gate.is_shut() { "it may be how clean runs differ" } else { "it is of the field" };
    format!(
        "If other runs are called the field, as much shows in {share:.1} % of cases ({level:.1} % allowed): {so}."
    )
}

/// The verdict in a sentence.
pub fn headline(report: &Report) -> String {
    let names =
        || report.effects.iter().map(|named| named.candidate.id.clone()).collect::<Vec<_>>().join(" + ");
    match report.verdict {
        Verdict::None if report.is_power_only() => {
            "NONE: no step of the power at rest; these logs cannot tell while driving: they lack the wheels' speeds.".to_owned()
        }
        Verdict::None => format!("NONE: nothing nameable; {}.", off_by(report)),
        Verdict::Named => format!("NAMED: the model lacks {}.", names()),
        Verdict::Ambiguous => format!(
            "AMBIGUOUS: the model lacks {}, or {}: these runs cannot tell them apart.",
            names(),
            report.ambiguous_with.join(" or ")
        ),
        Verdict::Unexplained => {
            format!(
                "UNEXPLAINED: there is a gap, and no effect is named. {}.",
                capital(&advice::why_unexplained(report))
            )
        }
    }
}

/// By how much the model is off, and how much of it is noise.
fn off_by(report: &Report) -> String {
    let [off, noise] = [report.confirmed.before_w, report.confirmed.floor_unclipped_w].map(words::watts);
    format!("the model is off by {off}, the noise is {noise}")
}

/// An effect with its coefficient, its error, and its meaning.
pub fn effect(named: &Named) -> String {
    let candidate = &named.candidate;
    let mut text = format!("{} = {}: {}", candidate.id, words::size(named), words::meaning(candidate));
    if let Some(direction) = words::direction(named) {
        // Adding zero takes the sign off −0.
        let degrees = direction.to_degrees().round() + 0.0;
        text += &format!(", rising towards {degrees}° from the heading at the start");
    } else {
        let detail = candidate.detail.words();
        if !detail.is_empty() {
            text += &format!(" ({detail})");
        }
    }
    text
}

/// The gap before and after against the noise floor.
pub fn gap(report: &Report) -> String {
    let confirmed = &report.confirmed;
    let count = confirmed.runs.len();
    let s = if count == 1 { "" } else { "s" };
    let floor = floor(report);
    let before = words::watts(confirmed.before_w);
    let stands = report.verdict.stands();
    if !stands {
        return format!("Gap (RMS) on {count} locked run{s}: {before}, noise floor {floor}.");
    }
    let better = confirmed.by_run.iter().filter(|(before, after)| after < before).count();
    let closed = match confirmed.closed {
        Some(closed) => format!("{} of the gap closed", words::percent(closed)),
        None => "share closed not testable: no locked run has the effect".to_owned(),
    };
    format!(
        "Gap (RMS) on {count} locked run{s}: {before} → {}, noise floor {floor}: {closed}; smaller in {better} of {count}, mean square by {}.",
        words::watts(confirmed.after_w),
        gain(report)
    )
}

/// By how much the mean square shrinks on the locked runs.
pub(super) fn gain(report: &Report) -> String {
    let gain = report.confirmed.gain_w2;
    match gain.ends() {
        Some((low, high)) => format!("{} W² (95 %: {} to {})", digits(gain.mean), digits(low), digits(high)),
        None => format!("{} W² (one locked run: no interval)", digits(gain.mean)),
    }
}

/// Three significant digits.
fn digits(value: f64) -> String {
    words::watts(value).trim_end_matches(" W").to_owned()
}

/// The noise floor; with the estimate where the gap that remains is below that.
pub(super) fn floor(report: &Report) -> String {
    let floor = words::watts(report.confirmed.floor_w);
    estimated(report).map_or_else(
        || floor.clone(),
        |estimated| format!("{floor} (estimated {estimated}, held at what is left)"),
    )
}

/// Label of a tile with the noise floor.
pub(super) fn floor_label(report: &Report) -> String {
    estimated(report)
        .map_or("noise floor".to_owned(), |estimated| format!("noise floor (estimated {estimated})"))
}

/// The noise floor as it was estimated, if that is not what counts.
fn estimated(report: &Report) -> Option<String> {
    let [floor, estimated] = [report.confirmed.floor_w, report.confirmed.floor_unclipped_w].map(words::watts);
    (floor != estimated).then_some(estimated)
}

/// A cell with its mean before and after.
pub fn cell_words(cell: &Cell) -> String {
    let after = cell.mean_after_w.map_or(String::new(), |w| format!(", after: {} W", words::signed_watts(w)));
    format!(
        "{}: {} ± {:.2} W (95 %){after}",
        cell.words,
        words::signed_watts(cell.mean_residual_w),
        cell.band_w
    )
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// Lines of words within the columns; those after the first stand two further in.
fn wrapped(indent: usize, text: &str) -> Vec<String> {
    let mut lines = Vec::new();
    let mut line = " ".repeat(indent);
    let mut empty = true;
    for word in text.split_whitespace() {
        if !empty && line.chars().count() + 1 + word.chars().count() > COLUMNS {
            lines.push(std::mem::replace(&mut line, " ".repeat(indent + 2)));
            empty = true;
        }
        if !empty {
            line.push(' ');
        }
        // A word longer than a line is cut.
        line.extend(word.chars().take(COLUMNS - indent - 2));
        empty = false;
    }
    lines.push(line);
    lines
}

/// Leaves out what the screen does not hold, and says so.
fn cut(lines: &mut Vec<String>) {
    if lines.len() > LINES {
        lines.truncate(LINES - 1);
        lines.push("… (more in --json and --report)".to_owned());
    }
}

#[cfg(test)]
mod tests {
    use super::{COLUMNS, LINES, cut, text, wrapped};
    use crate::report::example::report;
    use residuals::types::Verdict;

    #[test]
    fn every_verdict_fits_on_one_screen_and_says_what_it_has_to() {
        for (verdict, said) in [
            (
                Verdict::None,
                [
                    "NONE: nothing nameable; the model is off by 0.310 W, the noise is 0.120 W",
                    "noise floor 0.100 W",
                    "refit",
                ],
            ),
            (Verdict::Named, ["NAMED: the model lacks grade", "0.310 W → 0.110 W", "96 % of the gap closed"]),
            (Verdict::Ambiguous, ["cannot tell them apart", "windage: hold the top speed", "and 3 more"]),
            (Verdict::Unexplained, ["UNEXPLAINED", "with the number 7", "pitch_rad"]),
        ] {
            let text = text(&report(verdict));
            let flowing = text.split_whitespace().collect::<Vec<_>>().join(" ");
            for said in said {
                assert!(flowing.contains(said), "{said}: {text}");
            }
            assert!(text.lines().count() <= LINES, "{text}");
            assert!(text.lines().all(|line| line.chars().count() <= COLUMNS), "{text}");
        }
        // A slope along the world: √(0.03² + 0.06²) by the motors, three quarters of it by the
        // road, rising towards atan2(2, 1).
        let named = text(&report(Verdict::Named)).split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(
            named.contains("grade = 0.05033 ± 0.00075 rad (2.9°), coefficient 0.0671 ± 0.0010: ")
                && named.contains("along the way,")
                && named.contains("rising towards 63°"),
            "{named}"
        );
    }

    #[test]
    fn no_line_is_wider_than_the_screen_and_no_word_is_lost() {
        let text = "some words of a sentence ".repeat(30);
        let lines = wrapped(2, &text);
        assert!(lines.len() > 5 && lines.iter().all(|line| line.chars().count() <= COLUMNS));
        let words = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
        assert_eq!(words(&lines.join(" ")), words(&text));
        assert!(wrapped(2, &"x".repeat(500)).iter().all(|line| line.chars().count() <= COLUMNS));
        let mut many = vec![String::new(); 100];
        cut(&mut many);
        assert_eq!(many.len(), LINES);
        assert!(many[LINES - 1].contains("more"));
    }
}
