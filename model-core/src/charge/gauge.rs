//! The gauge: counts charge, and lets the voltage correct the count.
//!
//! A cell's voltage is U(s) + b − r₀ I − r₁ I₁ − r₂ I₂: the curve at charge s, what this cell has
//! beyond the curve, and the drops of the current at once and of its parts that follow with time
//! constants of seconds and minutes. All but U is linear in the unknowns s, b, r, so one filter
//! learns resistances from load steps and charge from what they leave. At rest the drops vanish
//! with what is not known of them: there the voltage says most.

use super::filter::{CHARGE, DRIFT, Filter, OFFSET, RESISTANCES};
use super::remaining::{Charge, Remaining, Resistance};
use super::{Curve, Pack};
use crate::real::Real;

// Where nothing else is said, what follows was tuned on 60 discharges of the simulated packs of
// `cargo xtask bench charge`, drawn by another random generator than its own: it is right for packs
// like those, and no measured pack has been asked.

/// The filter takes means over so long, s: polarisation does not move faster, and a board samples
/// 200 times as often.
const STEP_S: f64 = 1.0;
/// Longer steps of time are gaps, in which nobody counted, s.
const GAP_S: f64 = 10.0;
/// Time constants of the two polarisations, s: charge transfer and diffusion of small cells lie
/// around these.
const POLARISATION_S: [f64; 2] = [20.0, 300.0];
/// What is known of a cell's resistances beforehand: nothing but their size, Ω. A small cell has 20
/// to 100 mΩ at once and as much again later.
const RESISTANCE_OHM: [f64; 3] = [0.06, 0.03, 0.02];
/// What a cell's resistance is worth after minutes of load where nobody has learned it, Ω.
pub const USUAL_RESISTANCE_OHM: f64 = RESISTANCE_OHM[0] + RESISTANCE_OHM[1] + RESISTANCE_OHM[2];
const RESISTANCE_STD_OHM: [f64; 3] = [0.08, 0.03, 0.02];
/// By how much a cell's curve differs from the table, V, and over which share of the charge that
/// stays so: two makes of one chemistry and their hysteresis differ by this and not by more (the
/// curves of Molicel's and Samsung's cells in `cargo xtask bench charge`).
const OFFSET_STD_V: f64 = 0.010;
const OFFSET_SHARE: f64 = 0.15;
/// By how much capacity and counted current may be wrong over a whole discharge, as shares.
const COUNT_STD: f64 = 0.03;
/// Resistances wander by this share of their first size over a tenth of the charge (they rise at
/// its end), and in a quarter of an hour (warmth).
const WANDER: f64 = 0.15;
/// What a cell's voltage does besides, V, and for how long, s: polarisation of other shapes than
/// these, warmth.
const DRIFT_STD_V: f64 = 0.015;
const DRIFT_S: f64 = 30.0;
/// The same per ampere, Ω.
const DRIFT_OHM: f64 = 0.02;
/// Standard deviation of the mean over a step, V per cell: sensor, and steps of load within it.
const VOLTAGE_STD_V: f64 = 0.004;
/// What is shown follows what is believed by so much a second, beside what is counted: a load step
/// that teaches the resistance moves the belief at once, and nobody wants to see that. 3 points a
/// minute.
const SLEW: f64 = 0.0005;
/// How much wider than the first voltage tells the charge begins: that voltage counts again as a
/// correction, with the same offset.
const PLACE: f64 = 2.0;
/// A charge is unknown until it is known to this.
const KNOWN_STD: f64 = 0.1;
/// A resistance is unknown until it is known to this share.
const KNOWN_RESISTANCE: f64 = 0.5;
/// Time constant of the load that the remaining time is estimated for, s.
const LOAD_S: f64 = 60.0;

/// What is known of the charge at the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Start<T> {
    /// Nothing.
    Unknown,
    /// This much, from a store or a charger.
    Known(Charge<T>),
}

/// Sums over the step in hand.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Sums<T> {
    time: T,
    /// A·s.
    charge: T,
    /// V·s.
    voltage: T,
    /// J.
    energy: T,
}

/// Counts charge and corrects the count. [`Self::update`] once a sample; it may be asked at any
/// time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gauge<T> {
    pack: Pack<T>,
    filter: Filter<T>,
    /// The charge as it is shown; `None` while it is unknown.
    shown: Option<T>,
    /// Nothing told it the charge, and no voltage has come yet.
    is_lost: bool,
    step: Sums<T>,
    /// The current's slow parts, A.
    slow: [T; 2],
    /// Mean power of the last minute, W; `None` before the first step.
    load: Option<T>,
    /// Mean current of the last minute, A.
    current: T,
}

