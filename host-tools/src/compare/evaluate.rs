//! Baselines fitted and evaluated, as many at a time as there are cores.

use std::borrow::Cow;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;
use std::time::Instant;

use super::Pair;
use super::points::Wanted;
use crate::baselines::{Card, Layout, Need, Parameter, Point};
use crate::error::{Error, Result};
use crate::progress::CountProgress;
use crate::robot::Robot;

/// What came of one baseline.
pub struct Evaluation {
    /// Time to fit, s.
    pub fit_s: f64,
    /// What it learned.
    pub parameters: Vec<Parameter>,
    /// Measured and predicted power of every test point; NaN predicted where a reading that it needs has no value.
    pub pairs: Vec<Pair>,
}

/// Fits a baseline and predicts the test points. Points in which a reading that it needs has no value are left out.
///
/// # Errors
/// Why it cannot be had for this robot and these logs.
pub fn evaluate(
    robot: &Robot,
    card: &Card,
    wanted: &Wanted,
    training: &[Point],
    test: &[Point],
) -> Result<Evaluation> {
    allowed(robot, card, wanted)?;
    let training = told(robot, card, training, "training")?;
    let told_test = told(robot, card, test, "test")?;
    let mut baseline = card.make(robot);
    let started = Instant::now();
    baseline.fit(&training)?;
    let fit_s = started.elapsed().as_secs_f64();
    let mut predicted = baseline.predict(&told_test)?.into_iter();
    let mut next = |point: &Point| {
        if is_told(robot, card, point) { predicted.next().unwrap_or(f64::NAN) } else { f64::NAN }
    };
    let pairs = test.iter().map(|point| (point.power, next(point))).collect();
    Ok(Evaluation { fit_s, parameters: baseline.parameters(), pairs })
}

/// Whether the log tells everything at this point that the baseline needs.
fn is_told(robot: &Robot, card: &Card, point: &Point) -> bool {
    card.needs.iter().all(|need| need.values(robot, &point.readings).into_iter().all(f64::is_finite))
}

/// The points that tell everything; at least half of them have to.
fn told<'a>(robot: &Robot, card: &Card, points: &'a [Point], what: &str) -> Result<Cow<'a, [Point]>> {
    if points.iter().all(|point| is_told(robot, card, point)) {
        return Ok(Cow::Borrowed(points));
    }
    let told: Vec<Point> = points.iter().copied().filter(|point| is_told(robot, card, point)).collect();
    if 2 * told.len() >= points.len() {
        return Ok(Cow::Owned(told));
    }
    let empty = |need: &Need, index: usize| {
        points.iter().any(|point| !need.values(robot, &point.readings)[index].is_finite())
    };
    let named = card.needs.iter().flat_map(|need| {
        let columns = need.columns(robot).iter().enumerate();
        columns.filter(|(index, _)| empty(need, *index)).map(|(_, column)| *column)
    });
    let named = named.collect::<Vec<_>>().join(" or ");
    let (missing, all) = (points.len() - told.len(), points.len());
    Err(Error::failed(format!("{named} has no value in {missing} of {all} {what} rows")))
}

/// Whether a baseline can be had for this robot and these logs.
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

/// [`evaluate`] of every card, in their order. Nothing of it depends on the number of cores but the time.
pub fn evaluate_all(
    robot: &Robot,
    cards: &[&Card],
    wanted: &Wanted,
    training: &[Point],
    test: &[Point],
) -> Vec<Result<Evaluation>> {
    // Networks take the longest: whoever begins with them ends sooner.
    let mut order: Vec<usize> = (0..cards.len()).collect();
    order.sort_by_key(|&index| !cards[index].is_network());
    let next = AtomicUsize::new(0);
    let workers = thread::available_parallelism().map_or(1, usize::from).min(cards.len());
    let progress = CountProgress::new("fitting models", cards.len() as u64);
    let mut found = thread::scope(|scope| {
        let (send, receive) = mpsc::channel();
        for _ in 0..workers {
            let (send, order, next) = (send.clone(), &order, &next);
            scope.spawn(move || {
                while let Some(&index) = order.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let evaluation = evaluate(robot, cards[index], wanted, training, test);
                    // The receiver waits for every worker.
                    let _ = send.send((index, evaluation));
                }
            });
        }
        drop(send);
        receive.iter().inspect(|_| progress.one_more()).collect::<Vec<_>>()
    });
    found.sort_by_key(|(index, _)| *index);
    found.into_iter().map(|(_, evaluation)| evaluation).collect()
}
