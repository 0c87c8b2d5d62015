//! What a reproduction is asked for.

use serde::Serialize;

/// What was asked for.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Settings {
    /// The first seed; figures over time show this one.
    pub first_seed: u64,
    /// Number of seeds that figures with a spread are over.
    pub seeds: u64,
    /// Payload windows of the sweep, in s.
    pub windows_s: Vec<u32>,
    /// Names of the baselines.
    pub baselines: Vec<&'static str>,
}

impl Settings {
    /// Which seeds.
    pub(super) fn words(&self) -> String {
        let first = self.first_seed;
        match self.seeds {
            1 => format!("Seed {first}"),
            count => format!("Seeds {first} to {}", first + count.saturating_sub(1)),
        }
    }
}
