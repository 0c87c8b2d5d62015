//! One of the targets, named by the variable FUZZ_TARGET, under libFuzzer: `cargo xtask fuzz`.
#![no_main]

#[path = "../../host-tools/tests/fuzz/targets.rs"]
mod targets;

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

struct Chosen {
    target: targets::Target,
    /// In memory where the system has such a folder.
    path: PathBuf,
}

static CHOSEN: LazyLock<Chosen> = LazyLock::new(|| {
    let name = std::env::var("FUZZ_TARGET").expect("FUZZ_TARGET names a target");
    let (_, target) =
        *targets::TARGETS.iter().find(|(target, _)| *target == name).expect("there is such a target");
    let memory = Path::new("/dev/shm");
    let folder = if memory.is_dir() { memory.to_owned() } else { std::env::temp_dir() };
    Chosen { target, path: folder.join(format!("fuzz-{name}-{}", std::process::id())) }
});

libfuzzer_sys::fuzz_target!(|data: &[u8]| (CHOSEN.target)(data, &CHOSEN.path));
