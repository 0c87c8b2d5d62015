//! The measuring chain: from what is true in the plant to what a log shows.

use std::collections::VecDeque;

use rand::RngExt;
use serde::Serialize;

use super::encoder::{SpeedSource, register_speed, speed_from_ticks, ticks};
use super::ina219::Ina219;
use super::kinematics::MAX_WHEELS;
use super::noise::{Ar1, Stream, stream};

/// Where the power comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum PowerSource {
    /// The true supply power at the time of the sample.
    Exact,
    /// An INA219 in the motors' rail, its conversions ending at the time of the sample.
    Ina219,
}

/// Settings of the measuring chain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensors {
    /// How wheel speeds are read.
    pub speed: SpeedSource,
    /// Standard deviation of white noise on the speeds as read, rad/s.
    pub speed_noise_rad_s: f64,
    /// How power is read.
    pub power: PowerSource,
    /// The power sensor where one is used.
    pub ina219: Ina219,
    /// Standard deviation of the noise added to the power before quantisation, W.
    pub power_noise_w: f64,
    /// What is added to that standard deviation for every watt read: noise that grows with the
    /// power.
    pub power_noise_per_w: f64,
    /// Degrees of freedom of Student's t, above 2, whose heavy tails that noise has; none for
    /// Gaussian noise.
    pub power_noise_tail: Option<f64>,
    /// Correlation of that noise from one sample to the next, −1 to 1.
    pub power_autocorrelation: f64,
    /// Standard deviation of the sampling instants, s, clipped at ±3; the log's time stays true.
    pub jitter_s: f64,
}

impl Sensors {
    /// No sensor between plant and log.
    pub fn exact() -> Self {
        Self {
            speed: SpeedSource::Exact,
            speed_noise_rad_s: 0.0,
            power: PowerSource::Exact,
            ina219: Ina219::default(),
            power_noise_w: 0.0,
            power_noise_per_w: 0.0,
            power_noise_tail: None,
            power_autocorrelation: 0.0,
            jitter_s: 0.0,
        }
    }

    /// What an OpenCR with an INA219 sees at `rate_hz`: encoder ticks, as many averages as fit, 0.1
    /// W noise.
    pub fn servo(rate_hz: f64) -> Self {
        let ina219 = Ina219 { averages: Ina219::averages_within(1.0 / rate_hz), ..Ina219::default() };
        Self {
            speed: SpeedSource::Encoder,
            power: PowerSource::Ina219,
            ina219,
            power_noise_w: 0.1,
            ..Self::exact()
        }
    }

    /// As in the paper's experiment (Section 7): meant for 20 Hz, the stock firmware's speed
    /// register, 16 averages.
    pub fn paper20() -> Self {
        let ina219 = Ina219 { averages: 16, ..Ina219::default() };
        Self { speed: SpeedSource::Register, ina219, ..Self::servo(20.0) }
    }
}

/// Speeds as read, wheel by wheel.
#[derive(Debug, Clone)]
pub(super) struct SpeedReader {
    source: SpeedSource,
    noise: Ar1,
    noise_rad_s: f64,
    angle: [f64; MAX_WHEELS],
    last_ticks: [i64; MAX_WHEELS],
    last_time_s: f64,
}

impl SpeedReader {
    pub(super) fn new(sensors: &Sensors, seed: u64) -> Self {
        let noise = Ar1::new(stream(seed, Stream::Speed), 0.0, None);
        let mut rng = stream(seed, Stream::EncoderPhase);
        let angle = [(); MAX_WHEELS].map(|()| rng.random_range(0.0..std::f64::consts::TAU));
        Self {
            source: sensors.speed,
            noise,
            noise_rad_s: sensors.speed_noise_rad_s,
            angle,
            last_ticks: angle.map(ticks),
            last_time_s: 0.0,
        }
    }

    /// The wheels have turned by `turned`, rad.
    pub(super) fn observe(&mut self, turned: [f64; MAX_WHEELS]) {
        for (angle, turned) in self.angle.iter_mut().zip(turned) {
            *angle += turned;
        }
    }

    pub(super) fn read(&mut self, time_s: f64, speed: [f64; MAX_WHEELS]) -> [f64; MAX_WHEELS] {
        let read = match self.source {
            SpeedSource::Exact => speed,
            SpeedSource::Register => speed.map(register_speed),
            SpeedSource::Encoder => {
                let now = self.angle.map(ticks);
                let span = time_s - self.last_time_s;
                let before = std::mem::replace(&mut self.last_ticks, now);
                self.last_time_s = time_s;
                std::array::from_fn(
                    |i| if span > 0.0 { speed_from_ticks(now[i] - before[i], span) } else { 0.0 },
                )
            }
        };
        if self.noise_rad_s == 0.0 {
            return read;
        }
        read.map(|speed| speed + self.noise_rad_s * self.noise.next())
    }
}

