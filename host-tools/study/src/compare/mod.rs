//! Every model and baseline on the same split.
//!
//! Nothing here is chosen for our model alone. Models of the literature choose the filter's cutoff
//! (`cutoff`). A neutral regression chooses the delay between speeds and power (`delay`). A model
//! that takes the mass also has a row with an estimated one ([`search`]).

mod adapting;
mod comparison;
mod cutoff;
mod delay;
mod entry;
mod evaluate;
mod figure;
mod mass;
mod ours;
mod persistence;
pub mod points;
mod search;
mod settings;
mod split;

pub use self::comparison::{Comparison, compare};
pub use self::entry::{Entry, Horizon, LeftOut, MassSource, Pair, WeightSeeds};
pub use self::evaluate::{Beside, Evaluation, MassSearch, WithoutMass, allowed, evaluate, evaluate_all};
pub use self::ours::{OURS, OurModel, names};
pub use self::persistence::persistence_r2;
pub use self::search::{Searched, search};
pub use self::settings::Settings;
pub use self::split::{BLOCK_S, HOLD_OUT, Split};
