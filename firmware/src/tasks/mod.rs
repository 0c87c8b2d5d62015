//! What the board does all the time, over drivers of any board.

mod link;

pub use link::Connection;
