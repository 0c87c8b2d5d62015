//! `cargo xtask test`: everything a change has to pass.

use std::process::Command;

use crate::docs;
use crate::images;
use crate::python;
use crate::set_up::{self, Consent, TARGET, TargetCargo};
use crate::steps::{Steps, Stop, command, command_line};

/// A second of the emulated chip takes ten, on one core.
const LONGEST_TEST: &str = "samples_at_200_hz";

/// One set for the whole host: a second would compile large libraries again. Not --all-features:
/// nothing tests a debug probe without one, and its library takes minutes (`cargo clippy -p
/// host-tools --features probe`).
const HOST_FEATURES: &str = "--features on-target-tests/system";

/// Images that must not pass, and what each has to say.
const MUST_NOT_PASS: [(&str, &str); 4] = [
    ("must-fail", "test result: FAILED. 2 passed; 2 failed"),
    ("must-panic", "on purpose"),
    ("must-time-out", "no end after"),
    ("must-overflow-stack", "Lockup"),
];

/// True when everything passed. Packages that are missing are installed as `consent` has it.
pub(crate) fn run(consent: Consent) -> bool {
    let mut steps = Steps::default();
    let result = all(&mut steps, consent);
    steps.print_summary();
    let tests = steps.tests();
    tests.reasons().for_each(|reason| println!("skipped  {reason}"));
    let failed = if result.is_ok() { tests.failed } else { tests.failed.max(1) };
    let counts = format!("{} passed; {failed} failed; {} skipped", tests.passed(), tests.skipped());
    match &result {
        Ok(()) => println!("\ntest result: ok. {counts}"),
        Err(stop) => println!("\nstopped: {stop}\n\ntest result: FAILED. {counts}"),
    }
    result.is_ok()
}

fn all(steps: &mut Steps, consent: Consent) -> Result<(), Stop> {
    let mut target = None;
    steps.work("set-up", || {
        set_up::components()?;
        target = Some(set_up::target()?);
        set_up::browser(consent);
        // Without it its tests are skipped: nothing else needs it.
        if let Err(stop) = python::environment() {
            println!("   {stop}");
        }
        set_up::qemu(consent)
    })?;
    let target = target.ok_or_else(|| Stop::new("no target"))?;

    steps.run("format", command("cargo fmt --all --check"))?;
    steps.run(
        "lints, host",
        command(&format!("cargo clippy --workspace --all-targets {HOST_FEATURES} -- -D warnings")),
    )?;
    steps.run(
        "lints, board",
        target.command(&format!(
            "clippy --package model-core --package firmware --lib --target {TARGET} -- -D warnings"
        )),
    )?;
    for board in [images::OPENCR, images::VIRTUAL] {
        steps.run(
            &format!("lints, {board}"),
            target.command(&format!(
                "clippy --package firmware --features {board} --lib --bin {board} --target {TARGET} -- -D warnings"
            )),
        )?;
        // Its modules are not there on the host, whose documentation is checked below.
        let mut documentation = target
            .command(&format!("doc --package firmware --no-deps --lib --features {board} --target {TARGET}"));
        documentation.env("RUSTDOCFLAGS", "-D warnings");
        steps.run(&format!("documentation, {board}"), documentation)?;
    }
    // The image that wants a key: any will do.
    let mut signed = target.command(&format!(
        "clippy --package firmware --features {},signed --lib --target {TARGET} -- -D warnings",
        images::OPENCR
    ));
    signed.env("GMR_COEFFICIENTS_KEY", "00".repeat(32));
    steps.run("lints, opencr with a key", signed)?;
    steps.run(
        "lints, images",
        target.command(&format!(
            "clippy --package on-target-tests --features panic-probe --lib --bins --tests --target {TARGET} -- \
             -D warnings"
        )),
    )?;
    steps.run(
        "tests, emulated board",
        target.command(&format!("test --package on-target-tests --target {TARGET} --no-fail-fast")),
    )?;
    steps.work("the harness can fail", || harness_can_fail(&target))?;
    steps.run("no panics on the board", target.command(&panic_probe("no-panic")))?;
    steps.work("no double precision on the board", no_double_precision)?;
    steps.work("the panic probe can fail", || {
        fails_with(&target, &panic_probe("must-not-link"), "undefined symbol")
    })?;

    let mut documentation = command(&format!("cargo doc --workspace --no-deps {HOST_FEATURES}"));
    documentation.env("RUSTDOCFLAGS", "-D warnings");
    steps.run("documentation", documentation)?;
    steps.work("pages", docs::check)?;
    let host_tests = |which: &str| {
        let mut tests = command(&format!("cargo test --workspace {HOST_FEATURES} {which}"));
        target.tell(&mut tests);
        tests
    };
    steps.run("tests, host: build", host_tests("--no-run"))?;
    steps.run_beside(
        "tests, host",
        host_tests(&format!("--no-fail-fast -- --skip {LONGEST_TEST}")),
        host_tests(&format!("--test emulated -- {LONGEST_TEST}")),
    )?;

    let mut deny = None;
    steps.work("set-up of cargo-deny", || {
        deny = Some(set_up::cargo_deny()?);
        Ok(())
    })?;
    let deny = deny.ok_or_else(|| Stop::new("no cargo-deny"))?;
    let check = |which: &[&str]| {
        let mut check = Command::new(&deny);
        check.args(["--all-features", "check", "--hide-inclusion-graph"]).args(which);
        check
    };
    steps.run("licences and sources", check(&["licenses", "bans", "sources"]))?;
    if set_up::advisories(&deny) {
        steps.run("advisories", check(&["--disable-fetch", "advisories"]))
    } else {
        println!("   advisories: not checked, their database cannot be reached from here");
        Ok(())
    }
}

