//! Power and payload models of wheeled robots.
//!
//! What the controller board computes and what the host fits and replays, once: `no_std`, no
//! allocation, no panics, and no `unsafe` but for the
//! instructions that no safe code reaches ([`real`], [`block`]). Everything is generic
//! over the number of wheels `N` and over the scalar (`f32` on the board, `f64` on the host). Units
//! are SI throughout. "Eq. n" cites the paper named in the README.
//!
//! The way of a sample: [`estimator`] filters speed and power with one [`filter`], forms the
//! wheels' [`motion`], asks the [`model`] for the power as a polynomial of the mass, and hands that
//! to a [`payload`] estimator.
#![no_std]

#[cfg(test)]
extern crate std;

pub mod adapt;
pub mod block;
pub mod board;
pub mod charge;
pub mod clamp;
pub mod coefficients;
mod conditioner;
pub mod conditioning;
pub mod delay;
pub mod effects;
pub mod energy;
pub mod eq18;
pub mod estimator;
pub mod filter;
pub mod gyro;
pub mod kinematics;
pub mod model;
pub mod motion;
pub mod payload;
pub mod plausibility;
pub mod polynomial;
pub mod quadratic;
pub mod real;
mod sample;
pub mod slip;
pub mod torque;
