//! Adds what a machine with nothing but rustup's stable toolchain lacks.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::steps::{Stop, answer, command, command_line};

/// The board's, and the emulated core's.
pub(crate) const TARGET: &str = "thumbv7em-none-eabihf";

/// Builds core for [`TARGET`] where rustup cannot fetch it, and links the result as the toolchain `debian`. Beside the
/// project, not part of it.
const FALLBACK: &str = "../shared/tools/thumb-target.sh";
const FALLBACK_TOOLCHAIN: &str = "debian";

/// cargo as it builds for [`TARGET`].
pub(crate) struct TargetCargo {
    toolchain: Option<&'static str>,
}

impl TargetCargo {
    /// Tells the tests that build images themselves which toolchain to use.
    pub(crate) fn tell(&self, tests: &mut Command) {
        if let Some(toolchain) = self.toolchain {
            tests.env("BOARD_TOOLCHAIN", toolchain);
        }
    }

    /// `cargo` with the arguments of `line`.
    pub(crate) fn command(&self, line: &str) -> Command {
        match self.toolchain {
            Some(toolchain) => command(&format!("cargo +{toolchain} {line}")),
            None => command(&format!("cargo {line}")),
        }
    }
}

/// rustfmt and clippy, which rustup's minimal profile leaves out.
pub(crate) fn components() -> Result<(), Stop> {
    for (probe, component) in [("cargo fmt --version", "rustfmt"), ("cargo clippy --version", "clippy")] {
        if answer(probe).is_none() {
            obtain(command(&format!("rustup component add {component}")))?;
        }
    }
    Ok(())
}

/// The core library for [`TARGET`].
pub(crate) fn target() -> Result<TargetCargo, Stop> {
    if has_core("rustc") {
        return Ok(TargetCargo { toolchain: None });
    }
    let stop = match obtain(command(&format!("rustup target add {TARGET}"))) {
        Ok(()) if has_core("rustc") => return Ok(TargetCargo { toolchain: None }),
        Ok(()) => Stop::new(format!(
            "rustup added {TARGET}, but rustc does not find it: is another rustc first in PATH?"
        )),
        Err(stop) => stop,
    };
    if !crate::paths::root().join(FALLBACK).exists() {
        return Err(stop);
    }
    println!("   {stop}\n   building core from the distribution's sources instead");
    obtain(command(&format!("{FALLBACK} {TARGET}")))?;
    if has_core(&format!("rustc +{FALLBACK_TOOLCHAIN}")) {
        Ok(TargetCargo { toolchain: Some(FALLBACK_TOOLCHAIN) })
    } else {
        Err(Stop::new(format!("{FALLBACK} ended well, but there is no core for {TARGET}")))
    }
}

fn has_core(rustc: &str) -> bool {
    let Some(folder) = answer(&format!("{rustc} --print target-libdir --target {TARGET}")) else {
        return false;
    };
    let Ok(files) = Path::new(&folder).read_dir() else { return false };
    files.flatten().any(|file| file.file_name().to_string_lossy().starts_with("libcore-"))
}

/// The emulator: installed where that needs no password, named where it does.
pub(crate) fn qemu() -> Result<(), Stop> {
    package(
        "qemu-system-arm",
        "qemu-system-arm is missing: `apt install qemu-system-arm` (Debian, Ubuntu), \
         `dnf install qemu-system-arm-core` (Fedora), `brew install qemu` (macOS), then again",
    )
}

/// A browser without a screen, for the page of `gmr gap --report`. Without one its test skips: nothing else needs it.
pub(crate) fn browser() {
    let names = ["chromium", "chromium-browser", "google-chrome", "chrome"];
    if names.iter().any(|name| answer(&format!("{name} --version")).is_some()) {
        return;
    }
    if let Err(stop) = package("chromium", "no browser: the test that opens a page in one will skip") {
        println!("   {stop}");
    }
}

/// A program by Debian's package of its name; `missing` says what to do where that cannot be had.
fn package(name: &str, missing: &str) -> Result<(), Stop> {
    let is_there = || answer(&format!("{name} --version")).is_some();
    if is_there() {
        return Ok(());
    }
    let sudo = if answer("id -u").as_deref() == Some("0") {
        ""
    } else if answer("sudo -n true").is_some() {
        "sudo "
    } else {
        return Err(Stop::new(missing));
    };
    if answer("apt-get --version").is_none() {
        return Err(Stop::new(missing));
    }
    // A fresh machine has no package lists yet; one without network may still have the package.
    let _ = obtain(command(&format!("{sudo}apt-get -qq update")));
    obtain(command(&format!("{sudo}apt-get -qq install --yes --no-install-recommends {name}")))
        .map_err(|stop| Stop::new(format!("{stop}\n   {missing}")))?;
    if is_there() { Ok(()) } else { Err(Stop::new(missing)) }
}

/// cargo-deny: the installed one, or one built into the target folder.
pub(crate) fn cargo_deny() -> Result<PathBuf, Stop> {
    if answer("cargo-deny --version").is_some() {
        return Ok("cargo-deny".into());
    }
    let folder = crate::paths::target_folder().join("tools");
    let program = folder.join("bin/cargo-deny");
    if Command::new(&program).arg("--version").output().is_ok_and(|output| output.status.success()) {
        return Ok(program);
    }
    let mut install =
        command("cargo install --quiet cargo-deny --version ^0.20 --locked --no-default-features");
    install.arg("--root").arg(&folder).arg("--target-dir").arg(folder.join("build"));
    // It runs for a second: compiling it without optimisation is what costs least in all.
    install.env("CARGO_PROFILE_RELEASE_OPT_LEVEL", "0");
    install.env("CARGO_PROFILE_RELEASE_LTO", "off");
    install.env("CARGO_PROFILE_RELEASE_CODEGEN_UNITS", "16");
    install.env("CARGO_PROFILE_RELEASE_DEBUG", "0");
    obtain(install)?;
    // Half a gigabyte that nobody needs again.
    let _ = std::fs::remove_dir_all(folder.join("build"));
    Ok(program)
}

fn obtain(mut command: Command) -> Result<(), Stop> {
    let line = command_line(&command);
    println!("   {line}");
    let status = command.env("DEBIAN_FRONTEND", "noninteractive").current_dir(crate::paths::root()).status();
    match status {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(Stop::new(format!("{line}\n   {status}"))),
        Err(error) => Err(Stop::new(format!("{line}\n   {error}"))),
    }
}