fn panic_probe(image: &str) -> String {
    format!(
        "build --release --package on-target-tests --features panic-probe --bin {image} --target {TARGET}"
    )
}

/// Each of [`MUST_NOT_PASS`] ends with a failure, and for its own reason.
fn harness_can_fail(target: &TargetCargo) -> Result<(), Stop> {
    MUST_NOT_PASS.into_iter().try_for_each(|(image, expected)| {
        fails_with(
            target,
            &format!("run --package on-target-tests --bin {image} --target {TARGET}"),
            expected,
        )
    })
}

/// cargo with `arguments` fails and says `expected`.
fn fails_with(target: &TargetCargo, arguments: &str, expected: &str) -> Result<(), Stop> {
    let mut command = target.command(arguments);
    let line = command_line(&command);
    println!("   {line}");
    let output = command
        .current_dir(crate::paths::root())
        .output()
        .map_err(|error| Stop::new(format!("{line}\n   {error}")))?;
    let said = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
    if output.status.success() {
        return Err(Stop::new(format!("{line}\n   ended with success, which it must not")));
    }
    if !said.contains(expected) {
        return Err(Stop::new(format!("{line}\n   failed without saying `{expected}`:\n{said}")));
    }
    println!("   fails as it should: {expected}");
    Ok(())
}

/// The compiler knows that the board's core computes in single precision only: arithmetic in f64
/// calls a function.
///
/// The emulated core has both and would not show the fault that a board reports
/// (.cargo/config.toml, -fp64).
fn no_double_precision() -> Result<(), Stop> {
    let image = crate::paths::target_folder().join(TARGET).join("release/no-panic");
    let bytes = std::fs::read(&image).map_err(|error| Stop::new(format!("{}: {error}", image.display())))?;
    let multiplication = b"__aeabi_dmul";
    if bytes.windows(multiplication.len()).any(|window| window == multiplication) {
        Ok(())
    } else {
        Err(Stop::new(format!(
            "{} has no __aeabi_dmul: double precision was compiled to instructions that the board's core lacks; \
             does RUSTFLAGS replace the flags of .cargo/config.toml?",
            image.display()
        )))
    }
}
