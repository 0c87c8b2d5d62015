//! What lies within the axes of a chart: lines and areas are cut there, not drawn over what stands
//! beside the plot.

/// A point of a chart.
pub(super) type At = (f64, f64);

/// Ends of both axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Window {
    pub(super) x: (f64, f64),
    pub(super) y: (f64, f64),
}

impl Window {
    pub(super) fn holds(&self, (x, y): At) -> bool {
        (self.x.0..=self.x.1).contains(&x) && (self.y.0..=self.y.1).contains(&y)
    }

    /// The pieces of a line that are inside; a point that is not finite ends a piece (Liang and
    /// Barsky 1984, segment by segment).
    pub(super) fn line(&self, points: &[At]) -> Vec<Vec<At>> {
        let mut pieces: Vec<Vec<At>> = Vec::new();
        let mut open = false;
        for (index, pair) in points.windows(2).enumerate() {
            let Some((from, to)) = self.segment(pair[0], pair[1]) else {
                open = false;
                continue;
            };
            match pieces.last_mut().filter(|_| open && from == pair[0]) {
                Some(piece) => piece.push(to),
                None => pieces.push(vec![from, to]),
            }
            open = to == pair[1] && index + 2 < points.len();
        }
        pieces
    }

    /// The part of a segment that is inside.
    fn segment(&self, from: At, to: At) -> Option<(At, At)> {
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let (mut enters, mut leaves) = (0.0_f64, 1.0_f64);
        let edges = [
            (-dx, from.0 - self.x.0),
            (dx, self.x.1 - from.0),
            (-dy, from.1 - self.y.0),
            (dy, self.y.1 - from.1),
        ];
        for (slope, room) in edges {
            if !(slope.is_finite() && room.is_finite()) || (slope == 0.0 && room < 0.0) {
                return None;
            }
            if slope < 0.0 {
                enters = enters.max(room / slope);
            } else if slope > 0.0 {
                leaves = leaves.min(room / slope);
            }
        }
        let at = |share: f64| (from.0 + share * dx, from.1 + share * dy);
        let first = if enters > 0.0 { at(enters) } else { from };
        let last = if leaves < 1.0 { at(leaves) } else { to };
        (enters <= leaves).then_some((first, last))
    }

    /// The part of an area that is inside (Sutherland and Hodgman 1974); nothing where there is
    /// none.
    pub(super) fn area(&self, corners: Vec<At>) -> Vec<At> {
        type Axis = fn(At) -> f64;
        let edges: [(Axis, f64, f64); 4] = [
            (|at| at.0, self.x.0, 1.0),
            (|at| at.0, self.x.1, -1.0),
            (|at| at.1, self.y.0, 1.0),
            (|at| at.1, self.y.1, -1.0),
        ];
        edges.into_iter().fold(corners, |corners, (axis, edge, side)| {
            let depth = |at: At| side * (axis(at) - edge);
            let mut kept = Vec::with_capacity(corners.len() + 4);
            let before = corners.last().into_iter().chain(&corners);
            for (&from, &to) in before.zip(&corners) {
                let (outer, inner) = (depth(from), depth(to));
                if (outer < 0.0) != (inner < 0.0) {
                    let share = outer / (outer - inner);
                    kept.push((from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1)));
                }
                if inner >= 0.0 {
                    kept.push(to);
                }
            }
            kept
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Window;

    const UNIT: Window = Window { x: (0.0, 1.0), y: (0.0, 1.0) };

    /// A peak that leaves through the upper edge at x = 0.25 and comes back at 0.75.
    #[test]
    fn a_line_that_leaves_and_comes_back_is_two() {
        let pieces = UNIT.line(&[(0.0, 0.5), (0.5, 1.5), (1.0, 0.5)]);
        assert_eq!(pieces, [vec![(0.0, 0.5), (0.25, 1.0)], vec![(0.75, 1.0), (1.0, 0.5)]]);
    }

    /// Both ends outside, the middle inside; then one that passes by; then one along the edge.
    #[test]
    fn what_crosses_the_window_shows_and_what_passes_by_does_not() {
        assert_eq!(UNIT.line(&[(-1.0, 0.5), (2.0, 0.5)]), [vec![(0.0, 0.5), (1.0, 0.5)]]);
        assert!(UNIT.line(&[(-1.0, 2.0), (2.0, 2.0)]).is_empty());
        assert_eq!(UNIT.line(&[(0.0, 1.0), (1.0, 1.0)]), [vec![(0.0, 1.0), (1.0, 1.0)]]);
    }

    #[test]
    fn holes_split_a_line() {
        let pieces = UNIT.line(&[(0.0, 0.5), (0.2, 0.5), (0.3, f64::NAN), (0.4, 0.5), (0.6, 0.5)]);
        assert_eq!(pieces, [vec![(0.0, 0.5), (0.2, 0.5)], vec![(0.4, 0.5), (0.6, 0.5)]]);
    }

    /// The upper half of a square twice as high as the window is cut off: its area is 1 then.
    #[test]
    fn an_area_ends_at_the_window() {
        let square = vec![(0.0, 0.0), (1.0, 0.0), (1.0, 2.0), (0.0, 2.0)];
        let kept = UNIT.area(square);
        let doubled: f64 = (0..kept.len())
            .map(|k| (kept[k], kept[(k + 1) % kept.len()]))
            .map(|(a, b)| a.0 * b.1 - b.0 * a.1)
            .sum();
        assert!((doubled - 2.0).abs() < 1e-12 && kept.iter().all(|at| UNIT.holds(*at)), "{kept:?}");
        assert!(UNIT.area(vec![(2.0, 0.0), (3.0, 0.0), (3.0, 1.0)]).is_empty());
    }
}
