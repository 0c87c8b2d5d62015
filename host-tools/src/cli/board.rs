//! `gmr board`: the virtual board and its robot, for whoever opens the link.

use std::io::IsTerminal as _;
use std::path::{Path, PathBuf};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use logs::arguments::times_real_time;
use plant::{Kinematics, ProfileKind, Robot};
use support::error::Result;
use support::output::{self, check_apart};
use support::overwrite::Form;
use virtual_board::robot::{RobotOptions, VirtualRobot};
use virtual_board::session::{Progress, Request, Watcher, session};

use super::drive::DriveArguments;
use super::overwrite::OverwriteArgument;

/// Where cargo puts the image.
const IMAGE: &str = "target/thumbv7em-none-eabihf/release/virtual";

/// The profile that lets the board drive.
const DRIVEN_BY_BOARD: &str = "none";

/// Arguments of `gmr board`.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  gmr board --link /tmp/board --speed max")]
pub(crate) struct Arguments {
    #[command(flatten)]
    drive: DriveArguments,
    /// Board seconds per second: a number, or max
    #[arg(long, default_value = "1", value_name = "N|max")]
    speed: String,
    /// Keep to wall time whatever clients do: for programs written for the real board, which have
    /// time limits of their own
    #[arg(long, conflicts_with_all = ["speed", "wait"])]
    realtime: bool,
    /// Stand still until a client has sent its first byte
    #[arg(long)]
    wait: bool,
    /// Standard deviation of a power reading of motors and battery, W
    #[arg(long, default_value_t = 0.1, allow_negative_numbers = true)]
    power_noise: f64,
    /// Start with so much in a battery of the TurtleBot3's size, 0 to 1, that empties [default: one
    /// that never does]
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    charge: Option<f64>,
    /// The laser scanner stands still
    #[arg(long)]
    no_lidar: bool,
    /// Make a symbolic link to the pseudo terminal
    #[arg(long, value_name = "PATH")]
    link: Option<PathBuf>,
    /// The same for the port of the ROS node, which the stock firmware would have
    #[arg(long, value_name = "PATH")]
    node: Option<PathBuf>,
    /// Inject faults at their times (docs/board.md)
    #[arg(long, value_name = "FILE.toml")]
    faults: Option<PathBuf>,
    /// Keep the board's flash in a file
    #[arg(long, value_name = "FILE")]
    flash: Option<PathBuf>,
    /// Write what was true, 200 times a second: speeds, mass, power of drives and rails
    #[arg(long, value_name = "FILE.csv")]
    truth: Option<PathBuf>,
    /// The board's image
    #[arg(long, value_name = "ELF", default_value = IMAGE)]
    image: PathBuf,
    /// Show the board's log (needs defmt-print)
    #[arg(long)]
    log: bool,
    /// Print what was run as JSON, at the end
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    overwrite: OverwriteArgument,
}

pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    check_apart(
        arguments.truth.iter().chain(&arguments.flash).map(PathBuf::as_path),
        [Path::new(&arguments.drive.profile), &arguments.image],
    )?;
    arguments.overwrite.check(&arguments.truth, Form::Truth)?;
    let request = Request {
        image: &arguments.image,
        duration_s: arguments.drive.duration,
        speed: times_real_time(&arguments.speed)?,
        waits_for_clients: !arguments.realtime,
        waits_for_first: arguments.wait,
        link: arguments.link.as_deref(),
        node: arguments.node.as_deref(),
        faults: arguments.faults.as_deref(),
        flash: arguments.flash.as_deref(),
        truth: arguments.truth.as_deref(),
        log: arguments.log,
    };
    let mut line = StatusLine(status_line());
    let answer = session(&request, robot(arguments)?, &mut line)?;
    line.0.finish_and_clear();
    if arguments.json {
        return output::print_json(&answer);
    }
    eprintln!(
        "{:.3} s in {:.3} s: {:.1} × real time, {} exchanges",
        answer.board_s, answer.wall_s, answer.speed, answer.exchanges
    );
    Ok(())
}

fn robot(arguments: &Arguments) -> Result<VirtualRobot> {
    let driven_by_board = arguments.drive.profile == DRIVEN_BY_BOARD;
    let scenario = if driven_by_board {
        let robot = Robot::new(arguments.drive.plant, Kinematics::Differential);
        arguments.drive.scenario_of(ProfileKind::Standstill, robot)?
    } else {
        arguments.drive.scenario(Kinematics::Differential)?
    };
    let options = RobotOptions {
        power_noise_w: arguments.power_noise,
        lidar: !arguments.no_lidar,
        driven_by_board,
        charge: arguments.charge,
    };
    VirtualRobot::new(scenario, options)
}

/// What a terminal shows meanwhile.
struct StatusLine(ProgressBar);

impl Watcher for StatusLine {
    fn links(&mut self, link: &Path, node: &Path) {
        eprintln!("link: {}", link.display());
        eprintln!("node: {}", node.display());
    }

    fn at(&mut self, now: &Progress) {
        self.0.set_message(format!(
            "{:.1} s, {:.1} × real time, {} kg, motors {:.2} W, battery {:.2} W",
            now.board_s, now.speed, now.mass_kg, now.motors_w, now.battery_w
        ));
        self.0.tick();
    }
}

/// A line on standard error; none when that is no terminal.
fn status_line() -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style =
        ProgressStyle::with_template("{spinner} {msg}").unwrap_or_else(|_| ProgressStyle::default_spinner());
    ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr()).with_style(style)
}
