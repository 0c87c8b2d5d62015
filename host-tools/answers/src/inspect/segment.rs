//! Change points of the mean: optimal partitioning with pruning (PELT; Killick, Fearnhead and
//! Eckley 2012).

/// One value and how much it weighs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Point {
    pub(super) value: f64,
    pub(super) weight: f64,
}

/// Ends (exclusive) of the pieces of constant mean that minimise weighted squares / `variance` +
/// `penalty` a piece. Every piece has at least `shortest` points, unless there are fewer than twice
/// as many in all.
pub(super) fn pieces(points: &[Point], variance: f64, penalty: f64, shortest: usize) -> Vec<usize> {
    let count = points.len();
    if count < 2 * shortest {
        return if count == 0 { Vec::new() } else { vec![count] };
    }
    // Sums about the first value, so that squares do not cancel.
    let origin = points[0].value;
    let mut sums = Vec::with_capacity(count + 1);
    sums.push((0.0, 0.0, 0.0));
    for point in points {
        let (weight, first, second) = sums[sums.len() - 1];
        let value = point.value - origin;
        sums.push((
            weight + point.weight,
            first + point.weight * value,
            second + point.weight * value * value,
        ));
    }
    let cost = |from: usize, to: usize| {
        let weight = sums[to].0 - sums[from].0;
        let first = sums[to].1 - sums[from].1;
        ((sums[to].2 - sums[from].2 - first * first / weight) / variance).max(0.0)
    };

    let mut best = vec![f64::INFINITY; count + 1];
    let mut previous = vec![0; count + 1];
    best[0] = -penalty;
    // A start that is worse than a cut at `to` stays worse, but that cut can be used `shortest`
    // points later only.
    let mut candidates = vec![(0, usize::MAX)];
    for to in shortest..=count {
        for &(from, _) in &candidates {
            let total = best[from] + cost(from, to) + penalty;
            if total < best[to] {
                best[to] = total;
                previous[to] = from;
            }
        }
        for (from, expires) in &mut candidates {
            if best[*from] + cost(*from, to) > best[to] {
                *expires = (*expires).min(to + shortest);
            }
        }
        candidates.retain(|&(_, expires)| expires > to);
        let next = to + 1 - shortest;
        if next > 0 && best[next].is_finite() {
            candidates.push((next, usize::MAX));
        }
    }
    let mut ends = vec![count];
    while let Some(&end) = ends.last()
        && previous[end] > 0
    {
        ends.push(previous[end]);
    }
    ends.reverse();
    ends
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(values: impl IntoIterator<Item = f64>) -> Vec<Point> {
        values.into_iter().map(|value| Point { value, weight: 1.0 }).collect()
    }

    /// Every partition tried.
    fn exhaustive(points: &[Point], penalty: f64, shortest: usize) -> f64 {
        let cost = |piece: &[Point]| {
            let mean = piece.iter().map(|point| point.value).sum::<f64>() / piece.len() as f64;
            piece.iter().map(|point| (point.value - mean).powi(2)).sum::<f64>()
        };
        let mut best = vec![f64::INFINITY; points.len() + 1];
        best[0] = -penalty;
        for to in shortest..=points.len() {
            for from in 0..=to - shortest {
                best[to] = best[to].min(best[from] + cost(&points[from..to]) + penalty);
            }
        }
        best[points.len()]
    }

    #[test]
    fn pruning_loses_nothing() {
        let mut state = 1_u64;
        let mut noise = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as f64 / (1_u64 << 31) as f64 - 0.5
        };
        for trial in 0..60 {
            let steps = 1 + trial % 4;
            let points = points((0..60).map(|k| f64::from(k / (60 / steps)) * 1.5 + noise()));
            let (penalty, shortest) = (0.3 + 0.05 * f64::from(trial), 3);
            let mut from = 0;
            let mut cost = -penalty;
            for end in pieces(&points, 1.0, penalty, shortest) {
                assert!(end - from >= shortest);
                let piece = &points[from..end];
                let mean = piece.iter().map(|point| point.value).sum::<f64>() / piece.len() as f64;
                cost += piece.iter().map(|point| (point.value - mean).powi(2)).sum::<f64>() + penalty;
                from = end;
            }
            let best = exhaustive(&points, penalty, shortest);
            assert!((cost - best).abs() < 1e-9, "trial {trial}: {cost} for {best}");
        }
    }

    #[test]
    fn a_step_is_found_where_it_is() {
        let points = points((0..40).map(|k| if k < 17 { 1.0 } else { 2.0 } + 0.01 * f64::from(k % 3)));
        assert_eq!(pieces(&points, 1e-4, 20.0, 3), [17, 40]);
    }
}
