//! One discharge of the simulated battery, and what the gauge makes of it.

use firmware::measurement::BatteryMeter;
use firmware::parameters::RAILS;
use firmware::power_sensors::RailReading;
use model_core::charge::{Charge, Curve, Gauge, Pack, Point, Start};
use plant::battery::{Battery, BatteryState, CURVE};
use rand::RngExt as _;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

/// s between samples: what polarises moves slower.
const PERIOD_S: f64 = 0.05;
/// Battery and start are uncertain by this for so long, s: 20 points at 3 a minute are shown after
/// 7 minutes; the rest is for the filter.
pub(crate) const SETTLED_S: f64 = 1200.0;
/// How long after a load step a jump counts, s.
const AFTER_STEP_S: f64 = 10.0;
/// A discharge ends here, share.
const EMPTY: f64 = 0.03;
/// Of an INA219 (SBOS448G): one code of the current with a shunt of 0.1 Ω, A, and of the bus
/// voltage, V.
const CURRENT_LSB_A: f64 = 1e-4;
const VOLTAGE_LSB_V: f64 = 4e-3;

/// What else is not as the gauge believes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Setting {
    /// The capacity is that of the label, the sensor's gains are calibrated, the room is between 15
    /// and 30 °C.
    Known,
    /// The capacity is 3 % off at most, the gains by 0.3 % (current) and 0.1 % (voltage, one
    /// standard deviation), at 5 to 35 °C.
    Harsh,
    /// As known, and the gauge has this make's curve, as `open_circuit_v` of robot.toml tells it;
    /// not its hysteresis.
    OwnCurve,
    /// As known, but from 65 to 80 % on, and told 20 points too much.
    TooHigh,
    /// As known, but by the board's firmware: told nothing, behind its sensor's shunt, on a robot
    /// that never draws less than half an ampere.
    Board,
}

/// Who follows the discharge.
enum Follower {
    Gauge(Box<Gauge<f32>>),
    Board(Box<BatteryMeter>),
}

impl Follower {
    fn update(&mut self, current: f32, voltage: f32, time_s: f64) {
        match self {
            Self::Gauge(gauge) => gauge.update(current, voltage, PERIOD_S as f32),
            Self::Board(meter) => {
                let reading = RailReading { voltage, current, power: voltage * current };
                meter.update(Some(reading), (1e6 * time_s).round() as u64);
            }
        }
    }

    fn charge(&self) -> Option<Charge<f32>> {
        match self {
            Self::Gauge(gauge) => gauge.charge(),
            Self::Board(meter) => meter.known().charge,
        }
    }

    /// Ω
    fn resistance(&self) -> Option<f32> {
        match self {
            Self::Gauge(gauge) => gauge.resistance().map(|found| found.at_once),
            Self::Board(meter) => meter.known().resistance.map(|(at_once, _)| at_once),
        }
    }
}

/// How far the gauge was off, in points of charge.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Discharge {
    /// Worst behind [`SETTLED_S`].
    pub(crate) worst: f64,
    /// Root mean square behind it.
    pub(crate) rms: f64,
    /// From when on it stayed within 2 points for the rest of the run, s.
    pub(crate) within_s: f64,
    /// Greatest change of the error within ten seconds of a load step.
    pub(crate) jump: f64,
    /// Share of the samples behind [`SETTLED_S`] whose 95 % interval holds the truth.
    pub(crate) covered: f64,
    /// Error of the resistance at the end, as a share of the mean drop's; NaN where it stayed
    /// unknown.
    pub(crate) resistance: f64,
    /// Worst of the stock firmware's map from voltage behind [`SETTLED_S`].
    pub(crate) stock: f64,
    /// Greatest change of the stock map's error within ten seconds of a load step.
    pub(crate) stock_jump: f64,
}

/// Greatest change of an error from what it was at the last load steps.
#[derive(Default)]
struct Jumps {
    open: Vec<(f64, f64)>,
    greatest: f64,
}

impl Jumps {
    fn step(&mut self, time_s: f64, error: f64) {
        self.open.push((time_s + AFTER_STEP_S, error));
    }

    fn see(&mut self, time_s: f64, error: f64) {
        self.open.retain(|(until, _)| *until > time_s);
        for (_, before) in &self.open {
            self.greatest = self.greatest.max((error - before).abs());
        }
    }
}

