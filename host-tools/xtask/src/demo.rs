//! `cargo xtask demo`: the whole story on the virtual board, in one folder of results.
//!
//! Drive empty and fully loaded, record, fit, flash; then drive with a payload that nobody tells
//! the board and that changes, and hold the board's own estimates against the truth. Then let the
//! road slope and tell nobody: the gap between model and measurement is named, the effect flashed,
//! and the same drive again has none.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::images::{self, VIRTUAL};
use crate::set_up::{self, Consent};
use crate::steps::{Steps, Stop, command};

/// Where everything goes, in the workspace's directory.
const FOLDER: &str = "demo-output";

/// Board seconds per second: about half of what the emulator reaches, so that a busy machine, too,
/// fetches every sample in time.
const SPEED: u32 = 8;

/// Longest that a board may take to show its link, and to end after its drive.
const PATIENCE: Duration = Duration::from_secs(30);

/// A drive of the virtual robot, and what is done on the link meanwhile. `@/` stands for
/// [`FOLDER`].
struct Drive {
    name: &'static str,
    /// Arguments of `gmr board`.
    board: &'static str,
    /// Arguments of the `gmr` that talks to it.
    client: &'static str,
}

const TRAINING: [Drive; 2] = [
    Drive {
        name: "drive empty, and record",
        board: "--profile training --mass 1 --seed 1 --duration 101",
        client: "record --port @/link --mass 1 --duration 100 --out @/empty.csv",
    },
    Drive {
        name: "drive fully loaded, and record",
        board: "--profile training --mass 6 --seed 2 --duration 101",
        client: "record --port @/link --mass 6 --duration 100 --out @/full.csv",
    },
];

const FLASH: Drive = Drive {
    name: "flash the coefficients",
    board: "--profile standstill --duration 20",
    client: "flash --robot @/robot.toml --coeffs @/coefficients.toml --port @/link",
};

const UNKNOWN: Drive = Drive {
    name: "drive with 3 kg, then 4 kg, and tell nobody",
    board: "--profile test --mass 3@0,4@100 --seed 3 --duration 201 --truth @/truth.csv",
    client: "record --port @/link --backlog --duration 200 --out @/unknown.csv",
};

/// Four drives on a road that rises ahead by 0.02, with payloads that are noted: one stays locked
/// to confirm what the others name. The last is driven again, with the effect flashed, and its
/// payload noted by nobody.
const SLOPES: [Drive; 5] = [
    Drive {
        name: "the road slopes, and nobody is told: drive empty",
        board: "--profile training --mass 1 --seed 11 --duration 61 --effect grade=0.02:along=travel",
        client: "record --port @/link --mass 1 --duration 60 --out @/slope_1.csv",
    },
    Drive {
        name: "drive with 4.5 kg",
        board: "--profile training --mass 4.5 --seed 13 --duration 61 --effect grade=0.02:along=travel",
        client: "record --port @/link --mass 4.5 --duration 60 --out @/slope_2.csv",
    },
    Drive {
        name: "drive fully loaded",
        board: "--profile test --mass 6 --seed 14 --duration 61 --effect grade=0.02:along=travel",
        client: "record --port @/link --mass 6 --duration 60 --out @/slope_3.csv",
    },
    Drive {
        name: "drive with 3 kg",
        board: "--profile test --mass 3 --seed 12 --duration 61 --effect grade=0.02:along=travel --truth @/slope_4_truth.csv",
        client: "record --port @/link --mass 3 --backlog --duration 60 --out @/slope_4.csv",
    },
    Drive {
        name: "the same drive again, its payload told to nobody",
        board: "--profile test --mass 3 --seed 12 --duration 61 --effect grade=0.02:along=travel --truth @/again_truth.csv",
        client: "record --port @/link --backlog --duration 60 --out @/again.csv",
    },
];

const FLASH_EXTENDED: Drive = Drive {
    name: "flash the coefficients with the effect",
    board: "--profile standstill --duration 20",
    client: "flash --robot @/robot.toml --coeffs @/extended.toml --port @/link",
};

