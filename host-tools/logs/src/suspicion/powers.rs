//! Power in a different unit than watts, or none at all.

use model_core::effects::GRAVITY;
use numerics::robust;

use super::doubt::{Kind, Suspicion, usual_mass_kg};
use super::thinned::Row;
use crate::robot::Robot;

/// Watts per kilogram that a robot on wheels takes at most: 10 the most seen (a Warthog, a Burger's
/// total power).
const MOST_W_KG: f64 = 100.0;

/// Watts per kilogram that it takes at least, where it moves: 0.06 the least seen, a simulated robot whose motors waste nothing
/// at a tenth of its speed.
pub const LEAST_W_KG: f64 = 0.03;

/// Power per weight and speed that no wheel on any ground goes below, by far: steel on steel takes
/// 0.001 to 0.002, the most frugal robot seen 0.015.
const LEAST_COST: f64 = 0.01;

/// Drives never feed back for more of the time than they draw: they would gain energy. What is
/// closer to 0 than a tenth of the greatest power says nothing about signs.
const MOST_NEGATIVE: f64 = 0.5;
const NEAR_ZERO: f64 = 0.1;

pub(super) fn suspicion(robot: &Robot, moving: &[&Row]) -> Option<Suspicion> {
    let mut powers: Vec<f64> = moving.iter().map(|row| row.power_w.abs()).collect();
    let high = robust::quantile(&mut powers, 0.95)?;
    if high == 0.0 {
        return Some(Suspicion {
            kind: Kind::NoPower,
            text: "power_w is 0 while the robot drives".to_owned(),
            remedy: "check the power sensor and its column; leave the log out".to_owned(),
        });
    }
    if high > MOST_W_KG * robot.mass_full_load_kg() {
        let text = format!(
            "the robot takes {high:.0} W while it moves, {:.0} W for each of its {} kg at most: power_w looks like mW, not W",
            high / robot.mass_full_load_kg(),
            robot.mass_full_load_kg()
        );
        return Some(of(text, "read it with --power-unit mW"));
    }
    let radius = robot.wheel_radius_m().unwrap_or(0.0);
    let cost = |row: &&Row| {
        let mass = if row.mass_kg.is_finite() { row.mass_kg } else { usual_mass_kg(robot) };
        row.power_w.abs() / (GRAVITY * mass * row.fastest() * radius)
    };
    let cost = robust::median(&mut moving.iter().map(cost).collect::<Vec<_>>())?;
    if high < LEAST_W_KG * robot.mass_no_load_kg() && cost < LEAST_COST {
        let text = format!(
            "the robot takes no more than {high:.2e} W while it moves, {cost:.1e} of its weight times its speed: power_w looks like kW, \
             not W"
        );
        return Some(of(text, "read it with --power-unit kW"));
    }
    let negative =
        moving.iter().filter(|row| row.power_w < -NEAR_ZERO * high).count() as f64 / moving.len() as f64;
    (negative > MOST_NEGATIVE).then(|| Suspicion {
        kind: Kind::PowerSign,
        text: format!(
            "power_w is negative in {:.0} % of the moving rows: its sign looks turned over",
            100.0 * negative
        ),
        remedy: "read it with --flip-power".to_owned(),
    })
}

fn of(text: String, remedy: &str) -> Suspicion {
    Suspicion { kind: Kind::PowerUnit, text, remedy: remedy.to_owned() }
}
