//! Steps that runs have in common, and whether the locked runs confirm them.

use logs::speed_column;
use model::effects::{Detail, ENTRIES, NotTestable, Physical, STATIC_STEP};
use model_core::torque::{PARAMETERS, TorqueModel};
use numerics::intervals::mean_interval;
use serde_json::{Value, json};
use support::error::Result;

use super::gap::{Squares, at_rest};
use super::read::PowerRun;
use super::rests::{Rests, Step};
use crate::confirm::Confirmed;
use crate::report::Report;
use crate::report::localise::Cell;
use residuals::predictor::State;
use residuals::split::{self, Split};
use residuals::thresholds::detect::NO_DIFFERENCE;
use residuals::thresholds::localise::CELLS;
use residuals::thresholds::power_only::{LEAST_BLOCKS, LEAST_RUNS, SAME_SHARE, STEP_ERRORS};
use residuals::types::{Named, Round, Scored, Standing, Status, Verdict};

/// The one effect that shows.
const STEP: &str = STATIC_STEP.id;

/// What these logs never show.
const CANNOT_KNOW: &str =
    "what switched, and whether it moves anything: a slow motion for the rest of the run looks the same";

/// A step that several runs have.
struct Kind {
    size_w: f64,
    std_err_w: f64,
    /// Run and step.
    members: Vec<(usize, Step)>,
}

impl Kind {
    fn has(&self, step: &Step) -> bool {
        is_same((self.size_w, self.std_err_w), (step.size_w(), step.std_err_w()))
    }

    /// When, and between which levels, run by run.
    fn detail(&self, runs: &[PowerRun]) -> Detail {
        let of = |value: &dyn Fn(&Step) -> f64| -> Value {
            self.members.iter().map(|(_, step)| value(step)).collect()
        };
        let names: Vec<&String> = self.members.iter().map(|(run, _)| &runs[*run].name).collect();
        Detail::Levels(vec![
            ("runs", json!(names)),
            ("after_s", of(&|step| step.between_s.0)),
            ("before_s", of(&|step| step.between_s.1)),
            ("from_w", of(&|step| step.from.level_w)),
            ("to_w", of(&|step| step.to.level_w)),
            ("sizes_w", of(&Step::size_w)),
            ("size_std_errs_w", of(&Step::std_err_w)),
            ("not_known", json!(CANNOT_KNOW)),
        ])
    }
}

fn is_same(one: (f64, f64), other: (f64, f64)) -> bool {
    let difference = (one.0 - other.0).abs();
    one.0 * other.0 > 0.0
        && (difference <= NO_DIFFERENCE * one.1.hypot(other.1) || difference <= SAME_SHARE * one.0.abs())
}

/// Looks for changes of the static power in logs of power only.
///
/// # Errors
/// Fewer runs than naming and confirming need.
pub fn investigate(runs: &[PowerRun]) -> Result<Report> {
    let split = split::in_order(&(0..runs.len()).collect::<Vec<_>>())?;
    let rests: Vec<Rests> = runs.iter().map(Rests::of).collect();
    let steps: Vec<(usize, Step)> = split
        .open
        .iter()
        .flat_map(|&run| rests[run].steps.iter().map(move |step| (run, step.clone())))
        .filter(|(_, step)| step.size_w().abs() > STEP_ERRORS * step.std_err_w())
        .collect();
    let greatest = steps.iter().map(|(_, step)| step.size_w().abs() / step.std_err_w()).fold(0.0, f64::max);
    let has_steps = !steps.is_empty();
    let (kinds, lone) = kinds(steps);
    let confirmed = confirm(runs, &rests, &split, &kinds);
    let refuted = confirmed.refuted(false);
    let verdict = match (kinds.is_empty(), has_steps) {
        (true, false) => Verdict::None,
        (true, true) => Verdict::Unexplained,
        (false, _) if refuted => Verdict::Unexplained,
        (false, _) => Verdict::Named,
    };
    let mut effects: Vec<Named> = Vec::new();
    if verdict == Verdict::Named {
        effects.extend(kinds.iter().map(|kind| named(kind.size_w, kind.std_err_w, kind.detail(runs))));
        effects.extend(kinds.first().and_then(|kind| between_runs(runs, kind)));
    }
    let outcome = match verdict {
        Verdict::None => "no step between levels that the power returns to; what lifts it in between is motion for all that \
                          these logs tell"
            .to_owned(),
        Verdict::Named => format!("added {STEP}"),
        _ if refuted => "the locked runs do not confirm the step".to_owned(),
        _ => format!(
            "{} in one run only; expected at least {LEAST_RUNS} open runs with the same step: record more",
            if lone == 1 { "a step".to_owned() } else { format!("{lone} steps") }
        ),
    };
    let candidates = kinds.iter().map(|kind| Scored {
        id: STEP.to_owned(),
        detail: kind.detail(runs),
        gain: (kind.size_w / kind.std_err_w).powi(2),
        coefficients: vec![kind.size_w],
        status: if verdict == Verdict::Named { Status::Winner } else { Status::Worse },
    });
    let round =
        Round { structure: greatest, allowed: STEP_ERRORS, candidates: candidates.collect(), outcome };
    let unknown = TorqueModel::from_array([f64::NAN; PARAMETERS]);
    Ok(Report {
        verdict,
        standing: Standing::Clear,
        effects,
        ambiguous_with: Vec::new(),
        not_testable: not_testable(),
        rounds: vec![round],
        localisation: cells(runs, &rests, &split.open),
        confirmed,
        state: State { torque: unknown, effects: Vec::new() },
        covariance: None,
        split,
        over_dispersion: None,
        clean_structure: None,
        refit: Vec::new(),
        residuals: (Vec::new(), None),
        base: [unknown, unknown],
        ties: Vec::new(),
        rivals: Vec::new(),
        relabelled: None,
        notes: Vec::new(),
        basis: None,
    })
}