/// True when every step ended well.
pub(crate) fn run(consent: Consent) -> bool {
    let mut steps = Steps::default();
    let result = all(&mut steps, consent);
    steps.print_summary();
    match result {
        Ok(()) => println!("\ndemo: done; logs, coefficients and plots are in {FOLDER}/"),
        Err(ref stop) => println!("\ndemo: FAILED: {stop}"),
    }
    result.is_ok()
}

fn all(steps: &mut Steps, consent: Consent) -> Result<(), Stop> {
    let mut target = None;
    steps.work("set-up", || {
        target = Some(set_up::target()?);
        set_up::qemu(consent)
    })?;
    let target = target.ok_or_else(|| Stop::new("no target"))?;
    steps.run("build the command", command("cargo build --release --package host-tools"))?;
    steps.run("build the board's image", target.command(&images::build(VIRTUAL)))?;
    // Logs are not written over, and a flash from an older demo would already know the
    // coefficients.
    let folder = crate::paths::root().join(FOLDER);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).map_err(|error| Stop::new(format!("{FOLDER}: {error}")))?;

    for drive in &TRAINING {
        run_drive(steps, drive)?;
    }
    steps.run("look at the recorded drive", gmr("inspect --plot @/inspect.png @/empty.csv"))?;
    steps.work("take the static power into the robot's file", describe_robot)?;
    steps.run(
        "fit the power model",
        gmr("fit --robot @/robot.toml --out @/coefficients.toml @/empty.csv @/full.csv"),
    )?;
    run_drive(steps, &FLASH)?;
    run_drive(steps, &UNKNOWN)?;
    steps.run(
        "hold the board's estimates against the truth",
        gmr("estimate --robot @/robot.toml --coeffs @/coefficients.toml --truth @/truth.csv \
             --plot @/estimate.png @/unknown.csv"),
    )?;
    slope(steps)
}

/// The chapter of the gap.
fn slope(steps: &mut Steps) -> Result<(), Stop> {
    let [recorded @ .., again] = &SLOPES;
    for drive in recorded {
        run_drive(steps, drive)?;
    }
    steps.run(
        "name what the model lacks, and add it",
        gmr("gap --robot @/robot.toml --coeffs @/coefficients.toml --out @/extended.toml \
             @/slope_1.csv @/slope_2.csv @/slope_3.csv @/slope_4.csv"),
    )?;
    run_drive(steps, &FLASH_EXTENDED)?;
    run_drive(steps, again)?;
    steps.work("the board's own estimates, without the effect and with it", || {
        let before = Errors::of("coefficients", "slope_4")?;
        let after = Errors::of("extended", "again")?;
        for (what, Errors { rmse_w, mass_percent }) in [("without", &before), ("with", &after)] {
            println!("   {what:7} power off by {rmse_w:.3} W (RMS), mass by {mass_percent:.1} % on average");
        }
        if after.rmse_w < before.rmse_w && after.mass_percent < before.mass_percent {
            Ok(())
        } else {
            Err(Stop::new("the gap did not shrink"))
        }
    })
}

/// How far the board's own estimates are off.
struct Errors {
    rmse_w: f64,
    mass_percent: f64,
}

impl Errors {
    /// Of a recorded drive, while these coefficients were in use.
    fn of(coefficients: &str, drive: &str) -> Result<Self, Stop> {
        let line = format!(
            "estimate --json --robot @/robot.toml --coeffs @/{coefficients}.toml --truth @/{drive}_truth.csv @/{drive}.csv"
        );
        let report = json(&line)?;
        let board = &report["board"];
        match (board["quality"]["rmse_w"].as_f64(), board["mass"]["mean_percent"].as_f64()) {
            (Some(rmse_w), Some(mass_percent)) => Ok(Self { rmse_w, mass_percent }),
            _ => Err(Stop::new(format!("gmr {line}: the board estimated nothing"))),
        }
    }
}

