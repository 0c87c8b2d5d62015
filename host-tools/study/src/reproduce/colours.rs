//! A method's colour: the same in every figure.

use report::{Colour, palette};

/// Methods in the order of the palette.
pub(super) struct Colours {
    methods: Vec<String>,
}

/// The palette's black is for what was measured.
const METHODS: usize = 6;

impl Colours {
    /// Of these methods; the first six distinguish.
    pub(super) fn of(methods: Vec<String>) -> Self {
        Self { methods }
    }

    pub(super) fn get(&self, method: &str) -> Colour {
        let place = self.methods.iter().position(|known| known == method);
        palette(place.unwrap_or(METHODS - 1) % METHODS)
    }
}

/// What was measured, and truths.
pub(super) fn black() -> Colour {
    palette(METHODS)
}
