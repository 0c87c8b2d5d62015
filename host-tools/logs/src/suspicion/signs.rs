//! A wheel whose speed is logged with the wrong sign.
//!
//! With one of two wheels turned over, straight drives are spins and spins straight drives. Either
//! may be what was driven. Curves are what tells: robots drive them about a point outside their
//! wheels, and what a turned wheel makes of such a curve is one about a point between the wheels,
//! but not in their middle, which is hardly ever driven. Four wheels on the ground have to agree
//! among themselves.

use numerics::robust;

use super::doubt::{Kind, Suspicion};
use super::thinned::Row;
use crate::robot::{Geometry, Robot};

/// Wheels slower than this share of the usual greatest are left out.
const FAST: f64 = 0.2;

/// Curves about a point between the wheels, over curves about one outside. Of right logs at most
/// 0.7 (a Warthog, on gravel), of turned ones at least 1.6.
const TURNED: f64 = 1.5;

/// A share of curves that says anything. Turned logs have 0.24 and more of the wrong ones; right ones that hardly drive
/// curves have had 0.06.
const LEAST_CURVES: f64 = 0.12;

/// Fewest rows.
const LEAST_ROWS: usize = 100;

/// Turning costs wheels that scrub some ten times what straight driving does; where straight drives
/// cost this much more, they are spins.
const SCRUB: f64 = 3.0;

/// Speeds of four wheels that disagree by this share of themselves are not of one robot.
const DISAGREE: f64 = 0.5;
/// With one turned over they have to agree this well.
const AGREE: f64 = 0.15;

pub(super) fn suspicion(robot: &Robot, moving: &[&Row]) -> Option<Suspicion> {
    let fast = robust::quantile(&mut moving.iter().map(|row| row.fastest()).collect::<Vec<_>>(), 0.95)?;
    let fast: Vec<&Row> = moving.iter().copied().filter(|row| row.fastest() > FAST * fast).collect();
    if fast.len() < LEAST_ROWS {
        return None;
    }
    match robot.geometry() {
        Geometry::DifferentialDrive { .. } | Geometry::SkidSteer { wheels: 2, .. } => of_two(robot, &fast),
        Geometry::SkidSteer { wheels: 4, .. } | Geometry::FourMecanum { .. } => of_four(robot, &fast),
        _ => None,
    }
}

fn of_two(robot: &Robot, rows: &[&Row]) -> Option<Suspicion> {
    let (mut inside, mut outside) = (0.0, 0.0);
    let (mut straight, mut spinning) = (Vec::new(), Vec::new());
    for row in rows {
        let &[left, right] = row.wheels() else { return None };
        let (way, rim) = (0.5 * (left + right).abs(), 0.5 * (right - left).abs());
        inside += f64::from(u8::from(0.1 * rim < way && way < 0.9 * rim));
        outside += f64::from(u8::from(0.1 * way < rim && rim < 0.9 * way));
        let effort = row.power_w.abs() / (left.abs() + right.abs());
        if rim < 0.1 * way {
            straight.push(effort);
        } else if way < 0.1 * rim {
            spinning.push(effort);
        }
    }
    let total = rows.len() as f64;
    let curves = inside > LEAST_CURVES * total && inside > TURNED * outside;
    let enough = straight.len() >= 20 && spinning.len() >= 20;
    let scrubs = matches!(robot.geometry(), Geometry::SkidSteer { .. });
    let costs = scrubs && enough && robust::median(&mut straight)? > SCRUB * robust::median(&mut spinning)?;
    (curves || costs).then(|| {
        let why = if curves {
            format!(
                "in {:.0} % of the rows the robot turns about a point between its wheels, but not in their middle",
                100.0 * inside / total
            )
        } else {
            "driving straight costs more than turning on the spot".to_owned()
        };
        of(&why, "1 or 2 (the one that is negative when the robot drives forward)", "2")
    })
}

/// Disagreement of front and rear, as the layout allows it, over the speeds.
fn disagreement(robot: &Robot, wheels: &[f64; 4]) -> f64 {
    let [front_left, front_right, rear_left, rear_right] = wheels;
    let size = wheels.iter().map(|speed| speed.abs()).sum::<f64>();
    let apart = match robot.geometry() {
        Geometry::FourMecanum { .. } => (front_left + front_right - rear_left - rear_right).abs(),
        _ => (front_left - rear_left).abs() + (front_right - rear_right).abs(),
    };
    apart / size
}

fn of_four(robot: &Robot, rows: &[&Row]) -> Option<Suspicion> {
    let apart = |turned: Option<usize>| {
        let each = rows.iter().filter_map(|row| {
            let mut wheels: [f64; 4] = row.wheels().try_into().ok()?;
            if let Some(wheel) = turned {
                wheels[wheel] = -wheels[wheel];
            }
            Some(disagreement(robot, &wheels))
        });
        robust::median(&mut each.collect::<Vec<_>>()).unwrap_or(0.0)
    };
    if apart(None) < 0.5 * DISAGREE {
        return None;
    }
    let likely: Vec<String> =
        (0..4).filter(|wheel| apart(Some(*wheel)) < AGREE).map(|wheel| (wheel + 1).to_string()).collect();
    let first = likely.first()?.clone();
    Some(of("the wheels of the robot disagree", &likely.join(" or "), &first))
}

fn of(why: &str, wheels: &str, first: &str) -> Suspicion {
    Suspicion {
        kind: Kind::SpeedSign,
        text: format!("{why}: the sign of wheel {wheels} looks turned over"),
        remedy: format!("read it with --flip-wheel {first}"),
    }
}
