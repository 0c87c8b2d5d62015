//! Adds what a machine with nothing but rustup's stable toolchain lacks.

use std::io::{IsTerminal as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::steps::{Stop, answer, command, command_line};

/// The board's, and the emulated core's.
pub(crate) const TARGET: &str = "thumbv7em-none-eabihf";

/// Whether packages of the system may be installed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Consent {
    /// Somebody at a terminal is asked; without a terminal they are only named.
    Ask,
    /// `--yes`
    Given,
}

/// cargo as it builds for [`TARGET`]: another toolchain than rustup's, where the variable
/// BOARD_TOOLCHAIN names one.
pub(crate) struct TargetCargo {
    toolchain: Option<String>,
}

impl TargetCargo {
    /// Tells the tests that build images themselves which toolchain to use.
    pub(crate) fn tell(&self, tests: &mut Command) {
        if let Some(toolchain) = &self.toolchain {
            tests.env("BOARD_TOOLCHAIN", toolchain);
        }
    }

    /// `cargo` with the arguments of `line`.
    pub(crate) fn command(&self, line: &str) -> Command {
        match &self.toolchain {
            Some(toolchain) => command(&format!("cargo +{toolchain} {line}")),
            None => command(&format!("cargo {line}")),
        }
    }
}

/// rustfmt and clippy, which rustup's minimal profile leaves out.
pub(crate) fn components() -> Result<(), Stop> {
    for (probe, component) in [("cargo fmt --version", "rustfmt"), ("cargo clippy --version", "clippy")] {
        if answer(probe).is_none() {
            obtain(&mut command(&format!("rustup component add {component}")))?;
        }
    }
    Ok(())
}

/// The core library for [`TARGET`].
pub(crate) fn target() -> Result<TargetCargo, Stop> {
    if let Ok(toolchain) = std::env::var("BOARD_TOOLCHAIN") {
        return if has_core(&format!("rustc +{toolchain}")) {
            Ok(TargetCargo { toolchain: Some(toolchain) })
        } else {
            Err(Stop::new(format!("BOARD_TOOLCHAIN names {toolchain}, which has no core for {TARGET}")))
        };
    }
    if has_core("rustc") {
        return Ok(TargetCargo { toolchain: None });
    }
    match obtain(&mut command(&format!("rustup target add {TARGET}"))) {
        Ok(()) if has_core("rustc") => Ok(TargetCargo { toolchain: None }),
        Ok(()) => Err(Stop::new(format!(
            "rustup added {TARGET}, but rustc does not find it: is another rustc first in PATH?"
        ))),
        // Nothing outside the checkout is run, however near it lies.
        Err(stop) => Err(Stop::new(format!(
            "{stop}\n   where rustup cannot fetch it, build core from a distribution's sources (../shared/tools/thumb-target.sh does, \
             where you have it), link that as a toolchain and name it in BOARD_TOOLCHAIN"
        ))),
    }
}

fn has_core(rustc: &str) -> bool {
    let Some(folder) = answer(&format!("{rustc} --print target-libdir --target {TARGET}")) else {
        return false;
    };
    let Ok(files) = Path::new(&folder).read_dir() else { return false };
    files.flatten().any(|file| file.file_name().to_string_lossy().starts_with("libcore-"))
}

/// The emulator: installed where one may, named where not.
pub(crate) fn qemu(consent: Consent) -> Result<(), Stop> {
    package(
        "qemu-system-arm",
        "qemu-system-arm is missing: `apt install qemu-system-arm` (Debian, Ubuntu), \
         `dnf install qemu-system-arm-core` (Fedora), `pacman -S qemu-system-arm` (Arch), `brew install qemu` (macOS), then again; \
         with --yes apt is run for you",
        consent,
    )
}

/// A Java that Spark runs on.
pub(crate) fn java(consent: Consent) -> Result<(), Stop> {
    let missing = "java is missing: `apt install default-jre-headless` (Debian, Ubuntu), or any Java from 17 on, then again; with --yes apt is \
                   run for you";
    program("java", "default-jre-headless", missing, consent)
}

/// A browser without a screen, for the page of `gmr gap --report`. Without one its test is skipped:
/// nothing else needs it.
pub(crate) fn browser(consent: Consent) {
    let names = ["chromium", "chromium-browser", "google-chrome", "chrome"];
    if names.iter().any(|name| answer(&format!("{name} --version")).is_some()) {
        return;
    }
    let missing = "no browser: the test that opens a page in one will be skipped";
    if let Err(stop) = package("chromium", missing, consent) {
        println!("   {stop}");
    }
}

/// A program by Debian's package of its name; `missing` says what to do where that cannot be had.
fn package(name: &str, missing: &str, consent: Consent) -> Result<(), Stop> {
    program(name, name, missing, consent)
}

/// A program by a package of Debian.
fn program(program: &str, name: &str, missing: &str, consent: Consent) -> Result<(), Stop> {
    let is_there = || answer(&format!("{program} --version")).is_some();
    if is_there() {
        return Ok(());
    }
    let sudo = if answer("id -u").as_deref() == Some("0") { "" } else { "sudo " };
    if answer("apt-get --version").is_none() {
        return Err(Stop::new(missing));
    }
    let install = format!("{sudo}apt-get -qq install --yes --no-install-recommends {name}");
    if !agrees(consent, &install) {
        return Err(Stop::new(missing));
    }
    // A fresh machine has no package lists yet; one without network may still have the package.
    let _ = obtain(&mut command(&format!("{sudo}apt-get -qq update")));
    obtain(&mut command(&install)).map_err(|stop| Stop::new(format!("{stop}\n   {missing}")))?;
    if is_there() { Ok(()) } else { Err(Stop::new(missing)) }
}

/// Whether a command that changes the system may be run.
fn agrees(consent: Consent, line: &str) -> bool {
    if consent == Consent::Given {
        return true;
    }
    let (input, mut output) = (std::io::stdin(), std::io::stdout());
    if !input.is_terminal() || !output.is_terminal() {
        return false;
    }
    print!("   run `{line}`? [y/N] ");
    let mut said = String::new();
    let asked = output.flush().and_then(|()| input.read_line(&mut said));
    asked.is_ok() && is_yes(&said)
}

fn is_yes(said: &str) -> bool {
    ["y", "yes"].contains(&said.trim().to_lowercase().as_str())
}

/// Whether the database of advisories is there, fetched now: not every machine that builds this
/// project reaches it.
pub(crate) fn advisories(deny: &Path) -> bool {
    let mut fetch = Command::new(deny);
    fetch.args(["fetch", "db"]);
    obtain(&mut fetch).is_ok()
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
    obtain(&mut install)?;
    // Half a gigabyte that nobody needs again.
    let _ = std::fs::remove_dir_all(folder.join("build"));
    Ok(program)
}

pub(crate) fn obtain(command: &mut Command) -> Result<(), Stop> {
    let line = command_line(command);
    println!("   {line}");
    let status = command.env("DEBIAN_FRONTEND", "noninteractive").current_dir(crate::paths::root()).status();
    match status {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(Stop::new(format!("{line}\n   {status}"))),
        Err(error) => Err(Stop::new(format!("{line}\n   {error}"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_clear_yes_is_one() {
        assert!(["y\n", "Y", " yes \n"].iter().all(|said| is_yes(said)));
        assert!(["", "\n", "n\n", "yeah, no\n", "sudo"].iter().all(|said| !is_yes(said)));
    }

    /// The tests' standard input is no terminal: nobody could be asked.
    #[test]
    fn with_consent_nobody_is_asked() {
        assert!(agrees(Consent::Given, "true"));
    }
}
