//! Baselines fitted and evaluated, on all cores.

use std::borrow::Cow;
use std::time::Instant;

use logs::robot::Robot;
use rayon::prelude::*;
use support::context::Context;
use support::error::{Error, Result};
use support::metrics::Metrics;
use support::progress::CountProgress;

use super::adapting::Prior;
use super::entry::{Pair, WeightSeeds};
use super::points::Wanted;
use super::search::{Searched, search};
use crate::baselines::{Baseline, Card, Layout, Need, Parameter, Point};

/// The results of one baseline.
pub struct Evaluation {
    /// Time to fit, s.
    pub fit_s: f64,
    /// What it learned.
    pub parameters: Vec<Parameter>,
    /// Measured and predicted power of every test point; NaN predicted where a reading that it
    /// needs has no value.
    pub pairs: Vec<Pair>,
    /// The same without the mass, if the model takes it and a search was requested.
    pub without_mass: Option<WithoutMass>,
    /// The mass of every test point as the model itself estimates it, kg; NaN where it does not
    /// know.
    pub masses: Option<Vec<f64>>,
    /// Measured and predicted power of every test point on a floor that adapts, if requested.
    /// `None` for a model that learns while it drives.
    pub adapted: Option<Vec<Pair>>,
    /// Of a network; the other fields are of the median one.
    pub weight_seeds: Option<WeightSeeds>,
}

/// A model that takes the mass, with an estimated one.
pub struct WithoutMass {
    /// Measured and predicted power of every test point; NaN predicted where no mass is known yet.
    pub pairs: Vec<Pair>,
    /// The mass taken for every test point, kg; NaN where none is known yet.
    pub masses: Vec<f64>,
}

/// How masses are searched for, for models that take them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MassSearch {
    /// From and to, kg.
    pub range: (f64, f64),
    /// Of so many seconds.
    pub window_s: f64,
}

/// Further requests beside the power at the given mass.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Beside {
    /// Its power at a mass that is searched for, if it takes one.
    pub masses: Option<MassSearch>,
    /// Its power where the floor adapts.
    pub adapts: bool,
}

/// Seeds of a network's weights.
const WEIGHT_SEEDS: [u64; 3] = [1, 2, 3];

/// Fits a baseline and predicts the test points. Points in which a reading that it needs has no
/// value are left out. A network is trained with three seeds of its weights, and the median one by
/// RMSE is taken.
///
/// # Errors
/// Why it cannot be had for this robot and these logs.
pub fn evaluate(
    robot: &Robot,
    card: &Card,
    wanted: &Wanted,
    training: &[Point],
    test: &[Point],
    beside: Beside,
) -> Result<Evaluation> {
    allowed(robot, card, wanted)?;
    let training = complete(robot, card, training, "training")?;
    let complete_test = complete(robot, card, test, "test")?;
    let seeds: &[u64] = if card.is_network() { &WEIGHT_SEEDS } else { &WEIGHT_SEEDS[..1] };
    let runs = seeds.par_iter().map(|seed| run(card.make_with(robot, *seed), &training, &complete_test));
    let (mut done, mut failed) = (Vec::new(), None);
    for run in runs.collect::<Vec<_>>() {
        match run {
            Ok(run) => done.push(run),
            Err(error) => failed = failed.or(Some(error)),
        }
    }
    if let (true, Some(error)) = (done.is_empty(), failed) {
        return Err(error);
    }
    done.sort_by(|a, b| a.rmse_w.total_cmp(&b.rmse_w));
    let of = |place: usize| done.get(place).map_or(f64::NAN, |run| run.r2);
    let weight_seeds = card.is_network().then(|| WeightSeeds {
        count: done.len(),
        least_r2: of(done.len() - 1),
        greatest_r2: of(0),
    });
    let median = done.swap_remove((done.len() - 1) / 2);

    // Back to all points: those without a value have no prediction.
    let everywhere = |values: &[f64]| -> Vec<f64> {
        let mut values = values.iter();
        let mut next = |point: &Point| {
            let value = is_complete(robot, card, point).then(|| values.next()).flatten();
            value.copied().unwrap_or(f64::NAN)
        };
        test.iter().map(&mut next).collect()
    };
    let pairs = |predicted: &[f64]| -> Vec<Pair> {
        test.iter().map(|point| point.power).zip(everywhere(predicted)).collect()
    };
    let without_mass = match beside.masses.filter(|_| card.takes_mass) {
        Some(MassSearch { range, window_s }) => {
            let Searched { masses, predicted } = search(&*median.model, &complete_test, range, window_s)?;
            Some(WithoutMass { pairs: pairs(&predicted), masses: everywhere(&masses) })
        }
        None => None,
    };
    let prior = match beside.adapts && !card.learns_while_driving() {
        true => Prior::of(&training, &median.model.predict(&training)?),
        false => None,
    };
    let adapted = prior.map(|prior| pairs(&prior.adapted(&complete_test, &median.predicted)));
    Ok(Evaluation {
        fit_s: median.fit_s,
        parameters: median.model.parameters(),
        pairs: pairs(&median.predicted),
        without_mass,
        adapted,
        masses: median.model.masses(&complete_test)?.map(|masses| everywhere(&masses)),
        weight_seeds,
    })
}

