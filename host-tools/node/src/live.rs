//! Readings and messages in, states out. Times are seconds since the start, whatever clock that is.

use std::collections::BTreeMap;

use logs::robot::Robot;
use logs::suspicion::LEAST_W_KG;
use logs::{RawRow, RawSample};
use model::coefficients::FittedModel;
use model::pipeline::reason_text;
use model_core::charge::Charge;
use model_core::payload::MassEstimate;
use model_core::plausibility::MOST_POWER;

use super::battery::Battery;
use super::clock::{Clock, Step};
use super::pipeline::Pipeline;
use super::power::Reading;
use super::state::{Health, State};
use super::wheels::{WheelMessage, Wheels};

/// What `gmr node` knows.
pub struct Node<'a> {
    robot: &'a Robot,
    coefficients: Option<&'a FittedModel>,
    wheels: Wheels,
    clock: Clock,
    /// Who tells of the wheels, and when last, s.
    speaker: Option<([u8; 16], f64)>,
    pipeline: Option<Pipeline>,
    /// Why there is no pipeline, though the rate is known.
    unfit: Option<String>,
    /// Time since the sample before, s.
    owed_s: f64,
    /// Sum and number of the readings since the message before.
    power: (f64, u32),
    last_reading: Option<(f64, Reading)>,
    /// Why there is none, where its source knows.
    missing_power: Option<String>,
    /// Mean power, W, and when the reading came that it was told of last, s.
    mean: (f64, Option<f64>),
    battery: Battery,
    samples: u64,
    faults: BTreeMap<&'static str, u64>,
}

/// Time over which the mean power is taken, s. Chosen: noise and braking are shorter. The first
/// reading counts as a tenth of it.
const MEAN_S: f64 = 1.0;

impl<'a> Node<'a> {
    /// Of a robot. Without coefficients there is no payload. The battery's charge is unknown unless
    /// it is given.
    pub fn new(robot: &'a Robot, coefficients: Option<&'a FittedModel>, charge: Option<Charge<f64>>) -> Self {
        Self {
            robot,
            coefficients,
            wheels: Wheels::of(robot),
            clock: Clock::default(),
            speaker: None,
            pipeline: None,
            unfit: None,
            owed_s: 0.0,
            power: (0.0, 0),
            last_reading: None,
            missing_power: None,
            mean: (0.0, None),
            battery: Battery::new(robot, charge),
            samples: 0,
            faults: BTreeMap::new(),
        }
    }

    /// A reading of the sensor. One that this robot can neither draw nor give back is counted and
    /// left out.
    pub fn reading(&mut self, at_s: f64, reading: Reading) {
        self.take_reading(at_s, reading);
    }

    /// Why there is no power, until there is some again; whether that is news.
    pub fn lacks_power(&mut self, why: Option<String>) -> bool {
        let is_news = why.is_some() != self.missing_power.is_some();
        if why.is_some() {
            (self.power, self.last_reading) = ((0.0, 0), None);
        }
        self.missing_power = why;
        is_news
    }

    /// Whether it was taken.
    fn take_reading(&mut self, at_s: f64, reading: Reading) -> bool {
        let watts = reading.power_w;
        if !watts.is_finite() {
            self.fault("power that is no number");
            return false;
        }
        if watts.abs() > MOST_POWER {
            self.fault("power that no robot draws");
            return false;
        }
        // A reading below 0 is noise. Drives that burn what they brake give nothing back for long.
        let elapsed = self.mean.1.map_or(0.1 * MEAN_S, |last| at_s - last);
        let mean = self.mean.0 + (watts - self.mean.0) * (elapsed / MEAN_S).clamp(0.0, 1.0);
        self.mean = (mean, Some(at_s));
        if !self.robot.regeneration() && mean < -LEAST_W_KG * self.robot.mass_no_load_kg() {
            self.fault("power below 0 W without regeneration: is the sensor the other way round?");
            return false;
        }
        self.battery.add(at_s, &reading);
        self.power.0 += reading.power_w;
        self.power.1 += 1;
        self.last_reading = Some((at_s, reading));
        true
    }

