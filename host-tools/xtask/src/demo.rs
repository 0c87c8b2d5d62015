//! `cargo xtask demo`: the whole story on the virtual board, in one folder of results.
//!
//! Drive empty and fully loaded, record, fit, flash; then drive with a payload that nobody tells the board and that changes,
//! and hold the board's own estimates against the truth.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::images::{self, VIRTUAL};
use crate::set_up;
use crate::steps::{Steps, Stop, command};

/// Where everything goes, in the workspace's directory.
const FOLDER: &str = "demo-output";

/// Longest that a board may take to show its link, and to end after its drive.
const PATIENCE: Duration = Duration::from_secs(30);

/// A drive of the virtual robot, and what is done on the link meanwhile. `@/` stands for [`FOLDER`].
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

/// True when every step ended well.
pub(crate) fn run() -> bool {
    let mut steps = Steps::default();
    let result = all(&mut steps);
    steps.print_summary();
    match result {
        Ok(()) => println!("\ndemo: done; logs, coefficients and plots are in {FOLDER}/"),
        Err(ref stop) => println!("\ndemo: FAILED: {stop}"),
    }
    result.is_ok()
}

fn all(steps: &mut Steps) -> Result<(), Stop> {
    let mut target = None;
    steps.work("set-up", || {
        target = Some(set_up::target()?);
        set_up::qemu()
    })?;
    let target = target.ok_or_else(|| Stop::new("no target"))?;
    steps.run("build the command", command("cargo build --release --package host-tools"))?;
    steps.run("build the board's image", target.command(&images::build(VIRTUAL)))?;
    // Logs are not written over, and a flash from an older demo would already know the coefficients.
    let folder = crate::root().join(FOLDER);
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
    )
}

/// The built-in Burger with the static power that `gmr inspect` finds: the servos' electronics are on the motors' rail.
fn describe_robot() -> Result<(), Stop> {
    let mut inspect = gmr("inspect --json @/empty.csv");
    let output = inspect
        .current_dir(crate::root())
        .output()
        .map_err(|error| Stop::new(format!("gmr inspect: {error}")))?;
    let found: serde_json::Value = serde_json::from_slice(&output.stdout)
        .map_err(|error| Stop::new(format!("gmr inspect --json: {error}")))?;
    let static_w = found["static_states"][0]["mean_w"]
        .as_f64()
        .ok_or_else(|| Stop::new("gmr inspect found no standstill in the recorded drive"))?;
    let burger = crate::root().join("host-tools/robots/burger.toml");
    let write = || -> std::io::Result<()> {
        let robot = fs::read_to_string(&burger)?;
        // Before the first section.
        let line = format!("static_power_w = {static_w:.4}\n\n[");
        fs::write(
            crate::root().join(FOLDER).join("robot.toml"),
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
        let line =
            format!("board --speed max --wait --link @/link --flash @/flash.bin --image @image {arguments}");
        let folder = crate::root().join(FOLDER);
        let said = folder.join("board.log");
        let link = folder.join("link");
        let _ = fs::remove_file(&link);
        let log = File::create(&said).map_err(|error| Stop::new(format!("{}: {error}", said.display())))?;
        let mut board = gmr(&line);
        board.current_dir(crate::root()).stdin(Stdio::null()).stdout(Stdio::null()).stderr(log);
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
    let mut command = Command::new(crate::target_folder().join("release/gmr"));
    command.args(arguments.split_whitespace().map(in_folder));
    command
}

/// `@/name` becomes a path in [`FOLDER`], `@image` that of the board's image; a mass schedule keeps its `@`.
fn in_folder(argument: &str) -> PathBuf {
    match argument.strip_prefix("@/") {
        Some(name) => Path::new(FOLDER).join(name),
        None if argument == "@image" => images::path(VIRTUAL),
        None => argument.into(),
    }
}
