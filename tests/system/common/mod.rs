//! The firmware's images.

#[path = "../../../host-tools/tests/suite/common/skipped.rs"]
mod skipped;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Once;

use skipped::skipped;

const TARGET: &str = "thumbv7em-none-eabihf";

/// The workspace's directory.
pub(crate) fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the tests are in the workspace")
}

/// The emulated STM32F746, in the folder that the variable STM32EMU names: it is no part of the
/// project, so nobody runs it unasked. `None`, and the test counted as skipped, where there is
/// none.
#[allow(dead_code, reason = "not every test that shares this file needs it")]
pub(crate) fn emulator() -> Option<PathBuf> {
    static READY: Once = Once::new();
    let Some(folder) = std::env::var_os("STM32EMU") else {
        skipped("STM32EMU names no folder with an emulator of the board");
        return None;
    };
    let folder = root().join(folder);
    if !folder.join("emu").exists() {
        skipped(&format!("there is no emulator in {}", folder.display()));
        return None;
    }
    // It sets itself up at its first start: not by several tests at once.
    READY.call_once(|| {
        let _ = Command::new(folder.join("emu")).arg("--help").output();
    });
    Some(folder)
}

/// The `opencr` image as users flash it, built if it is not there or not from these sources.
#[allow(dead_code, reason = "not every test that shares this file needs every image")]
pub(crate) fn opencr() -> PathBuf {
    image("opencr", "image")
}

/// The image for the emulated core, as users run it.
#[allow(dead_code, reason = "not every test that shares this file needs every image")]
pub(crate) fn virtual_board() -> PathBuf {
    image("virtual", "release")
}

fn image(name: &str, profile: &str) -> PathBuf {
    // Where rustup has no core for the board, xtask names the toolchain that has.
    let mut cargo = Command::new("cargo");
    if let Ok(toolchain) = std::env::var("BOARD_TOOLCHAIN") {
        cargo.env_remove("RUSTUP_TOOLCHAIN").arg(format!("+{toolchain}"));
    }
    cargo.args(["build", "--quiet", "--profile", profile, "--package", "firmware", "--features", name]);
    cargo.args(["--bin", name, "--target", TARGET]);
    let status = cargo.current_dir(root()).status().expect("cargo runs");
    assert!(status.success(), "the image {name} does not build");
    let target = std::env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into());
    root().join(target).join(TARGET).join(profile).join(name)
}
