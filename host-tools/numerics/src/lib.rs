//! Numerical methods that more than one crate needs, each once.
//!
//! An estimate has its standard error; a search has a typed ending. Its face: [`least_squares`],
//! [`levenberg_marquardt`], [`search`], [`robust`], [`intervals`], [`scaled_inverse`].
//!
//! Callers that share work among cores use rayon's indexed iterators and add the collected parts in
//! order, so the same input gives the same bytes whatever the number of cores.
#![deny(clippy::print_stderr, clippy::print_stdout)]

pub mod intervals;
pub mod least_squares;
pub mod levenberg_marquardt;
pub mod robust;
pub mod scaled_inverse;
pub mod search;
