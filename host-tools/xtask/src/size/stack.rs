//! How deep the stack gets, measured.

use std::path::Path;
use std::process::{Command, Stdio};

use crate::steps::{Stop, command_line};

/// Runs the image there, with all that the board does, and checks it.
const SCRIPT: &str = "tests/system/opencr_emulated.py";

/// Robot's seconds to run the image for.
const SECONDS: u32 = 10;

/// The deepest use seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Depth {
    pub(super) bytes: u64,
    /// For how long the image ran.
    pub(super) seconds: u32,
}

/// Runs the image in the emulated chip and looks how much paint is left; `None` where there is no
/// emulator.
pub(super) fn measure(image: &Path) -> Result<Option<Depth>, Stop> {
    // No part of the project: nobody runs it unasked.
    let Some(folder) = std::env::var_os("STM32EMU") else { return Ok(None) };
    let emulator = crate::paths::root().join(folder);
    if !emulator.join("emu").exists() {
        return Ok(None);
    }
    let mut command = Command::new(emulator.join("emu"));
    command.env("PYTHONPATH", &emulator).arg(crate::paths::root().join(SCRIPT)).arg(image);
    command.args(["--seconds", &SECONDS.to_string(), "--json"]).stderr(Stdio::inherit());
    let line = command_line(&command);
    let output = command.output().map_err(|error| Stop::new(format!("{line}\n   {error}")))?;
    let said = String::from_utf8_lossy(&output.stdout);
    match stack_bytes(&said) {
        Some(bytes) => Ok(Some(Depth { bytes, seconds: SECONDS })),
        None => {
            Err(Stop::new(format!("{line}\n   {}: no stack depth in what it says:\n{said}", output.status)))
        }
    }
}

/// The number behind `"stack_bytes":`.
fn stack_bytes(json: &str) -> Option<u64> {
    let (_, rest) = json.split_once("\"stack_bytes\":")?;
    let digits = rest.trim_start();
    let end = digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len());
    digits.get(..end)?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_depth_in_the_scripts_answer() {
        assert_eq!(stack_bytes("{\"samples\": 1, \"stack_bytes\": 4096}"), Some(4096));
        assert_eq!(stack_bytes("{\"samples\": 1}"), None);
    }
}