    /// A message about the wheels: a sample, with the mean power since the message before.
    pub fn wheels(&mut self, at_s: f64, message: &WheelMessage) {
        let speeds = match self.wheels.speeds(message) {
            Ok(speeds) => speeds,
            Err(why) => return self.fault(why),
        };
        match self.speaker {
            Some((from, last)) if from != message.from => {
                // Two at a time would be two robots, or two clocks.
                if at_s - last <= self.gap_s() {
                    return self.fault("speeds from another sender");
                }
                self.fault("new sender of speeds");
                self.owed_s += at_s - last;
                self.clock.restart();
                self.clock.step(at_s, message.stamp_s);
            }
            _ => match self.clock.step(at_s, message.stamp_s) {
                Step::First => {}
                Step::After(step) => self.owed_s += step,
                Step::Jumped(step) => {
                    self.fault("jumps of the speeds' clock");
                    self.owed_s += step;
                }
                Step::Late => return self.fault("speeds not later than those before"),
            },
        }
        self.speaker = Some((message.from, at_s));
        let (sum, count) = std::mem::take(&mut self.power);
        let power = match self.last_reading {
            Some((at, _)) if at_s - at > self.gap_s() => return self.fault("speeds without power"),
            None => return self.fault("speeds without power"),
            Some((_, last)) if count == 0 => last.power_w,
            Some(_) => sum / f64::from(count),
        };
        self.follow_rate();
        let power = power - self.robot.static_power_w().unwrap_or(0.0);
        self.sample(&RawSample { wheel_speed: speeds, wheel_acceleration: None, power });
    }

    /// A row of a log, as `gmr estimate` takes it; samples of the log have to come every
    /// `period_s`.
    ///
    /// # Errors
    /// As [`Pipeline::new`].
    pub fn row(&mut self, row: &RawRow, voltage_v: f64, period_s: f64) -> support::error::Result<()> {
        if self.pipeline.is_none()
            && let Some(coefficients) = self.coefficients
        {
            self.pipeline = Some(Pipeline::new(coefficients, period_s)?);
        }
        let is_other_run = row.elapsed.is_infinite() && row.run > 0;
        if let Some(pipeline) = self.pipeline.as_mut().filter(|_| is_other_run) {
            pipeline.restart();
        }
        let power_w = row.sample.power + self.robot.static_power_w().unwrap_or(0.0);
        let is_taken = self.take_reading(row.time, Reading { power_w, voltage_v });
        self.speaker = Some(([0; 16], row.time));
        self.owed_s = if row.elapsed.is_finite() {
            self.owed_s + row.elapsed
        } else if is_other_run {
            f64::MAX
        } else {
            0.0
        };
        if is_taken {
            self.sample(&row.sample);
        }
        Ok(())
    }

    fn sample(&mut self, sample: &RawSample) {
        if let Some(pipeline) = &mut self.pipeline {
            pipeline.push(sample, std::mem::take(&mut self.owed_s));
            self.samples += 1;
        }
    }

    /// Begins when the rate is known, and anew when it is another.
    fn follow_rate(&mut self) {
        let Some(coefficients) = self.coefficients else { return };
        let period = match &self.pipeline {
            None => self.clock.period_s(),
            Some(pipeline) => self.clock.other_period_s(pipeline.period_s()),
        };
        let Some(period_s) = period else { return };
        if self.pipeline.is_some() {
            self.fault("changes of the speeds' rate");
        }
        match Pipeline::new(coefficients, period_s) {
            Ok(pipeline) => {
                self.pipeline = Some(pipeline);
                self.unfit = None;
            }
            Err(why) => {
                self.pipeline = None;
                self.unfit = Some(why.message().to_owned());
            }
        }
        self.owed_s = 0.0;
    }

    fn fault(&mut self, what: &'static str) {
        *self.faults.entry(what).or_default() += 1;
    }

    fn gap_s(&self) -> f64 {
        self.robot.node().greatest_gap_s
    }

