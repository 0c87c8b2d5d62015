//! Why the board started: what its chip and its own last words say.

/// What ended the run before this one. As the control table shows it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum ResetCause {
    /// The supply came.
    #[default]
    PowerOn = 0,
    /// The button, or a probe.
    Pin = 1,
    /// Somebody asked for it.
    Software = 2,
    /// The firmware panicked.
    Panic = 3,
    /// The core faulted.
    Fault = 4,
    /// An interrupt that nobody handles.
    Interrupt = 5,
    /// The non-maskable interrupt.
    NonMaskable = 6,
    /// It hung: the stack ran over, a task stood still, or a clock did not start.
    Hang = 7,
    /// The independent watchdog, with which the stock bootloader is called.
    IndependentWatchdog = 8,
    /// The chip's supply fell too low.
    BrownOut = 9,
}

impl ResetCause {
    /// `None` for a code that this version does not know.
    #[must_use]
    pub const fn from_code(code: u8) -> Option<Self> {
        Some(match code {
            0 => Self::PowerOn,
            1 => Self::Pin,
            2 => Self::Software,
            3 => Self::Panic,
            4 => Self::Fault,
            5 => Self::Interrupt,
            6 => Self::NonMaskable,
            7 => Self::Hang,
            8 => Self::IndependentWatchdog,
            9 => Self::BrownOut,
            _ => return None,
        })
    }

    /// Whether nobody wanted it.
    #[must_use]
    pub const fn is_failure(self) -> bool {
        !matches!(self, Self::PowerOn | Self::Pin | Self::Software | Self::IndependentWatchdog)
    }

    /// In words.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::PowerOn => "power-on",
            Self::Pin => "reset button",
            Self::Software => "asked for",
            Self::Panic => "panic",
            Self::Fault => "fault of the core",
            Self::Interrupt => "interrupt without a handler",
            Self::NonMaskable => "non-maskable interrupt",
            Self::Hang => "hang",
            Self::IndependentWatchdog => "call of the bootloader",
            Self::BrownOut => "brown-out",
        }
    }
}

/// The last reset, and how often nobody wanted one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ResetReport {
    /// Why.
    pub cause: ResetCause,
    /// Where, of a fault: the address of the instruction; the number of an interrupt without a
    /// handler; else 0.
    pub address: u32,
    /// Resets that nobody wanted, since the supply came.
    pub failures: u32,
}

impl ResetReport {
    /// A board that has just got its supply.
    pub const NONE: Self = Self { cause: ResetCause::PowerOn, address: 0, failures: 0 };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_comes_back() {
        for code in 0..=u8::MAX {
            if let Some(cause) = ResetCause::from_code(code) {
                assert_eq!(cause as u8, code);
                assert!(!cause.text().is_empty());
            }
        }
        assert!(ResetCause::from_code(9).is_some() && ResetCause::from_code(10).is_none());
    }
}
