//! What of a bag shows energy and motion at a glance, without a robot.toml.

use log_formats::Bag;
use log_formats::merge::{Clock, Request};
use support::error::Result;

use super::choose::{
    Chosen, Fields, Power, battery, column, drivers_wheels, field, joints, mass, named_wheels, power, sum,
    topic,
};
use super::columns::{Column, Expression};
use super::known::{ODOMETRY, ODOMETRY_KIND};
use crate::robot::Robot;
use crate::{POWER, speed_column};

/// Forward speed, m/s.
pub const SPEED: &str = "v_m_s";
/// Turn rate, rad/s.
pub const TURN: &str = "omega_rad_s";
/// Current drawn, A.
pub const CURRENT: &str = "battery_a";
/// Charge that the battery reports, 0 to 1.
pub const CHARGE: &str = "charge";

/// Speed, turn, wheels, power, current, charge and mass, as far as the bag has them.
///
/// # Errors
/// Several topics of one name; a definition that cannot be read.
pub fn glance(bag: &Bag, robot: &Robot) -> Result<Option<Chosen>> {
    let topics = robot.topics();
    let mut fields = Fields::default();
    let mut columns: Vec<Column> = Vec::new();
    if let Some(wheels) = named_wheels(robot, &mut fields)? {
        columns.extend(wheels);
    } else if let Some(wheels) = drivers_wheels(bag, None, robot.wheels(), &mut fields)? {
        columns.extend(wheels);
    } else if let Some(wheels) = joints(bag, robot.wheels(), &mut fields)? {
        columns.extend(wheels);
    } else if let Some(encoders) = bag.topics().iter().find(|topic| topic.kind == "wheel_encoders") {
        for (wheel, index) in [1, 0].into_iter().enumerate() {
            let place = fields.place(field(encoders, &format!("wheel_speed[{index}]"))?);
            columns.push(column(speed_column(wheel), Expression::Number(place, 1.0), &*encoders.name));
        }
    }
    if let Some(odometry) = topic(bag, topics.odometry.as_ref(), ODOMETRY_KIND, &ODOMETRY, "odometry")? {
        for (name, member) in [(SPEED, "linear.x"), (TURN, "angular.z")] {
            let place = fields.place(field(odometry, &format!("twist.twist.{member}"))?);
            columns.push(column(name, Expression::Number(place, 1.0), &*odometry.name));
        }
    }
    match power(bag, topics)? {
        Some(Power::Direct(field, scale)) => {
            let source = field.to_string();
            columns.push(column(POWER, Expression::Number(fields.place(field), scale), source));
        }
        Some(Power::Product { voltage, current, scale, .. }) => {
            let source = current.topic.clone();
            let (voltage, current) = (fields.place(voltage), fields.place(current));
            columns.push(column(POWER, Expression::Product(voltage, current, scale), &*source));
            columns.push(column(CURRENT, Expression::Number(current, scale), source));
        }
        Some(Power::Sum(parts)) => columns.push(sum(parts, &mut fields)),
        None => {}
    }
    if let Some(battery) = battery(bag)? {
        let place = fields.place(field(battery, "percentage")?);
        columns.push(column(CHARGE, Expression::Number(place, 1.0), &*battery.name));
    } else if let Some(battery) = bag.topics().iter().find(|topic| topic.kind == "battery_status") {
        let place = fields.place(field(battery, "remaining")?);
        columns.push(column(CHARGE, Expression::Number(place, 1.0), &*battery.name));
    }
    if fields.base.is_empty() {
        return Ok(None);
    }
    columns.extend(mass(bag, topics, &mut fields)?);
    let Fields { base, others } = fields;
    let request = Request { base, others, greatest_gap_s: topics.greatest_gap_s, clock: Clock::Stamp };
    Ok(Some(Chosen { request, columns, battery: None, lacking: Vec::new() }))
}
