//! Negative self-test of the harness: a broken expectation fails the run, and the tests after it
//! still run.
#![cfg_attr(target_os = "none", no_std, no_main)]

use on_target_tests::{Outcome, close, ensure, tests};

tests!(passes, fails, fails_closely, passes_after);

fn passes() -> Outcome {
    Ok(())
}

fn fails() -> Outcome {
    ensure(false, format_args!("on purpose"))
}

fn fails_closely() -> Outcome {
    close(format_args!("on purpose"), 1.0, 1.5, 0.25)
}

fn passes_after() -> Outcome {
    close(format_args!("just close enough"), 1.0, 1.5, 0.5)
}
