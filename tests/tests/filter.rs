//! The causal filter in single precision against SciPy in double: reference/filter.py.
#![cfg_attr(target_os = "none", no_std, no_main)]

use model_core::filter::{Channel, LowPass};
use on_target_tests::{Failed, Outcome, close, ensure, tests};

#[allow(clippy::excessive_precision, clippy::approx_constant)]
mod reference {
    include!("../reference/filter.rs");
}
use reference::{CUTOFF_HZ, RATE_HZ, SAMPLES};

tests!(follows_scipy, settles_anywhere);

/// What single precision may lose at 2 Hz of 200, in units of the largest value.
///
/// A second-order section rounds some nine times a step, each by at most 2⁻²⁴ of its output. Its
/// recursion sums these up with the gain 1 / (1 + a1 + a2) = 1 / (4 · 9.4e-4) = 266, times 2.1
/// where the section rings: 9 · 2⁻²⁴ · (266 + 540) = 4.3e-4 for both, were all errors as large as
/// can be and of the signs that hurt most. Rounded coefficients move the poles by some 2e-5. A
/// formula that is wrong shows at once: one sample's delay is 1e-2.
const LOSS: f64 = 5e-4;

/// The derivative is 2 tan(π f_c / f_s) f_s = 12.6 / s times the difference of two filtered values.
const DERIVATIVE_LOSS: f64 = 12.6 * 2.0 * LOSS;

fn low_pass() -> Result<LowPass<f32>, Failed> {
    match LowPass::new(CUTOFF_HZ, 1.0 / RATE_HZ) {
        Ok(filter) => Ok(filter),
        Err(error) => {
            ensure(false, format_args!("{error:?}"))?;
            Err(Failed)
        }
    }
}

fn follows_scipy() -> Outcome {
    let filter = low_pass()?;
    let peak = SAMPLES.iter().map(|sample| f64::from(sample.input).abs()).fold(0.0, f64::max);
    let mut channel = Channel::default();
    let mut worst = 0.0_f64;
    for (i, sample) in SAMPLES.iter().enumerate() {
        if i == 0 {
            filter.settle(&mut channel, sample.input);
        }
        let out = filter.step(&mut channel, sample.input);
        close(format_args!("value {i}"), out.value, sample.filtered, LOSS * peak)?;
        close(format_args!("derivative {i}"), out.derivative, sample.derivative, DERIVATIVE_LOSS * peak)?;
        worst = worst.max((f64::from(out.value) - sample.filtered).abs());
    }
    // The bound would be worth little if it were far from what happens.
    ensure(worst > 1e-3 * LOSS * peak, format_args!("worst error {worst:e}: is this single precision?"))
}

/// Settled at a level, a filter stays there: what it loses is the same rounding.
fn settles_anywhere() -> Outcome {
    let filter = low_pass()?;
    for level in [0.0_f32, 1e-6, -3.7, 6.4, 1e6] {
        let mut channel = Channel::default();
        filter.settle(&mut channel, level);
        for i in 0..400 {
            let out = filter.step(&mut channel, level);
            let size = f64::from(level).abs();
            close(format_args!("step {i} at {level}"), out.value, f64::from(level), LOSS * size)?;
            close(format_args!("derivative {i} at {level}"), out.derivative, 0.0, DERIVATIVE_LOSS * size)?;
        }
    }
    Ok(())
}
