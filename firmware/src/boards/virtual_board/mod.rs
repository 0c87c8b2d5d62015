//! The board under QEMU (`mps2-an500`, a Cortex-M7): the buses end at a virtual robot on the
//! emulator's host, everything else is the image that the OpenCR runs.
//!
//! Buses take no board time here, save the delay of the servos' answers: what is late on the real
//! board because a bus is slow is not late here.

mod executor;
mod failure;
mod inertial_port;
mod link;
mod queue;
mod robot;
mod sensor_bus;
mod servo_port;
mod store_flash;
mod time;

use defmt_semihosting as _;
use semihosting::process::ExitCode;
use static_cell::{ConstStaticCell, StaticCell};

use crate::exchange::Kind;

/// Bounds what is waited for: board time is the emulator's.
pub use embassy_time::Delay as Limit;
pub use executor::run;
use link::Queues;

pub use inertial_port::InertialPort;
pub use link::Link;
pub use robot::Robot;
pub use sensor_bus::SensorBus;
pub use servo_port::ServoPort;
pub use store_flash::StoreFlash;

/// What the tasks use of the board.
pub struct Board {
    /// The four power sensors.
    pub sensors: SensorBus,
    /// The wheel servos.
    pub servos: ServoPort,
    /// Bounds what is waited for on their bus.
    pub servo_limit: Limit,
    /// The inertial sensor.
    pub inertial: InertialPort,
    /// The host: the port that the ROS node opens, and ours.
    pub links: [Link; 2],
    /// Coefficients, calibration and robot.
    pub store: StoreFlash,
}

/// Starts board time and waits for the robot. To be called once.
pub fn init() -> Board {
    static ROBOT: StaticCell<Robot> = StaticCell::new();
    static QUEUES: ConstStaticCell<[Queues; 2]> = ConstStaticCell::new([const { Queues::new() }; 2]);
    time::start();
    let Some(robot) = Robot::open() else {
        defmt::error!("no files to exchange with a robot in the emulator's folder");
        ExitCode::FAILURE.exit_process()
    };
    let robot = ROBOT.init(robot);
    let [node, host] = QUEUES.take();
    defmt::info!("virtual board: up");
    Board {
        sensors: SensorBus(robot),
        servos: ServoPort::new(robot),
        servo_limit: Limit,
        inertial: InertialPort(robot),
        links: [Link::new(robot, Kind::NodeLink, node), Link::new(robot, Kind::Link, host)],
        store: StoreFlash(robot),
    }
}
