//! Every reader against bytes that nobody meant: a small corpus, mutated for some seconds a reader.
//!
//! Always the same bytes in the same order; how far they get depends on the machine. `cargo xtask
//! fuzz` looks further, guided by what the readers' code does; what it finds is kept in the corpus.

#[path = "../fuzz/targets.rs"]
mod targets;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// For each of fourteen readers, on two cores: about half a minute.
const TIME: Duration = Duration::from_secs(2);
/// So many anyway, where the machine has other things to do.
const LEAST: usize = 300;
/// Longer inputs only repeat what shorter ones show.
const LONGEST: usize = 4096;
/// Things that readers look for.
const WORDS: [&[u8]; 18] = [
    b"time_s",
    b"wheel1_rad_s",
    b"power_w",
    b"mass_kg",
    b"run",
    b"nan",
    b"-inf",
    b"1e308",
    b"-0",
    b"\r\n",
    b",",
    b"\"",
    b"[[effect]]\n",
    b"= ",
    b"\xFF\xFF\xFD\x00",
    b"\xEF\xBB\xBF",
    b"18446744073709551616",
    b"\0",
];

fn corpus(target: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/corpus").join(target);
    let mut files: Vec<PathBuf> = folder.read_dir().unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(!files.is_empty(), "{}", folder.display());
    files.iter().map(|file| std::fs::read(file).unwrap()).collect()
}

/// Some of the input's bytes changed, doubled, left out or replaced by a word, or by a piece of
/// another input.
fn mutate(rng: &mut ChaCha8Rng, input: &mut Vec<u8>, other: &[u8]) {
    let at = rng.random_range(0..=input.len());
    let end = (at + rng.random_range(0..16)).min(input.len());
    match rng.random_range(0..7) {
        0 if at < input.len() => input[at] ^= 1 << rng.random_range(0..8),
        1 if at < input.len() => input[at] = rng.random(),
        2 => _ = input.drain(at..end),
        3 => {
            let piece = input[at..end].to_vec();
            input.splice(at..at, piece);
        }
        4 => _ = input.splice(at..end, WORDS[rng.random_range(0..WORDS.len())].iter().copied()),
        5 => {
            let from = rng.random_range(0..=other.len());
            let to = (from + rng.random_range(0..64)).min(other.len());
            input.splice(at..end, other[from..to].iter().copied());
        }
        _ => input.truncate(at),
    }
    input.truncate(LONGEST);
}

fn fuzz(name: &str) {
    let (_, target) = *targets::TARGETS.iter().find(|(target, _)| *target == name).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("input");
    let try_one = |input: &[u8]| {
        if catch_unwind(AssertUnwindSafe(|| target(input, &path))).is_err() {
            panic!("{name} fails on {:?}", String::from_utf8_lossy(input));
        }
    };
    let corpus = corpus(name);
    corpus.iter().for_each(|input| try_one(input));
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let (begun, mut executions) = (Instant::now(), corpus.len());
    while begun.elapsed() < TIME || executions < LEAST {
        let mut input = corpus[rng.random_range(0..corpus.len())].clone();
        let other = &corpus[rng.random_range(0..corpus.len())];
        for _ in 0..rng.random_range(1..=6) {
            mutate(&mut rng, &mut input, other);
        }
        try_one(&input);
        executions += 1;
    }
    println!("{name}: {executions} executions");
}

macro_rules! readers {
    ($($name:ident),+) => {
        $(
            #[test]
            fn $name() {
                fuzz(stringify!($name));
            }
        )+

        /// None is forgotten.
        #[test]
        fn every_target_has_a_test() {
            assert_eq!(targets::TARGETS.map(|(name, _)| name), [$(stringify!($name)),+]);
        }
    };
}

readers!(
    log,
    robot,
    coefficients,
    effects,
    image,
    link,
    servo,
    mcap,
    sqlite,
    ulog,
    ros1,
    dataflash,
    vesc_tool,
    parquet
);
