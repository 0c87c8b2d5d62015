//! Drives that stay in a room: they return the way they went, and go no further than there is room.

use super::family::{Block, Knots, Recipe, at};
use super::limits::Limits;

/// Length and width of a floor without obstacles, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Room {
    /// The longer side, m.
    pub length_m: f64,
    /// The shorter one, m.
    pub width_m: f64,
}

/// Shares of a block's holds that are tried until it fits.
const SHORTER: [f64; 7] = [1.0, 0.7, 0.5, 0.35, 0.2, 0.1, 0.0];

/// Step of the path, s.
const STEP_S: f64 = 0.02;

/// More than any block takes, s.
const ONE_BLOCK_S: f64 = 120.0;

impl Room {
    /// The blocks that fit, each followed by itself backwards in time: it ends where it began.
    /// Those that do not fit even with the shortest holds are left out.
    pub(super) fn fitted(&self, blocks: Vec<Block>, limits: &Limits) -> Vec<Block> {
        blocks.into_iter().filter_map(|block| self.fit(&block, limits)).collect()
    }

    fn fit(&self, block: &Block, limits: &Limits) -> Option<Block> {
        SHORTER.iter().map(|share| block.there_and_back(*share)).find(|tried| {
            // Once: to the end of the first repetition.
            let recipe = Recipe { lead_s: 0.0, duration_s: ONE_BLOCK_S, blocks: vec![0] };
            self.holds(&recipe.knots(std::slice::from_ref(tried), limits))
        })
    }

    /// Whether the path of a drive fits into the room, whichever way it is turned by a right angle.
    pub fn holds(&self, knots: &Knots) -> bool {
        let [a, b] = extent(knots);
        let fits = |a: f64, b: f64| a <= self.length_m && b <= self.width_m;
        fits(a, b) || fits(b, a)
    }
}

/// Size of the box around a path, m: along the heading at its start, and across.
fn extent(knots: &Knots) -> [f64; 2] {
    let end = knots.last().map_or(0.0, |(time, _)| *time);
    let (mut position, mut heading) = ([0.0_f64; 2], 0.0_f64);
    let (mut low, mut high) = (position, position);
    for k in 0..(end / STEP_S) as usize {
        let [speed, turn] = at(knots, (k as f64 + 0.5) * STEP_S);
        heading += 0.5 * turn * STEP_S;
        position[0] += speed * heading.cos() * STEP_S;
        position[1] += speed * heading.sin() * STEP_S;
        heading += 0.5 * turn * STEP_S;
        for axis in 0..2 {
            low[axis] = low[axis].min(position[axis]);
            high[axis] = high[axis].max(position[axis]);
        }
    }
    [high[0] - low[0], high[1] - low[1]]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two metres ahead, a quarter turn to the left, one metre.
    #[test]
    fn the_box_around_a_path_is_that_of_its_corners() {
        let quarter = std::f64::consts::FRAC_PI_2;
        let knots = vec![
            (0.0, [0.5, 0.0]),
            (4.0, [0.5, 0.0]),
            (4.001, [0.0, quarter]),
            (5.0, [0.0, quarter]),
            (5.001, [0.5, 0.0]),
            (7.001, [0.5, 0.0]),
        ];
        let [along, across] = extent(&knots);
        assert!((along - 2.0).abs() < 0.02 && (across - 1.0).abs() < 0.02, "{along} {across}");
        assert!(Room { length_m: 2.1, width_m: 1.1 }.holds(&knots));
        assert!(Room { length_m: 1.1, width_m: 2.1 }.holds(&knots), "turned by a right angle");
        assert!(!Room { length_m: 3.0, width_m: 0.9 }.holds(&knots));
    }
}