/// Power as read.
#[derive(Debug, Clone)]
pub(super) struct PowerReader {
    source: PowerSource,
    ina219: Ina219,
    noise: Ar1,
    noise_w: f64,
    noise_per_w: f64,
    /// Supply energy, J, at the end of each of the last steps; oldest first.
    energy: VecDeque<f64>,
    step_s: f64,
    last_power_w: f64,
}

impl PowerReader {
    /// A sensor that has read `level_w` all the time before.
    pub(super) fn new(sensors: &Sensors, step_s: f64, seed: u64, level_w: f64) -> Self {
        let window = (2.0 * sensors.ina219.conversion_time_s() / step_s).ceil() as usize + 2;
        let noise =
            Ar1::new(stream(seed, Stream::Power), sensors.power_autocorrelation, sensors.power_noise_tail);
        let energy = (0..window).map(|k| k as f64 * step_s * level_w).collect();
        Self {
            source: sensors.power,
            ina219: sensors.ina219,
            noise,
            noise_w: sensors.power_noise_w,
            noise_per_w: sensors.power_noise_per_w,
            energy,
            step_s,
            last_power_w: level_w,
        }
    }

    /// The supply gave `power_w` during one step.
    pub(super) fn observe(&mut self, power_w: f64) {
        self.last_power_w = power_w;
        if self.source == PowerSource::Ina219 {
            let total = self.energy.back().copied().unwrap_or(0.0) + power_w * self.step_s;
            self.energy.pop_front();
            self.energy.push_back(total);
        }
    }

    /// Supply energy, J, up to `age_s` before now; straight between steps.
    fn energy_before(&self, age_s: f64) -> f64 {
        let place = (self.energy.len() - 1) as f64 - age_s / self.step_s;
        let below = place.floor().max(0.0) as usize;
        let share = place - below as f64;
        let above = (below + 1).min(self.energy.len() - 1);
        self.energy[below] + share * (self.energy[above] - self.energy[below])
    }

    pub(super) fn read(&mut self, supply_v: f64) -> f64 {
        let noise = |power: f64, unit: f64| (self.noise_w + self.noise_per_w * power.abs()) * unit;
        let unit = self.noise.next();
        match self.source {
            PowerSource::Exact => self.last_power_w + noise(self.last_power_w, unit),
            PowerSource::Ina219 => {
                // The shunt is converted first, then the bus: the current is older than the reading
                // by a conversion.
                let conversion = self.ina219.conversion_time_s();
                let energy = self.energy_before(conversion) - self.energy_before(2.0 * conversion);
                let power = energy / conversion;
                let current = (power + noise(power, unit)) / supply_v;
                self.ina219.power_w(self.ina219.convert(current, supply_v))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 12 V, so one current code of 0.1 mA is 1.2 mW. Power steps from 0 to 6 W at 20 ms; with 16
    /// averages a conversion takes 8.512 ms, so the shunt's window ends 8.512 ms before the
    /// reading.
    #[test]
    fn the_power_sensor_averages_and_quantises() {
        let sensors = Sensors { power_noise_w: 0.0, ..Sensors::paper20() };
        let h = 0.25e-3;
        let mut reader = PowerReader::new(&sensors, h, 1, 0.0);
        let mut readings = Vec::new();
        for step in 1..=200 {
            reader.observe(if step > 80 { 6.0 } else { 0.0 });
            readings.push(reader.read(12.0));
        }
        for (step, &reading) in (1..).zip(&readings) {
            let now = f64::from(step) * h;
            let share = ((now - 0.02 - 8.512e-3) / 8.512e-3).clamp(0.0, 1.0);
            // Half a code of current, at most.
            assert!((reading - 6.0 * share).abs() <= 0.6e-3 + 1e-9, "{now}: {reading}");
            let codes = reading / 1.2e-3;
            assert!((codes - codes.round()).abs() < 1e-9, "{reading} is no whole number of codes");
        }
        assert_eq!(*readings.last().unwrap(), 6.0);
    }

    #[test]
    fn the_encoder_loses_no_tick() {
        let mut reader = SpeedReader::new(&Sensors { speed: SpeedSource::Encoder, ..Sensors::exact() }, 3);
        let start = reader.last_ticks[0];
        let mut sum = 0.0;
        for k in 1..=1000 {
            reader.observe([0.005 * 1.2345, 0.0, 0.0, 0.0]);
            sum += reader.read(f64::from(k) * 0.005, [9.9; 4])[0] * 0.005;
        }
        let turned = (reader.last_ticks[0] - start) as f64 * std::f64::consts::TAU / 4096.0;
        // Within a tick of the true angle, and speeds add up to the ticks (a thousand roundings of
        // 1e-16).
        assert!((turned - 5.0 * 1.2345).abs() <= std::f64::consts::TAU / 4096.0);
        assert!((sum - turned).abs() < 1e-9);
    }
}
