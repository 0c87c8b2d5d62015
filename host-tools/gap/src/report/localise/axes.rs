//! What the residual is binned by, and where the bins end.

use logs::robot::chassis::Together;
use logs::runs::{Row, Runs};

use residuals::noise::whiten::Signal;
use residuals::smooth;
use residuals::thresholds::localise::{CELLS, STEPS, STRAIGHT};

/// One axis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axis {
    /// Its name in JSON.
    pub(super) name: String,
    /// Its value in each row; NaN where a row is not on it.
    pub(super) values: Signal,
    /// 0 is an edge: what is on either side differs in kind.
    pub(super) signed: bool,
    /// Cells of too few runs are joined to their neighbours.
    pub(super) joins: bool,
    /// Edges of their own.
    pub(super) edges: Option<Vec<f64>>,
}

/// All axes, in order.
pub(super) fn axes(runs: &Runs) -> Vec<Axis> {
    let on = |value: &dyn Fn(&Row) -> f64| -> Signal {
        runs.runs.iter().map(|run| run.rows.iter().map(value).collect()).collect()
    };
    let moving =
        |value: &dyn Fn(&Row) -> f64| on(&|row| if row.wheels.is_moving() { value(row) } else { f64::NAN });
    let axis = |name: &str, values: Signal, signed: bool| Axis {
        name: name.to_owned(),
        values,
        signed,
        joins: true,
        edges: None,
    };
    let most = runs.runs.iter().flat_map(|run| &run.rows).map(|row| row.turn_rate.abs()).fold(0.0, f64::max);
    let straight = STRAIGHT * most;
    let turning =
        |sign: f64| moving(&|row| if sign * row.turn_rate > straight { row.speed.abs() } else { f64::NAN });
    let mut axes = vec![
        axis("speed", moving(&|row| row.speed), true),
        axis("acceleration", moving(&|row| acceleration(runs, row)), true),
        axis("turn-rate", moving(&|row| row.turn_rate), true),
        axis("mass", on(&|row| row.mass), false),
        axis("time", on(&|row| row.time), false),
        Axis {
            joins: false,
            edges: (most > 0.0).then(|| vec![-most, -straight, straight, most]),
            ..axis("side", moving(&|row| row.turn_rate), true)
        },
        axis("heading", moving(&|row| row.heading[1].atan2(row.heading[0])), true),
        axis("speed-turning-left", turning(1.0), false),
        axis("speed-turning-right", turning(-1.0), false),
        Axis {
            joins: false,
            edges: Some(vec![0.0, 0.0]),
            ..axis("standing", on(&|row| if row.wheels.is_moving() { f64::NAN } else { 0.0 }), false)
        },
    ];
    for place in smooth::further(runs) {
        let values = runs.runs.iter().map(|run| run.extra(place).to_vec()).collect();
        axes.push(axis(&runs.columns[place], values, false));
    }
    axes
}

/// Acceleration along the path, m/s²: positive while the body gets faster.
pub(super) fn acceleration(runs: &Runs, row: &Row) -> f64 {
    let twist = runs.robot.twist(row.wheels.iter().map(|wheel| wheel.acceleration));
    // A speed of 0 has no direction.
    if row.speed == 0.0 { 0.0 } else { twist.vx * row.speed.signum() }
}

impl Axis {
    /// Least and greatest value.
    pub(super) fn extent(&self) -> (f64, f64) {
        let values = match &self.edges {
            Some(edges) => edges.clone(),
            None => self.values.iter().flatten().copied().collect(),
        };
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(*x), high.max(*x)))
    }

    /// Ends of the cells, ascending: the extent, and between them quantiles as round numbers.
    pub(super) fn edges(&self) -> Vec<f64> {
        if let Some(edges) = &self.edges {
            return edges.clone();
        }
        let mut sorted: Vec<f64> =
            self.values.iter().flatten().copied().filter(|value| value.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        let (Some(&least), Some(&most)) = (sorted.first(), sorted.last()) else { return Vec::new() };
        let step = round_step((most - least) / STEPS);
        let quantiles = (1..CELLS).map(|cell| sorted[cell * sorted.len() / CELLS]);
        let mut inner: Vec<f64> = quantiles.map(|quantile| (quantile / step).round() * step).collect();
        if self.signed && least < 0.0 && most > 0.0 {
            inner.push(0.0);
            inner.sort_by(f64::total_cmp);
        }
        inner.retain(|edge| *edge > least && *edge < most);
        let mut edges = vec![least];
        edges.extend(inner);
        edges.push(most);
        // Edges closer than half a step are the same edge.
        edges.dedup_by(|a, b| (*a - *b).abs() < 0.5 * step);
        edges
    }
}

/// 1, 2 or 5 times a power of ten, the greatest that is not above.
pub(super) fn round_step(most: f64) -> f64 {
    if most <= 0.0 || !most.is_finite() {
        return 1.0;
    }
    let ten = 10.0_f64.powf(most.log10().floor());
    [5.0, 2.0].into_iter().find(|factor| factor * ten <= most).unwrap_or(1.0) * ten
}

#[cfg(test)]
mod tests {
    use super::{Axis, round_step};

    #[test]
    fn edges_are_round_and_separate_forward_from_backward() {
        let values = (0..=1000).map(|k| -0.3117 + 0.9 * f64::from(k) / 1000.0).collect();
        let axis =
            Axis { name: "speed".to_owned(), values: vec![values], signed: true, joins: true, edges: None };
        let edges = axis.edges();
        assert_eq!((edges[0], edges[edges.len() - 1]), (-0.3117, -0.3117 + 0.9));
        assert!(edges.contains(&0.0), "{edges:?}");
        for edge in &edges[1..edges.len() - 1] {
            assert!((edge / 0.02 - (edge / 0.02).round()).abs() < 1e-9, "{edge} is no multiple of 0.02");
        }
        assert!(edges.is_sorted() && edges.len() <= 8, "{edges:?}");
    }

    #[test]
    fn steps_are_round() {
        for (most, step) in [(0.0225, 0.02), (0.07, 0.05), (1.9, 1.0), (30.0, 20.0)] {
            assert!((round_step(most) / step - 1.0).abs() < 1e-12, "{most}");
        }
    }
}
