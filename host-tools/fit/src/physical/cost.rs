//! The clamped cost and its derivatives, summed over rows.

use model_core::motion::Wheel;
use model_core::torque::{self, Drive, TorqueModel};
use nalgebra::{Const, SMatrix, SVector};
use numerics::levenberg_marquardt::LeastSquares;
use rayon::prelude::*;

use super::super::dataset::{Kept, Stretch};
use super::block::{self, Block, dot};

/// How many parameters there are: what both sides share, their imbalance, the losses of gear and
/// bridge, and the share of the friction that passes the gear.
pub const PARAMETERS: usize = torque::PARAMETERS + 4;

/// In the order of [`TorqueModel::to_array`], then the imbalance, the losses of gear and bridge,
/// and the share of the friction that passes the gear.
pub type Parameters = SVector<f64, PARAMETERS>;

type Matrix = SMatrix<f64, PARAMETERS, PARAMETERS>;

/// Place of κ, which multiplies no part of the torque.
pub(super) const WINDING_LOSS: usize = 5;

/// Place of the imbalance: the one parameter of either sign.
pub const IMBALANCE: usize = torque::PARAMETERS;

/// Place of the gear's loss.
pub const GEAR_LOSS: usize = IMBALANCE + 1;

/// Place of the bridge's drop, which multiplies no part of the torque either.
pub const BRIDGE_DROP: usize = GEAR_LOSS + 1;

/// Place of the share of the friction that passes the gear. It is part of the form, so no search
/// moves it.
pub(super) const WHEEL_FRICTION_SHARE: usize = BRIDGE_DROP + 1;

/// What a residual of r W costs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Loss {
    /// r².
    Squares,
    /// r² up to this size k in W, then k (2 |r| − k) (Huber 1964).
    Huber(f64),
}

impl Loss {
    fn of(self, residual: f64) -> f64 {
        match self {
            Self::Huber(size) if residual.abs() > size => size * (2.0 * residual.abs() - size),
            _ => residual * residual,
        }
    }

    /// What a squared residual has to be multiplied by to pull as this does.
    pub(super) fn weight(self, residual: f64) -> f64 {
        match self {
            Self::Huber(size) if residual.abs() > size => size / residual.abs(),
            _ => 1.0,
        }
    }
}

/// The cost of rows.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cost<'a> {
    pub(super) rows: Stretch<'a>,
    pub(super) drive: Drive,
    pub(super) loss: Loss,
    /// Parameters that may move: nobody asks for the slopes of the others.
    pub(super) free: [bool; PARAMETERS],
}

/// Rows that are summed by one core at a time. Their sums are added in the order of the rows.
const CHUNK: usize = 2048;

/// The model of these parameters.
pub fn torque(parameters: &Parameters) -> TorqueModel<f64> {
    let shared = parameters.fixed_rows::<{ torque::PARAMETERS }>(0).into_owned();
    TorqueModel {
        imbalance: parameters[IMBALANCE],
        gear_loss: parameters[GEAR_LOSS],
        bridge_drop: parameters[BRIDGE_DROP],
        wheel_friction_share: parameters[WHEEL_FRICTION_SHARE],
        ..TorqueModel::from_array(shared.into())
    }
}

/// The parameters of a model.
pub fn parameters(torque: &TorqueModel<f64>) -> Parameters {
    let shared = torque.to_array();
    let others = [torque.imbalance, torque.gear_loss, torque.bridge_drop, torque.wheel_friction_share];
    Parameters::from_fn(|i, _| *shared.get(i).unwrap_or_else(|| &others[i - IMBALANCE]))
}

/// ∂τ/∂θ of a wheel: N·m per unit of each parameter.
#[inline(always)]
pub(super) fn along(torque: &TorqueModel<f64>, wheel: &Wheel<f64>, mass: f64) -> [f64; PARAMETERS] {
    let slope = torque.gear_slope(wheel, mass);
    let load = mass * (1.0 + slope);
    let friction = 1.0 + torque.wheel_friction_share * slope;
    [
        friction * wheel.direction,
        wheel.direction * load,
        friction * wheel.speed,
        wheel.acceleration,
        load * wheel.inertial_torque,
        0.0,
        load * wheel.scrub,
        friction * wheel.side,
        torque.gear_share(wheel, mass),
        0.0,
        0.0,
    ]
}

