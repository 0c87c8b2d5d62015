//! The demo's loop with asserted figures: the firmware's image on the emulated core, the virtual
//! robot around it.
//!
//! Drive empty and fully loaded, record, fit, flash; then drive with a payload that nobody tells
//! the board and that changes. Then the road slopes, which nobody tells either: the gap is seen on
//! the board, named, flashed, and gone. Board time runs only while somebody receives, so these
//! figures do not depend on the machine's speed.

use std::fmt::Write as _;
use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use std::time::Duration;

use board::client::{Board, Client};
use board::flasher::{Running, Target as _};
use board::recorder::{self, Ending, Options};
use firmware::control_table::{self as table, Item, Reason, UploadState};
use firmware::record::RECORD_BYTES;
use logs::robot::Robot;
use model::coefficients::CoefficientsFile;
use model_core::coefficients::{Coefficients, Name};
use model_core::model::Model;
use plant::{Effect, Kinematics, PayloadSchedule, PlantSet, ProfileKind, Scenario};
use serde_json::Value;
use support::context::Context;
use tempfile::TempDir;
use virtual_board::board::{BoardOptions, VirtualBoard};
use virtual_board::flash::VirtualFlash;
use virtual_board::robot::{RobotOptions, VirtualRobot};
use virtual_board::truth::{self, TruthRows};

/// What a drive is.
struct Drive {
    kind: ProfileKind,
    mass: &'static str,
    seed: u64,
    seconds: u64,
    /// What is not as it was in training, as `gmr board --effect` takes it.
    effect: Option<&'static str>,
}

/// The virtual board with its robot, and a client that has been there since its first sample.
struct System {
    client: Client<VirtualBoard>,
    board: Board,
}

impl System {
    fn start(drive: &Drive, flash: &Path) -> Self {
        let seconds = drive.seconds as f64 + 30.0;
        let mut scenario =
            Scenario::new(PlantSet::Servo, Kinematics::Differential, drive.kind, seconds, drive.seed);
        scenario.payload = PayloadSchedule::parse(drive.mass).unwrap();
        scenario.effects = drive.effect.iter().map(|effect| Effect::parse(effect).unwrap()).collect();
        let robot = RobotOptions { power_noise_w: 0.1, lidar: true, driven_by_board: false, charge: None };
        let robot = VirtualRobot::new(scenario, robot).unwrap();
        let options = BoardOptions { flash: VirtualFlash::open(flash).unwrap(), ..BoardOptions::default() };
        let mut board = VirtualBoard::start(&crate::images::virtual_board(), robot, options).unwrap();
        board.server_mut().note_truths(truth::PERIOD_US);
        let (client, board) = Client::connect(board).unwrap();
        Self { client, board }
    }

    /// Records from the board's first sample on, beside the truth.
    fn record(&mut self, seconds: u64, mass_kg: Option<f64>, log: &Path, truth: &Path) {
        let options = Options { duration: Some(Duration::from_secs(seconds)), mass_kg, backlog: true };
        let mut text = String::new();
        let recording = recorder::record(
            &mut self.client,
            &self.board,
            &options,
            &mut |lines| {
                text.push_str(lines);
                Ok(())
            },
            &mut |_| ControlFlow::Continue(()),
        )
        .unwrap();
        assert!(matches!(recording.ending, Ending::Complete), "{:?}", recording.ending);
        assert_eq!(recording.lost, 0);
        // The first sample is late by the start of the inertial sensor: the time since it ends with
        // one more.
        assert!((200 * seconds..=200 * seconds + 1).contains(&recording.rows), "{recording:?}");
        // Before their first conversion, and before the servos are known.
        assert!(recording.incomplete <= 3, "{recording:?}");
        fs::write(log, text).unwrap();
        let mut text = truth::HEADER.to_owned();
        let mut rows = TruthRows::default();
        for row in self.client.transport().server_mut().take_truths() {
            rows.push(&mut text, &row);
        }
        fs::write(truth, text).unwrap();
    }

    /// Nothing went wrong that the board counts.
    fn assert_healthy(&mut self) {
        for counter in
            [&table::MISSED_DEADLINES, &table::SERVO_TIMEOUTS, &table::SERVO_BROKEN, &table::BUS_ERRORS]
        {
            assert_eq!(self.client.get::<u32>(counter).unwrap(), 0, "{}", counter.name);
        }
    }

    /// Of the rails' sensors.
    fn health(&mut self) -> Vec<u8> {
        let block = self.client.block(&table::RAIL_HEALTH, &table::RAIL_HEALTH).unwrap();
        block.all(&table::RAIL_HEALTH).unwrap()
    }

