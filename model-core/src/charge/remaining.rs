//! What the gauge tells.

/// How full a battery is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Charge<T> {
    /// Share of the capacity, 0 to 1.
    pub share: T,
    /// Its standard deviation.
    pub std: T,
}

/// Resistance of a whole pack.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resistance<T> {
    /// Within a second of a load step, Ω.
    pub at_once: T,
    /// Its standard deviation, Ω.
    pub std: T,
    /// After minutes of the same load, Ω.
    pub lasting: T,
}

/// What is left until the robot stops: at its cutoff under load, or empty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Remaining<T> {
    /// What the battery still gives at the present load, J.
    pub energy: T,
    /// 95 % interval of the energy, J.
    pub energy_low: T,
    /// Its other end, J.
    pub energy_high: T,
    /// How long that lasts at the mean power of the last minute, s; `None` while nothing is drawn.
    pub time: Option<T>,
    /// That power, W.
    pub load: T,
}
