//! Where the residual lies: its mean by speed, acceleration, turn rate, mass, time, side, heading
//! and every further column.
//!
//! The unit of a band is the run: a cell's mean is the mean of its runs' means, its band the
//! interval that their scatter leaves. A cell of which fewer than `LEAST_RUNS` runs have
//! `LEAST_ROWS` rows is joined to its neighbour, or not shown.

mod axes;
mod band;
mod map;
mod words;

use logs::runs::Runs;
use serde::Serialize;

use self::axes::{Axis, axes};
use self::band::spread;
pub use self::map::{Map, Square, map};
use residuals::noise::whiten::Signal;

/// One cell of a map.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cell {
    /// What is binned: `speed` (m/s, forward), `acceleration` (m/s², positive while the speed
    /// grows), `turn-rate` (rad/s, left), `mass` (kg), `time` (s since the start), `side` (rad/s:
    /// right turns, straight, left turns), `heading` (rad since the start), `speed-turning-left`,
    /// `speed-turning-right` (m/s), `standing`, or the name of a further column.
    pub axis: String,
    /// From …
    pub from: f64,
    /// … to.
    pub to: f64,
    /// Mean of measured less predicted power before anything is added, W.
    pub mean_residual_w: f64,
    /// Half the 95 % interval, by the scatter of the runs' means, W.
    pub band_w: f64,
    /// The mean with the effects added, W; null where none was added.
    pub mean_after_w: Option<f64>,
    /// Its band, W.
    pub band_after_w: Option<f64>,
    /// Runs that have enough rows in it.
    pub runs: usize,
    /// The cell in words: `left turns above 0.3 m/s`.
    pub words: String,
}

impl Cell {
    /// Whether its band leaves out 0.
    pub fn stands_out(&self) -> bool {
        self.mean_residual_w.abs() > self.band_w
    }
}

/// All cells, the axes in order.
pub fn cells(runs: &Runs, residual: &Signal) -> Vec<Cell> {
    axes(runs).iter().flat_map(|axis| cells_of(axis, residual)).collect()
}

/// Fills in what the same cells hold once effects are added.
pub fn fill_after(runs: &Runs, cells: &mut [Cell], residual: &Signal) {
    for axis in axes(runs) {
        let most = axis.extent().1;
        for cell in cells.iter_mut().filter(|cell| cell.axis == axis.name) {
            let after = spread(&axis.values, residual, &|x| inside(x, cell.from, cell.to, most));
            cell.mean_after_w = after.map(|spread| spread.mean);
            cell.band_after_w = after.map(|spread| spread.band);
        }
    }
}

/// Cells are half open; the last one of an axis holds its end.
fn inside(value: f64, from: f64, to: f64, most: f64) -> bool {
    value >= from && (value < to || (value <= to && to >= most))
}

fn cells_of(axis: &Axis, residual: &Signal) -> Vec<Cell> {
    let (least, most) = axis.extent();
    let mut cells: Vec<Cell> = Vec::new();
    let edges = axis.edges();
    // Cells of too few runs grow until they have enough; a remainder at the end joins the last one.
    let mut from = 0;
    for to in 1..edges.len() {
        let whole = |from: f64, to: f64| {
            let spread = spread(&axis.values, residual, &|x| inside(x, from, to, most))?;
            Some(Cell {
                axis: axis.name.clone(),
                from,
                to,
                mean_residual_w: spread.mean,
                band_w: spread.band,
                mean_after_w: None,
                band_after_w: None,
                runs: spread.runs,
                words: words::of(&axis.name, (from, to), (least, most)),
            })
        };
        if let Some(cell) = whole(edges[from], edges[to]) {
            cells.push(cell);
            from = to;
        } else if to + 1 == edges.len()
            && axis.joins
            && let Some(last) = cells.pop()
        {
            cells.extend(whole(last.from, edges[to]));
        } else if !axis.joins {
            from = to;
        }
    }
    // A single cell says nothing about the axis.
    if cells.len() == 1 && axis.joins { Vec::new() } else { cells }
}

#[cfg(test)]
mod tests {
    use super::band::band;
    use super::{cells_of, spread};
    use crate::report::localise::axes::Axis;
    use residuals::thresholds::localise::LEAST_ROWS;

    fn axis(values: Vec<Vec<f64>>) -> Axis {
        Axis { name: "mass".to_owned(), values, signed: false, joins: true, edges: None }
    }

    /// Means 1, 2, 3 W: standard deviation 1, t(0.975, 2) = 4.303, 4.303/√3 = 2.484. However many
    /// rows a run has, it counts once.
    #[test]
    fn the_band_is_that_of_three_runs_not_of_their_rows() {
        let values = vec![vec![0.0; 10], vec![0.0; 1000], vec![0.0; 20]];
        let residual = vec![vec![1.0; 10], vec![2.0; 1000], vec![3.0; 20]];
        let spread = spread(&values, &residual, &|_| true).unwrap();
        assert_eq!((spread.mean, spread.runs), (2.0, 3));
        assert!((spread.band - 2.484).abs() < 1e-3, "{}", spread.band);
    }

    #[test]
    fn cells_with_too_few_rows_or_runs_are_not_shown() {
        let thin = vec![vec![1.0; LEAST_ROWS - 1]; 9];
        assert_eq!(spread(&thin, &thin, &|_| true), None);
        assert_eq!(band(&[1.0, 2.0]), None);
    }

    /// Twelve runs, each of one mass: cells of a sixth of the rows would hold two runs, so
    /// neighbours join until they hold three.
    #[test]
    fn neighbours_join_until_they_have_runs_enough() {
        let values: Vec<Vec<f64>> = (1..=12).map(|mass| vec![f64::from(mass); 100]).collect();
        let cells = cells_of(&axis(values.clone()), &values);
        assert!(cells.len() >= 2, "{cells:?}");
        assert!(cells.iter().all(|cell| cell.runs >= 3), "{cells:?}");
        assert_eq!(cells.iter().map(|cell| cell.runs).sum::<usize>(), 12, "no run is lost");
        assert!(cells.windows(2).all(|pair| pair[0].to == pair[1].from));
        assert!(cells[0].words.starts_with("total mass below"), "{}", cells[0].words);
        // All runs of one mass: the axis says nothing.
        assert!(cells_of(&axis(vec![vec![3.0; 100]; 12]), &values).is_empty());
    }
}
