//! The command line of `gmr node`, which is also that of `gmr-node`.

use std::io::IsTerminal as _;
use std::path::PathBuf;

use logs::arguments::{UnitArguments, times_real_time};
use logs::robot::{FOUND, PowerChip};
use model_core::charge::Charge;
use support::context::Context;
use support::error::{Error, Result};
use support::output;

use super::{Health, Outlet, Request, State, WheelsFrom, node};

/// Where nobody watches, a line so often, s, and at every change.
const LINE_S: f64 = 10.0;

/// What is known of a charge that somebody tells, as a share.
const TOLD_STD: f64 = 0.05;

/// Arguments of `gmr node`.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  gmr node --robot robot.toml --coeffs coefficients.toml\n  gmr node --robot robot.toml --coeffs coefficients.toml --replay run.csv \
    --speed 10\n  gmr node --robot robot.toml --replay run.csv --no-ros --speed max --json"
)]
pub struct Arguments {
    /// The robot: a robot.toml, whose [node] has sensor and topics, or burger, turtlebot4, warthog,
    /// husky; auto: the nearest robot.toml upward, else burger
    #[arg(long, default_value = FOUND)]
    robot: PathBuf,
    /// Coefficients as gmr fit writes them; without any there is a battery, but no payload
    #[arg(long, value_name = "C.toml")]
    coeffs: Option<PathBuf>,
    /// A log in the sensor's place: its power, its voltage (bus_v), and unless --wheels topic its
    /// speeds
    #[arg(long, value_name = "LOG")]
    replay: Option<PathBuf>,
    /// Where speeds come from in a replay
    #[arg(long, value_enum, default_value = "log", requires = "replay")]
    wheels: WheelsFrom,
    /// So many times as fast as the log was recorded, or max
    #[arg(long, value_name = "FACTOR", default_value = "1", requires = "replay")]
    speed: String,
    /// Time between two messages of each topic, s
    #[arg(long, value_name = "S", default_value_t = 1.0, allow_negative_numbers = true)]
    every: f64,
    /// Charge of the battery at the start, 0 to 1, if you know it; it is taken as known to 5 points
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    charge: Option<f64>,
    /// The sensor's chip [default: of robot.toml, else ina219]
    #[arg(long, value_enum)]
    sensor: Option<PowerChip>,
    /// Its bus [default: of robot.toml, else /dev/i2c-1]
    #[arg(long, value_name = "/dev/i2c-N")]
    bus: Option<String>,
    /// ROS's domain [default: ROS_DOMAIN_ID, else 0]
    #[arg(long, value_name = "0…232")]
    domain: Option<u16>,
    /// Stay off the network: for a replay
    #[arg(long, requires = "replay")]
    no_ros: bool,
    /// A line of JSON for each look, on standard output
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    units: UnitArguments,
}

/// Runs it.
///
/// # Errors
/// As [`node`]; numbers out of their ranges.
pub fn run(context: &Context, arguments: &Arguments) -> Result<()> {
    let (context, mut robot) = arguments.units.robot(context, &arguments.robot, [])?;
    robot.set_node(arguments.sensor, arguments.bus.as_deref());
    let every_s = arguments.every;
    if !(0.01..=3600.0).contains(&every_s) {
        return Err(Error::usage(format!("--every {every_s}: expected 0.01 to 3600 s")));
    }
    let charge = match arguments.charge {
        Some(share) if !(0.0..=1.0).contains(&share) => {
            return Err(Error::usage(format!("--charge {share}: expected 0 to 1")));
        }
        share => share.map(|share| Charge { share, std: TOLD_STD }),
    };
    let request = Request {
        robot: &robot,
        coeffs: arguments.coeffs.as_deref(),
        replay: arguments.replay.as_deref(),
        wheels: arguments.wheels,
        speed: times_real_time(&arguments.speed)?,
        every_s,
        charge,
        domain: arguments.domain,
        no_ros: arguments.no_ros,
    };
    node(&context, &request, &mut Terminal::new(arguments.json))
}

/// Standard output: lines of JSON, a line that is drawn again, or a log of what changes.
struct Terminal {
    json: bool,
    is_redrawn: bool,
    last: Option<(Health, f64)>,
}

impl Terminal {
    fn new(json: bool) -> Self {
        Self { json, is_redrawn: std::io::stdout().is_terminal() && !json, last: None }
    }
}

impl Outlet for Terminal {
    fn say(&mut self, trouble: &str) {
        output::say(format_args!("{trouble}"));
    }

    fn publish(&mut self, state: &State) -> Result<()> {
        if self.json {
            output::print(format_args!("{}\n", output::json_line(state)?));
            return output::finish();
        }
        let is_due =
            self.last.is_none_or(|(before, at)| before != state.state || state.time_s - at >= LINE_S);
        if self.is_redrawn && self.last.is_some_and(|(before, _)| before == state.state) {
            output::redraw(1);
        } else if !is_due {
            return Ok(());
        }
        self.last = Some((state.state, state.time_s));
        output::print(format_args!("{}\n", state.line()));
        // Whoever reads this may have left.
        output::finish()
    }
}
