//! The residual over two axes.

use logs::runs::{Row, Runs};

use super::axes::{acceleration, round_step};
use super::band::{Spread, spread};
use residuals::noise::whiten::Signal;
use residuals::thresholds::localise::SQUARES;

/// A square with enough runs in it.
#[derive(Debug, Clone, PartialEq)]
pub struct Square {
    /// From and to on the first axis: forward speed, m/s.
    pub x: (f64, f64),
    /// On the second.
    pub y: (f64, f64),
    /// Mean residual before, W, over the means of its runs.
    pub before_w: f64,
    /// With the effects added.
    pub after_w: Option<f64>,
}

/// Mean residual over forward speed and turn rate, or acceleration where the robot does not turn.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    /// What the second axis shows, with its unit.
    pub y_label: &'static str,
    /// Its squares; what fewer runs met is left out.
    pub squares: Vec<Square>,
}

/// The map of a residual before and, where there is one, after.
pub fn map(runs: &Runs, before: &Signal, after: Option<&Signal>) -> Map {
    let value = |of: &dyn Fn(&Row) -> f64| -> Signal {
        runs.runs.iter().map(|run| run.rows.iter().map(of).collect()).collect()
    };
    let speed = value(&|row| row.speed);
    let by_turn = over(&speed, &value(&|row| row.turn_rate), before, after);
    // Fewer squares than a line has: the robot went straight.
    if by_turn.len() as f64 > SQUARES {
        return Map { y_label: "turn rate (rad/s), left positive", squares: by_turn };
    }
    let gain = value(&|row| acceleration(runs, row));
    Map { y_label: "acceleration (m/s²)", squares: over(&speed, &gain, before, after) }
}

fn over(x: &Signal, y: &Signal, before: &Signal, after: Option<&Signal>) -> Vec<Square> {
    let (x_step, y_step) = (step(x), step(y));
    // Which square a row is in, as one number; no drive has 10⁵ squares in a line.
    let name = |x: f64, y: f64| (x / x_step).floor() * 1e6 + (y / y_step).floor();
    let places: Signal =
        x.iter().zip(y).map(|(x, y)| x.iter().zip(y).map(|(x, y)| name(*x, *y)).collect()).collect();
    let mut names: Vec<f64> = places.iter().flatten().copied().collect();
    names.sort_by(f64::total_cmp);
    names.dedup();
    let square = |number: f64| {
        let at = |residual| -> Option<Spread> { spread(&places, residual, &|name| name == number) };
        let column = (number / 1e6).round();
        let row = number - column * 1e6;
        let ends = |place: f64, step: f64| (place * step, (place + 1.0) * step);
        Some(Square {
            x: ends(column, x_step),
            y: ends(row, y_step),
            before_w: at(before)?.mean,
            after_w: after.and_then(at).map(|spread| spread.mean),
        })
    };
    names.into_iter().filter_map(square).collect()
}

/// A round step that divides the middle nine tenths of the values into [`SQUARES`] at most: a few
/// spins shall not make it coarse. Where nearly all values are alike, a tenth of their whole range.
fn step(values: &Signal) -> f64 {
    let mut sorted: Vec<f64> = values.iter().flatten().copied().collect();
    sorted.sort_by(f64::total_cmp);
    let at = |share: usize| sorted.get(share * sorted.len() / 20).copied().unwrap_or(0.0);
    let whole = sorted.last().zip(sorted.first()).map_or(0.0, |(last, first)| last - first);
    let least = (at(19) - at(1)).max(0.1 * whole) / SQUARES;
    let below = round_step(least);
    [1.0, 2.0, 2.5, 5.0].map(|factor| factor * below).into_iter().find(|step| *step >= least).unwrap_or(below)
}

#[cfg(test)]
mod tests {
    use super::{over, step};

    /// Nearly all rows at a constant speed: squares follow the few that are not.
    #[test]
    fn values_that_are_nearly_all_alike_make_no_thin_squares() {
        let mut values = vec![1e-12; 1000];
        values.extend([-0.5, 0.5]);
        assert!((0.001..0.1).contains(&step(&vec![values])));
    }

    /// A residual of 1 W where x and y are both above 0, in four runs over a grid of values; after:
    /// nothing.
    #[test]
    fn squares_lie_where_their_rows_are() {
        let grid = |of: fn(f64, f64) -> f64| -> Vec<Vec<f64>> {
            let run = (0..4000).map(|k| {
                let (i, j) = (f64::from(k % 63) - 31.0, f64::from(k / 63) - 31.0);
                of(0.01 * i + 0.001, 0.1 * j + 0.01)
            });
            vec![run.collect(); 4]
        };
        let (x, y) = (grid(|x, _| x), grid(|_, y| y));
        let residual = grid(|x, y| f64::from(u8::from(x > 0.0 && y > 0.0)));
        let squares = over(&x, &y, &residual, Some(&grid(|_, _| 0.0)));
        assert!(squares.len() > 30, "{}", squares.len());
        for square in squares {
            let wanted = f64::from(u8::from(square.x.0 >= 0.0 && square.y.0 >= 0.0));
            assert_eq!((square.before_w, square.after_w), (wanted, Some(0.0)), "{square:?}");
        }
    }
}
