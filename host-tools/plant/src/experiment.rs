//! The regime of the paper's experiment (Section 7): one robot, its drives and its sensors, as a
//! preset.
//!
//! The paper publishes no log. What it says is kept: the servos of a TurtleBot3, wheel speeds that
//! come as messages at about 20 Hz, an INA219, one floor, training without and with full load over
//! the whole range of speeds (not of turns), a test from 2 kg to 3 kg of payload on another
//! profile. What it does not say, how briskly and how noisily, is [`REGIME`], set so that its own
//! method, its regression and its perceptron come near the figures that it states for them. How
//! near: `gmr reproduce`.

use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use serde::Serialize;
use support::error::Result;

use super::ina219::Ina219;
use super::kinematics::Kinematics;
use super::noise::{Stream, stream};
use super::rails::PowerTree;
use super::{PayloadSchedule, PlantSet, Profile, ProfileKind, Rounds, Scenario, Sensors, Simulation};

/// Which drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Drive {
    /// 1 kg, then 6 kg.
    Training,
    /// 3 kg, then 4 kg.
    Test,
    /// Ten minutes of errands, with a new payload after each.
    Errands,
}

/// What the paper leaves open.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Regime {
    /// Rolling resistance of the floor, force per normal force.
    pub rolling_resistance: f64,
    /// Rounds to learn from.
    pub training: Rounds,
    /// Rounds to be tested on.
    pub test: Rounds,
    /// Length of both, s.
    pub duration_s: f64,
    /// Samples per second, Hz.
    pub rate_hz: f64,
    /// White noise of the wheel speeds, rad/s.
    pub speed_noise_rad_s: f64,
    /// White noise of the power, W.
    pub power_noise_w: f64,
}

/// As set.
pub const REGIME: Regime = Regime {
    rolling_resistance: 0.014,
    training: Rounds {
        speed: (0.1, 1.0),
        curve: 0.3,
        hold_s: (0.6, 3.0),
        acceleration_m_s2: (0.05, 0.5),
        shares: [0.025, 0.0, 0.02],
    },
    test: Rounds {
        speed: (0.69, 0.99),
        curve: 0.8,
        hold_s: (0.1, 2.0),
        acceleration_m_s2: (0.18, 0.5),
        shares: [0.0; 3],
    },
    duration_s: 200.0,
    rate_hz: 20.0,
    speed_noise_rad_s: 0.02,
    power_noise_w: 0.03,
};

/// Voltage of the drives' supply, V.
pub const SUPPLY_V: f64 = 12.0;

/// Length of the errands, s, and of the shortest and the longest of them.
const ERRANDS_S: (f64, (f64, f64)) = (600.0, (70.0, 140.0));

/// A payload that changes does so by this much at least, kg.
const LEAST_CHANGE_KG: f64 = 0.5;

/// One drive of a seed.
///
/// # Errors
/// A payload schedule that cannot be.
pub fn scenario(drive: Drive, seed: u64) -> Result<Scenario> {
    let regime = &REGIME;
    // Every drive has its own seed; they repeat only where they wrap.
    let seed = seed.wrapping_mul(3).wrapping_add(drive as u64);
    let (rounds, duration_s) = match drive {
        Drive::Training => (&regime.training, regime.duration_s),
        Drive::Test => (&regime.test, regime.duration_s),
        Drive::Errands => (&regime.test, ERRANDS_S.0),
    };
    let half_s = 0.5 * duration_s;
    let payload = match drive {
        Drive::Training => PayloadSchedule::steps(vec![(0.0, 1.0), (half_s, 6.0)])?,
        Drive::Test => PayloadSchedule::steps(vec![(0.0, 3.0), (half_s, 4.0)])?,
        Drive::Errands => errands(seed)?,
    };
    let still = ProfileKind::Standstill;
    let mut scenario = Scenario::new(PlantSet::Servo, Kinematics::Differential, still, duration_s, seed);
    let robot = &mut scenario.robot;
    robot.supply_v = SUPPLY_V;
    for wheel in &mut robot.wheels {
        wheel.rolling_resistance = regime.rolling_resistance;
    }
    scenario.profile = Profile::rounds(&robot.geometry, &robot.limits, duration_s, rounds, seed);
    scenario.payload = payload;
    scenario.rate_hz = regime.rate_hz;
    scenario.sensors = Sensors {
        speed_noise_rad_s: regime.speed_noise_rad_s,
        power_noise_w: regime.power_noise_w,
        ..Sensors::paper20()
    };
    Ok(scenario)
}

