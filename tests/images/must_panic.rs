//! Negative self-test of the harness: a panic fails the run.
#![cfg_attr(target_os = "none", no_std, no_main)]

use on_target_tests::{Outcome, tests};

tests!(panics);

fn panics() -> Outcome {
    panic!("on purpose")
}
