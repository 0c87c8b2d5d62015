//! Effects that a fitted torque model may lack: what each adds to the wheels' torques, or to the
//! power they sum up to.
//!
//! An effect is a [`Term`] times a coefficient. Torque terms add to τ_i of [`crate::torque`] and so
//! pass the winding loss and the clamp as every torque does; supply terms act on the sum of the
//! wheels' powers. With a coefficient of 0 each of them leaves the power as it was.
//!
//! At a known mass and in a known [`Scene`], [`Extended`] gives the power, and the same as a
//! polynomial of the mass. What coefficients hold is a list of [`Column`]s: terms, and what acts on
//! the sensors or has a state of its own. [`live`] runs that list along with the estimator, in real
//! time.

mod columns;
mod course;
mod extended;
mod layout;
pub mod live;
mod term;

pub(crate) use columns::Encoded;
pub use columns::{Cause, Column, Columns, InvalidColumns, MOST_COLUMNS, Needs};
pub use course::{Course, Heat};
pub use extended::Extended;
pub use layout::{Layout, Side};
pub use term::{Effect, Scene, Supply, Term, Torque};

/// Standard gravity, m/s².
pub const GRAVITY: f64 = 9.80665;
