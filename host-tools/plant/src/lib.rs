//! The simulated robot: a forward simulation that shares no formula and no code with `model-core`.
//!
//! A wheel speed loop sets voltages ([`controller`]), windings and rotors answer ([`motor`]), gears
//! pass torque with a loss ([`gear`]), and one rigid body couples the wheels that roll on the floor
//! ([`body`]). Sensors turn what is true into what a log shows ([`sensors`]). [`sets`] has the
//! robots, [`profile`] and [`payload`] what they do, [`effects`] what may differ from what a fit
//! knew, from a slope to a wrong sensor. [`rails`] are the supplies of a robot that has such a
//! board, [`battery`] the charge behind them.
//!
//! Its face: [`simulate`] of a [`Scenario`], and [`log`] to write it.
#![deny(clippy::print_stderr, clippy::print_stdout)]

pub mod battery;
pub mod body;
pub mod controller;
pub mod drive;
pub mod effects;
pub mod encoder;
pub mod experiment;
pub mod field;
pub mod gear;
mod imu;
pub mod ina219;
pub mod kinematics;
pub mod log;
pub mod motion;
pub mod motor;
pub mod noise;
pub mod payload;
pub mod profile;
pub mod rails;
pub mod scenario;
pub mod sensors;
pub mod sets;
mod simulation;
#[cfg(test)]
mod tests;

pub use effects::Effect;
pub use field::Field;
pub use kinematics::{Geometry, Kinematics, MAX_WHEELS};
pub use log::{Column, Columns};
pub use payload::PayloadSchedule;
pub use profile::{Profile, ProfileKind, Rounds};
pub use scenario::Scenario;
pub use sensors::Sensors;
pub use sets::{PlantSet, Robot};
pub use simulation::{Record, Sample, Simulation, simulate};