/// Power of a row, W, and its slope; the slope is 0 where no wheel draws power.
pub fn predict(torque: &TorqueModel<f64>, row: &Kept<'_>, drive: Drive) -> (f64, Parameters) {
    let mut power = 0.0;
    let mut slope = Parameters::zeros();
    let draw = torque.draw();
    for wheel in row.wheels {
        let total = torque.torque(wheel, row.mass);
        let wheel_power = draw.power(wheel.speed, total);
        if wheel_power < 0.0 && drive == Drive::Dissipative {
            continue;
        }
        power += wheel_power;
        let by = draw.slope(wheel.speed, total);
        for (slope, along) in slope.iter_mut().zip(along(torque, wheel, row.mass)) {
            *slope += by * along;
        }
        slope[WINDING_LOSS] += total * total;
        slope[BRIDGE_DROP] += total.abs();
    }
    (power, slope)
}

/// Power of a row, W, clamped wheels drawing nothing.
pub fn power(torque: &TorqueModel<f64>, row: &Kept<'_>, drive: Drive) -> f64 {
    let mut power = 0.0;
    for wheel in row.wheels {
        let wheel_power = torque.wheel_power(wheel, row.mass);
        power += if wheel_power < 0.0 && drive == Drive::Dissipative { 0.0 } else { wheel_power };
    }
    power
}

/// ∂P/∂θ of a row: watts per unit of each parameter; what a clamped wheel would draw has none.
pub fn gradient(torque: &TorqueModel<f64>, row: &Kept<'_>, drive: Drive) -> Parameters {
    predict(torque, row, drive).1
}

/// Residual of a row, W; `None` where no wheel draws power.
pub(super) fn residual(torque: &TorqueModel<f64>, row: &Kept<'_>, drive: Drive) -> Option<f64> {
    let mut power = 0.0;
    let mut draws = false;
    for wheel in row.wheels {
        let wheel_power = torque.wheel_power(wheel, row.mass);
        let counts = wheel.direction != 0.0 && (drive == Drive::Regenerative || wheel_power >= 0.0);
        draws |= counts;
        power += if counts { wheel_power } else { 0.0 };
    }
    draws.then_some(row.power - power)
}

/// 0 for rows in which no wheel draws power, the loss's weight for the others.
pub(super) fn weight(torque: &TorqueModel<f64>, row: &Kept<'_>, drive: Drive, loss: Loss) -> f64 {
    residual(torque, row, drive).map_or(0.0, |residual| loss.weight(residual))
}

impl Cost<'_> {
    /// Sums over the rows, chunk by chunk.
    fn sum<S: Send>(&self, one: impl Fn(Stretch<'_>) -> S + Sync + Send) -> Vec<S> {
        if self.rows.others().len() <= CHUNK {
            return vec![one(self.rows)];
        }
        self.rows.par_chunks(CHUNK).map(one).collect()
    }
}

impl LeastSquares<Const<PARAMETERS>> for Cost<'_> {
    fn cost(&self, parameters: &Parameters) -> f64 {
        let torque = torque(parameters);
        let chunk = |rows: Stretch<'_>| {
            let mut block = Block::new(self.drive);
            let mut sum = 0.0;
            for rows in rows.blocks(block::ROWS) {
                block.predict(&torque, rows);
                sum += block.residual.iter().map(|residual| self.loss.of(*residual)).sum::<f64>();
            }
            sum
        };
        self.sum(chunk).into_iter().sum()
    }

    /// Of the squares that lie above the loss and touch it here: their minimum lowers the loss,
    /// too.
    fn derivatives(&self, parameters: &Parameters) -> (Parameters, Matrix) {
        let torque = torque(parameters);
        let free: Vec<usize> = (0..PARAMETERS).filter(|place| self.free[*place]).collect();
        let chunk = |rows: Stretch<'_>| {
            let mut block = Block::new(self.drive);
            let (mut gradient, mut matrix) = (Parameters::zeros(), Matrix::zeros());
            for rows in rows.blocks(block::ROWS) {
                block.differentiate(&torque, rows);
                let weights = block.residual.map(|residual| self.loss.weight(residual));
                for (count, &i) in free.iter().enumerate() {
                    let mut weighed = weights;
                    weighed.iter_mut().zip(&block.slopes[i]).for_each(|(weighed, slope)| *weighed *= slope);
                    gradient[i] -= dot(&weighed, &block.residual);
                    for &j in &free[..=count] {
                        matrix[(i, j)] += dot(&weighed, &block.slopes[j]);
                    }
                }
            }
            (gradient, matrix)
        };
        let (mut gradient, mut matrix) = (Parameters::zeros(), Matrix::zeros());
        for (one, other) in self.sum(chunk) {
            gradient += one;
            matrix += other;
        }
        // Only the lower triangle has been summed.
        matrix.fill_upper_triangle_with_lower_triangle();
        (gradient, matrix)
    }
}
