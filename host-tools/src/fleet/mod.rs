//! Many robots over many days: every log read once into its sums ([`crate::gram`]), what they say of each robot, and since when.

mod abstain;
mod drift;
mod keys;
mod page;
mod rank;
mod source;
mod state;

pub use self::abstain::{Judged, judge};
pub use self::drift::{Change, Drift, changes};
pub use self::page::save;
pub use self::rank::{Standing, rank};
pub use self::source::{Log, find};
pub use self::state::{Outcome, State};
