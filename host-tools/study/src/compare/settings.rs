//! What a comparison is asked for.

/// Settings of a comparison.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Mass of logs without one, kg.
    pub mass_kg: f64,
    /// Payload window, s.
    pub window_s: f64,
    /// Names of the models to compare.
    pub models: Vec<&'static str>,
    /// Whether models have rows with the mass given and a floor that adapts.
    pub adapt: bool,
}
