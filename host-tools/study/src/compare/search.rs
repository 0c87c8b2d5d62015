//! Estimates the mass of a model that takes it, as ours does: by a search over the latest window.
//!
//! Every second, the mass is chosen at which the model's power over the last window is nearest to
//! the measured one (least squares; a grid over the robot's masses, then the parabola through the
//! best three). It is used for the second that follows. So any model with a mass as its input
//! estimates the mass, too, and predicts without knowing it.

use support::error::Result;

use crate::baselines::{Baseline, Point};

/// Masses on the grid.
const GRID: usize = 41;

/// The result of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Searched {
    /// The mass taken for each point, kg; NaN before the first full window of a run.
    pub masses: Vec<f64>,
    /// The power predicted with it, W; NaN without one.
    pub predicted: Vec<f64>,
}

/// Searches masses from `range.0` to `range.1`, kg, over windows of so many seconds.
///
/// # Errors
/// The model has not been fitted.
pub fn search(model: &dyn Baseline, points: &[Point], range: (f64, f64), window_s: f64) -> Result<Searched> {
    let step = (range.1 - range.0) / (GRID - 1) as f64;
    let at = |place: usize| range.0 + step * place as f64;
    let mut costs = Vec::with_capacity(GRID);
    for place in 0..GRID {
        let loaded: Vec<Point> = points.iter().map(|point| Point { mass: at(place), ..*point }).collect();
        let predicted = model.predict(&loaded)?;
        let squares = points.iter().zip(predicted).map(|(point, power)| (point.power - power).powi(2));
        // A point without a prediction weighs nothing at any mass.
        costs.push(squares.map(|square| if square.is_finite() { square } else { 0.0 }).collect::<Vec<f64>>());
    }
    let second = |point: &Point| point.time.floor() as i64;
    let window = window_s.round().max(1.0) as usize;
    let mut masses = Vec::with_capacity(points.len());
    let mut first = 0;
    for run in points.chunk_by(|a, b| a.run == b.run) {
        let mut seconds: Vec<[f64; GRID]> = Vec::new();
        for points in run.chunk_by(|a, b| second(a) == second(b)) {
            let known = latest(&seconds, window).map_or(f64::NAN, |costs| lowest(&costs, range.0, step));
            masses.extend(std::iter::repeat_n(known, points.len()));
            let last = first + points.len();
            seconds.push(std::array::from_fn(|place| costs[place][first..last].iter().sum()));
            first = last;
        }
    }
    let loaded: Vec<Point> = points
        .iter()
        .zip(&masses)
        .map(|(point, mass)| Point { mass: if mass.is_finite() { *mass } else { range.0 }, ..*point })
        .collect();
    let mut predicted = model.predict(&loaded)?;
    for (power, mass) in predicted.iter_mut().zip(&masses) {
        if !mass.is_finite() {
            *power = f64::NAN;
        }
    }
    Ok(Searched { masses, predicted })
}

/// Sums over the last full window.
fn latest(seconds: &[[f64; GRID]], window: usize) -> Option<[f64; GRID]> {
    let window = seconds.get(seconds.len().checked_sub(window)?..)?;
    Some(std::array::from_fn(|place| window.iter().map(|costs| costs[place]).sum()))
}

/// The lowest of a parabola through the least cost and its neighbours, within the grid.
fn lowest(costs: &[f64; GRID], first: f64, step: f64) -> f64 {
    let best = (0..GRID).min_by(|a, b| costs[*a].total_cmp(&costs[*b])).unwrap_or(0);
    let offset = match (best.checked_sub(1).map(|before| costs[before]), costs.get(best + 1)) {
        (Some(before), Some(behind)) => {
            let curvature = before - 2.0 * costs[best] + behind;
            if curvature > 0.0 { 0.5 * (before - behind) / curvature } else { 0.0 }
        }
        _ => 0.0,
    };
    first + step * (best as f64 + offset)
}

#[cfg(test)]
mod tests {
    use super::search;
    use crate::baselines::cards::PARASURAMAN;
    use crate::baselines::testing::{burger, drive};
    use crate::baselines::{Baseline, Point};

    /// A plane over speed and mass, learned at 1 to 3 kg, on a drive that carries 2.3 kg and from
    /// 40 s on 1.7 kg.
    fn planned() -> (Box<dyn Baseline>, Vec<Point>) {
        let power = |point: &Point| 0.3 + 2.0 * point.speed.vx.abs() + 0.4 * point.mass;
        let mut model = PARASURAMAN.make(&burger());
        model.fit(&drive(2000, power)).unwrap();
        let mut points = drive(1600, |_| 0.0);
        for point in &mut points {
            point.mass = if point.time < 40.0 { 2.3 } else { 1.7 };
            point.power = power(point);
        }
        (model, points)
    }

    /// The cost is a parabola in the mass, so the parabola through three points of the grid is
    /// exact: rounding only.
    #[test]
    fn finds_the_mass_of_its_own_data() {
        let (model, points) = planned();
        let searched = search(&*model, &points, (1.0, 6.0), 10.0).unwrap();
        for (point, mass) in points.iter().zip(&searched.masses) {
            let settled = (10.0..40.0).contains(&point.time) || point.time >= 50.0;
            assert!(mass.is_nan() == (point.time < 10.0), "{}: {mass}", point.time);
            assert!(!settled || (mass - point.mass).abs() < 1e-6, "{}: {mass}", point.time);
        }
        let settled = points.iter().position(|point| point.time >= 51.0).unwrap();
        assert!((searched.predicted[settled] - points[settled].power).abs() < 1e-6);
    }

    /// A second is predicted by what was measured before it.
    #[test]
    fn a_second_does_not_know_its_own_power() {
        let (model, mut points) = planned();
        let before = search(&*model, &points, (1.0, 6.0), 10.0).unwrap();
        let from = points.iter().position(|point| point.time >= 30.0).unwrap();
        points[from].power += 5.0;
        let after = search(&*model, &points, (1.0, 6.0), 10.0).unwrap();
        let next = points.iter().position(|point| point.time >= 31.0).unwrap();
        assert_eq!(before.masses[..next - 1][300..], after.masses[..next - 1][300..]);
        assert!((before.masses[next] - after.masses[next]).abs() > 1e-3);
    }
}
