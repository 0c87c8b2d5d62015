//! What a robot carries, and draws besides driving.

/// What the robot carries and draws besides driving.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Load {
    /// Total mass, kg.
    pub mass_kg: f64,
    /// Its standard deviation, kg.
    pub mass_std_kg: f64,
    /// Static power, W, where it is known.
    pub static_w: Option<f64>,
    /// Its standard deviation, W.
    pub static_std_w: f64,
}
