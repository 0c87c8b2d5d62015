//! The power tree: what each supply rail gives, by the state of what hangs on it.
//!
//! ```text
//! battery ─┬─ motors: both servos, electronics and drives
//!          └─ 5 V converter ─┬─ computer
//!                            ├─ lidar
//!                            └─ the controller board itself, which no sensor sees alone
//! ```
//!
//! Source of the layout: OpenCR schematic (motors straight from the battery, a step-down converter
//! for 5 V).

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::battery::{Battery, BatteryState};
use super::noise::{Stream, stream};

/// Rails with a sensor: battery, motors, computer, lidar.
pub const RAILS: usize = 4;

/// Servos of the robots that have such a board.
pub const SERVOS: usize = 2;

/// Current of a servo's electronics without torque, A (XL430-W250 e-manual, Specifications: standby
/// current).
pub const SERVO_STANDBY_A: f64 = 0.052;

/// What a servo's electronics take more with torque on, A: a standing TurtleBot3 drew 1.12 W more
/// once its motors had been switched on (INA219 at its battery; S2-group's MSR 2021 replication
/// package), two servos, at about 12 V.
pub const SERVO_TORQUE_A: f64 = 1.12 / 2.0 / 12.0;

/// Power of a Raspberry Pi 3 B+ that waits, W. Published measurements lie between 1.9 and 2.5 W;
/// with a network and a few ROS nodes the upper end.
pub const COMPUTER_IDLE_W: f64 = 2.5;

/// The same at work on one or two of its four cores, W (all four: about 5 W).
pub const COMPUTER_BUSY_W: f64 = 3.5;

/// Mean time that the computer waits, and then works, s. An assumption: navigation goals come every
/// half a minute.
const COMPUTER_DWELL_S: [f64; 2] = [20.0, 8.0];

/// Power of the laser scanner LDS-01 while it turns, W (e-manual: 400 mA at 5 V or less).
pub const LIDAR_W: f64 = 2.0;

/// Power of the controller board itself, W: an STM32F746 at 216 MHz with its peripherals takes
/// about 100 mA at 5 V.
pub const BOARD_W: f64 = 0.5;

/// Efficiency of the 5 V converter: an XL4005 from 12 V at 1 A, after its data sheet's curve.
pub const CONVERTER_EFFICIENCY: f64 = 0.9;

/// Its output, V.
pub const CONVERTER_V: f64 = 5.0;

/// Inner resistance of the battery with its leads, Ω: three lithium cells of 1.8 Ah with some 30 mΩ
/// each.
pub const BATTERY_OHM: f64 = 0.1;

/// Shunt of the battery's sensor, Ω: after it a discharging battery's voltage is lower by its drop.
const SHUNT_OHM: f64 = 0.1;

/// ROBOTIS LB-012 with cells of a different make than the gauge's curve, typical ones.
pub const LB_012: Battery = Battery {
    capacity_ah: 1.8,
    cells: 3.0,
    ohmic_ohm: 0.05,
    transfer_ohm: 0.02,
    transfer_s: 25.0,
    diffusion_s: 150.0,
    hysteresis_v: 0.005,
    ambient_c: 23.0,
    curve_offset_v: 0.0,
};

/// Power and voltage of one rail.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Supply {
    /// W
    pub power_w: f64,
    /// At the consumer's side of the shunt, V.
    pub voltage_v: f64,
}

impl Supply {
    /// A
    pub fn current_a(self) -> f64 {
        self.power_w / self.voltage_v
    }
}

/// What hangs on the rails, and in which state.
#[derive(Debug, Clone)]
pub struct PowerTree {
    source: Source,
    /// The scanner turns.
    pub lidar: bool,
    /// The servos' torque is switched on.
    pub torque: [bool; SERVOS],
    computer: Computer,
}

/// What everything comes from.
#[derive(Debug, Clone)]
enum Source {
    /// Never empty: this open-circuit voltage, V, in series with [`BATTERY_OHM`].
    Constant(f64),
    /// Cells, the time of the last reading, s, and their voltage after the shunt then, V.
    Cells { state: BatteryState, time_s: f64, voltage_v: f64 },
}