/// What a `gmr` with `--json` says.
fn json(line: &str) -> Result<serde_json::Value, Stop> {
    let output = gmr(line)
        .current_dir(crate::paths::root())
        .stderr(Stdio::inherit())
        .output()
        .map_err(|error| Stop::new(format!("gmr {line}: {error}")))?;
    serde_json::from_slice(&output.stdout).map_err(|error| Stop::new(format!("gmr {line}: {error}")))
}

/// The built-in Burger with the static power that `gmr inspect` finds: the servos' electronics are
/// on the motors' rail.
fn describe_robot() -> Result<(), Stop> {
    let report = json("inspect --json @/empty.csv")?;
    let static_w = report["static_states"][0]["mean_w"]
        .as_f64()
        .ok_or_else(|| Stop::new("gmr inspect found no standstill in the recorded drive"))?;
    let burger = crate::paths::root().join("host-tools/robots/burger.toml");
    let write = || -> std::io::Result<()> {
        let robot = fs::read_to_string(&burger)?;
        // Before the first section.
        let line = format!("static_power_w = {static_w:.4}\n\n[");
        fs::write(
            crate::paths::root().join(FOLDER).join("robot.toml"),
            robot.replacen("\n[", &format!("\n{line}"), 1),
        )
    };
    write().map_err(|error| Stop::new(format!("{FOLDER}/robot.toml: {error}")))?;
    println!("   static_power_w = {static_w:.4}");
    Ok(())
}

fn run_drive(steps: &mut Steps, drive: &Drive) -> Result<(), Stop> {
    let mut board = Board::start(drive.board)?;
    let result = steps.run(drive.name, gmr(drive.client));
    let ended = board.finish();
    result.and(ended)
}

/// `gmr board` in the background.
struct Board {
    process: Child,
    said: PathBuf,
}

impl Board {
    fn start(arguments: &str) -> Result<Self, Stop> {
        let line = format!(
            "board --speed {SPEED} --wait --link @/link --flash @/flash.bin --image @image {arguments}"
        );
        let folder = crate::paths::root().join(FOLDER);
        let said = folder.join("board.log");
        let link = folder.join("link");
        let _ = fs::remove_file(&link);
        let log = File::create(&said).map_err(|error| Stop::new(format!("{}: {error}", said.display())))?;
        let mut board = gmr(&line);
        board.current_dir(crate::paths::root()).stdin(Stdio::null()).stdout(Stdio::null()).stderr(log);
        println!("   gmr {line}");
        let process = board.spawn().map_err(|error| Stop::new(format!("gmr board: {error}")))?;
        let mut board = Self { process, said };
        let begun = Instant::now();
        while fs::symlink_metadata(&link).is_err() {
            if begun.elapsed() > PATIENCE || !matches!(board.process.try_wait(), Ok(None)) {
                return Err(board.stop("showed no link"));
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        Ok(board)
    }

    /// Waits until the drive is over.
    fn finish(&mut self) -> Result<(), Stop> {
        let begun = Instant::now();
        loop {
            match self.process.try_wait() {
                Ok(Some(status)) if status.success() => return Ok(()),
                Ok(None) if begun.elapsed() < PATIENCE => std::thread::sleep(Duration::from_millis(20)),
                _ => return Err(self.stop("did not end well")),
            }
        }
    }

    fn stop(&mut self, why: &str) -> Stop {
        let _ = self.process.kill();
        let said = fs::read_to_string(&self.said).unwrap_or_default();
        Stop::new(format!("gmr board {why}:\n{said}"))
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn gmr(arguments: &str) -> Command {
    let mut command = Command::new(crate::paths::target_folder().join("release/gmr"));
    command.args(arguments.split_whitespace().map(in_folder));
    command
}

/// `@/name` becomes a path in [`FOLDER`], `@image` that of the board's image; a mass schedule keeps
/// its `@`.
fn in_folder(argument: &str) -> PathBuf {
    match argument.strip_prefix("@/") {
        Some(name) => Path::new(FOLDER).join(name),
        None if argument == "@image" => images::path(VIRTUAL),
        None => argument.into(),
    }
}