/// Everything but a step needs the wheels' speeds.
fn not_testable() -> Vec<NotTestable> {
    let wheels = speed_column(0);
    let others = ENTRIES.iter().filter(|entry| entry.id != STEP);
    others
        .map(|entry| NotTestable {
            id: entry.id.to_owned(),
            reason: match entry.needs {
                "" => format!("needs {wheels}"),
                more => format!("needs {wheels}, {more}"),
            },
        })
        .collect()
}

/// Steps that at least two runs have in common, those of most runs first, and the number of others.
fn kinds(mut steps: Vec<(usize, Step)>) -> (Vec<Kind>, usize) {
    let mut kinds = Vec::new();
    loop {
        let alike = |centre: &Step| -> Vec<usize> {
            let centre = (centre.size_w(), centre.std_err_w());
            let same =
                |(_, (_, step)): &(usize, &(usize, Step))| is_same(centre, (step.size_w(), step.std_err_w()));
            steps.iter().enumerate().filter(same).map(|(place, _)| place).collect()
        };
        let runs_of = |places: &[usize]| {
            let mut runs: Vec<usize> = places.iter().map(|&place| steps[place].0).collect();
            runs.dedup();
            runs.len()
        };
        let best = steps.iter().map(|(_, step)| alike(step)).max_by_key(|places| runs_of(places));
        match best {
            Some(places) if runs_of(&places) >= LEAST_RUNS => {
                let members: Vec<(usize, Step)> = places.iter().map(|&place| steps[place].clone()).collect();
                kinds.push(kind(members));
                let mut place = 0;
                steps.retain(|_| {
                    place += 1;
                    !places.contains(&(place - 1))
                });
            }
            _ => return (kinds, steps.len()),
        }
    }
}

fn kind(members: Vec<(usize, Step)>) -> Kind {
    let weight = |step: &Step| step.std_err_w().powi(-2);
    let weights: f64 = members.iter().map(|(_, step)| weight(step)).sum();
    let size_w = members.iter().map(|(_, step)| weight(step) * step.size_w()).sum::<f64>() / weights;
    let count = members.len() as f64;
    let scatter = members.iter().map(|(_, step)| (step.size_w() - size_w).powi(2)).sum::<f64>()
        / (count - 1.0).max(1.0);
    Kind { size_w, std_err_w: weights.powf(-0.5).max((scatter / count).sqrt()), members }
}

fn named(size_w: f64, std_err_w: f64, detail: Detail) -> Named {
    let any = (f64::NEG_INFINITY, f64::INFINITY);
    let candidate = STATIC_STEP.candidate(Vec::new(), any, detail, 0.0);
    let physical = Physical { value: size_w, unit: candidate.unit.clone(), std_err: std_err_w };
    Named { candidate, coefficients: vec![size_w], std_errs: vec![std_err_w], physical: Some(physical) }
}

