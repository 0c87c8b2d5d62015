//! Printing, on the emulator or the host.

/// Prints to the emulator's, or the host's, standard output.
#[macro_export]
#[doc(hidden)]
macro_rules! say {
    ($($argument:tt)*) => {{
        #[cfg(target_os = "none")]
        $crate::target::print(format_args!($($argument)*));
        #[cfg(not(target_os = "none"))]
        print!($($argument)*);
    }};
}