impl Source {
    /// The voltage after the battery's sensor, V, at a time, s, that never decreases, under a
    /// current, A, and a power, W.
    fn voltage(&mut self, now_s: f64, current_a: f64, power_w: f64) -> f64 {
        match self {
            // V = E − R (I + P / V).
            Self::Constant(battery_v) => {
                let open = *battery_v - BATTERY_OHM * current_a;
                0.5 * (open + (open * open - 4.0 * BATTERY_OHM * power_w).max(0.0).sqrt())
            }
            // The power's current by the voltage before: a step is short, and R P / V² far below 1.
            Self::Cells { state, time_s, voltage_v } => {
                let current = current_a + power_w / *voltage_v;
                let behind = state.draw(current, now_s - *time_s) - SHUNT_OHM * current;
                // Cells that are pulled below this have a protection that opens.
                (*time_s, *voltage_v) = (now_s, behind.max(1.0));
                *voltage_v
            }
        }
    }
}

impl PowerTree {
    /// A battery of `battery_v` without load; the scanner turns, the servos' torque is off.
    pub fn new(battery_v: f64, seed: u64) -> Self {
        Self {
            source: Source::Constant(battery_v),
            lidar: true,
            torque: [false; SERVOS],
            computer: Computer::new(seed),
        }
    }

    /// The same with a battery that has this much in it, 0 to 1, and gives it.
    pub fn with_cells(battery: Battery, charge: f64, seed: u64) -> Self {
        let mut state = battery.at(charge);
        let voltage_v = state.draw(0.0, 0.0);
        Self { source: Source::Cells { state, time_s: 0.0, voltage_v }, ..Self::new(voltage_v, seed) }
    }

    /// What is in the battery, 0 to 1; `None` of one that is never empty.
    pub fn charge(&self) -> Option<f64> {
        match &self.source {
            Source::Constant(_) => None,
            Source::Cells { state, .. } => Some(state.charge()),
        }
    }

    /// The rails' powers and voltages at a time, s, that never goes back, while the drives draw
    /// `actuation_w`.
    pub fn supply(&mut self, time_s: f64, actuation_w: f64) -> [Supply; RAILS] {
        let computer = if self.computer.is_busy_at(time_s) { COMPUTER_BUSY_W } else { COMPUTER_IDLE_W };
        let lidar = if self.lidar { LIDAR_W } else { 0.0 };
        let converter = (computer + lidar + BOARD_W) / CONVERTER_EFFICIENCY;
        let servos_a: f64 =
            self.torque.iter().map(|&on| SERVO_STANDBY_A + if on { SERVO_TORQUE_A } else { 0.0 }).sum();
        // Drives and converter take power, whatever the voltage, the servos' electronics a current.
        let voltage = self.source.voltage(time_s, servos_a, actuation_w + converter);
        let motors = actuation_w + servos_a * voltage;
        [
            Supply { power_w: motors + converter, voltage_v: voltage },
            Supply { power_w: motors, voltage_v: voltage },
            Supply { power_w: computer, voltage_v: CONVERTER_V },
            Supply { power_w: lidar, voltage_v: CONVERTER_V },
        ]
    }
}

/// A computer that waits and works by turns, each for an exponentially distributed time.
#[derive(Debug, Clone)]
struct Computer {
    rng: ChaCha8Rng,
    busy: bool,
    until_s: f64,
}

impl Computer {
    fn new(seed: u64) -> Self {
        let mut computer = Self { rng: stream(seed, Stream::Computer), busy: false, until_s: 0.0 };
        computer.until_s = computer.dwell();
        computer
    }

    fn dwell(&mut self) -> f64 {
        let uniform: f64 = self.rng.random_range(f64::MIN_POSITIVE..1.0);
        -COMPUTER_DWELL_S[usize::from(self.busy)] * uniform.ln()
    }

