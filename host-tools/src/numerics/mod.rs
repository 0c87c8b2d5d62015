//! Numerical methods that more than one room needs, each once: what is estimated here has its error, what is searched for here
//! has a typed ending.
//!
//! Where work is shared among cores, it is by rayon's indexed iterators, collected in order: a sum is taken over the collected
//! parts, never by a parallel reduction, so the same input gives the same bytes whatever the number of cores.

pub mod intervals;
pub mod least_squares;
pub mod levenberg_marquardt;
pub mod robust;
pub mod scaled_inverse;
pub mod search;
