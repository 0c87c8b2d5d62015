//! What a search leaves to the cost's rounding.

use nalgebra::{Const, SMatrix, SVector};

use super::super::{Bounds, LeastSquares, Tolerances, descend, polish};

/// a e^{b x} through points that are on no such curve, so that the cost at the minimum is not
/// small.
struct Decay;

/// x, and y: 2 e^{−x / 2} and up to 0.3 beside it.
fn points() -> impl Iterator<Item = (f64, f64)> {
    (0..40).map(|k| {
        let x = 0.1 * f64::from(k);
        (x, 2.0 * (-0.5 * x).exp() + 0.3 * (2.7 * f64::from(k)).sin())
    })
}

impl LeastSquares<Const<2>> for Decay {
    fn cost(&self, p: &SVector<f64, 2>) -> f64 {
        points().map(|(x, y)| (p[0] * (p[1] * x).exp() - y).powi(2)).sum()
    }

    fn derivatives(&self, p: &SVector<f64, 2>) -> (SVector<f64, 2>, SMatrix<f64, 2, 2>) {
        let (mut gradient, mut matrix) = (SVector::zeros(), SMatrix::zeros());
        for (x, y) in points() {
            let power = (p[1] * x).exp();
            let slope = SVector::<f64, 2>::new(power, p[0] * x * power);
            gradient += slope * (p[0] * power - y);
            matrix += slope * slope.transpose();
        }
        (gradient, matrix)
    }
}

/// From two starts a search ends some 10⁻⁹ apart; polished, at one point.
#[test]
fn two_searches_end_at_one_minimum() {
    let ends = [[1.0, -0.1], [4.0, -2.0]].map(|start| {
        let start = SVector::from(start);
        let bounds = Bounds::none(&start);
        let tolerances = Tolerances { cost_share: 1e-10, gradient: 0.0, step: 0.0, ..Tolerances::default() };
        let ended = descend(&Decay, &start, &bounds, &tolerances).parameters;
        (ended, polish(&Decay, &ended, &bounds))
    });
    let [(first, first_polished), (second, second_polished)] = ends;
    let apart = (first_polished - second_polished).norm();
    assert!(apart < 1e-13, "{apart:e}");
    assert!((first - second).norm() > 100.0 * apart.max(1e-14), "the searches ended as near as that");
}

/// At a bound a parameter stays; far from a minimum nothing moves.
#[test]
fn bounds_hold_and_what_is_no_minimum_is_left_alone() {
    let far = SVector::from([1.0, 3.0]);
    assert_eq!(polish(&Decay, &far, &Bounds::none(&far)), far);
    let bounds = Bounds { lower: SVector::from([0.0, -0.2]), upper: SVector::from([10.0, 0.0]) };
    let ended = descend(&Decay, &SVector::from([1.0, -0.1]), &bounds, &Tolerances::default()).parameters;
    assert_eq!(ended[1], -0.2);
    assert_eq!(polish(&Decay, &ended, &bounds)[1], -0.2);
}
