//! What `gmr node` is asked to do, until it is interrupted or a log ends.

use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

#[cfg(feature = "ros")]
use logs::robot::PowerChip;
use logs::robot::Robot;
use model::coefficients::CoefficientsFile;
use model_core::charge::Charge;
use support::context::Context;
use support::error::{Error, Result};
use support::interrupt;

use super::power::LoggedPower;
use super::{Node, Outlet, PowerSource, State, WheelSource, replay};

/// Between two looks at sensor and network: twice as often as the sensor converts.
const NAP: Duration = Duration::from_millis(5);

/// What is asked for.
#[derive(Debug, Clone, Copy)]
pub struct Request<'a> {
    /// The robot, with its sensor.
    pub robot: &'a Robot,
    /// Coefficients; without any there is a battery, but no payload.
    pub coeffs: Option<&'a Path>,
    /// A log in the sensor's place.
    pub replay: Option<&'a Path>,
    /// Where speeds come from in a replay.
    pub wheels: WheelsFrom,
    /// So many times as fast as the log was recorded; none: as fast as it goes.
    pub speed: Option<f64>,
    /// Time between two states, s.
    pub every_s: f64,
    /// Of the battery at the start, where somebody knows it.
    pub charge: Option<Charge<f64>>,
    /// ROS's domain, where it is told.
    pub domain: Option<u16>,
    /// Whether it stays off the network.
    pub no_ros: bool,
}

/// Where speeds come from in a replay.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum WheelsFrom {
    /// From the log
    Log,
    /// From ROS 2, at the log's pace
    Topic,
}

/// Runs a node, which tells `terminal` what it tells the network.
///
/// # Errors
/// Coefficients, log, sensor or network cannot be had; what is asked for cannot be together; nobody
/// takes the states.
pub fn node(context: &Context, request: &Request<'_>, terminal: &mut dyn Outlet) -> Result<()> {
    let Request { robot, speed, every_s, charge, .. } = *request;
    let file = request.coeffs.map(|file| CoefficientsFile::read(file, robot)).transpose()?;
    let coefficients = file.as_ref().map(|file| &file.coefficients);
    let mut node = Node::new(robot, coefficients, charge);
    let Network { wheels, outlet, power } = network(request)?;
    let mut outlets = Outlets { ros: outlet, terminal };
    if request.wheels == WheelsFrom::Log
        && let Some(log) = request.replay
    {
        let stopped = interrupt::catch();
        return replay::rows(context, &mut node, robot, log, (speed, every_s), &mut outlets, stopped)
            .map(|_| ());
    }
    let Some(wheels) = wheels else {
        return Err(Error::usage("--wheels topic with --no-ros: expected speeds from one of log and topic"));
    };
    let mut power = power.map_or_else(|| source(context, request), Ok)?;
    let Some(speed) = speed else {
        return Err(Error::usage(
            "--speed max with --wheels topic: expected a number, for both to keep in step",
        ));
    };
    live(&mut node, &mut *power, wheels, &mut outlets, Pace { speed, every_s })
}

/// How time passes.
struct Pace {
    /// Seconds of the node in a second of the wall's clock.
    speed: f64,
    every_s: f64,
}

/// Until it is interrupted, or the log ends.
fn live(
    node: &mut Node<'_>,
    power: &mut dyn PowerSource,
    mut wheels: Box<dyn WheelSource>,
    outlets: &mut Outlets<'_>,
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
        let is_news = node.lacks_power(power.missing(now));
        if is_news || now >= next {
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
fn source(context: &Context, request: &Request<'_>) -> Result<Box<dyn PowerSource>> {
    if let Some(log) = request.replay {
        return Ok(Box::new(LoggedPower::open(context, log, request.robot)?));
    }
    #[cfg(target_os = "linux")]
    {
        Ok(Box::new(crate::i2c::Sensor::open(request.robot.node())?))
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
    /// Of topics, if it is there.
    power: Option<Box<dyn PowerSource>>,
}

#[cfg(feature = "ros")]
fn network(request: &Request<'_>) -> Result<Network> {
    use crate::ros::Domain;
    if request.no_ros {
        return Ok(Network::default());
    }
    let domain = Domain::join(request.robot, domain(request.domain)?)?;
    let wheels: Option<Box<dyn WheelSource>> =
        if request.replay.is_some() && request.wheels == WheelsFrom::Log {
            None
        } else {
            Some(Box::new(domain.wheels()?))
        };
    let power: Option<Box<dyn PowerSource>> = match request.robot.node().sensor {
        PowerChip::Topics if request.replay.is_none() => Some(Box::new(domain.power(request.robot)?)),
        _ => None,
    };
    Ok(Network { wheels, outlet: Some(Box::new(domain.outlet(request.robot)?)), power })
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
fn network(request: &Request<'_>) -> Result<Network> {
    if request.no_ros {
        return Ok(Network::default());
    }
    Err(Error::usage("this gmr was built without ROS 2 (feature ros); expected --replay LOG --no-ros"))
}

/// Whoever hears.
struct Outlets<'a> {
    ros: Option<Box<dyn Outlet>>,
    terminal: &'a mut dyn Outlet,
}

impl Outlet for Outlets<'_> {
    fn publish(&mut self, state: &State) -> Result<()> {
        if let Some(ros) = &mut self.ros {
            ros.trouble().iter().for_each(|trouble| self.terminal.say(trouble));
            ros.publish(state)?;
        }
        self.terminal.publish(state)
    }
}
