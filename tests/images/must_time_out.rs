//! Negative self-test of the harness: a test without end fails the run.
#![cfg_attr(target_os = "none", no_std, no_main)]

use on_target_tests::{Outcome, tests};

tests!(never_ends);

fn never_ends() -> Outcome {
    loop {
        core::hint::spin_loop();
    }
}
