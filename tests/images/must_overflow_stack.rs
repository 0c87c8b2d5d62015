//! Negative self-test of the harness, and of memory.x: a stack overflow faults and fails the run.
#![cfg_attr(target_os = "none", no_std, no_main)]

use core::hint::black_box;

use on_target_tests::{Outcome, ensure, tests};

tests!(overflows_the_stack);

fn overflows_the_stack() -> Outcome {
    // On a host this would not end in a report.
    let depth = if cfg!(target_os = "none") { u32::MAX } else { 1 };
    ensure(descend(depth) == 0, format_args!("came back"))
}

fn descend(depth: u32) -> u32 {
    let room = black_box([depth; 64]);
    if depth == 0 {
        0
    } else {
        descend(black_box(depth - 1)) + black_box(room.map(|_| 0)).iter().sum::<u32>()
    }
}