/// Runs that are lower than others by the same power before and after the step: a state that does
/// not change within a run.
fn between_runs(runs: &[PowerRun], kind: &Kind) -> Option<Named> {
    let mut levels: Vec<(usize, f64, f64, f64)> = kind
        .members
        .iter()
        .map(|(run, step)| {
            let (from, to) = (&step.from, &step.to);
            // Of the mean of both.
            (*run, from.level_w, to.level_w, 0.5 * from.std_err_w.hypot(to.std_err_w))
        })
        .collect();
    levels.sort_by(|a, b| (a.1 + a.2).total_cmp(&(b.1 + b.2)));
    let gap = |place: usize| levels[place + 1].1 + levels[place + 1].2 - levels[place].1 - levels[place].2;
    let cut = (0..levels.len().checked_sub(1)?).max_by(|&a, &b| gap(a).total_cmp(&gap(b)))?;
    let (low, high) = levels.split_at(cut + 1);
    let mean = |group: &[(usize, f64, f64, f64)], level: fn(&(usize, f64, f64, f64)) -> f64| {
        group.iter().map(level).sum::<f64>() / group.len() as f64
    };
    let before = mean(low, |run| run.1) - mean(high, |run| run.1);
    let after = mean(low, |run| run.2) - mean(high, |run| run.2);
    let error = mean(low, |run| run.3).hypot(mean(high, |run| run.3));
    let size = 0.5 * (before + after);
    let stands_out = size.abs() > STEP_ERRORS * error && (before - after).abs() < 2.0 * NO_DIFFERENCE * error;
    stands_out.then(|| {
        let names = |group: &[(usize, f64, f64, f64)]| -> Vec<&String> {
            group.iter().map(|run| &runs[run.0].name).collect()
        };
        let detail = Detail::Levels(vec![
            ("between", json!("runs")),
            ("runs", json!(names(low))),
            ("against", json!(names(high))),
            ("sizes_w", json!([before, after])),
            ("not_known", json!("what differs between these runs")),
        ]);
        named(size, error, detail)
    })
}

/// The gap at rest of the locked runs: a step has the size of the open runs, and the run's own
/// time.
fn confirm(runs: &[PowerRun], rests: &[Rests], split: &Split, kinds: &[Kind]) -> Confirmed {
    let mut all = Squares::default();
    let mut by_run = Vec::new();
    let mut shows = false;
    for &place in &split.locked {
        let steps: Vec<(f64, f64)> = rests[place]
            .steps
            .iter()
            .filter_map(|step| {
                let kind = kinds.iter().find(|kind| kind.has(step))?;
                Some((step.between_s.1, kind.size_w))
            })
            .collect();
        shows |= !steps.is_empty();
        let shift = |time: f64| steps.iter().filter(|(at, _)| time >= *at).map(|(_, size)| size).sum();
        let squares = Squares::of(&runs[place], &rests[place], shift);
        by_run.push((squares.mean(squares.before), squares.mean(squares.after)));
        all.add(&squares);
    }
    let open = all.before - all.floor;
    let closed = (shows && open > 0.0).then(|| (all.before - all.after) / open);
    let gains: Vec<f64> = by_run.iter().map(|(before, after)| before - after).collect();
    Confirmed {
        runs: split.locked.iter().map(|&place| runs[place].name.clone()).collect(),
        before_w: all.mean(all.before).sqrt(),
        after_w: all.mean(all.after).sqrt(),
        floor_w: all.mean(all.floor).sqrt(),
        floor_unclipped_w: all.mean(all.floor).sqrt(),
        closed,
        share: None,
        clean_w: None,
        floor_how: "RMS of the power at rest about the levels that it keeps returning to on the locked runs",
        residuals: [Vec::new(), Vec::new()],
        gain_w2: mean_interval(&gains),
        by_run,
    }
}

/// Power at rest less its mean over the run, by time.
fn cells(runs: &[PowerRun], rests: &[Rests], open: &[usize]) -> Vec<Cell> {
    let residuals: Vec<Vec<(f64, f64)>> = open
        .iter()
        .map(|&place| {
            let start = runs[place].blocks.first().map_or(0.0, |block| block.from_s);
            let rest = at_rest(&runs[place], &rests[place]);
            let mean = rest.iter().map(|rest| rest.power_w).sum::<f64>() / rest.len().max(1) as f64;
            rest.iter().map(|rest| (rest.time_s - start, rest.power_w - mean)).collect()
        })
        .collect();
    let longest = residuals.iter().flatten().map(|(time, _)| *time).fold(0.0, f64::max);
    let edge = |cell: usize| longest * cell as f64 / CELLS as f64;
    let cell = |place: usize| {
        let (from, to) = (edge(place), edge(place + 1));
        let means: Vec<f64> = residuals
            .iter()
            .filter_map(|run| {
                let inside = run.iter().filter(|(time, _)| *time >= from && *time <= to).map(|(_, r)| *r);
                let values: Vec<f64> = inside.collect();
                (values.len() >= LEAST_BLOCKS).then(|| values.iter().sum::<f64>() / values.len() as f64)
            })
            .collect();
        let mean = mean_interval(&means);
        let band_w = mean.half_width?;
        Some(Cell {
            axis: "time".to_owned(),
            from,
            to,
            mean_residual_w: mean.mean,
            band_w,
            mean_after_w: None,
            band_after_w: None,
            runs: means.len(),
            words: format!("at rest, {from:.0} to {to:.0} s after the start"),
        })
    };
    (0..CELLS).filter_map(cell).collect()
}
