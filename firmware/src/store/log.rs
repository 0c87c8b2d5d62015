//! Where the next record of the totals goes.

/// Of one sector.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Log {
    pub(super) sector: u32,
    /// Number of the record's place.
    pub(super) next: usize,
}

impl Log {
    /// Of a sector that is still empty.
    pub(super) const fn new(sector: u32) -> Self {
        Self { sector, next: 0 }
    }
}
