//! Real roots of a x² + b x + c without cancellation.

use crate::real::Real;

/// The real roots, lower first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Roots<T> {
    /// No real root, or coefficients that determine none (all zero, not finite).
    None,
    /// One root: the equation is linear, or its two roots coincide.
    One(T),
    /// Two distinct roots, ascending.
    Two(T, T),
}

/// Solves a x² + b x + c = 0.
///
/// The root of larger magnitude is q / a with q = −(b + sgn(b) √(b² − 4ac)) / 2, in which nothing
/// cancels; the other is c / q. The coefficients are scaled by the largest first, so that b² cannot
/// overflow. Where a is so small that q / a is not finite, the equation is linear in all but name
/// and c / q is its root.
pub fn roots<T: Real>(a: T, b: T, c: T) -> Roots<T> {
    let scale = a.abs().at_least(b.abs()).at_least(c.abs());
    if !(a.is_finite() && b.is_finite() && c.is_finite()) || scale == T::ZERO {
        return Roots::None;
    }
    let (a, b, c) = (a / scale, b / scale, c / scale);
    if a == T::ZERO {
        return finite(-c / b);
    }
    let half = b * T::HALF;
    let discriminant = half * half - a * c;
    if discriminant < T::ZERO {
        return Roots::None;
    }
    let root = discriminant.sqrt();
    let q = if half < T::ZERO { root - half } else { -(half + root) };
    if q == T::ZERO {
        return Roots::One(T::ZERO);
    }
    let (far, near) = (q / a, c / q);
    if !far.is_finite() {
        return finite(near);
    }
    if far == near {
        Roots::One(far)
    } else if far < near {
        Roots::Two(far, near)
    } else {
        Roots::Two(near, far)
    }
}

/// The real root of a x² + b x + c = 0 within ±`reach`; of two, the upper. `None` too where a
/// square would overflow.
///
/// The same formula as in [`roots`] without its scaling and its cases, for what runs at every
/// sample: a quotient by zero lies beyond any reach, and no number is within it.
#[inline]
pub fn root_within<T: Real>(a: T, b: T, c: T, reach: T) -> Option<T> {
    let half = b * T::HALF;
    let discriminant = half * half - a * c;
    if !(discriminant >= T::ZERO && discriminant.is_finite()) {
        return None;
    }
    let root = discriminant.sqrt();
    let q = if half < T::ZERO { root - half } else { -(half + root) };
    let (far, near) = (q / a, c / q);
    let (upper, lower) = if far > near { (far, near) } else { (near, far) };
    if upper.abs() <= reach {
        Some(upper)
    } else if lower.abs() <= reach {
        Some(lower)
    } else {
        None
    }
}

fn finite<T: Real>(root: T) -> Roots<T> {
    if root.is_finite() { Roots::One(root) } else { Roots::None }
}

#[cfg(test)]
mod tests {
    use super::{Roots, root_within, roots};
    use proptest::prelude::*;

    #[test]
    fn degenerate_cases_are_typed() {
        assert_eq!(roots(0.0, 0.0, 0.0), Roots::None);
        assert_eq!(roots(0.0, 0.0, 1.0), Roots::None);
        assert_eq!(roots(0.0, 2.0, -4.0), Roots::One(2.0));
        assert_eq!(roots(1.0, 0.0, 1.0), Roots::None);
        assert_eq!(roots(1.0, -2.0, 1.0), Roots::One(1.0));
        assert_eq!(roots(3.0, 0.0, 0.0), Roots::One(0.0));
        assert_eq!(roots(f64::NAN, 1.0, 1.0), Roots::None);
        assert_eq!(roots(1.0, f64::INFINITY, 1.0), Roots::None);
    }

    /// (x − 1e-8)(x − 1e8): the schoolbook formula loses the small root altogether.
    #[test]
    fn small_root_survives_cancellation() {
        let Roots::Two(low, high) = roots(1.0_f64, -(1e8 + 1e-8), 1.0) else { panic!("two roots") };
        assert!((low / 1e-8 - 1.0).abs() < 4.0 * f64::EPSILON, "{low}");
        assert!((high / 1e8 - 1.0).abs() < 4.0 * f64::EPSILON, "{high}");
    }

    /// b² alone would overflow.
    #[test]
    fn large_coefficients_do_not_overflow() {
        let Roots::Two(low, high) = roots(1e200_f64, -3e200, 2e200) else { panic!("two roots") };
        assert!((low - 1.0).abs() < 1e-15 && (high - 2.0).abs() < 1e-15);
    }

    proptest! {
        /// Roots put in come out: forming the coefficients perturbs them by ε relative to their
        /// terms, which moves a root x by at most some ε (x² + |x s| + |p|) / |x − other|.
        #[test]
        fn recovers_chosen_roots(low in -50.0..50.0_f64, gap in 1e-3..50.0_f64, a in 1e-3..1e3_f64) {
            let high = low + gap;
            match roots(a, -a * (low + high), a * low * high) {
                Roots::Two(l, h) => {
                    let tolerance = 16.0 * f64::EPSILON * (high * high + low * low) / gap;
                    prop_assert!((l - low).abs() <= tolerance, "{} {}", l, low);
                    prop_assert!((h - high).abs() <= tolerance, "{} {}", h, high);
                }
                other => prop_assert!(false, "{other:?}"),
            }
        }

        /// The same root as by way of [`roots`], but for those that rounding takes over the edge.
        #[test]
        fn root_within_is_the_upper_root_inside(
            a in prop_oneof![Just(0.0), -2.0..2.0_f64], b in -5.0..5.0_f64, c in -5.0..5.0_f64, reach in 0.1..5.0_f64,
        ) {
            let inside = |x: &f64| x.abs() <= reach;
            let expected = match roots(a, b, c) {
                Roots::None => None,
                Roots::One(x) => Some(x).filter(inside),
                Roots::Two(low, high) => Some(high).filter(inside).or(Some(low).filter(inside)),
            };
            let root = root_within(a, b, c, reach);
            let discriminant = b * b - 4.0 * a * c;
            let near_edge = |x: f64| (x.abs() - reach).abs() < 1e-9;
            match (expected, root) {
                (Some(x), Some(y)) => prop_assert!((x - y).abs() < 1e-9 || near_edge(x) || near_edge(y)),
                (Some(x), None) | (None, Some(x)) => prop_assert!(near_edge(x) || discriminant.abs() < 1e-9),
                (None, None) => {}
            }
        }

        #[test]
        fn never_panics(a in any::<f32>(), b in any::<f32>(), c in any::<f32>()) {
            prop_assert!(root_within(a, b, c, 5.0).is_none_or(|x| x.abs() <= 5.0));
            match roots(a, b, c) {
                Roots::None => {}
                Roots::One(x) => prop_assert!(x.is_finite()),
                Roots::Two(x, y) => prop_assert!(x < y),
            }
        }
    }
}