    fn is_busy_at(&mut self, time_s: f64) -> bool {
        while time_s >= self.until_s {
            self.busy = !self.busy;
            self.until_s += self.dwell();
        }
        self.busy
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the battery gives is what rails and board take, and its voltage falls by R I.
    #[test]
    fn the_rails_sum_to_the_battery() {
        let mut tree = PowerTree::new(12.0, 1);
        for (torque, lidar, actuation) in [(false, true, 0.0), (true, true, 3.0), (true, false, 25.0)] {
            tree.torque = [torque; SERVOS];
            tree.lidar = lidar;
            let [battery, motors, computer, scanner] = tree.supply(0.0, actuation);
            let converter = (computer.power_w + scanner.power_w + 0.5) / 0.9;
            assert!((battery.power_w - motors.power_w - converter).abs() < 1e-12);
            assert!((battery.voltage_v - (12.0 - 0.1 * battery.current_a())).abs() < 1e-12);
            assert_eq!((motors.voltage_v, scanner.voltage_v), (battery.voltage_v, 5.0));
        }
    }

    /// What flows leaves the cells, and the voltage is theirs less the shunt's drop: at rest some
    /// 7.5 W.
    #[test]
    fn cells_give_what_the_rails_take() {
        let mut tree = PowerTree::with_cells(LB_012, 0.8, 1);
        let mut drawn = 0.0;
        for step in 1..=40_000 {
            let [battery, ..] = tree.supply(f64::from(step) * 0.01, 3.0);
            drawn += battery.current_a() * 0.01;
        }
        let gone = 0.8 - tree.charge().unwrap();
        assert!((gone * 1.8 * 3600.0 / drawn - 1.0).abs() < 1e-3, "{gone} {drawn}");
        let [before, ..] = tree.supply(400.0, 3.0);
        let [after, ..] = tree.supply(400.001, 13.0);
        let drop = (before.voltage_v - after.voltage_v) / (after.current_a() - before.current_a());
        // 3 · 50 mΩ, somewhat more below 25 °C, and the shunt's 0.1 Ω.
        assert!((0.24..0.28).contains(&drop), "{drop}");
        assert_eq!(PowerTree::new(12.0, 1).charge(), None);
    }

    /// By hand, at a battery of 12 V: the converter gives (2.5 + 2 + 0.5) W / 0.9 = 5.5556 W, the
    /// servos take 0.104 A. The voltage solves V² − (12 − 0.0104) V + 0.55556 = 0: 11.94308 V.
    /// Motors 1.24208 W; with torque 1.12 W / 12 V more current: 2.3556 W.
    #[test]
    fn a_standing_robot_draws_what_its_data_sheets_say() {
        let mut tree = PowerTree::new(12.0, 1);
        let [battery, motors, computer, lidar] = tree.supply(0.0, 0.0);
        assert!((battery.voltage_v - 11.943_08).abs() < 1e-5, "{}", battery.voltage_v);
        assert!((motors.power_w - 1.242_08).abs() < 1e-5, "{}", motors.power_w);
        assert_eq!((computer.power_w, lidar.power_w), (2.5, 2.0));
        tree.torque = [true; SERVOS];
        let more = tree.supply(0.0, 0.0)[1].power_w - motors.power_w;
        // 93.33 mA at 11.9337 V, and 9.3 mV less for the 104 mA.
        assert!((more - 1.1129).abs() < 1e-3, "{more}");
    }

    /// Exponential dwells of 20 and 8 s: at work for 2/7 of the time. Over 100 000 s, 3571 cycles,
    /// the share's standard deviation is √(2 (2/7)² (5/7)² / 3571) = 0.0048; four of them.
    #[test]
    fn the_computer_works_for_its_share_of_the_time() {
        let mut tree = PowerTree::new(12.0, 3);
        let busy = (0..100_000).filter(|&s| tree.supply(f64::from(s), 0.0)[2].power_w > 3.0).count();
        assert!((busy as f64 / 1e5 - 2.0 / 7.0).abs() < 0.02, "{busy}");
    }
}
