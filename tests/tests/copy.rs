//! The OpenCR image's copying by words moves what it is told to, and nothing beside it.
#![cfg_attr(target_os = "none", no_std, no_main)]

use core::hint::black_box;

use on_target_tests::{Outcome, ensure, tests};

/// What the image has, instead of the compiler's own.
#[cfg(target_os = "none")]
#[path = "../../firmware/src/boards/opencr/copy.rs"]
mod copy;

tests!(bytes, words);

/// Four turns of the longest loop, and a rest.
const LONGEST: usize = 144;
/// Room on both sides.
const MARGIN: usize = 8;
const NOTHING: u8 = 0xA5;

/// Every length, from every address within a word to every other.
fn bytes() -> Outcome {
    let source: [u8; LONGEST + MARGIN] = core::array::from_fn(|at| at as u8 ^ 0x5A);
    for length in 0..=LONGEST {
        for (from, to) in (0..4).flat_map(|from| (MARGIN..MARGIN + 4).map(move |to| (from, to))) {
            let mut place = [NOTHING; LONGEST + 2 * MARGIN];
            let bytes = &black_box(&source)[from..from + black_box(length)];
            black_box(&mut place)[to..to + length].copy_from_slice(bytes);
            let is_right = place.iter().enumerate().all(|(at, byte)| {
                let moved = at.checked_sub(to).filter(|at| *at < length).map(|at| source[from + at]);
                *byte == moved.unwrap_or(NOTHING)
            });
            ensure(is_right, format_args!("{length} bytes from {from} to {to}"))?;
        }
    }
    Ok(())
}

/// Words, for which the compiler asks by a name of its own.
fn words() -> Outcome {
    let source: [u32; LONGEST / 4] = core::array::from_fn(|at| 0x0102_0304 * (at as u32 + 1));
    for length in 0..=source.len() {
        let mut place = [0; LONGEST / 4 + 2];
        black_box(&mut place)[1..1 + length].copy_from_slice(&black_box(&source)[..black_box(length)]);
        let moved = place[1..1 + length] == source[..length];
        let others = place[0] == 0 && place[1 + length..].iter().all(|word| *word == 0);
        ensure(moved && others, format_args!("{length} words"))?;
    }
    Ok(())
}
