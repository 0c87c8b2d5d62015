//! Figures that the paper states for single windows.

/// One window length of Section 8, worst-case start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// s
    pub window_s: f64,
    /// Mass error, %.
    pub mass_percent: f64,
    /// MAPE of the power, %.
    pub mape_percent: f64,
    /// R² of the power.
    pub r2: f64,
}

/// Section 8: moving windows of 12.5 and 50 s.
pub const WINDOWS: [Window; 2] = [
    Window { window_s: 12.5, mass_percent: 19.8, mape_percent: 11.1, r2: 0.68 },
    Window { window_s: 50.0, mass_percent: 11.6, mape_percent: 8.6, r2: 0.79 },
];

/// Section 7.1: mean and standard deviation of the static power, W.
pub const STATIC_W: (f64, f64) = (6.393, 0.29);
