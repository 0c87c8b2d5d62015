//! Every model and baseline on the same split.
//!
//! Nothing here is chosen for our model alone: the filter's cutoff by models of the literature
//! (`cutoff`), the delay between speeds and power by a regression that is nobody's (`delay`), and a
//! model that takes the mass has a row in which it finds it ([`search`]).

mod adapting;
mod comparison;
mod cutoff;
mod delay;
mod entry;
mod evaluate;
mod figure;
mod mass;
mod own;
mod persistence;
pub mod points;
mod search;
mod settings;
mod split;

pub use self::comparison::{Comparison, compare};
pub use self::entry::{Entry, Horizon, LeftOut, MassSource, Pair, WeightSeeds};
pub use self::evaluate::{Beside, Evaluation, Found, MassSearch, allowed, evaluate, evaluate_all};
pub use self::own::{OWN, Own, names};
pub use self::persistence::persistence_r2;
pub use self::search::{Searched, search};
pub use self::settings::Settings;
pub use self::split::{BLOCK_S, HOLD_OUT, Split};
