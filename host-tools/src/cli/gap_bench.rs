//! `gmr gap-bench`: what the gap workflow finds of effects hidden in simulated runs.

use std::collections::BTreeMap;
use std::io::IsTerminal;

use indicatif::{ProgressBar, ProgressStyle};

use crate::error::{Error, Result};
use crate::gap::bench::coverage::{self, Covered};
use crate::gap::bench::manoeuvre::{self, Ending, Parted};
use crate::gap::bench::sets::noises;
use crate::gap::bench::{self, Case, Outcome};
use crate::gap::types::Verdict;
use crate::numerics::robust::median;
use crate::robot::Robot;

/// Arguments of `gmr gap-bench`.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Seeds of every effect and size
    #[arg(long, default_value_t = 3)]
    seeds: u64,
    /// The first seed
    #[arg(long, default_value_t = 1)]
    first_seed: u64,
    /// Sizes: RMS of what an effect adds to the power, in standard deviations of its noise
    #[arg(long, value_delimiter = ',', default_value = "0.5,1,2")]
    sizes: Vec<f64>,
    /// Effect-free sets
    #[arg(long, default_value_t = 20)]
    free: u64,
    /// Only these effects
    #[arg(long, value_delimiter = ',')]
    only: Vec<String>,
    /// Sets whose effect is taken out of the dictionary, per effect
    #[arg(long, default_value_t = 0)]
    removed: u64,
    /// Sets with two effects
    #[arg(long, default_value_t = 0)]
    pairs: usize,
    /// Of sets that end in a tie: drive the suggested manoeuvre, look again, and count what is then told apart
    #[arg(long)]
    manoeuvre: bool,
    /// Of sets whose effect is named: add it, estimate masses in runs that nobody has seen, and count how often the 95 % interval holds
    #[arg(long)]
    coverage: bool,
    /// Print every set
    #[arg(long)]
    all: bool,
}

pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let robot = Robot::load("burger")?;
    let effects: Vec<_> = bench::typical()?
        .into_iter()
        .filter(|effect| arguments.only.is_empty() || arguments.only.iter().any(|only| only == effect.id()))
        .collect();
    let last = arguments.first_seed + arguments.seeds;
    let case =
        |effects: Vec<_>, size, seed| Case { effects, size, seed, noise: noises()[0], removed: Vec::new() };
    let mut cases = Vec::new();
    for effect in &effects {
        for &size in &arguments.sizes {
            for seed in arguments.first_seed..last {
                cases.push(case(vec![effect.clone()], size, seed));
            }
        }
        for seed in arguments.first_seed..arguments.first_seed + arguments.removed {
            let removed = vec![effect.id().to_owned()];
            cases.push(Case { removed, ..case(vec![effect.clone()], 1.0, seed) });
        }
    }
    for pair in 0..arguments.pairs {
        let (first, step) = (pair % effects.len(), 1 + pair / effects.len() * 3 % (effects.len() - 1).max(1));
        let second = (first + step) % effects.len();
        if effects[first].id() != effects[second].id() {
            let both = vec![effects[first].clone(), effects[second].clone()];
            cases.push(case(both, 1.0, arguments.first_seed + pair as u64));
        }
    }
    cases.extend((0..arguments.free).map(|k| bench::effect_free(1000 * arguments.first_seed + k)));
    if cases.is_empty() {
        return Err(Error::usage("no set is asked for"));
    }
    let bar = if std::io::stderr().is_terminal() {
        ProgressBar::new(cases.len() as u64)
    } else {
        ProgressBar::hidden()
    };
    bar.set_style(
        ProgressStyle::with_template("{wide_bar} {pos}/{len} {eta}")
            .unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    if arguments.manoeuvre {
        let parted = manoeuvre::run(&robot, &cases, &bar)?;
        bar.finish_and_clear();
        print_parted(&parted, cases.len());
        return Ok(());
    }
    if arguments.coverage {
        let covered = coverage::run(&robot, &cases, &bar)?;
        bar.finish_and_clear();
        print_coverage(&covered, arguments.all);
        return Ok(());
    }
    let mut outcomes = bench::run(&robot, cases, &bar)?;
    bar.finish_and_clear();
    outcomes.sort_by_key(|outcome| (label(outcome), outcome.case.size.to_bits(), outcome.case.seed));
    print(&outcomes, arguments.all);
    Ok(())
}

/// How often the mass interval of an extended model holds the mass.
fn print_coverage(covered: &[Covered], all: bool) {
    let figure = |name: &str, windows: &[(bool, f64)]| {
        let holds = windows.iter().filter(|(holds, _)| *holds).count();
        let mut widths: Vec<f64> = windows.iter().map(|(_, width)| *width).collect();
        let share = 100.0 * holds as f64 / windows.len() as f64;
        let middle = median(&mut widths).unwrap_or(f64::NAN);
        println!("{name:<62} {share:>6.1} %  {holds} of {} windows, median ± {middle:.3} kg", windows.len());
    };
    let label = |own: &Covered| {
        let hidden: Vec<&str> = own.case.effects.iter().map(|effect| effect.id()).collect();
        format!(
            "{} size {} seed {}: {}",
            hidden.join(" + "),
            own.case.size,
            own.case.seed,
            own.named.join(" + ")
        )
    };
    for own in covered.iter().filter(|_| all) {
        figure(&label(own), &own.windows);
    }
    let of = |right: bool, windows: fn(&Covered) -> &Vec<(bool, f64)>| -> Vec<(bool, f64)> {
        covered.iter().filter(|own| own.right || !right).flat_map(|own| windows(own).clone()).collect()
    };
    figure("95 % mass interval after an extension, rightly named", &of(true, |own| &own.windows));
    figure("the same, by the noise of the base alone", &of(true, |own| &own.by_base));
    figure("95 % mass interval after an extension, whatever was named", &of(false, |own| &own.windows));
}

