//! `gmr node`: one power sensor on the robot's own computer and wheel speeds from ROS 2; payload, battery and what is left back to it.

use std::io::IsTerminal as _;
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use logs::robot::{FOUND, PowerChip, Robot};
use logs::with_wheels;
use model::coefficients::CoefficientsFile;
use model_core::charge::Charge;
use node::power::LoggedPower;
use node::{Health, Node, Outlet, PowerSource, State, WheelSource, replay};
use support::context::Context;
use support::error::{Error, Result};
use support::interrupt;

use super::units::UnitArguments;

/// Between two looks at sensor and network: twice as often as the sensor converts.
const NAP: Duration = Duration::from_millis(5);

/// Where nobody watches, a line so often, s, and at every change.
const LINE_S: f64 = 10.0;

/// What is known of a charge that somebody tells, as a share.
const TOLD_STD: f64 = 0.05;

/// Arguments of `gmr node`.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  gmr node --robot robot.toml --coeffs coefficients.toml\n  gmr node --robot robot.toml --coeffs coefficients.toml --replay run.mcap \
    --speed 10\n  gmr node --robot robot.toml --replay run.csv --no-ros --speed max --json"
)]
pub(crate) struct Arguments {
    /// The robot: a robot.toml, whose [node] has sensor and topics, or burger, turtlebot4, warthog, husky; auto: the nearest robot.toml upward, else burger
    #[arg(long, default_value = FOUND)]
    robot: PathBuf,
    /// Coefficients as gmr fit writes them; without any there is a battery, but no payload
    #[arg(long, value_name = "C.toml")]
    coeffs: Option<PathBuf>,
    /// A log in the sensor's place: its power, its voltage (bus_v), and unless --wheels topic its speeds
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

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum WheelsFrom {
    /// From the log
    Log,
    /// From ROS 2, at the log's pace
    Topic,
}

pub(crate) fn run(context: &Context, arguments: &Arguments) -> Result<()> {
    let (context, mut robot) = arguments.units.robot(context, &arguments.robot, [])?;
    robot.set_node(arguments.sensor, arguments.bus.as_deref());
    let robot = robot;
    with_wheels!(robot, run_with(&context, &robot, arguments))
}

fn run_with<const N: usize>(context: &Context, robot: &Robot, arguments: &Arguments) -> Result<()> {
    let every = arguments.every;
    if !(0.01..=3600.0).contains(&every) {
        return Err(Error::usage(format!("--every {every}: expected 0.01 to 3600 s")));
    }
    let charge = match arguments.charge {
        Some(share) if !(0.0..=1.0).contains(&share) => {
            return Err(Error::usage(format!("--charge {share}: expected 0 to 1")));
        }
        share => share.map(|share| Charge { share, std: TOLD_STD }),
    };
    let speed = speed(&arguments.speed)?;
    let file = arguments.coeffs.as_ref().map(|file| CoefficientsFile::<N>::read(file, robot)).transpose()?;
    let coefficients = file.as_ref().map(|file| &file.coefficients);
    let mut node = Node::new(robot, coefficients, charge);
    let Network { wheels, outlet } = network(robot, arguments)?;
    let mut outlets = Outlets { ros: outlet, terminal: Terminal::new(arguments.json) };
    if arguments.wheels == WheelsFrom::Log
        && let Some(log) = &arguments.replay
    {
        let stopped = interrupt::catch();
        return replay::rows(context, &mut node, robot, log, (speed, every), &mut outlets, stopped)
            .map(|_| ());
    }
    let Some(wheels) = wheels else {
        return Err(Error::usage("--wheels topic with --no-ros: expected speeds from one of log and topic"));
    };
    let mut power = source(context, robot, arguments)?;
    let Some(speed) = speed else {
        return Err(Error::usage(
            "--speed max with --wheels topic: expected a number, for both to keep in step",
        ));
    };
    live(&mut node, &mut *power, wheels, &mut outlets, Pace { speed, every_s: every })
}

/// How many times as fast as the log; none: as fast as it goes.
fn speed(written: &str) -> Result<Option<f64>> {
    if written == "max" {
        return Ok(None);
    }
    match written.parse::<f64>() {
        Ok(speed) if (1e-3..=1e6).contains(&speed) => Ok(Some(speed)),
        _ => Err(Error::usage(format!("--speed {written}: expected a number from 0.001 to 1000000, or max"))),
    }
}

/// How time passes.
struct Pace {
    /// Seconds of the node in a second of the wall's clock.
    speed: f64,
    every_s: f64,
}

/// Until it is interrupted, or the log ends.
fn live<const N: usize>(
    node: &mut Node<'_, N>,
    power: &mut dyn PowerSource,
    mut wheels: Box<dyn WheelSource>,
    outlets: &mut Outlets,
    pace: Pace,
) -> Result<()> {
    let stopped = interrupt::catch();
    let began = Instant::now();
    let mut next = pace.every_s;
    while !stopped.load(Ordering::Relaxed) && !power.is_over() {
        let now = pace.speed * began.elapsed().as_secs_f64();
        for (at, reading) in power.take(now)? {
            node.reading(at, reading);
        }
        for message in wheels.take() {
            node.wheels(now, &message);
        }
        if now >= next {
            next = now.max(next + pace.every_s);
            let mut state = node.state(now);
            state.faults.extend(power.faults());
            outlets.publish(&state)?;
        }
        std::thread::sleep(NAP.div_f64(pace.speed.max(1.0)));
    }
    Ok(())
}

/// The sensor, or a log in its place.
fn source(context: &Context, robot: &Robot, arguments: &Arguments) -> Result<Box<dyn PowerSource>> {
    if let Some(log) = &arguments.replay {
        return Ok(Box::new(LoggedPower::open(context, log, robot)?));
    }
    #[cfg(target_os = "linux")]
    {
        Ok(Box::new(node::i2c::Sensor::open(robot.node())?))
    }
    #[cfg(not(target_os = "linux"))]
    {
        Err(Error::usage("a sensor is read on Linux only; expected --replay LOG"))
    }
}

/// The two directions of ROS 2.
#[derive(Default)]
struct Network {
    wheels: Option<Box<dyn WheelSource>>,
    outlet: Option<Box<dyn Outlet>>,
}

#[cfg(feature = "ros")]
fn network(robot: &Robot, arguments: &Arguments) -> Result<Network> {
    use node::ros::Domain;
    if arguments.no_ros {
        return Ok(Network::default());
    }
    let domain = Domain::join(robot, domain(arguments.domain)?)?;
    let wheels: Option<Box<dyn WheelSource>> =
        if arguments.replay.is_some() && arguments.wheels == WheelsFrom::Log {
            None
        } else {
            Some(Box::new(domain.wheels()?))
        };
    Ok(Network { wheels, outlet: Some(Box::new(domain.outlet(robot)?)) })
}

#[cfg(feature = "ros")]
fn domain(told: Option<u16>) -> Result<u16> {
    let number = match (told, std::env::var("ROS_DOMAIN_ID")) {
        (Some(number), _) => number,
        (None, Ok(text)) if !text.is_empty() => text.parse().map_err(|_| {
            Error::usage(format!("ROS_DOMAIN_ID is {text:?}; expected a number from 0 to 232"))
        })?,
        _ => 0,
    };
    // Ports above do not exist (DDSI-RTPS 9.6.1.1).
    if number > 232 {
        return Err(Error::usage(format!("domain {number}: expected 0 to 232")));
    }
    Ok(number)
}

#[cfg(not(feature = "ros"))]
fn network(_: &Robot, arguments: &Arguments) -> Result<Network> {
    if arguments.no_ros {
        return Ok(Network::default());
    }
    Err(Error::usage("this gmr was built without ROS 2 (feature ros); expected --replay LOG --no-ros"))
}

/// Whoever hears.
struct Outlets {
    ros: Option<Box<dyn Outlet>>,
    terminal: Terminal,
}

impl Outlet for Outlets {
    fn publish(&mut self, state: &State) -> Result<()> {
        if let Some(ros) = &mut self.ros {
            ros.trouble().iter().for_each(|trouble| eprintln!("{trouble}"));
            ros.publish(state)?;
        }
        self.terminal.publish(state)
    }
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
    fn publish(&mut self, state: &State) -> Result<()> {
        if self.json {
            println!("{}", support::output::json_line(state)?);
            return support::output::finish();
        }
        let is_due =
            self.last.is_none_or(|(before, at)| before != state.state || state.time_s - at >= LINE_S);
        if self.is_redrawn && self.last.is_some_and(|(before, _)| before == state.state) {
            support::output::redraw(1);
        } else if !is_due {
            return Ok(());
        }
        self.last = Some((state.state, state.time_s));
        println!("{}", state.line());
        // Whoever reads this may have left.
        support::output::finish()
    }
}