    /// What is known `now`, s. Old speeds and old power are none.
    pub fn state(&self, now_s: f64) -> State {
        let reading =
            self.last_reading.filter(|(at, _)| now_s - at <= self.gap_s()).map(|(_, reading)| reading);
        let speeds_age = self.speaker.map(|(_, at)| (now_s - at).max(0.0));
        let are_speeds_fresh = speeds_age.is_some_and(|age| age <= self.gap_s());
        let estimate = self.pipeline.as_ref().and_then(Pipeline::latest);
        let now = estimate.filter(|_| are_speeds_fresh && reading.is_some());
        let (health, why) = self.health(now_s, reading.is_some(), speeds_age);
        let mass = now.and_then(|now| now.mass.known());
        let payload = |mass: f64| mass - self.robot.mass_no_load_kg();
        let charge = reading.and_then(|_| self.battery.charge());
        let remaining = reading.and_then(|_| self.battery.remaining());
        State {
            time_s: now_s,
            state: health,
            why,
            payload_kg: mass.map(|mass| payload(mass.mass)),
            payload_low_kg: mass.map(|mass| payload(mass.low)),
            payload_high_kg: mass.map(|mass| payload(mass.high)),
            mass_kg: mass.map(|mass| mass.mass),
            measured_w: now.and_then(|now| now.measured),
            predicted_w: now.and_then(|now| now.power),
            energy_j: self.pipeline.as_ref().map(Pipeline::energy_j),
            power_w: reading.map(|reading| reading.power_w),
            voltage_v: reading.map(|reading| reading.voltage_v).filter(|voltage| voltage.is_finite()),
            current_a: reading.and_then(|reading| self.battery.current_a(&reading)),
            charge: charge.map(|charge| charge.share),
            charge_std: charge.map(|charge| charge.std),
            remaining_j: remaining.map(|battery| battery.energy),
            remaining_low_j: remaining.map(|battery| battery.energy_low),
            remaining_high_j: remaining.map(|battery| battery.energy_high),
            remaining_s: remaining.and_then(|battery| battery.time),
            resistance_ohm: self.battery.resistance().map(|resistance| resistance.at_once),
            no_charge: self.battery.why_not(),
            speeds_age_s: speeds_age,
            rate_hz: self.pipeline.as_ref().map(|pipeline| 1.0 / pipeline.period_s()),
            samples: self.samples,
            changes: self.pipeline.as_ref().map_or(0, Pipeline::changes),
            faults: self.faults.clone(),
        }
    }

    fn health(&self, now_s: f64, is_powered: bool, speeds_age: Option<f64>) -> (Health, Option<String>) {
        let said = |health, why: &str| (health, Some(why.to_owned()));
        if !is_powered {
            return match self.last_reading {
                None if self.missing_power.is_some() => (Health::NoPower, self.missing_power.clone()),
                None => said(Health::NoPower, "no power has been read yet"),
                Some((at, _)) => said(Health::NoPower, &format!("no power for {:.1} s", now_s - at)),
            };
        }
        match speeds_age {
            None => return said(Health::NoSpeeds, "no wheel speeds have come yet"),
            Some(age) if age > self.gap_s() => {
                return said(Health::NoSpeeds, &format!("no wheel speeds for {age:.1} s"));
            }
            Some(_) => {}
        }
        if self.coefficients.is_none() {
            return said(Health::Unknown, "no coefficients were given (--coeffs)");
        }
        if let Some(why) = &self.unfit {
            return said(Health::Unknown, why);
        }
        match self.pipeline.as_ref().and_then(Pipeline::latest).map(|estimate| estimate.mass) {
            None => said(Health::Unknown, "the rate of the speeds is still being measured"),
            Some(MassEstimate::Unknown(reason)) => said(Health::Unknown, reason_text(reason)),
            Some(MassEstimate::Known(_)) => (Health::Ok, None),
            Some(MassEstimate::Beyond(mass)) => match mass.place {
                model_core::payload::Place::Below => {
                    said(Health::Ok, "lighter than the robot without payload: this is its nearest end")
                }
                _ => {
                    said(Health::Ok, "heavier than the robot with its full payload: this is its nearest end")
                }
            },
        }
    }
}

#[cfg(test)]
mod tests;
