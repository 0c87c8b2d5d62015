//! The error byte of a status.

/// Set beside any code: the device has an alert; its register 70 says which.
pub const ALERT: u8 = 0x80;

/// Why an instruction was not carried out (e-manual, Protocol 2.0, Status Packet).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Refusal {
    /// It failed.
    Result = 1,
    /// There is no such instruction.
    Instruction = 2,
    /// Its checksum did not match.
    Checksum = 3,
    /// A value is outside its range.
    Range = 4,
    /// Fewer or more data than the register has.
    Length = 5,
    /// A value is beyond a limit.
    Limit = 6,
    /// The register cannot be written, or not now.
    Access = 7,
}

impl Refusal {
    /// The refusal in an error byte, alert apart; `None` for none or an unknown one.
    #[must_use]
    pub const fn from_error(error: u8) -> Option<Self> {
        Some(match error & !ALERT {
            1 => Self::Result,
            2 => Self::Instruction,
            3 => Self::Checksum,
            4 => Self::Range,
            5 => Self::Length,
            6 => Self::Limit,
            7 => Self::Access,
            _ => return None,
        })
    }
}
