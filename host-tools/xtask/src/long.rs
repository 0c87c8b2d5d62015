//! `cargo xtask long`: what takes a night, each at the scale that is asked for.

use std::process::Command;

use crate::fuzz;
use crate::paths::{root, target_folder};
use crate::steps::{Steps, Stop, command};

/// The targets that take bytes from a wire.
const PARSERS: [&str; 2] = ["link", "servo"];

const TARGET: &str = "thumbv7em-none-eabihf";

/// What to do, and how much of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Long {
    /// Executions of each parser.
    Fuzz(u64),
    /// Hours of the virtual board's life.
    Soak(f64),
    /// Power cuts.
    Cuts(u64),
    /// Minutes of the official client.
    Client(f64),
}

impl Long {
    /// `fuzz | soak | cuts | client [SCALE]`; `None` for anything else.
    pub(crate) fn parse(arguments: &[&str]) -> Option<Self> {
        let number =
            |text: &str| text.parse().ok().filter(|number: &f64| *number > 0.0 && number.is_finite());
        let count = |text: &str| text.parse().ok().filter(|count| *count > 0);
        Some(match *arguments {
            ["fuzz"] => Self::Fuzz(100_000_000),
            ["soak"] => Self::Soak(4.0),
            ["cuts"] => Self::Cuts(1000),
            ["client"] => Self::Client(60.0),
            ["fuzz", executions] => Self::Fuzz(count(executions)?),
            ["soak", hours] => Self::Soak(number(hours)?),
            ["cuts", cuts] => Self::Cuts(count(cuts)?),
            ["client", minutes] => Self::Client(number(minutes)?),
            _ => return None,
        })
    }
}

/// # Errors
/// What failed.
pub(crate) fn run(steps: &mut Steps, long: Long) -> Result<(), Stop> {
    match long {
        Long::Fuzz(executions) => fuzz::on_all_cores(steps, &PARSERS, executions),
        Long::Soak(hours) => {
            virtual_board(steps)?;
            let mut soak = script("soak.py");
            soak.arg(gmr()).arg(firmware("virtual")).args(["--hours", &hours.to_string()]);
            steps.run(&format!("soak, {hours} h of the board's time"), soak)
        }
        Long::Cuts(cuts) => {
            let folder = std::env::var_os("STM32EMU").ok_or_else(|| {
                Stop::new(
                    "STM32EMU names no folder with an emulator of the board, which is no part of the project",
                )
            })?;
            let emulator = root().join(folder);
            let build = format!(
                "cargo build --profile image --package firmware --features opencr --bin opencr --target {TARGET}"
            );
            steps.run("firmware", command(&build))?;
            let mut run = Command::new(emulator.join("emu"));
            run.env("PYTHONPATH", &emulator).arg(root().join("tests/system/opencr_cuts.py"));
            run.arg(target_folder().join(TARGET).join("image/opencr")).args(["--cuts", &cuts.to_string()]);
            steps.run(&format!("{cuts} power cuts"), run)
        }
        Long::Client(minutes) => {
            virtual_board(steps)?;
            let folder = target_folder().join("long");
            std::fs::create_dir_all(&folder)
                .map_err(|error| Stop::new(format!("{}: {error}", folder.display())))?;
            let (node, link) = (folder.join("node"), folder.join("link"));
            let mut board = Command::new(gmr());
            let seconds = (60.0 * minutes + 120.0).to_string();
            board.args([
                "board",
                "--realtime",
                "--profile",
                "none",
                "--power-noise",
                "0",
                "--duration",
                &seconds,
            ]);
            board.arg("--node").arg(&node).arg("--link").arg(&link).arg("--image").arg(firmware("virtual"));
            let mut child = board.spawn().map_err(|error| Stop::new(format!("gmr board: {error}")))?;
            let mut client = script("node_client.py");
            client.arg(&node).args(["--minutes", &minutes.to_string()]);
            let done =
                wait_for(&node).and_then(|()| steps.run(&format!("the client, {minutes} minutes"), client));
            // By itself it would go on to the end of its time.
            let _ = child.kill();
            let _ = child.wait();
            done
        }
    }
}

/// Until the board has made its link, for a minute at most.
fn wait_for(link: &std::path::Path) -> Result<(), Stop> {
    for _ in 0..600 {
        if link.symlink_metadata().is_ok() {
            return Ok(());
        }
        std::thread::sleep(std::time::Duration::from_millis(100));
    }
    Err(Stop::new(format!("gmr board has made no {} within a minute", link.display())))
}

fn virtual_board(steps: &mut Steps) -> Result<(), Stop> {
    steps.run("gmr", command("cargo build --release --package host-tools --bin gmr"))?;
    let build = format!(
        "cargo build --release --package firmware --features virtual --bin virtual --target {TARGET}"
    );
    steps.run("firmware", command(&build))
}

fn gmr() -> std::path::PathBuf {
    target_folder().join("release/gmr")
}

fn firmware(name: &str) -> std::path::PathBuf {
    target_folder().join(TARGET).join("release").join(name)
}

fn script(name: &str) -> Command {
    let mut python = Command::new("python3");
    python.arg(root().join("tests/system").join(name));
    python
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_are_understood() {
        assert_eq!(Long::parse(&["fuzz"]), Some(Long::Fuzz(100_000_000)));
        assert_eq!(Long::parse(&["cuts", "7"]), Some(Long::Cuts(7)));
        assert_eq!(Long::parse(&["soak", "0.5"]), Some(Long::Soak(0.5)));
        assert_eq!(Long::parse(&["client", "2"]), Some(Long::Client(2.0)));
        let wrong: [&[&str]; 5] = [&[], &["sleep"], &["fuzz", "0"], &["soak", "nan"], &["cuts", "1", "2"]];
        assert!(wrong.iter().all(|arguments| Long::parse(arguments).is_none()));
    }
}