    fn upload(&mut self, item: Item, bytes: &[u8]) {
        let board = self.board.clone();
        let timeout = Duration::from_secs(20);
        let mut running = Running { client: &mut self.client, board: &board, timeout, waiting: &mut |_| {} };
        running.put(item, bytes).unwrap();
    }

    /// Uploads what must not be taken, and gives the board's reason.
    fn refusal(&mut self, bytes: &[u8]) -> Reason {
        self.client.set(&table::UPLOAD_ITEM, Item::Coefficients as u8).unwrap();
        self.client.set(&table::UPLOAD_LENGTH, bytes.len() as u16).unwrap();
        self.client.set_bytes(&table::UPLOAD_WINDOW, bytes).unwrap();
        self.client.set(&table::UPLOAD_COMMAND, 1_u8).unwrap();
        self.client.wait(Duration::from_secs(2)).unwrap();
        let state: u8 = self.client.get(&table::UPLOAD_STATE).unwrap();
        assert_eq!(UploadState::from_code(state), Some(UploadState::Refused));
        Reason::from_code(self.client.get(&table::UPLOAD_REASON).unwrap()).unwrap()
    }
}

/// Runs `gmr` and gives its JSON.
fn gmr(arguments: &[&str]) -> Value {
    let output = Command::new(env!("CARGO_BIN_EXE_gmr")).args(arguments).arg("--json").output().unwrap();
    assert!(output.status.success(), "gmr {arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Paths in a folder, as text.
fn path(folder: &TempDir, name: &str) -> String {
    folder.path().join(name).to_str().unwrap().to_owned()
}

/// The built-in Burger with the static power of the motors' rail, as `gmr inspect` finds it.
fn describe_robot(folder: &TempDir) -> String {
    let report = gmr(&["inspect", &path(folder, "empty.csv")]);
    let static_w = report["static_states"][0]["mean_w"].as_f64().unwrap();
    let burger = include_str!("../../robots/burger.toml");
    let mut robot = String::new();
    let (head, sections) = burger.split_once("\n[").unwrap();
    write!(robot, "{head}\nstatic_power_w = {static_w}\n\n[{sections}").unwrap();
    let file = path(folder, "robot.toml");
    fs::write(&file, robot).unwrap();
    file
}

/// What training left: its logs, the robot's file, coefficients.
struct Trained {
    folder: TempDir,
    robot: String,
    coefficients: String,
    fitted: Coefficients<f32, 2>,
}

/// Trained once, for all tests.
fn trained() -> &'static Trained {
    static TRAINED: OnceLock<Trained> = OnceLock::new();
    TRAINED.get_or_init(|| {
        let folder = TempDir::new().unwrap();
        let (robot, coefficients, fitted) = train(&folder);
        Trained { folder, robot, coefficients, fitted }
    })
}

/// Two training drives, a fit, and the image for the board.
fn train(folder: &TempDir) -> (String, String, Coefficients<f32, 2>) {
    for (name, mass, seed) in [("empty", "1", 1), ("full", "6", 2)] {
        let drive = Drive { kind: ProfileKind::Training, mass, seed, seconds: 100, effect: None };
        let mut system = System::start(&drive, &folder.path().join("flash.bin"));
        assert!(!system.board.has_coefficients);
        let log = PathBuf::from(path(folder, &format!("{name}.csv")));
        system.record(100, mass.parse().ok(), &log, &PathBuf::from(path(folder, "ignored.csv")));
        system.assert_healthy();
    }
    let robot_file = describe_robot(folder);
    let coefficients = path(folder, "coefficients.toml");
    let (empty, full) = (path(folder, "empty.csv"), path(folder, "full.csv"));
    gmr(&["fit", "--robot", &robot_file, "--out", &coefficients, &empty, &full]);
    let robot = Robot::load(&Context::default(), Path::new(&robot_file)).unwrap();
    let fitted = CoefficientsFile::read(Path::new(&coefficients), &robot)
        .unwrap()
        .coefficients
        .core::<2>()
        .convert()
        .unwrap();
    (robot_file, coefficients, fitted)
}

/// Mass within 3 % from 25 s after each change on, power within 5 % (MAPE), the change noticed
/// within 10 s, no deadline missed, and the board's estimates those of the host's replay.
#[test]
fn the_board_finds_a_payload_that_nobody_told_it() {
    let folder = TempDir::new().unwrap();
    let flash = folder.path().join("flash.bin");
    let Trained { robot, coefficients, fitted, .. } = trained();

    // Flash while the robot stands; what is bad before and after changes nothing.
    let image = fitted.encode().unwrap();
    let still = Drive { kind: ProfileKind::Standstill, mass: "1", seed: 1, seconds: 60, effect: None };
    let mut system = System::start(&still, &flash);
    assert_eq!(system.refusal(&image.as_bytes()[..image.as_bytes().len() - 1]), Reason::Length);
    assert_eq!(system.client.get::<u8>(&table::COEFFICIENTS_STATE).unwrap(), Reason::Empty as u8);
    system.upload(Item::Coefficients, image.as_bytes());
    let crc: u32 = system.client.get(&table::COEFFICIENTS_CRC).unwrap();
    let mut other = *fitted;
    other.robot.name = Name::new("another");
    assert_eq!(system.refusal(other.encode().unwrap().as_bytes()), Reason::Robot);
    let mut flipped = image.as_bytes().to_vec();
    flipped[80] ^= 4;
    assert_eq!(system.refusal(&flipped), Reason::Checksum);
    assert_eq!(system.client.get::<u32>(&table::COEFFICIENTS_CRC).unwrap(), crc);
    drop(system);

    // The board has been off; the coefficients are still there.
    let unknown = Drive { kind: ProfileKind::Test, mass: "3@0,4@100", seed: 3, seconds: 200, effect: None };
    let mut system = System::start(&unknown, &flash);
    assert!(system.board.has_coefficients);
    assert_eq!(system.client.get::<u32>(&table::COEFFICIENTS_CRC).unwrap(), crc);
    let (log, truth) = (path(&folder, "unknown.csv"), path(&folder, "truth.csv"));
    system.record(200, None, Path::new(&log), Path::new(&truth));
    system.assert_healthy();

    let report = gmr(&[
        "estimate",
        "--robot",
        robot,
        "--coeffs",
        coefficients,
        "--window",
        "25",
        "--truth",
        &truth,
        &log,
    ]);
    let board = &report["board"];
    println!("{board:#}\n{:#}", report["true_changes"]);
    let number = |value: &Value| value.as_f64().unwrap();
    assert!(number(&board["mass"]["samples"]) > 25_000.0, "{board:#}");
    assert!(number(&board["mass"]["worst_percent"]) <= 3.0, "{board:#}");
    assert!(number(&board["quality"]["mape_percent"]) <= 5.0, "{board:#}");
    let changes = report["true_changes"].as_array().unwrap();
    assert_eq!(changes.len(), 1, "{changes:?}");
    assert!(number(&changes[0]["delay_s"]) <= 10.0, "{changes:?}");
    assert_eq!(report["changes"].as_array().unwrap().len(), 1, "{:#}", report["changes"]);

    assert_equal(board);
}

/// The board's columns are the replay's.
///
/// Single precision against double. What a filter at 1/50 of the sample rate keeps of a constant is
/// off by up to 250 roundings (1 / (1 + a1 + a2)), 1.5e-5; a mass passes two of them, and sums of
/// 5,000 samples.
fn assert_equal(board: &Value) {
    let number = |key: &str| board[key].as_f64().unwrap();
    assert_eq!(number("disagreements"), 0.0, "{board:#}");
    assert!(number("mass_difference") <= 1e-4, "{board:#}");
    assert!(number("power_difference_w") <= 1e-4 * number("largest_power_w"), "{board:#}");
}

/// A road that rises ahead by 0.02, a hundredth of the weight more than rolling resistance: on the
/// board the power is off by it.
const SLOPE: Option<&str> = Some("grade=0.02:along=travel");

/// Drives on the slope: training and test drives in turn, so that locked runs and open ones meet
/// both.
const SLOPES: [(ProfileKind, &str, u64); 4] = [
    (ProfileKind::Training, "1", 11),
    (ProfileKind::Test, "3", 12),
    (ProfileKind::Training, "4.5", 13),
    (ProfileKind::Test, "6", 14),
];

/// The gap on the board's own records is named, the slope goes into the coefficients, and the same
/// drive again has no gap: the error is what it is on level ground. What the board computes with
/// the effect is what the replay does.
#[test]
fn a_slope_that_nobody_told_is_named_flashed_and_gone() {
    let Trained { folder, robot, coefficients, fitted } = trained();
    let place = TempDir::new().unwrap();
    let flash = place.path().join("flash.bin");
    let drive = |(kind, mass, seed): (ProfileKind, &'static str, u64)| Drive {
        kind,
        mass,
        seed,
        seconds: 60,
        effect: SLOPE,
    };
    let upload = |image: &[u8]| {
        let still = Drive { kind: ProfileKind::Standstill, mass: "1", seed: 1, seconds: 10, effect: None };
        System::start(&still, &flash).upload(Item::Coefficients, image);
    };
    let record = |drive: &Drive, mass: Option<f64>, name: &str| {
        let mut system = System::start(drive, &flash);
        assert!(system.board.has_coefficients);
        let (log, truth) = (path(&place, &format!("{name}.csv")), path(&place, &format!("{name}_truth.csv")));
        system.record(60, mass, Path::new(&log), Path::new(&truth));
        system.assert_healthy();
        (log, truth)
    };
    let estimate = |coefficients: &str, (log, truth): &(String, String)| {
        gmr(&["estimate", "--robot", robot, "--coeffs", coefficients, "--truth", truth, log])
    };

    upload(fitted.encode().unwrap().as_bytes());
    let level = estimate(coefficients, &record(&Drive { effect: None, ..drive(SLOPES[1]) }, None, "level"));
    let runs: Vec<(String, String)> = SLOPES
        .iter()
        .enumerate()
        .map(|(place, run)| record(&drive(*run), run.1.parse().ok(), &format!("slope_{place}")))
        .collect();
    let extended = folder.path().join("extended.toml");
    let extended = extended.to_str().unwrap();
    let logs: Vec<&str> = runs.iter().map(|(log, _)| log.as_str()).collect();
    let report =
        gmr(&[&["gap", "--robot", robot, "--coeffs", coefficients, "--out", extended], &logs[..]].concat());
    assert_eq!(report["verdict"], "named", "{report:#}");
    assert_eq!(report["effects"].as_array().unwrap().len(), 1, "{report:#}");
    let effect = &report["effects"][0];
    assert_eq!((&effect["id"], &effect["detail"]["along"]), (&"grade".into(), &"the way ahead".into()));
    // The drive folds its efficiency in: the weight is multiplied by what multiplies the inertia.
    let Model::Signed { torque, .. } = fitted.model else { panic!("signed") };
    let slope = effect["coefficient"].as_f64().unwrap() / f64::from(torque.inertia_gain);
    assert!((slope / 0.02 - 1.0).abs() < 0.1, "{slope}");
    assert!(report["gap_closed"].as_f64().unwrap() > 0.9, "{report:#}");

    let loaded = Robot::load(&Context::default(), Path::new(robot)).unwrap();
    let read = CoefficientsFile::read(Path::new(extended), &loaded).unwrap().coefficients.core::<2>();
    upload(read.convert::<f32>().unwrap().encode().unwrap().as_bytes());
    let before = estimate(coefficients, &runs[1]);
    let again = record(&drive(SLOPES[1]), None, "again");
    let after = estimate(extended, &again);
    println!("level {:#}\nbefore {:#}\nafter {:#}", level["board"], before["board"], after["board"]);
    assert_equal(&before["board"]);
    assert_equal(&after["board"]);
    let error = |report: &Value| report["board"]["quality"]["rmse_w"].as_f64().unwrap();
    let (level, before_w, after_w) = (error(&level), error(&before), error(&after));
    assert!(before_w > 2.0 * level && after_w <= 1.1 * level, "{level} {before_w} {after_w}");
    let mass = |report: &Value| report["board"]["mass"]["worst_percent"].as_f64().unwrap();
    assert!(mass(&after) <= 3.0 && mass(&after) < mass(&before), "{} {}", mass(&before), mass(&after));
}

/// A sensor that is pulled out costs its own rail, and nothing of the rest.
#[test]
fn one_dead_sensor_costs_its_own_rail() {
    let folder = TempDir::new().unwrap();
    let drive = Drive { kind: ProfileKind::Training, mass: "2", seed: 5, seconds: 10, effect: None };
    let mut system = System::start(&drive, &folder.path().join("flash.bin"));
    system.client.wait(Duration::from_secs(1)).unwrap();
    const COMPUTER: usize = 2;
    system.client.transport().robot_mut().sensors[COMPUTER].absent = true;
    system.client.wait(Duration::from_secs(2)).unwrap();
    assert_eq!(system.health(), [0, 0, 3, 0]);
    let power: Vec<f32> =
        system.client.block(&table::RAIL_POWER, &table::RAIL_POWER).unwrap().all(&table::RAIL_POWER).unwrap();
    assert!(power[COMPUTER].is_nan() && power[0] > 1.0 && power[1] > 0.5 && power[3] > 0.5, "{power:?}");
    assert_eq!(system.client.get::<u32>(&table::MISSED_DEADLINES).unwrap(), 0);
    system.client.transport().robot_mut().sensors[COMPUTER].absent = false;
    system.client.wait(Duration::from_secs(2)).unwrap();
    assert_eq!(system.health(), [0, 0, 0, 0]);
    assert_eq!(system.client.get::<u16>(&table::RECORD_SIZE).unwrap(), RECORD_BYTES as u16);
}
