//! What the board logs: through defmt in its images, nowhere on a host.

#[cfg(all(target_os = "none", any(feature = "opencr", feature = "virtual")))]
mod output {
    macro_rules! info {
        ($($argument:tt)*) => { defmt::info!($($argument)*) };
    }
    macro_rules! warning {
        ($($argument:tt)*) => { defmt::warn!($($argument)*) };
    }
    /// A value as its [`Debug`] shows it.
    pub(crate) use defmt::Debug2Format as Shown;
    pub(crate) use {info, warning};
}

#[cfg(not(all(target_os = "none", any(feature = "opencr", feature = "virtual"))))]
mod output {
    macro_rules! nothing {
        ($format:literal $(, $argument:expr)* $(,)?) => {{ $(let _ = &$argument;)* }};
    }
    pub(crate) struct Shown<'a, T>(#[expect(dead_code, reason = "not shown here")] pub(crate) &'a T);
    pub(crate) use {nothing as info, nothing as warning};
}

pub(crate) use output::{Shown, info, warning};
