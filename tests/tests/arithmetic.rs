//! The emulated core computes as IEEE 754 single precision asks: what all other images rely on.
#![cfg_attr(target_os = "none", no_std, no_main)]

use core::hint::black_box;

use model_core::real::Real;
use on_target_tests::{Outcome, close, ensure, tests, within};

tests!(rounding, subnormals, not_a_number, square_root);

/// 1 + 2⁻²⁴ lies halfway between two floats and rounds to the even one; 1 + 3·2⁻²⁴ rounds up.
fn rounding() -> Outcome {
    let ulp = f64::from(f32::EPSILON);
    close(format_args!("1 + 2^-24"), black_box(1.0_f32) + black_box(f32::EPSILON / 2.0), 1.0, 0.0)?;
    close(
        format_args!("1 + 3*2^-24"),
        black_box(1.0_f32) + black_box(1.5 * f32::EPSILON),
        1.0 + 2.0 * ulp,
        0.0,
    )
}

/// Nothing sets the flush-to-zero bit: half of the smallest normal number is not zero.
fn subnormals() -> Outcome {
    let half = black_box(f32::MIN_POSITIVE) / black_box(2.0);
    close(format_args!("MIN_POSITIVE / 2"), half, f64::from(f32::MIN_POSITIVE) / 2.0, 0.0)
}

fn not_a_number() -> Outcome {
    let nan = black_box(0.0_f32) / black_box(0.0);
    ensure(nan.is_nan(), format_args!("0/0 is {nan}"))?;
    ensure(!within(nan.into(), 0.0, f64::INFINITY), format_args!("NaN is near 0"))
}

/// The FPU's square root is libm's, bit for bit: special values, then every 9,973rd of all bit
/// patterns (a prime: all exponents and endings occur).
fn square_root() -> Outcome {
    let special = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        f32::MIN_POSITIVE,
        f32::MIN_POSITIVE / 2.0,
        f32::from_bits(1),
        f32::MAX,
        f32::MIN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
        1.0 - f32::EPSILON / 2.0,
        1.0 + f32::EPSILON,
    ];
    special.into_iter().try_for_each(same_root)?;
    (0..=u32::MAX).step_by(9_973).try_for_each(|bits| same_root(f32::from_bits(bits)))
}

fn same_root(x: f32) -> Outcome {
    let (found, reference) = (Real::sqrt(black_box(x)), libm::sqrtf(x));
    let same = found.to_bits() == reference.to_bits() || found.is_nan() && reference.is_nan();
    ensure(same, format_args!("√{x:e}: found {found:e}, libm {reference:e}"))
}
