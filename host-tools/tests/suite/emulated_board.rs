//! The commands that talk to a board, on the USB link of the very image that is flashed, in an
//! emulated STM32F746.
//!
//! The emulator is no part of the project: the variable STM32EMU names its folder, and without this
//! is skipped. It runs in real time.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

/// It loads its Python packages first.
const PATIENCE: Duration = Duration::from_secs(60);

/// Killed when dropped.
struct Emulator(Child);

impl Drop for Emulator {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The image with its link at a path; `None` where there is no emulator.
fn start(link: &Path) -> Option<Emulator> {
    let folder = crate::images::emulator()?;
    let child = Command::new(folder.join("emu"))
        .env("PYTHONPATH", &folder)
        .arg(crate::images::root().join("tests/system/opencr_emulated.py"))
        .arg(crate::images::opencr())
        .args(["--seconds", "600", "--terminal"])
        .arg(link)
        .stdout(Stdio::null())
        .spawn()
        .expect("the emulator starts");
    let mut emulator = Emulator(child);
    let begun = Instant::now();
    while !link.exists() {
        assert!(begun.elapsed() < PATIENCE, "the emulator shows no link");
        assert!(matches!(emulator.0.try_wait(), Ok(None)), "the emulator ended early");
        std::thread::sleep(Duration::from_millis(50));
    }
    Some(emulator)
}

fn gmr(folder: &Path, line: &str) -> Value {
    let output = Command::new(env!("CARGO_BIN_EXE_gmr"))
        .current_dir(folder)
        .args(line.split_whitespace())
        .arg("--json")
        .output()
        .unwrap();
    assert!(output.status.success(), "gmr {line}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn records_flashes_and_estimates_on_the_usb_link() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let Some(_emulator) = start(&here.join("link")) else { return };
    gmr(here, "simulate --rate 200 --sensors servo --duration 60 --mass 1@0,6@30 --out training.csv");
    gmr(here, "fit --out coefficients.toml training.csv");

    let before = gmr(here, "record --port link --duration 2 --out before.csv");
    assert_eq!(before["lost"], 0, "{before:#}");
    assert_eq!(before["rows"], 400, "{before:#}");
    assert_eq!(before["board"]["has_coefficients"], false, "{before:#}");

    // On the board's clock; it waits until the robot stands.
    let flashed = gmr(here, "flash --coeffs coefficients.toml --port link --timeout 60");
    assert_eq!(flashed["verified"], true, "{flashed:#}");

    // Some of it is a drive: the robot rests 6 s at a time.
    let after = gmr(here, "record --port link --duration 8 --out after.csv");
    assert_eq!(after["lost"], 0, "{after:#}");
    assert_eq!(after["rows"], 1600, "{after:#}");
    assert_eq!(after["board"]["has_coefficients"], true, "{after:#}");
    let header = fs::read_to_string(here.join("after.csv")).unwrap();
    assert!(header.starts_with("time_s,wheel1_rad_s,wheel2_rad_s,power_w"), "{}", &header[..80]);
    assert!(header.lines().next().unwrap().contains("board_mass_kg"), "{}", &header[..200]);
    let estimate = gmr(here, "estimate --coeffs coefficients.toml --window 2 after.csv");
    assert_eq!(estimate["rows"], 1600, "{estimate:#}");
    assert!(estimate["board"].is_object(), "{estimate:#}");
    assert!(estimate["windows"].as_array().unwrap().len() > 3, "{estimate:#}");
}
