//! What `gmr gap-bench` prints for people.

use std::collections::BTreeMap;

use gap::bench::Outcome;
use gap::bench::count::{Closed, Count, Coverage, Seconds, count, figures, label};
use gap::bench::coverage::Covered;
use gap::bench::manoeuvre::{Ending, Parted};

/// How often the mass interval of an extended model holds the mass.
pub(super) fn print_coverage(covered: &[Covered], all: bool) {
    let print = |name: &str, figure: &Coverage| {
        let Coverage { holds, windows, half_width_kg, .. } = figure;
        let (share, width) = (figure.percent(), half_width_kg.unwrap_or(f64::NAN));
        println!("{name:<62} {share:>6.1} %  {holds} of {windows} windows, median ± {width:.3} kg");
    };
    for model in covered.iter().filter(|_| all) {
        let hidden: Vec<&str> = model.case.effects.iter().map(|effect| effect.id()).collect();
        let (size, seed) = (model.case.size, model.case.seed);
        let label = format!("{} size {size} seed {seed}: {}", hidden.join(" + "), model.named.join(" + "));
        print(&label, &Coverage::of("", model.windows.iter().copied()));
    }
    for figure in Coverage::all(covered) {
        print(figure.name, &figure);
    }
}

/// A line a tie, and how many were distinguished.
pub(super) fn print_parted(parted: &[Parted], sets: usize) {
    for tie in parted {
        let case = &tie.case;
        let hidden: Vec<&str> = case.effects.iter().map(|effect| effect.id()).collect();
        let z: Vec<String> = tie
            .suggestion
            .pairs
            .iter()
            .map(|pair| format!("{}: {:.1}", pair.ids.join("/"), pair.z))
            .collect();
        println!(
            "{:?}: {} size {} seed {}: tie [{}] then [{}]; expected z {}; {} for {:.0} s at {:?} kg, {} clean",
            tie.ending,
            hidden.join(" + "),
            case.size,
            case.seed,
            tie.tie.join(", "),
            tie.names.join(", "),
            z.join(", "),
            tie.suggestion.words,
            tie.suggestion.duration_s().unwrap_or(0.0),
            tie.suggestion.masses_kg,
            tie.suggestion.reference_runs
        );
    }
    let number = |ending| parted.iter().filter(|tie| tie.ending == ending).count();
    let alone =
        parted.iter().filter(|tie| tie.suggestion.knots.is_some() && tie.suggestion.reference_runs == 0);
    println!(
        "{} ties were driven in the field alone, the others with clean runs of the profile, too",
        alone.count()
    );
    println!(
        "{sets} sets, {} ties: {} resolved to the truth, {} still tied, {} to another effect, {} lost, {} without a profile",
        parted.len(),
        number(Ending::Resolved),
        number(Ending::Tied),
        number(Ending::Wrong),
        number(Ending::Lost),
        number(Ending::NoProfile)
    );
}

/// A line a kind of set, those that went wrong, and the figures.
pub(super) fn print(outcomes: &[Outcome], all: bool) {
    let mut table: BTreeMap<String, Vec<&Outcome>> = BTreeMap::new();
    for outcome in outcomes {
        table.entry(label(outcome)).or_default().push(outcome);
    }
    println!("{:<40} sets right twins tie wrong abst none  closed", "hidden");
    for (label, outcomes) in &table {
        let number = |wanted: Count| outcomes.iter().filter(|outcome| count(outcome) == wanted).count();
        let mut closed: Vec<f64> = outcomes.iter().filter_map(|outcome| outcome.closed).collect();
        closed.sort_by(f64::total_cmp);
        let middle =
            closed.get(closed.len() / 2).map_or("    –".to_owned(), |c| format!("{:>4.0} %", 100.0 * c));
        println!(
            "{label:<40} {:>4} {:>5} {:>5} {:>3} {:>5} {:>4} {:>4}  {middle}",
            outcomes.len(),
            number(Count::Right),
            number(Count::TwinTie),
            number(Count::InTie),
            number(Count::Wrong),
            number(Count::Abstained),
            number(Count::Missed)
        );
    }
    for outcome in outcomes.iter().filter(|outcome| all || count(outcome) == Count::Wrong) {
        let sizes: Vec<String> = outcome.case.effects.iter().map(|e| format!("{:.3e}", e.size())).collect();
        println!(
            "{} ({}) size {} seed {}: {:?} {} tie [{}] closed {:?} {:.2} s: {}",
            label(outcome),
            sizes.join(", "),
            outcome.case.size,
            outcome.case.seed,
            outcome.verdict,
            outcome.named.join(", "),
            outcome.ties.join(", "),
            outcome.closed.map(|c| (100.0 * c).round()),
            outcome.seconds,
            outcome.note
        );
    }
    print_figures(outcomes);
}

fn print_figures(outcomes: &[Outcome]) {
    println!("figures");
    for figure in figures(outcomes) {
        println!("{:<62} {:>6.1} %  {} of {}", figure.name, figure.percent(), figure.count, figure.of);
    }
    if let Some(closed) = Closed::of(outcomes) {
        println!(
            "{:<62} {:>6.1} %  worst effect {:.1} % ({})",
            "gap closed on locked runs where rightly named, median",
            100.0 * closed.median,
            100.0 * closed.worst,
            closed.worst_effect
        );
    }
    if let Some(seconds) = Seconds::of(outcomes) {
        println!(
            "{:<62} {:>6.2} s  slowest {:.2} s",
            "time for one set, two at a time, median", seconds.median, seconds.slowest
        );
    }
}
