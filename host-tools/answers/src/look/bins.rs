//! Means over cells of equal width, and means over time in cells that widen as the log goes on.

/// Power over something that is not negative.
#[derive(Debug, Clone)]
pub(super) struct Bins {
    width: f64,
    /// Seconds, sum and sum of squares of the power over them.
    cells: Vec<[f64; 3]>,
}

/// Cells beyond the last are left out: such a speed is a fault.
const MOST: usize = 400;

/// Cells with less time, s, say nothing.
const LEAST_S: f64 = 0.5;

impl Bins {
    pub(super) fn new(width: f64) -> Self {
        Self { width, cells: Vec::new() }
    }

    pub(super) fn add(&mut self, at: f64, power: f64, seconds: f64) {
        let place = (at.abs() / self.width) as usize;
        if place >= MOST || !at.is_finite() {
            return;
        }
        if self.cells.len() <= place {
            self.cells.resize(place + 1, [0.0; 3]);
        }
        for (sum, term) in self.cells[place].iter_mut().zip([1.0, power, power * power]) {
            *sum += term * seconds;
        }
    }

    /// From, to, mean and standard deviation of each cell with enough time.
    pub(super) fn means(&self) -> Vec<(f64, f64, f64, f64)> {
        let cells = self.cells.iter().enumerate().filter(|(_, cell)| cell[0] >= LEAST_S);
        cells
            .map(|(place, [seconds, sum, squares])| {
                let mean = sum / seconds;
                let from = place as f64 * self.width;
                (from, from + self.width, mean, (squares / seconds - mean * mean).max(0.0).sqrt())
            })
            .collect()
    }
}

/// A course over time of some hundred points, however long it is.
#[derive(Debug, Clone)]
pub(super) struct Course {
    width: f64,
    cells: Vec<(f64, f64)>,
}

/// Nothing for longer than this, s, breaks a curve.
const GAP_S: f64 = 2.0;

/// Points of a course at most.
const POINTS: usize = 1000;

impl Course {
    pub(super) fn new() -> Self {
        Self { width: 0.05, cells: Vec::new() }
    }

    pub(super) fn add(&mut self, time: f64, value: f64, seconds: f64) {
        let mut place = (time / self.width).max(0.0) as usize;
        while place >= POINTS {
            let pairs = self.cells.chunks(2);
            self.cells = pairs
                .map(|pair| pair.iter().fold((0.0, 0.0), |sum, cell| (sum.0 + cell.0, sum.1 + cell.1)))
                .collect();
            self.width *= 2.0;
            place = (time / self.width) as usize;
        }
        if self.cells.len() <= place {
            self.cells.resize(place + 1, (0.0, 0.0));
        }
        self.cells[place].0 += seconds;
        self.cells[place].1 += seconds * value;
    }

    /// Time and mean; NaN once where there is nothing for longer than a gap.
    pub(super) fn points(&self) -> Vec<(f64, f64)> {
        let mut points: Vec<(f64, f64)> = Vec::new();
        for (place, (seconds, sum)) in self.cells.iter().enumerate().filter(|(_, cell)| cell.0 > 0.0) {
            let time = (place as f64 + 0.5) * self.width;
            if points.last().is_some_and(|(last, _)| time - last > GAP_S + self.width) {
                points.push((time, f64::NAN));
            }
            points.push((time, sum / seconds));
        }
        points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A constant stays itself through every widening.
    #[test]
    fn a_course_of_any_length_keeps_its_mean() {
        let mut course = Course::new();
        (0..200_000).for_each(|row| course.add(f64::from(row) * 0.05, 3.0, 0.05));
        let points = course.points();
        assert!(points.len() <= POINTS && points.len() > POINTS / 2, "{}", points.len());
        assert!(points.iter().all(|(_, value)| (value - 3.0).abs() < 1e-9));
    }

    #[test]
    fn cells_have_the_mean_and_spread_of_what_is_in_them() {
        let mut bins = Bins::new(0.1);
        [2.0, 4.0].into_iter().for_each(|power| bins.add(-0.25, power, 1.0));
        let [(from, to, mean, spread)] = bins.means()[..] else { panic!() };
        assert!((from - 0.2).abs() < 1e-12 && (to - 0.3).abs() < 1e-12);
        assert_eq!((mean, spread), (3.0, 1.0));
    }
}