impl<T: Real> Gauge<T> {
    /// Of a pack and what is known of its charge.
    pub fn new(pack: Pack<T>, start: Start<T>) -> Self {
        let number = T::from_f64;
        let charge = match start {
            Start::Known(charge) if charge.share.is_finite() && charge.std.is_finite() => charge,
            // Uniform from 0 to 1 would be 0.29; a little more, for the table's own ends.
            _ => Charge { share: T::HALF, std: number(0.35) },
        };
        let share = T::ZERO.at_least(charge.share).at_most(T::ONE);
        let [r0, r1, r2] = RESISTANCE_OHM.map(number);
        let [d0, d1, d2] = RESISTANCE_STD_OHM.map(number);
        let filter = Filter::new(
            [share, T::ZERO, r0, r1, r2, T::ZERO],
            [charge.std.at_least(number(0.005)), number(OFFSET_STD_V), d0, d1, d2, number(DRIFT_STD_V)],
        );
        let mut gauge = Self {
            pack,
            filter,
            shown: None,
            is_lost: matches!(start, Start::Unknown),
            step: Sums::default(),
            slow: [T::ZERO; 2],
            load: None,
            current: T::ZERO,
        };
        // What a start tells is shown however uncertain it is: its own deviation says so.
        gauge.shown = matches!(start, Start::Known(_)).then_some(share);
        gauge
    }

    /// Takes the current in A, positive while discharging, and the voltage in V of the whole pack,
    /// held for `elapsed` s. What is not finite, and time that runs backwards, changes nothing;
    /// after a gap the charge is as uncertain as the load before makes it.
    pub fn update(&mut self, current: T, voltage: T, elapsed: T) {
        let charge = current * elapsed;
        let is_sample = charge.is_finite() && (voltage * elapsed).is_finite() && elapsed > T::ZERO;
        if !is_sample || voltage <= T::ZERO {
            return;
        }
        if elapsed > T::from_f64(GAP_S) {
            self.pass(elapsed);
            return;
        }
        self.step.time += elapsed;
        self.step.charge += charge;
        self.step.voltage += voltage * elapsed;
        self.step.energy += voltage * charge;
        // Half a sample early rather than one late.
        if self.step.time + T::HALF * elapsed >= T::from_f64(STEP_S) {
            let step = self.step;
            self.step = Sums::default();
            self.close(&step);
        }
    }

    /// A gap: the load may have gone on or not.
    fn pass(&mut self, elapsed: T) {
        let gone = self.current.abs() * elapsed / self.pack.capacity;
        let half = (T::HALF * gone).at_most(T::ONE);
        self.count(half);
        self.filter.loosen(CHARGE, half * half);
        self.slow = [T::HALF * self.current; 2];
        self.step = Sums::default();
    }

    /// Takes a share of the capacity out.
    fn count(&mut self, gone: T) {
        let number = T::from_f64;
        let [charge, ..] = &mut self.filter.state;
        *charge = (*charge - gone).at_least(-number(0.05)).at_most(number(1.05));
        self.shown = self.shown.map(|shown| shown - gone);
        let moved = gone.abs();
        self.filter.loosen(CHARGE, number(COUNT_STD * COUNT_STD) * moved);
        let keep = T::ONE / (T::ONE + moved / number(OFFSET_SHARE));
        self.filter.fade(OFFSET, keep);
        self.filter.loosen(OFFSET, number(OFFSET_STD_V * OFFSET_STD_V) * (T::ONE - keep * keep));
    }

    fn close(&mut self, step: &Sums<T>) {
        let number = T::from_f64;
        let (current, voltage) = (step.charge / step.time, step.voltage / step.time / self.pack.cells);
        let gone = step.charge / self.pack.capacity;
        self.count(gone);
        for (slow, constant) in self.slow.iter_mut().zip(POLARISATION_S) {
            *slow += (current - *slow) * step.time / (step.time + number(constant));
        }
        let wander = WANDER * WANDER;
        let share = number(wander / 0.1) * gone.abs() + number(wander / 900.0) * step.time;
        for (place, size) in RESISTANCES.into_iter().zip(RESISTANCE_OHM) {
            self.filter.loosen(place, share * number(size * size));
        }
        let keep = number(DRIFT_S) / (number(DRIFT_S) + step.time);
        let under_load = number(DRIFT_OHM) * current;
        self.filter.fade(DRIFT, keep);
        let variance = number(DRIFT_STD_V * DRIFT_STD_V) + under_load * under_load;
        self.filter.loosen(DRIFT, variance * (T::ONE - keep * keep));
        if core::mem::replace(&mut self.is_lost, false) {
            self.place(current, voltage);
        }
        self.correct(current, voltage);
        self.show(step.time);
        let weight = step.time / (step.time + number(LOAD_S));
        let power = step.energy / step.time;
        self.current += (current - self.current) * weight;
        self.load = Some(self.load.map_or(power, |load| load + (power - load) * weight));
    }

