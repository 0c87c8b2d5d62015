//! Options that several effects have.

use super::entry::{Choice, Values};

/// When an effect begins that is there from the start unless told otherwise.
pub(super) const AT: Choice = Choice {
    name: "at",
    values: Values::Number(0.0, 1e7),
    default: Some(0.0),
    meaning: "when it begins, s since the start",
};

/// When an effect begins whose time nobody knows.
pub(super) const DRAWN_AT: Choice = Choice {
    default: None,
    meaning: "when it begins, s since the start [default: drawn from the seed]",
    ..AT
};

/// The side, for the effects that concern one.
pub(super) const SIDE: Choice = Choice {
    name: "side",
    values: Values::Word(&["left", "right"]),
    default: Some(0.0),
    meaning: "which side",
};