/// A fitted model on the test points.
struct Run {
    model: Box<dyn Baseline>,
    fit_s: f64,
    predicted: Vec<f64>,
    rmse_w: f64,
    r2: f64,
}

fn run(mut model: Box<dyn Baseline>, training: &[Point], test: &[Point]) -> Result<Run> {
    let started = Instant::now();
    model.fit(training)?;
    let fit_s = started.elapsed().as_secs_f64();
    let predicted = model.predict(test)?;
    let mut metrics = Metrics::new(0.0);
    for (point, predicted) in test.iter().zip(&predicted).filter(|(_, predicted)| predicted.is_finite()) {
        metrics.add(point.power, *predicted);
    }
    let quality = metrics.quality();
    let rmse_w = quality.map_or(f64::NAN, |quality| quality.rmse_w);
    let r2 = quality.and_then(|quality| quality.r2).unwrap_or(f64::NAN);
    Ok(Run { model, fit_s, predicted, rmse_w, r2 })
}

/// Whether the log has every value that the baseline needs at this point.
fn is_complete(robot: &Robot, card: &Card, point: &Point) -> bool {
    card.needs.iter().all(|need| need.values(robot, &point.readings).into_iter().all(f64::is_finite))
}

/// The points with every value; at least half of them have to.
fn complete<'a>(robot: &Robot, card: &Card, points: &'a [Point], what: &str) -> Result<Cow<'a, [Point]>> {
    if points.iter().all(|point| is_complete(robot, card, point)) {
        return Ok(Cow::Borrowed(points));
    }
    let kept: Vec<Point> = points.iter().copied().filter(|point| is_complete(robot, card, point)).collect();
    if 2 * kept.len() >= points.len() {
        return Ok(Cow::Owned(kept));
    }
    let empty = |need: &Need, index: usize| {
        points.iter().any(|point| !need.values(robot, &point.readings)[index].is_finite())
    };
    let named = card.needs.iter().flat_map(|need| {
        let columns = need.columns(robot).iter().enumerate();
        columns.filter(|(index, _)| empty(need, *index)).map(|(_, column)| *column)
    });
    let named = named.collect::<Vec<_>>().join(" or ");
    let (missing, all) = (points.len() - kept.len(), points.len());
    Err(Error::failed(format!("{named} has no value in {missing} of {all} {what} rows")))
}

/// Whether a baseline is available for this robot and these logs.
///
/// # Errors
/// Why not: the wheels' layout, or the columns that the logs lack.
pub fn allowed(robot: &Robot, card: &Card, wanted: &Wanted) -> Result<()> {
    if !(card.layouts.is_empty() || card.layouts.contains(&Layout::of(robot))) {
        let layouts: Vec<&str> = card.layouts.iter().map(|layout| layout.name()).collect();
        return Err(Error::failed(format!("it is a model of {}", layouts.join(" or "))));
    }
    let lacking = card.needs.iter().filter(|need| !wanted.has(**need));
    let lacking: Vec<&str> = lacking.flat_map(|need| need.columns(robot)).copied().collect();
    if lacking.is_empty() {
        return Ok(());
    }
    Err(Error::failed(format!("the logs have no {}", lacking.join(", "))))
}

/// [`evaluate`] for every card, in their order. The number of cores changes only the time.
pub fn evaluate_all(
    context: &Context,
    robot: &Robot,
    cards: &[&Card],
    wanted: &Wanted,
    training: &[Point],
    test: &[Point],
    beside: Beside,
) -> Vec<Result<Evaluation>> {
    let progress = CountProgress::new(context, "fitting models", cards.len() as u64);
    let one = |card: &&Card| {
        let evaluation = evaluate(robot, card, wanted, training, test, beside);
        progress.one_more();
        evaluation
    };
    cards.par_iter().with_max_len(1).map(one).collect()
}
