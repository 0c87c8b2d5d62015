//! The board's inertial sensor, and the robot's orientation from it.
//!
//! Two chips are fitted to OpenCRs, an MPU-9250 or an ICM-20648 ([`Chip`] asks which). Both measure
//! rotation and acceleration; the first has a magnetometer besides, which is not read: motors and
//! their currents are its nearest magnets, and the stock firmware keeps it out of its orientation
//! too.
//!
//! ```text
//! Chip: probe, set-up, reading, brown-outs ── Tracker: bias at rest, VQF, one yaw of all sources
//!                                     heading from the wheels ──┘
//! ```

mod chip;
#[cfg(test)]
mod testing;
mod tracker;

pub use chip::{Chip, Fault, Motion};
pub use tracker::Tracker;

/// Which chip there is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum ChipModel {
    /// TDK InvenSense MPU-9250.
    Mpu9250 = 1,
    /// TDK InvenSense ICM-20648.
    Icm20648 = 2,
}

/// Whether the sensor can be believed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum InertialHealth {
    /// It tells the orientation.
    Ok = 0,
    /// None has ever answered.
    #[default]
    Absent = 1,
    /// Its bias is not known yet: the robot has not stood still for long enough.
    Settling = 2,
    /// It has answered, and does not any more.
    Lost = 3,
}

impl InertialHealth {
    /// `None` for a code that this version does not know.
    #[must_use]
    pub const fn from_code(code: u8) -> Option<Self> {
        Some(match code {
            0 => Self::Ok,
            1 => Self::Absent,
            2 => Self::Settling,
            3 => Self::Lost,
            _ => return None,
        })
    }
}

/// What is known of the sensor, and by it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct InertialSnapshot {
    /// Of the sensor.
    pub health: InertialHealth,
    /// Which one, once it has answered.
    pub model: Option<ChipModel>,
    /// Readings that failed since it answered first, whatever the reason.
    pub errors: u32,
    /// Times that it was set up anew after its first time.
    pub restarts: u32,
    /// rad/s, forward, left, up, bias taken off.
    pub rotation: Option<[f32; 3]>,
    /// m/s², likewise.
    pub acceleration: Option<[f32; 3]>,
    /// Bias of the gyroscope, rad/s.
    pub bias: Option<[f32; 3]>,
    /// The bias is being learned anew, or waits for standstill.
    pub is_calibrating: bool,
    /// Unit quaternion w, x, y, z; `None` before the first look.
    pub orientation: Option<[f32; 4]>,
}

impl InertialSnapshot {
    /// Before anybody asked.
    pub const UNKNOWN: Self = Self {
        health: InertialHealth::Absent,
        model: None,
        errors: 0,
        restarts: 0,
        rotation: None,
        acceleration: None,
        bias: None,
        is_calibrating: false,
        orientation: None,
    };
}