/// A full discharge with load steps of 0 to 2 A every 5 to 120 s, one in seven to rest; the gauge
/// starts 20 points off, or told nothing, and knows no resistance.
pub(crate) fn discharge(seed: u64, setting: Setting) -> Discharge {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let harsh = setting == Setting::Harsh;
    let mut within = |from: f64, to: f64| rng.random_range(from..to);
    let spread = if harsh { 0.03 } else { 1e-9 };
    let battery = Battery {
        capacity_ah: 1.8 * (1.0 + within(-spread, spread)),
        cells: 3.0,
        ohmic_ohm: within(0.02, 0.08),
        transfer_ohm: within(0.01, 0.03),
        transfer_s: within(10.0, 40.0),
        diffusion_s: within(60.0, 300.0),
        hysteresis_v: within(0.0, 0.01),
        ambient_c: if harsh { within(5.0, 35.0) } else { within(15.0, 30.0) },
        curve_offset_v: 0.0,
    };
    let too_high = setting == Setting::TooHigh;
    let start = if too_high { within(0.65, 0.8) } else { within(0.85, 1.0) };
    let told = Charge { share: (if too_high { start + 0.2 } else { start - 0.2 }) as f32, std: 0.2 };
    let mut normal = || -> f64 { (0..12).map(|_| within(0.0, 1.0)).sum::<f64>() - 6.0 };
    let (current_gain, voltage_gain) =
        if harsh { (1.0 + 0.003 * normal(), 1.0 + 0.001 * normal()) } else { (1.0, 1.0) };
    let board = setting == Setting::Board;
    let mut follower = if board {
        Follower::Board(Box::default())
    } else {
        let mut pack = Pack::turtlebot3();
        if setting == Setting::OwnCurve {
            let points =
                CURVE.map(|(charge, voltage)| Point { charge: charge as f32, voltage: voltage as f32 });
            pack.curve = Curve::new(points).expect("the plant's curve rises");
        }
        Follower::Gauge(Box::new(Gauge::new(pack, Start::Known(told))))
    };
    let (least_a, shunt_ohm) = if board { (0.5, f64::from(RAILS[0].shunt.ohm)) } else { (0.02, 0.0) };
    let mut state: BatteryState = battery.at(start);

    let (mut time_s, mut until_s, mut load_a) = (0.0, 0.0, 0.0);
    let (mut worst, mut stock, mut squares, mut covered, mut samples) = (0.0_f64, 0.0_f64, 0.0, 0, 0);
    let (mut jumps, mut stock_jumps, mut within_s) = (Jumps::default(), Jumps::default(), 0.0);
    let mut last: Option<[f64; 2]> = None;
    while state.charge() > EMPTY {
        if time_s >= until_s {
            load_a = if within(0.0, 1.0) < 1.0 / 7.0 { least_a } else { within(0.0, 2.0).max(least_a) };
            until_s = time_s + within(5.0, 120.0);
            // The first load is no step: nothing was shown before it.
            if let Some([error, by_voltage]) = last {
                jumps.step(time_s, error);
                stock_jumps.step(time_s, by_voltage);
            }
        }
        let voltage = state.draw(load_a, PERIOD_S) - shunt_ohm * load_a;
        // A twelfth of a uniform's variance: noise of 2 mA and 5 mV.
        let noise = |size: f64, uniform: f64| size * 12.0_f64.sqrt() * (uniform - 0.5);
        let measured_a = (load_a * current_gain + noise(0.002, within(0.0, 1.0))) / CURRENT_LSB_A;
        let measured_v = (voltage * voltage_gain + noise(0.005, within(0.0, 1.0))) / VOLTAGE_LSB_V;
        let (measured_a, measured_v) =
            (measured_a.round() * CURRENT_LSB_A, measured_v.round() * VOLTAGE_LSB_V);
        follower.update(measured_a as f32, measured_v as f32, time_s);
        time_s += PERIOD_S;
        // A second at most, then it is known.
        let Some(shown) = follower.charge() else { continue };
        let error = f64::from(shown.share) - state.charge();
        // 10.5 V are empty, 12.3 V full: turtlebot3's own.
        let by_voltage = ((measured_v - 10.5) / 1.8).clamp(0.0, 1.0) - state.charge();
        jumps.see(time_s, error);
        stock_jumps.see(time_s, by_voltage);
        last = Some([error, by_voltage]);
        if error.abs() > 0.02 {
            within_s = time_s;
        }
        if time_s > SETTLED_S {
            worst = worst.max(error.abs());
            stock = stock.max(by_voltage.abs());
            squares += error * error;
            covered += i32::from(error.abs() <= 1.96 * f64::from(shown.std));
            samples += 1;
        }
    }
    let samples = f64::from(samples);
    let resistance = follower.resistance().map_or(f64::NAN, |found| {
        // What the ohmic part is at this temperature, half full and up.
        let before = state.draw(0.0, 1e-6);
        let drop = before - state.draw(1.0, 1e-6);
        f64::from(found) / drop - 1.0
    });
    Discharge {
        worst: 100.0 * worst,
        rms: 100.0 * (squares / samples).sqrt(),
        within_s,
        jump: 100.0 * jumps.greatest,
        covered: f64::from(covered) / samples,
        resistance,
        stock: 100.0 * stock,
        stock_jump: 100.0 * stock_jumps.greatest,
    }
}
