//! Options that several effects have.

use super::entry::{Choice, Values};

/// Onset of an effect that is present from the start by default.
pub(super) const AT: Choice = Choice {
    name: "at",
    values: Values::Number(0.0, 1e7),
    default: Some(0.0),
    meaning: "when it begins, s since the start",
};

/// Onset of an effect that is drawn at random.
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
