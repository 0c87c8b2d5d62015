//! The rows of any log, as moments.

use std::path::Path;

use log_formats::merge::merge;
use log_formats::table::Cell;
use logs::foreign::{self, CHARGE, CURRENT, Column, SPEED, TURN};
use logs::robot::Robot;
use logs::{MASS, POWER, RUN, TIME, TableReader, missing};
use support::context::Context;
use support::error::{Error, Result};

use super::tally::{Moment, Tally};
use super::topics::{Topic, Topics};

/// Places of what a moment needs among named columns, and the units that they are in.
struct Places {
    power_in_w: f64,
    /// rad/s in one unit of each wheel's speed.
    wheel_scales: Vec<f64>,
    mass_in_kg: f64,
    /// The total mass that somebody weighed, kg.
    weighed: Option<f64>,
    speed: Option<usize>,
    turn: Option<usize>,
    wheels: Vec<usize>,
    power: Option<usize>,
    current: Option<usize>,
    charge: Option<usize>,
    mass: Option<usize>,
}

impl Places {
    fn of(names: &[&str], log: &Path, robot: &Robot) -> Self {
        let place = |name: &str| names.iter().position(|other| *other == name);
        let is_wheel = |name: &str| name.starts_with("wheel") && name.ends_with("_rad_s");
        let wheels: Vec<usize> = (0..names.len()).filter(|&at| is_wheel(names[at])).collect();
        Self {
            power_in_w: robot.log_units().power_in_w(),
            wheel_scales: (0..wheels.len()).map(|wheel| robot.log_speed_scale(wheel)).collect(),
            mass_in_kg: robot.log_units().mass.in_kg(),
            weighed: robot.log_units().mass_of(log),
            speed: place(SPEED),
            turn: place(TURN),
            wheels,
            power: place(POWER),
            current: place(CURRENT),
            charge: place(CHARGE),
            mass: place(MASS),
        }
    }

    fn moment(&self, time_s: f64, number: impl Fn(usize) -> f64) -> Moment {
        let at = |place: Option<usize>| place.map_or(f64::NAN, &number);
        let wheels = self.wheels.iter().zip(&self.wheel_scales);
        let wheels = wheels.map(|(&wheel, scale)| (scale * number(wheel)).abs()).sum::<f64>();
        Moment {
            time_s,
            speed_m_s: at(self.speed),
            turn_rad_s: at(self.turn),
            wheels_rad_s: wheels / self.wheels.len() as f64,
            power_w: self.power_in_w * at(self.power),
            current_a: self.power_in_w.signum() * at(self.current),
            charge: at(self.charge),
            mass_kg: self.weighed.unwrap_or_else(|| self.mass_in_kg * at(self.mass)),
        }
    }
}

/// Reads a log of any format.
///
/// # Errors
/// A log that cannot be read.
pub(super) fn read(context: &Context, log: &Path, robot: &Robot, allow_cut: bool) -> Result<(Tally, Topics)> {
    let mut tally = Tally::new();
    if let Some(bag) = foreign::bag_of(context, log, allow_cut)? {
        let bag = &bag.0;
        let mut topics: Vec<Topic> = bag
            .topics()
            .iter()
            .map(|topic| Topic {
                name: topic.name.clone(),
                kind: topic.kind.clone(),
                messages: topic.messages,
            })
            .collect();
        topics.sort_by(|a, b| a.name.cmp(&b.name));
        let named = |error: Error| error.in_file(log);
        let Some(chosen) = foreign::glance(bag, robot).map_err(named)? else {
            return Ok((tally, Topics { topics, sources: Vec::new(), cut: false }));
        };
        let names: Vec<&str> = chosen.columns.iter().map(|column| &*column.name).collect();
        let places = Places::of(&names, log, robot);
        // The kinematics make wheel speeds of odometry, for every other command as well.
        tally.has_wheels = places.speed.is_some() && places.turn.is_some();
        let merged = merge(bag, &chosen.request, &mut |time, numbers| {
            tally.add(&places.moment(time, |place| chosen.columns[place].expression.of(numbers)));
            Ok(())
        });
        let merged = merged.map_err(|error| named(foreign::wrong(error)))?;
        let source = |column: &Column| format!("{} from {}", column.name, column.source);
        let cut = merged.ending != log_formats::Ending::Whole;
        return Ok((tally, Topics { topics, sources: chosen.columns.iter().map(source).collect(), cut }));
    }
    let mut reader = TableReader::open(context, log)?;
    let columns = reader.columns().to_vec();
    let Some(time) = columns.iter().position(|name| name == TIME) else {
        let message = missing(TIME, &columns);
        return Err(Error::failed(message).in_file(log).at_line(1));
    };
    let places = Places::of(&columns.iter().map(String::as_str).collect::<Vec<_>>(), log, robot);
    let mut row = Vec::new();
    while reader.next_row(&mut row)? {
        let number = |place: usize| if let Cell::Number(number) = &row[place] { *number } else { f64::NAN };
        tally.add(&places.moment(number(time), number));
    }
    let kind = |name: &String| if name == RUN { "text" } else { "number" }.to_owned();
    let topics =
        columns.iter().map(|name| Topic { name: name.clone(), kind: kind(name), messages: Some(tally.rows) });
    Ok((tally.clone(), Topics { topics: topics.collect(), sources: Vec::new(), cut: false }))
}
