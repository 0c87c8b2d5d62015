//! A sensor or an amplifier that ends at a value: the greatest one comes again and again, where no
//! other does.

use super::doubt::{Kind, Suspicion};
use super::thinned::Row;

/// Fewest rows at the greatest value, and fewest times that it is come to: noise comes to its
/// greatest once.
const LEAST_ROWS: usize = 20;
const LEAST_TIMES: usize = 3;

/// Any other value is met this many times less often.
const OFTENER: usize = 5;

/// Sensors that count in steps coarser than this share of their greatest value repeat themselves
/// anyway: a speed in encoder ticks stays at the speed limit of the robot.
const COARSE: f64 = 5e-3;

/// Which quantity ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    Power,
    Speed,
}

impl Quantity {
    fn of(self, row: &Row) -> f64 {
        match self {
            Self::Power => row.power_w,
            Self::Speed => row.fastest(),
        }
    }
}

pub(super) fn suspicion(quantity: Quantity, moving: &[&Row]) -> Option<Suspicion> {
    let values: Vec<f64> = moving.iter().map(|row| quantity.of(row)).collect();
    let greatest = values.iter().copied().fold(0.0, f64::max);
    let is_greatest = |value: &f64| *value == greatest;
    let times =
        values.chunk_by(|a, b| is_greatest(a) == is_greatest(b)).filter(|run| is_greatest(&run[0])).count();
    let mut sorted = values.clone();
    sorted.sort_by(f64::total_cmp);
    let finest = sorted
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .filter(|step| *step > 0.0)
        .fold(f64::INFINITY, f64::min);
    let met = |run: &[f64]| run.len();
    let same = || sorted.chunk_by(|a, b| a == b);
    let at_greatest = same().next_back().map_or(0, met);
    // Drives that cannot feed back are at 0 as often as they like.
    let elsewhere = same().filter(|run| run[0] != 0.0 && !is_greatest(&run[0])).map(met).max().unwrap_or(0);
    let ends = at_greatest >= LEAST_ROWS.max(OFTENER * elsewhere) && times >= LEAST_TIMES;
    if !ends || finest > COARSE * greatest {
        return None;
    }
    let (what, unit) = match quantity {
        Quantity::Power => ("power_w", "W"),
        Quantity::Speed => ("the speed of a wheel", "rad/s"),
    };
    let text = format!(
        "{what} never exceeds {greatest} {unit}, which it comes to {times} times and keeps in {:.1} % of the moving rows: the sensor is clipped",
        100.0 * at_greatest as f64 / values.len() as f64
    );
    let remedy = "widen the sensor's range (its shunt or gain), or drive so that it is not reached";
    Some(Suspicion { kind: Kind::Clipped, text, remedy: remedy.to_owned() })
}
