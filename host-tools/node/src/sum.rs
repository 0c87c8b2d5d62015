//! Power as `[topics]` of robot.toml names it, of messages as they come: the sum that logs have, of
//! the latest of each topic.

#![cfg_attr(not(feature = "ros"), allow(dead_code, reason = "topics come over ROS 2"))]

use log_formats::Field;
use logs::foreign::{NamedPower, named_power};
use logs::robot::Robot;
use support::error::{Error, Result};

use super::power::Reading;

/// A topic is quick where messages are at most this share of the greatest gap apart. It counts as
/// silent after half of that gap, so that one lost message is no silence.
const QUICK_SHARE: f64 = 0.25;

/// Weight of the last interval in the usual one: a memory of five messages.
const WEIGHT: f64 = 0.2;

/// The sum, and what it waits for.
pub(super) struct Sum {
    power: NamedPower,
    pub(super) topics: Vec<Told>,
    numbers: Vec<f64>,
    /// Of the node, and of slow topics as logs hold them, s.
    gaps_s: [f64; 2],
}

/// A topic of the sum.
pub(super) struct Told {
    pub(super) name: String,
    /// Where its numbers go.
    places: Vec<usize>,
    last_s: Option<f64>,
    usual_s: f64,
    /// Why its messages cannot be read.
    pub(super) unreadable: Option<String>,
}

impl Sum {
    /// As robot.toml names it.
    ///
    /// # Errors
    /// It does not.
    pub(super) fn of(robot: &Robot) -> Result<Self> {
        let power = named_power(robot)?.ok_or_else(|| {
            Error::usage(
                "sensor = \"topics\", and [topics] of robot.toml names no power; expected power as a field or a list of products, or voltage and current",
            )
        })?;
        let mut topics: Vec<Told> = Vec::new();
        for (place, field) in power.fields.iter().enumerate() {
            match topics.iter_mut().find(|told| told.name == field.topic) {
                Some(told) => told.places.push(place),
                None => topics.push(Told {
                    name: field.topic.clone(),
                    places: vec![place],
                    last_s: None,
                    usual_s: f64::INFINITY,
                    unreadable: None,
                }),
            }
        }
        let numbers = vec![f64::NAN; power.fields.len()];
        let gaps_s = [robot.node().greatest_gap_s, robot.topics().greatest_gap_s];
        Ok(Self { power, topics, numbers, gaps_s })
    }

    /// The fields of a topic, as [`Self::take`] takes their numbers.
    pub(super) fn fields(&self, topic: usize) -> Vec<&Field> {
        self.topics[topic].places.iter().map(|&place| &self.power.fields[place]).collect()
    }

    /// A message of a topic.
    pub(super) fn take(&mut self, topic: usize, now_s: f64, numbers: &[f64]) {
        let told = &mut self.topics[topic];
        if let Some(last_s) = told.last_s {
            let step = now_s - last_s;
            told.usual_s =
                if told.usual_s.is_finite() { told.usual_s + WEIGHT * (step - told.usual_s) } else { step };
        }
        told.last_s = Some(now_s);
        for (&place, &number) in told.places.iter().zip(numbers) {
            self.numbers[place] = number;
        }
    }

    /// The sum now; none while a part of it is missing.
    pub(super) fn reading(&self, now_s: f64) -> Option<Reading> {
        if self.missing(now_s).is_some() {
            return None;
        }
        let voltage_v = self.power.voltage.map_or(f64::NAN, |(place, scale)| self.numbers[place] * scale);
        Some(Reading { power_w: self.power.expression.of(&self.numbers), voltage_v })
    }

    /// Which part of it, and since when.
    pub(super) fn missing(&self, now_s: f64) -> Option<String> {
        let silent = |told: &Told| {
            if let Some(why) = &told.unreadable {
                return Some(format!("no power: {why}"));
            }
            let Some(last_s) = told.last_s else {
                return Some(format!("no power: {} has sent nothing yet", told.name));
            };
            let [quick_s, slow_s] = self.gaps_s;
            let most_s =
                if told.usual_s <= QUICK_SHARE * quick_s { quick_s / 2.0 } else { slow_s.max(quick_s) };
            let age = now_s - last_s;
            (age > most_s).then(|| format!("no power: {} is silent for {age:.1} s", told.name))
        };
        let no_number = || {
            let place = self.numbers.iter().position(|number| !number.is_finite())?;
            Some(format!("no power: {} is no number", self.power.fields[place]))
        };
        self.topics.iter().find_map(silent).or_else(no_number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sum(power: &str) -> Result<Sum> {
        let text = include_str!("../../robots/burger.toml");
        Sum::of(&Robot::parse(&format!("{text}\n[topics]\n{power}\n")).unwrap())
    }

    const BOTH: &str = "power = [{ voltage = \"/left:v\", current = \"/left:i\" }, \
                        { voltage = { field = \"/right:v\", unit = \"mV\" }, current = { field = \"/right:i\", scale = -1 } }]";

    /// 12 V · 2 A + 11 V · 3 A; of two drivers one falls silent: within a second there is no power,
    /// and it is named.
    #[test]
    fn a_part_that_falls_silent_leaves_no_sum() {
        let mut sum = sum(BOTH).unwrap();
        assert!(sum.missing(0.0).unwrap().contains("/left has sent nothing"));
        for tick in 0..100 {
            let now = 0.02 * f64::from(tick);
            sum.take(0, now, &[12.0, 2.0]);
            sum.take(1, now, &[11_000.0, -3.0]);
            assert_eq!(sum.reading(now), Some(Reading { power_w: 57.0, voltage_v: 12.0 }));
        }
        let last = 0.02 * 99.0;
        sum.take(0, last + 0.45, &[12.0, 2.0]);
        assert!(sum.reading(last + 0.45).is_some());
        sum.take(0, last + 0.55, &[12.0, 2.0]);
        let why = sum.missing(last + 0.55).unwrap();
        assert!(sum.reading(last + 0.55).is_none() && why.contains("/right is silent for 0.6 s"), "{why}");
        sum.take(1, last + 0.6, &[11_000.0, -3.0]);
        assert!(sum.reading(last + 0.6).is_some());
    }

    /// A battery that reports once a second is held as logs hold it; a number that is none is
    /// named.
    #[test]
    fn what_is_slow_is_waited_for() {
        let mut sum =
            sum("voltage = \"/battery:voltage\"\ncurrent = { field = \"/battery:current\", scale = -1 }")
                .unwrap();
        sum.take(0, 0.0, &[12.0, -1.0]);
        sum.take(0, 1.0, &[12.0, -1.5]);
        assert_eq!(sum.reading(2.9), Some(Reading { power_w: 18.0, voltage_v: 12.0 }));
        assert!(sum.reading(3.1).is_none());
        sum.take(0, 3.2, &[12.0, f64::NAN]);
        assert!(sum.missing(3.2).unwrap().contains("/battery:current is no number"));
    }

    #[test]
    fn without_a_name_there_is_no_sum() {
        let Err(refused) = sum("odometry = \"/odom\"") else { panic!() };
        assert!(refused.to_string().contains("names no power; expected"), "{refused}");
    }
}
