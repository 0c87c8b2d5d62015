//! Effects of the user's own: a formula over the columns of the logs, beside those of the
//! dictionary.
//!
//! ```toml
//! [[effect]]
//! id = "door"
//! meaning = "the open door drags in the wind"
//! formula = "abs(wheel1_rad_s) * door_open"
//! unit = "W·s/rad"
//! sign = "positive"
//! range = [0, 5]
//! ```
//!
//! The power that such an effect takes is its coefficient times the formula. Like any effect it is
//! what is new in the field: where the clean runs have the formula's columns too, and the formula
//! varies in them, what it takes there already is none.

mod columns;
mod file;
mod formula;

pub use columns::UserCandidates;
pub use file::{UserEffect, read};
pub use formula::{Formula, Signals};
