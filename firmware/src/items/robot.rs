//! Which robot the board is built into: coefficients for another one are refused.
//!
//! | offset | bytes | what |
//! |---|---|---|
//! | 0 | 4 | magic `GMRR` |
//! | 4 | 2 | format version, 1 |
//! | 6 | 2 | length of the image, checksum included: 44 + 12 N |
//! | 8 | 1 | wheels N |
//! | 9 | 3 | 0 |
//! | 12 | 24 | robot name, UTF-8, padded with zeros |
//! | 36 | 4 | radius of gyration about the vertical axis, f32, m |
//! | 40 | 12 N | R, f32, rows vx, vy (m), ω (dimensionless), one column a wheel |
//! | 40 + 12 N | 4 | CRC-32 (ISO-HDLC) of all before |

use model_core::coefficients::{NAME_BYTES, Name, Robot};
use model_core::kinematics::Kinematics;
use model_core::plausibility::MOST_LENGTH;

use super::frame::{FRAME, open, seal};
use crate::bytes::Reader;
use crate::control_table::Reason;
use crate::wheels::WHEELS;

/// Bytes of the image.
pub const ROBOT_BYTES: usize = FRAME + 4 + NAME_BYTES + 4 + 12 * WHEELS;

const MAGIC: [u8; 4] = *b"GMRR";

/// Lengths that differ by less, relatively, are the same: each side may have rounded them to single
/// precision its own way.
const SAME: f32 = 1e-6;

/// Name and geometry of the robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RobotIdentity {
    /// Not empty.
    pub name: Name,
    /// About the vertical axis, m.
    pub gyration_radius: f32,
    /// R: rows vx, vy (m), ω (dimensionless), one column a wheel.
    pub rows: [[f32; WHEELS]; 3],
}

impl Default for RobotIdentity {
    /// [`Self::BURGER`]
    fn default() -> Self {
        Self::BURGER
    }
}

impl RobotIdentity {
    /// TurtleBot3 Burger: wheels of 0.033 m, 0.160 m apart (ROBOTIS specification); radius of
    /// gyration as in `gmr`'s built-in description.
    pub const BURGER: Self = {
        const WHEEL_RADIUS: f32 = 0.033;
        const TRACK: f32 = 0.160;
        const FORWARD: f32 = WHEEL_RADIUS / 2.0;
        const TURN: f32 = WHEEL_RADIUS / TRACK;
        Self {
            name: Name::literal("TurtleBot3 Burger"),
            gyration_radius: 0.064,
            rows: [[FORWARD, FORWARD], [0.0, 0.0], [-TURN, TURN]],
        }
    };

    /// Of the robot that these coefficients are for.
    #[must_use]
    pub fn of(robot: &Robot<f32, WHEELS>) -> Self {
        Self { name: robot.name, gyration_radius: robot.gyration_radius, rows: *robot.kinematics.rows() }
    }

    /// Whether coefficients for `robot` are for this one.
    #[must_use]
    pub fn is(&self, robot: &Robot<f32, WHEELS>) -> bool {
        let same = |a: f32, b: f32| (a - b).abs() <= SAME * a.abs().max(b.abs());
        let rows = self.rows.iter().flatten().zip(robot.kinematics.rows().iter().flatten());
        self.name == robot.name
            && same(self.gyration_radius, robot.gyration_radius)
            && rows.into_iter().all(|(ours, theirs)| same(*ours, *theirs))
    }

    /// The image.
    #[must_use]
    pub fn encode(&self) -> [u8; ROBOT_BYTES] {
        seal(MAGIC, |body| {
            body.put([WHEELS as u8, 0, 0, 0]);
            body.put(*self.name.as_bytes());
            body.put(self.gyration_radius.to_le_bytes());
            self.rows.iter().flatten().for_each(|entry| body.put(entry.to_le_bytes()));
        })
    }

    /// Reads an image back.
    ///
    /// # Errors
    /// The first thing that is wrong with it.
    pub fn decode(image: &[u8]) -> Result<Self, Reason> {
        let mut body = Reader(open(MAGIC, image)?);
        let [wheels, reserved @ ..] = body.take::<4>().ok_or(Reason::Length)?;
        if usize::from(wheels) != WHEELS {
            return Err(Reason::Wheels);
        }
        let name = body.take().ok_or(Reason::Length)?;
        let gyration_radius = body.take().map(f32::from_le_bytes).ok_or(Reason::Length)?;
        let mut rows = [[0.0; WHEELS]; 3];
        for entry in rows.iter_mut().flatten() {
            *entry = body.take().map(f32::from_le_bytes).ok_or(Reason::Length)?;
        }
        if !body.0.is_empty() {
            return Err(Reason::Length);
        }
        let name = Name::from_bytes(name).filter(|name| !name.as_str().is_empty()).ok_or(Reason::Value)?;
        // Comparisons that NaN fails.
        let is_length = |value: f32| value.abs() <= MOST_LENGTH as f32;
        let is_robot = reserved == [0; 3]
            && gyration_radius > 0.0
            && is_length(gyration_radius)
            && rows.iter().flatten().all(|entry| is_length(*entry))
            && Kinematics::from_rows(rows).is_ok();
        if is_robot { Ok(Self { name, gyration_radius, rows }) } else { Err(Reason::Value) }
    }
}
