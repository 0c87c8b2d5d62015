//! Long series for a screen: nothing that a pixel could show is lost.

/// The smallest and the greatest of every one of `columns` columns of equal width, in their order.
/// Points whose y is not finite end a piece: the pieces are drawn apart.
pub(super) fn pieces(points: &[(f64, f64)], x: (f64, f64), columns: usize) -> Vec<Vec<(f64, f64)>> {
    let mut pieces = Vec::new();
    for piece in points.split(|(x, y)| !x.is_finite() || !y.is_finite()) {
        if piece.len() <= 4 * columns {
            if !piece.is_empty() {
                pieces.push(piece.to_vec());
            }
            continue;
        }
        let column = |point: &(f64, f64)| ((point.0 - x.0) / (x.1 - x.0) * columns as f64).floor();
        let mut thinned = Vec::with_capacity(4 * columns);
        for group in piece.chunk_by(|a, b| column(a) == column(b)) {
            let by_y = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
            let (Some(&low), Some(&high)) = (group.iter().min_by(by_y), group.iter().max_by(by_y)) else {
                continue;
            };
            if low.0 <= high.0 { thinned.extend([low, high]) } else { thinned.extend([high, low]) }
        }
        pieces.push(thinned);
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::pieces;

    #[test]
    fn extremes_stay_and_length_is_bounded() {
        let mut points: Vec<_> = (0..100_000).map(|k| (f64::from(k), (f64::from(k) * 0.01).sin())).collect();
        points[54_321].1 = 9.0;
        let thinned = pieces(&points, (0.0, 1e5), 100);
        assert_eq!(thinned.len(), 1);
        assert!(thinned[0].len() <= 200);
        assert!(thinned[0].contains(&(54_321.0, 9.0)));
        assert!(thinned[0].is_sorted_by(|a, b| a.0 <= b.0));
    }

    #[test]
    fn holes_split() {
        let points = [(0.0, 1.0), (1.0, f64::NAN), (2.0, 1.0), (3.0, 2.0)];
        assert_eq!(pieces(&points, (0.0, 3.0), 10), [vec![(0.0, 1.0)], vec![(2.0, 1.0), (3.0, 2.0)]]);
    }
}
