//! Laws of the quadratic's roots beside those that its unit tests check.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

use model_core::quadratic::{Roots, roots};
use proptest::prelude::*;

fn all(roots: Roots<f64>) -> Vec<f64> {
    match roots {
        Roots::None => vec![],
        Roots::One(x) => vec![x],
        Roots::Two(x, y) => vec![x, y],
    }
}

/// Numbers of all sizes, zero among them.
fn coefficient() -> impl Strategy<Value = f64> {
    prop_oneof![1 => Just(0.0), 8 => (-1.0..1.0_f64, -12..12_i32).prop_map(|(x, e)| x * 10.0_f64.powi(e))]
}

proptest! {
    /// Every root put back leaves only the rounding of its three terms.
    #[test]
    fn roots_are_roots(a in coefficient(), b in coefficient(), c in coefficient()) {
        for x in all(roots(a, b, c)) {
            let terms = [a * x * x, b * x, c];
            let size: f64 = terms.iter().map(|term| term.abs()).sum();
            prop_assert!(terms.iter().sum::<f64>().abs() <= 16.0 * f64::EPSILON * size, "{} of {:?}", x, terms);
        }
    }

    /// There are as many as the discriminant says, well away from where rounding decides.
    #[test]
    fn as_many_as_the_discriminant_says(a in coefficient(), b in coefficient(), c in coefficient()) {
        prop_assume!(a != 0.0);
        let (square, product) = (b * b, 4.0 * a * c);
        prop_assume!((square - product).abs() > 1e-12 * (square + product.abs()));
        let count = if square > product { 2 } else { 0 };
        prop_assert_eq!(all(roots(a, b, c)).len(), count);
    }

    /// Neither a common factor nor the sign matters; x → −x mirrors the roots.
    #[test]
    fn scaling_and_mirroring(a in coefficient(), b in coefficient(), c in coefficient(), power in -60..60_i32) {
        let once = all(roots(a, b, c));
        // A power of two rounds nothing.
        let factor = 2.0_f64.powi(power);
        let scaled = all(roots(factor * a, factor * b, factor * c));
        let negated = all(roots(-a, -b, -c));
        let mirrored: Vec<_> = all(roots(a, -b, c)).into_iter().rev().map(|x| -x).collect();
        for other in [scaled, negated, mirrored] {
            prop_assert_eq!(once.len(), other.len());
            for (x, y) in once.iter().zip(&other) {
                prop_assert!((x - y).abs() <= 8.0 * f64::EPSILON * x.abs(), "{} {}", x, y);
            }
        }
    }

    /// As a fades the equation turns linear: the near root stays −c/b.
    #[test]
    fn fading_square(b in 0.1..10.0_f64, c in -10.0..10.0_f64, exponent in -320..-20_i32) {
        let all_roots = all(roots(10.0_f64.powi(exponent), b, c));
        prop_assert!(all_roots.iter().any(|x| (x + c / b).abs() <= 4.0 * f64::EPSILON * (c / b).abs()), "{:?}", all_roots);
    }
}
