//! How outcomes of `gmr gap-bench` are counted.

use std::collections::BTreeMap;

use numerics::robust::median;
use serde::Serialize;

use super::coverage::Covered;
use super::{Case, Outcome};
use residuals::types::Verdict;

/// What is hidden in a set.
pub fn label(outcome: &Outcome) -> String {
    let case = &outcome.case;
    let ids: Vec<&str> = case.effects.iter().map(|effect| effect.id()).collect();
    let kind = if case.removed.is_empty() { "" } else { " (removed)" };
    if ids.is_empty() { format!("none, {}", case.noise.name) } else { ids.join(" + ") + kind }
}

/// Effects that no drive on level ground distinguishes within a minute: a tie between them is the
/// right answer.
const TWINS: [[&str; 2]; 5] = [
    ["viscous-change", "lubricant-warm-up"],
    ["viscous-change", "windage"],
    ["lubricant-warm-up", "windage"],
    ["supply-sag", "gear-load-loss"],
    ["wheel-drag", "sensor-gain"],
];

/// How an outcome is counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Count {
    /// What was hidden is named, and nothing else.
    Right,
    /// It is in a tie of effects that no drive distinguishes.
    TwinTie,
    /// It is in a tie.
    InTie,
    /// Another effect is named, or it is in no tie.
    Wrong,
    /// Something is there, and nothing is named.
    Abstained,
    /// Nothing is there.
    Missed,
}

/// Counts an outcome.
pub fn count(outcome: &Outcome) -> Count {
    let truth: Vec<&str> = outcome.case.effects.iter().map(|effect| effect.id()).collect();
    let has = |list: &[String], id: &str| list.iter().any(|name| name == id);
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

/// How many sets of a kind ended in a way.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figure {
    /// Of which sets, and how.
    pub name: &'static str,
    /// How many.
    pub count: usize,
    /// Of so many.
    pub of: usize,
}

impl Figure {
    /// None where there is no such set.
    fn of(name: &'static str, sets: &[&Outcome], wanted: impl Fn(&Outcome) -> bool) -> Option<Self> {
        let count = sets.iter().filter(|outcome| wanted(outcome)).count();
        (!sets.is_empty()).then_some(Self { name, count, of: sets.len() })
    }

    /// %
    pub fn percent(&self) -> f64 {
        100.0 * self.count as f64 / self.of as f64
    }
}

/// All figures of a bench.
pub fn figures(outcomes: &[Outcome]) -> Vec<Figure> {
    let of = |wanted: &dyn Fn(&Case) -> bool| -> Vec<&Outcome> {
        outcomes.iter().filter(|outcome| wanted(&outcome.case)).collect()
    };
    let alone = of(&is_alone);
    let free = of(&|case| case.effects.is_empty());
    let removed = of(&|case| !case.removed.is_empty());
    let pairs = of(&|case| case.effects.len() == 2);
    [
        Figure::of("alone: right single name, true twins in a tie counted", &alone, |outcome| {
            matches!(count(outcome), Count::Right | Count::TwinTie)
        }),
        Figure::of("alone: truth is the name or in the tie set", &alone, |outcome| {
            matches!(count(outcome), Count::Right | Count::TwinTie | Count::InTie)
        }),
        Figure::of("alone: wrong single name", &alone, |outcome| {
            count(outcome) == Count::Wrong && outcome.ties.is_empty()
        }),
        Figure::of("no effect: an alarm", &free, |outcome| outcome.verdict != Verdict::None),
        Figure::of("effect removed from the dictionary: a single name", &removed, |outcome| {
            count(outcome) == Count::Wrong
        }),
        Figure::of("pairs: both named, or one named and the other in a tie", &pairs, |outcome| {
            matches!(count(outcome), Count::Right | Count::InTie)
        }),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn is_alone(case: &Case) -> bool {
    case.effects.len() == 1 && case.removed.is_empty()
}

/// Share of the gap that is closed on locked runs where an effect alone is rightly named.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Closed {
    pub median: f64,
    /// The least median of an effect.
    pub worst: f64,
    pub worst_effect: String,
}

impl Closed {
    /// None where no effect is.
    pub fn of(outcomes: &[Outcome]) -> Option<Self> {
        let mut closed: BTreeMap<String, Vec<f64>> = BTreeMap::new();
        let right = |outcome: &&Outcome| {
            is_alone(&outcome.case) && matches!(count(outcome), Count::Right | Count::TwinTie)
        };
        for outcome in outcomes.iter().filter(right) {
            if let Some(share) = outcome.closed {
                closed.entry(label(outcome)).or_default().push(share);
            }
        }
        let mut all: Vec<f64> = closed.values().flatten().copied().collect();
        let worst = closed.into_iter().map(|(id, mut shares)| (middle(&mut shares), id));
        let (worst, worst_effect) = worst.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(Self { median: middle(&mut all), worst, worst_effect })
    }
}

/// Time for one set, s.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Seconds {
    pub median: f64,
    pub slowest: f64,
}

impl Seconds {
    pub fn of(outcomes: &[Outcome]) -> Option<Self> {
        let mut seconds: Vec<f64> = outcomes.iter().map(|outcome| outcome.seconds).collect();
        let slowest = seconds.iter().copied().max_by(f64::total_cmp)?;
        Some(Self { median: middle(&mut seconds), slowest })
    }
}

/// The value in the middle, the upper of two; NaN of none.
fn middle(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// How often mass intervals hold the mass.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Coverage {
    pub name: &'static str,
    pub holds: usize,
    pub windows: usize,
    /// Median of the intervals' half widths.
    pub half_width_kg: Option<f64>,
}

impl Coverage {
    /// Of windows: whether the interval holds the mass, and its half width, kg.
    pub fn of(name: &'static str, windows: impl Iterator<Item = (bool, f64)>) -> Self {
        let (inside, mut widths): (Vec<bool>, Vec<f64>) = windows.unzip();
        let holds = inside.iter().filter(|holds| **holds).count();
        Self { name, holds, windows: inside.len(), half_width_kg: median(&mut widths) }
    }

    /// %
    pub fn percent(&self) -> f64 {
        100.0 * self.holds as f64 / self.windows as f64
    }

    /// All figures of a bench.
    pub fn all(covered: &[Covered]) -> [Self; 3] {
        let of = |right: bool, windows: fn(&Covered) -> &Vec<(bool, f64)>| {
            let wanted = covered.iter().filter(move |set| set.right || !right);
            wanted.flat_map(move |set| windows(set).iter().copied())
        };
        [
            Self::of("95 % mass interval after an extension, rightly named", of(true, |set| &set.windows)),
            Self::of("the same, by the noise of the base alone", of(true, |set| &set.by_base)),
            Self::of(
                "95 % mass interval after an extension, whatever was named",
                of(false, |set| &set.windows),
            ),
        ]
    }
}
