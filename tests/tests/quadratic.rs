//! Quadratic roots in single precision against 60 decimal digits: reference/quadratic.py.
#![cfg_attr(target_os = "none", no_std, no_main)]

use model_core::quadratic::{Roots, roots};
use on_target_tests::{Outcome, close, ensure, tests};

#[allow(clippy::excessive_precision, clippy::approx_constant)]
mod reference {
    include!("../reference/quadratic.rs");
}
use reference::CASES;

tests!(roots_to_their_last_digits, what_determines_no_root);

/// Each root within what its own conditioning makes of single precision's roundoff (the tolerance
/// is in the table).
fn roots_to_their_last_digits() -> Outcome {
    for (i, case) in CASES.iter().enumerate() {
        let [a, b, c] = case.coefficients;
        let (count, found) = match roots(a, b, c) {
            Roots::None => (0, [0.0; 2]),
            Roots::One(x) => (1, [x, 0.0]),
            Roots::Two(x, y) => (2, [x, y]),
        };
        ensure(count == case.count, format_args!("case {i}: {count} roots, reference {}", case.count))?;
        for ((found, reference), tolerance) in found.iter().zip(case.roots).zip(case.tolerances) {
            close(format_args!("case {i}"), *found, reference, tolerance)?;
        }
    }
    Ok(())
}

fn what_determines_no_root() -> Outcome {
    for (a, b, c) in [(0.0, 0.0, 0.0), (f32::NAN, 1.0, 1.0), (1.0, f32::INFINITY, 1.0), (1.0, 1.0, f32::NAN)]
    {
        let found = roots(a, b, c);
        ensure(found == Roots::None, format_args!("{a}, {b}, {c}: {found:?}"))?;
    }
    Ok(())
}
