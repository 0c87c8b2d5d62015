//! How full the battery is, what it can still give, and what its resistance is: from its current
//! and voltage alone.
//!
//! A voltage says little of the charge while current flows: a pack of 0.2 Ω lies 0.4 V low at 2 A,
//! a third of the whole scale. So the current is counted, and the voltage corrects the count by as
//! much as it can be trusted: much at rest, where it is that of the [`Curve`], less under load,
//! where resistance and polarisation are only as well known as load steps have shown them
//! ([`Gauge`]).
//!
//! Per sample a few sums; once a second a filter of five states. What is not known yet is unknown,
//! not a number.

mod curve;
mod filter;
mod gauge;
mod pack;
mod remaining;

pub use curve::{Curve, MOST_POINTS, Point};
pub use gauge::{Gauge, Start, USUAL_RESISTANCE_OHM};
pub use pack::{InvalidPack, Pack};
pub use remaining::{Charge, Remaining, Resistance};