    /// Begins where a cell's first voltage points to: from the middle of the scale, corrections
    /// would follow a slope that the curve does not have where the cell is.
    fn place(&mut self, current: T, voltage: T) {
        let number = T::from_f64;
        let [resistance, ..] = RESISTANCE_OHM.map(number);
        let [uncertain, ..] = RESISTANCE_STD_OHM.map(number);
        let charge = self.pack.curve.charge(voltage + resistance * current);
        let drop = uncertain * current;
        let variance = number(OFFSET_STD_V * OFFSET_STD_V + DRIFT_STD_V * DRIFT_STD_V) + drop * drop;
        let spread = number(PLACE) * variance.sqrt();
        let mut std = number(0.3);
        for _ in 0..8 {
            let slope = Curves::around(&self.pack.curve, charge, std * std).slope;
            std = (std + (spread / slope).at_least(number(0.02)).at_most(number(0.3))) * T::HALF;
        }
        self.filter.set(CHARGE, charge, std * std);
    }

    /// Lets a cell's mean voltage over a step correct what is believed.
    fn correct(&mut self, current: T, voltage: T) {
        let number = T::from_f64;
        let [charge, offset, r0, r1, r2, drift] = self.filter.state;
        let [minutes, hours] = self.slow;
        let Curves { middle, slope, bend } =
            Curves::around(&self.pack.curve, charge, self.filter.variance(CHARGE));
        let expected = middle + offset + drift - r0 * current - r1 * minutes - r2 * hours;
        let noise = number(VOLTAGE_STD_V * VOLTAGE_STD_V) + bend * bend;
        let slopes = [slope, T::ONE, -current, -minutes, -hours, T::ONE];
        self.filter.correct(voltage - expected, &slopes, noise);
        let [charge, _, resistances @ .., _] = &mut self.filter.state;
        *charge = charge.at_least(-number(0.05)).at_most(number(1.05));
        for resistance in resistances {
            *resistance = resistance.at_least(T::ZERO);
        }
    }

    /// Lets what is shown follow what is believed.
    fn show(&mut self, elapsed: T) {
        let [believed, ..] = self.filter.state;
        let most = T::from_f64(SLEW) * elapsed;
        let is_known = self.filter.variance(CHARGE).sqrt() <= T::from_f64(KNOWN_STD);
        let shown = match self.shown {
            Some(shown) => Some(shown + (believed - shown).at_least(-most).at_most(most)),
            None if is_known => Some(believed),
            None => None,
        };
        self.shown = shown.map(|shown| T::ZERO.at_least(shown).at_most(T::ONE));
    }

    /// How full it is; `None` before that is known to a tenth of the capacity, unless the start
    /// told it. While what is shown still follows what is believed, the deviation holds the
    /// distance of both.
    pub fn charge(&self) -> Option<Charge<T>> {
        let [believed, ..] = self.filter.state;
        let share = self.shown?;
        let behind = T::ZERO.at_least(believed).at_most(T::ONE) - share;
        Some(Charge { share, std: (self.filter.variance(CHARGE) + behind * behind).sqrt() })
    }

    /// Its resistance; `None` before load steps have shown it.
    pub fn resistance(&self) -> Option<Resistance<T>> {
        let [_, _, r0, r1, r2, _] = self.filter.state;
        let [first, ..] = RESISTANCES;
        let std = self.filter.variance(first).sqrt();
        let cells = self.pack.cells;
        (std <= T::from_f64(KNOWN_RESISTANCE) * r0).then_some(Resistance {
            at_once: cells * r0,
            std: cells * std,
            lasting: cells * (r0 + r1 + r2),
        })
    }

    /// Energy and time until the robot stops at the present load; `None` while the charge is
    /// unknown.
    pub fn remaining(&self) -> Option<Remaining<T>> {
        let charge = self.charge()?;
        let load = self.load?;
        let z = T::from_f64(1.96);
        let energy = self.energy_from(charge.share);
        Some(Remaining {
            energy,
            energy_low: self.energy_from(charge.share - z * charge.std),
            energy_high: self.energy_from((charge.share + z * charge.std).at_most(T::ONE)),
            time: (load > T::ZERO).then_some(energy / load),
            load,
        })
    }

    /// What the pack gives from this charge on to the cutoff, J, at the mean current of the last
    /// minute.
    fn energy_from(&self, charge: T) -> T {
        let [_, offset, r0, r1, r2, _] = self.filter.state;
        let drop = (r0 + r1 + r2) * T::ZERO.at_least(self.current);
        self.pack.energy(T::ZERO.at_least(charge), T::ZERO, drop - offset)
    }
}

/// The curve about a charge that is not known exactly.
struct Curves<T> {
    middle: T,
    /// V per unit of charge, over what is likely.
    slope: T,
    /// What the slope leaves out, V.
    bend: T,
}

impl<T: Real> Curves<T> {
    /// Secants over one standard deviation to both sides: a tangent would trust a steep end from
    /// afar.
    fn around(curve: &Curve<T>, charge: T, variance: T) -> Self {
        let reach = variance.sqrt().at_least(T::from_f64(0.01)).at_most(T::from_f64(0.3));
        let middle = curve.voltage(charge);
        let (below, above) = (curve.voltage(charge - reach), curve.voltage(charge + reach));
        Self { middle, slope: T::HALF * (above - below) / reach, bend: T::HALF * (above + below) - middle }
    }
}
