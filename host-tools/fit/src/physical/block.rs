//! Power of many rows at once, and what it changes by: loops over rows without a branch, which
//! compilers turn into instructions that take several rows each.

use model_core::motion::Wheel;
use model_core::torque::{Drive, TorqueModel};

use super::super::dataset::Stretch;
use super::cost::{BRIDGE_DROP, PARAMETERS, WINDING_LOSS, along};

/// Rows of a block.
pub(super) const ROWS: usize = 64;

/// One number a row.
pub(super) type Column = [f64; ROWS];

/// One wheel of every row.
struct Wheels {
    speed: Column,
    acceleration: Column,
    inertial_torque: Column,
    direction: Column,
    scrub: Column,
    side: Column,
}

impl Wheels {
    const AT_REST: Self = {
        let none = [0.0; ROWS];
        Self {
            speed: none,
            acceleration: none,
            inertial_torque: none,
            direction: none,
            scrub: none,
            side: none,
        }
    };

    fn put(&mut self, row: usize, wheel: &Wheel<f64>) {
        self.speed[row] = wheel.speed;
        self.acceleration[row] = wheel.acceleration;
        self.inertial_torque[row] = wheel.inertial_torque;
        self.direction[row] = wheel.direction;
        self.scrub[row] = wheel.scrub;
        self.side[row] = wheel.side;
    }

    #[inline(always)]
    fn at(&self, row: usize) -> Wheel<f64> {
        Wheel {
            speed: self.speed[row],
            acceleration: self.acceleration[row],
            inertial_torque: self.inertial_torque[row],
            direction: self.direction[row],
            scrub: self.scrub[row],
            side: self.side[row],
        }
    }
}

/// Rows and what a model makes of them. Rows that a block lacks have wheels at rest and no power,
/// so they add nothing to any sum.
pub(super) struct Block {
    /// Least power of a wheel, W.
    floor: f64,
    mass: Column,
    wheels: Wheels,
    /// Torque of these wheels, N·m, and what their power changes by with it; 0 where clamped.
    torque: Column,
    by: Column,
    /// Measured less predicted power, W.
    pub(super) residual: Column,
    /// ∂P/∂θ, a column for each parameter.
    pub(super) slopes: [Column; PARAMETERS],
}

impl Block {
    /// Without rows yet.
    pub(super) fn new(drive: Drive) -> Self {
        let floor = match drive {
            Drive::Dissipative => 0.0,
            Drive::Regenerative => f64::NEG_INFINITY,
        };
        let none = [0.0; ROWS];
        let slopes = [none; PARAMETERS];
        Self { floor, mass: none, wheels: Wheels::AT_REST, torque: none, by: none, residual: none, slopes }
    }

    /// Takes these rows, [`ROWS`] at most, and finds what the model leaves of their power.
    pub(super) fn predict(&mut self, torque: &TorqueModel<f64>, rows: Stretch<'_>) {
        self.take(torque, rows, |_, _| {});
    }

    /// The same with the slopes.
    pub(super) fn differentiate(&mut self, torque: &TorqueModel<f64>, rows: Stretch<'_>) {
        self.slopes = [[0.0; ROWS]; PARAMETERS];
        self.take(torque, rows, Self::add_slopes);
    }

    fn take(
        &mut self,
        torque: &TorqueModel<f64>,
        rows: Stretch<'_>,
        wheel_taken: impl Fn(&mut Self, &TorqueModel<f64>),
    ) {
        let others = rows.others();
        if others.len() < ROWS {
            (self.mass, self.residual) = ([0.0; ROWS], [0.0; ROWS]);
            self.wheels = Wheels::AT_REST;
        }
        for (row, (mass, residual)) in others.iter().zip(self.mass.iter_mut().zip(&mut self.residual)) {
            (*mass, *residual) = (row.mass, row.power);
        }
        let (wheels, wheels_a_row) = rows.wheels();
        for place in 0..wheels_a_row {
            for (row, of_row) in wheels.chunks_exact(wheels_a_row).take(ROWS).enumerate() {
                self.wheels.put(row, &of_row[place]);
            }
            self.subtract(torque);
            wheel_taken(self, torque);
        }
    }

    /// Subtracts the power of these wheels from the residuals.
    #[inline(never)]
    fn subtract(&mut self, torque: &TorqueModel<f64>) {
        let (model, draw, floor) = (*torque, torque.draw(), self.floor);
        let Self { mass, wheels, torque, by, residual, .. } = self;
        for row in 0..ROWS {
            let wheel = wheels.at(row);
            let total = model.torque(&wheel, mass[row]);
            let power = draw.power(wheel.speed, total);
            // A factor: a branch would leave the loop one row an instruction.
            let drawn = f64::from(u8::from(power >= floor));
            residual[row] -= drawn * power;
            torque[row] = drawn * total;
            by[row] = drawn * draw.slope(wheel.speed, total);
        }
    }

    /// Adds what the power of these wheels changes by.
    #[inline(never)]
    fn add_slopes(&mut self, torque: &TorqueModel<f64>) {
        let model = *torque;
        let Self { mass, wheels, torque, by, slopes, .. } = self;
        for row in 0..ROWS {
            let along = along(&model, &wheels.at(row), mass[row]);
            for (slopes, along) in slopes.iter_mut().zip(along) {
                slopes[row] += by[row] * along;
            }
            slopes[WINDING_LOSS][row] += torque[row] * torque[row];
            slopes[BRIDGE_DROP][row] += torque[row].abs();
        }
    }
}

/// Σ a b.
pub(super) fn dot(a: &Column, b: &Column) -> f64 {
    let mut sums = [0.0; 8];
    for (a, b) in a.as_chunks::<8>().0.iter().zip(b.as_chunks::<8>().0) {
        for lane in 0..8 {
            sums[lane] += a[lane] * b[lane];
        }
    }
    sums.iter().sum()
}
