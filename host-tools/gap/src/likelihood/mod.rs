//! One likelihood of every cause: it weighs what the rules name.
//!
//! A hierarchical Gaussian model of clean and field runs: the base's parameters, what the model's
//! form gets wrong in all runs alike and from run to run, the noise, and in the field one effect of
//! the dictionary. All but the effect is integrated out; causes are compared by what is left, and
//! [`priors`] has every prior with its reason. All field runs take part: none is locked.

pub mod asked;
pub mod bagged;
pub mod delay;
pub mod evidence;
pub mod functions;
pub mod gate;
pub mod normal;
pub mod posterior;
pub mod predicted;
pub mod priors;
pub mod products;
pub mod question;
pub mod relinearise;
pub mod rows;
pub mod scored;
pub mod step_times;
#[cfg(test)]
mod tests;
pub mod variances;
pub mod ways;
pub mod wrong_masses;

pub use gate::Gate;

/// The level of the gate, where none is asked for.
pub const LEVEL: f64 = 0.02;