/// Another payload after each errand, anything between empty and full.
fn errands(seed: u64) -> Result<PayloadSchedule> {
    let mut rng = stream(seed, Stream::Errands);
    let (end_s, (shortest_s, longest_s)) = ERRANDS_S;
    let (mut now_s, mut mass_kg) = (0.0, 1.0);
    let mut steps = Vec::new();
    while now_s < end_s {
        let other = loop {
            // Somebody put it on scales that show 10 g.
            let other: f64 = (100.0 * rng.random_range(1.0..6.0_f64)).round() / 100.0;
            if (other - mass_kg).abs() >= LEAST_CHANGE_KG {
                break other;
            }
        };
        steps.push((now_s, other));
        mass_kg = other;
        now_s += (rng.random_range(shortest_s..longest_s) * 10.0).round() / 10.0;
    }
    PayloadSchedule::steps(steps)
}

/// What sensors in the rails of battery and motors read at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RailReading {
    /// s
    pub time_s: f64,
    /// W
    pub battery_w: f64,
    /// Of the drives: the motors' rail without what the servos' electronics take at rest (P_stdby
    /// of Eq. 2), W.
    pub actuation_w: f64,
    /// Of all but the motors' rail: sensing, computing, communication, W.
    pub static_w: f64,
}

/// The rails during a seed's training drive.
///
/// # Errors
/// As [`scenario`].
pub fn rails(seed: u64) -> Result<Vec<RailReading>> {
    let scenario = scenario(Drive::Training, seed)?;
    let mut tree = PowerTree::new(scenario.robot.supply_v, seed);
    tree.torque = [true; super::rails::SERVOS];
    let mut rng = stream(seed, Stream::RailNoise);
    let sensor: Ina219 = scenario.sensors.ina219;
    let noise_w = scenario.sensors.power_noise_w;
    let mut readings = Vec::new();
    for sample in Simulation::new(&scenario)? {
        let rails = tree.supply(sample.time_s, sample.true_power_w);
        let [battery, motors, ..] = rails.map(|supply| {
            let unit: f64 = StandardNormal.sample(&mut rng);
            let current_a = (supply.power_w + noise_w * unit) / supply.voltage_v;
            sensor.power_w(sensor.convert(current_a, supply.voltage_v))
        });
        readings.push(RailReading {
            time_s: sample.time_s,
            battery_w: battery,
            actuation_w: sample.power_w,
            static_w: battery - motors,
        });
    }
    Ok(readings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drives_of_one_seed_differ_and_repeat() {
        let drive = |drive| scenario(drive, 4).unwrap();
        assert_eq!(drive(Drive::Errands), drive(Drive::Errands));
        assert_ne!(drive(Drive::Training).profile, drive(Drive::Test).profile);
        assert_ne!(drive(Drive::Test).seed, scenario(Drive::Training, 5).unwrap().seed);
    }

    /// 600 s of errands of 70 to 140 s: five to nine of them, each with a payload that differs from
    /// the one before.
    #[test]
    fn errands_change_the_payload() {
        for seed in 1..20 {
            let schedule = errands(seed).unwrap();
            let masses: Vec<f64> = (0..600).map(|second| schedule.mass_at(f64::from(second))).collect();
            let changes: Vec<_> = masses.windows(2).filter(|pair| pair[0] != pair[1]).collect();
            assert!((4..=8).contains(&changes.len()), "{}", changes.len());
            assert!(changes.iter().all(|pair| (pair[0] - pair[1]).abs() >= 0.5 - 1e-9));
            assert!(masses.iter().all(|mass| (1.0..=6.0).contains(mass)));
        }
    }
}