/// A line a tie, and how many were told apart.
fn print_parted(parted: &[Parted], sets: usize) {
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

fn label(outcome: &Outcome) -> String {
    let case = &outcome.case;
    let ids: Vec<&str> = case.effects.iter().map(|effect| effect.id()).collect();
    let kind = if case.removed.is_empty() { "" } else { " (removed)" };
    if ids.is_empty() { format!("none, {}", case.noise.name) } else { ids.join(" + ") + kind }
}

/// Effects that no drive on level ground tells apart within a minute: a tie between them is the right answer.
const TWINS: [[&str; 2]; 5] = [
    ["viscous-change", "lubricant-warm-up"],
    ["viscous-change", "windage"],
    ["lubricant-warm-up", "windage"],
    ["supply-sag", "gear-load-loss"],
    ["wheel-drag", "sensor-gain"],
];

/// How an outcome is counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Count {
    Right,
    TwinTie,
    InTie,
    Wrong,
    Abstained,
    Missed,
}

fn count(outcome: &Outcome) -> Count {
    let truth: Vec<&str> = outcome.case.effects.iter().map(|effect| effect.id()).collect();
    let has = |list: &[String], id: &str| list.iter().any(|own| own == id);
    match outcome.verdict {
        Verdict::None => Count::Missed,
        Verdict::Unexplained => Count::Abstained,
        Verdict::Named | Verdict::Ambiguous => {
            let all = outcome.named.iter().chain(&outcome.ties).cloned().collect::<Vec<_>>();
            let named = truth.iter().filter(|id| has(&outcome.named, id)).count();
            let covered = truth.iter().filter(|id| has(&all, id)).count();
            let wrong = outcome.named.iter().any(|id| !truth.contains(&id.as_str()));
            if !outcome.case.removed.is_empty() {
                return if outcome.verdict == Verdict::Named { Count::Wrong } else { Count::InTie };
            }
            if outcome.ties.is_empty() {
                return if named == truth.len() && !wrong { Count::Right } else { Count::Wrong };
            }
            let twins = truth.len() == 1
                && all.iter().all(|id| {
                    id == truth[0] || TWINS.iter().any(|t| t.contains(&id.as_str()) && t.contains(&truth[0]))
                });
            match (covered == truth.len(), twins) {
                (true, true) => Count::TwinTie,
                (true, false) => Count::InTie,
                _ => Count::Wrong,
            }
        }
    }
}

fn print(outcomes: &[Outcome], all: bool) {
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
    figures(outcomes);
}

/// A figure of the bench: how many sets of a kind ended so, of how many.
fn figure(name: &str, of: &[&Outcome], wanted: impl Fn(&Outcome) -> bool) {
    if of.is_empty() {
        return;
    }
    let count = of.iter().filter(|outcome| wanted(outcome)).count();
    let share = 100.0 * count as f64 / of.len() as f64;
    println!("{name:<62} {share:>6.1} %  {count} of {}", of.len());
}

fn figures(outcomes: &[Outcome]) {
    let of = |wanted: &dyn Fn(&Case) -> bool| -> Vec<&Outcome> {
        outcomes.iter().filter(|outcome| wanted(&outcome.case)).collect()
    };
    let alone = of(&|case| case.effects.len() == 1 && case.removed.is_empty());
    let free = of(&|case| case.effects.is_empty());
    let removed = of(&|case| !case.removed.is_empty());
    let pairs = of(&|case| case.effects.len() == 2);
    println!("figures");
    figure("alone: right single name, true twins in a tie counted", &alone, |outcome| {
        matches!(count(outcome), Count::Right | Count::TwinTie)
    });
    figure("alone: truth is the name or in the tie set", &alone, |outcome| {
        matches!(count(outcome), Count::Right | Count::TwinTie | Count::InTie)
    });
    figure("alone: wrong single name", &alone, |outcome| {
        count(outcome) == Count::Wrong && outcome.ties.is_empty()
    });
    figure("no effect: an alarm", &free, |outcome| outcome.verdict != Verdict::None);
    figure("effect removed from the dictionary: a single name", &removed, |outcome| {
        count(outcome) == Count::Wrong
    });
    figure("pairs: both named, or one named and the other in a tie", &pairs, |outcome| {
        matches!(count(outcome), Count::Right | Count::InTie)
    });
    let mut closed: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for outcome in alone.iter().filter(|outcome| matches!(count(outcome), Count::Right | Count::TwinTie)) {
        if let Some(share) = outcome.closed {
            closed.entry(label(outcome)).or_default().push(share);
        }
    }
    let middle = |mut shares: Vec<f64>| {
        shares.sort_by(f64::total_cmp);
        100.0 * shares[shares.len() / 2]
    };
    let worst =
        closed.iter().map(|(id, shares)| (middle(shares.clone()), id)).min_by(|a, b| a.0.total_cmp(&b.0));
    if let Some((worst, id)) = worst {
        let all: Vec<f64> = closed.values().flatten().copied().collect();
        println!(
            "{:<62} {:>6.1} %  worst effect {worst:.1} % ({id})",
            "gap closed on locked runs where rightly named, median",
            middle(all)
        );
    }
    let mut seconds: Vec<f64> = outcomes.iter().map(|outcome| outcome.seconds).collect();
    seconds.sort_by(f64::total_cmp);
    if let Some(slowest) = seconds.last() {
        println!(
            "{:<62} {:>6.2} s  slowest {slowest:.2} s",
            "time for one set, two at a time, median",
            seconds[seconds.len() / 2]
        );
    }
}
