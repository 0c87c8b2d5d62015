//! What the board logs: through defmt in its images, nowhere on a host.

/// An event that was to be expected.
macro_rules! info {
    ($($argument:tt)*) => {
        #[cfg(all(target_os = "none", any(feature = "opencr", feature = "virtual")))]
        defmt::info!($($argument)*);
    };
}

/// Something is not as it should be, and the board goes on.
macro_rules! warning {
    ($($argument:tt)*) => {
        #[cfg(all(target_os = "none", any(feature = "opencr", feature = "virtual")))]
        defmt::warn!($($argument)*);
    };
}

pub(crate) use {info, warning};
