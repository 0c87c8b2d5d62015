//! What makes a log another one than its columns say: speeds in rpm, power in kW, masses in grams,
//! a wheel's sign, a clipped sensor, a late clock.
//!
//! A log is checked against what robot.toml says of the robot (how fast its wheels can turn, what
//! it weighs) and against what driving costs at all. The limits were set so that none of some
//! hundred right logs is suspected: simulated ones of three sets of motors on four layouts of
//! wheels, and measured ones of a Husky (two floors), a Warthog and a TurtleBot3. What a wrong unit
//! makes of a log is a factor of ten and more, so there is room on both sides; a slow drive of an
//! unknown robot may pass in a wrong unit all the same.

mod clipped;
mod doubt;
mod late;
mod masses;
mod powers;
mod signs;
mod speeds;
mod thinned;

pub use doubt::{Kind, Suspicion};
pub use powers::LEAST_W_KG;

use crate::robot::Robot;

/// Looks at the rows of one log.
pub struct Look<'a> {
    robot: &'a Robot,
    rows: thinned::Thinned,
    masses: masses::Masses,
    cells: late::Cells,
}

impl<'a> Look<'a> {
    /// At a log of this robot.
    pub fn new(robot: &'a Robot) -> Self {
        Self {
            robot,
            rows: thinned::Thinned::default(),
            masses: masses::Masses::default(),
            cells: late::Cells::default(),
        }
    }

    /// The next row: its speeds, rad/s, the power of the drives, W, and the total mass, kg, NaN
    /// where it is not told. `fresh` where it does not continue the row before.
    pub fn add(&mut self, time_s: f64, fresh: bool, wheels: &[f64], power_w: f64, mass_kg: f64) {
        let fastest = wheels.iter().fold(0.0_f64, |fastest, speed| fastest.max(speed.abs()));
        let moves = fastest > self.robot.speed_dead_band_rad_s();
        self.masses.add(mass_kg);
        self.cells.add(time_s, fresh, wheels, power_w, mass_kg);
        self.rows.add(thinned::Row::new(wheels, power_w, mass_kg, moves));
    }

    /// What there is to doubt.
    pub fn finish(self) -> Vec<Suspicion> {
        let moving: Vec<&thinned::Row> = self.rows.rows().iter().filter(|row| row.moves).collect();
        let mut suspicions = self.masses.suspicions(self.robot);
        // Fewer rows say nothing about units.
        if moving.len() < LEAST_ROWS {
            return suspicions;
        }
        let power = powers::suspicion(self.robot, &moving);
        // Power in a different unit says nothing about what the speed costs.
        let standing = power.is_none().then(|| self.rows.standing_power_w());
        let speed = speeds::suspicion(self.robot, &moving, standing);
        let is_doubted = speed.is_some() || power.is_some();
        suspicions.extend(speed);
        suspicions.extend(power);
        suspicions.extend(signs::suspicion(self.robot, &moving));
        suspicions.extend(clipped::suspicion(clipped::Quantity::Power, &moving));
        suspicions.extend(clipped::suspicion(clipped::Quantity::Speed, &moving));
        if !is_doubted {
            suspicions.extend(self.cells.suspicion());
        }
        suspicions.sort_by_key(|suspicion| suspicion.kind);
        suspicions
    }
}

/// Fewest rows of a moving robot that are judged.
const LEAST_ROWS: usize = 50;
