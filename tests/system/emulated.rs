//! The very image that is flashed, in an emulated STM32F746 with its buses, started as the
//! bootloader leaves the chip.
//!
//! The emulator is no part of the project: the variable STM32EMU names its folder. Without, these
//! tests are skipped, and say so.

mod common;

use std::process::Command;

/// Runs a script with these arguments. `None` where there is no emulator.
fn run(script: &str, arguments: &[&str]) -> Option<(bool, String)> {
    let folder = common::emulator()?;
    let output = Command::new(folder.join("emu"))
        .env("PYTHONPATH", &folder)
        .arg(common::root().join("tests/system").join(script))
        .arg(common::opencr())
        .args(arguments)
        .output()
        .expect("the emulator starts");
    let said = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
    Some((output.status.success(), said.into_owned()))
}

fn emulate(arguments: &[&str]) -> Option<(bool, String)> {
    run("opencr_emulated.py", arguments)
}

fn script_passes(script: &str, arguments: &[&str]) {
    if let Some((is_good, said)) = run(script, arguments) {
        assert!(is_good, "{said}");
    }
}

fn passes(arguments: &[&str]) {
    script_passes("opencr_emulated.py", arguments);
}

/// 3 s: no deadline missed, no bus error, 200 samples a second with four sensors and two servos in
/// each. Longer: the script by hand.
#[test]
fn samples_at_200_hz() {
    passes(&["--seconds", "3"]);
}

/// A sensor that is not there costs its own rail only.
#[test]
fn an_absent_sensor_costs_its_own_rail() {
    passes(&["--seconds", "3", "--absent", "0x44"]);
}

/// A line held low, lost arbitration, bus errors, no acknowledgement: the sensors are back half a
/// second later, and no sample is late.
#[test]
fn the_sensor_bus_comes_back() {
    passes(&["--seconds", "2", "--bus-faults"]);
}

/// The expectations of a minute cannot hold when a servo does not answer: the script must say so.
#[test]
fn the_check_can_fail() {
    if let Some((is_good, said)) = emulate(&["--seconds", "2", "--silent-servo", "2"]) {
        assert!(!is_good && said.contains("wheels"), "{said}");
    }
}

/// Control transfers that are left unfinished, floods of them, SETUP packets that are none,
/// requests to endpoints that the chip has not: the next transfer is answered, a bus reset brings
/// the link back within 0.2 s, and the board never restarts.
#[test]
fn no_host_kills_the_link() {
    script_passes("opencr_usb.py", &[]);
}

/// A heartbeat that ends between two samples, a little before an upload is written: no word is
/// written to the flash, which stops the core, while the stop's packet is on the servos' bus. Three
/// places; at all fifteen of them: the script by hand.
#[test]
fn a_stop_between_samples_keeps_off_what_is_written() {
    script_passes("opencr_guard.py", &["--every", "500"]);
}

/// One bit in 10,000 on the power sensors' bus is another: no power that is off by more than 1 %
/// counts.
#[test]
fn flipped_bits_are_no_powers() {
    script_passes("opencr_flips.py", &["--seconds", "3"]);
}

/// Either inertial sensor is found once, calibrated, and turns as the robot does; lost or browned
/// out, it comes back without a jump.
#[test]
fn inertial_sensors_are_found_and_come_back() {
    script_passes("opencr_inertial.py", &[]);
}
