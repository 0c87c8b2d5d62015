//! All four sensors on their common bus.

use super::convert::{Conversion, Convert};
use super::sensor::Sensor;
use super::{Meter, RAIL_COUNT, RailReading, Status};
use crate::parameters::{RAILS, SENSOR_PROBE_SAMPLES};

/// The sensors of all rails on their bus.
pub struct PowerSensors<I> {
    bus: I,
    sensors: [Sensor; RAIL_COUNT],
    meters: [Meter; RAIL_COUNT],
    latest: [Option<RailReading>; RAIL_COUNT],
    /// Position in the round in which silent sensors have their turn.
    turn: u32,
}

impl<I: Convert> PowerSensors<I> {
    /// The rails of [`RAILS`] on this bus. Nothing is sent yet.
    pub fn new(bus: I) -> Self {
        Self {
            bus,
            sensors: RAILS.map(Sensor::new),
            meters: [Meter::default(); RAIL_COUNT],
            latest: [None; RAIL_COUNT],
            turn: 0,
        }
    }

    /// Asks the sensors one after the other, those that are set up in one go: what is new of each.
    /// `time_us` since start.
    ///
    /// A sensor that has gone costs its own rail, and the bus the time in which that finds out: at
    /// every poll until it counts as silent, then once in [`SENSOR_PROBE_SAMPLES`] polls, and never
    /// two silent ones in the same poll.
    pub async fn poll(&mut self, time_us: u64) -> [Option<RailReading>; RAIL_COUNT] {
        let Self { bus, sensors, meters, latest, turn } = self;
        let mut asked: [Option<Conversion>; RAIL_COUNT] = [None; RAIL_COUNT];
        for (index, (sensor, asked)) in (0..).zip(sensors.iter_mut().zip(&mut asked)) {
            if !sensor.status().is_silent() || *turn == index * TURNS {
                *asked = sensor.begin(bus).await;
            }
        }
        *turn = (*turn + 1) % SENSOR_PROBE_SAMPLES;
        bus.convert_each(&mut asked).await;
        let mut readings = [None; RAIL_COUNT];
        let places = sensors.iter_mut().zip(meters).zip(latest).zip(&mut readings);
        for (conversion, (((sensor, meter), latest), place)) in asked.into_iter().zip(places) {
            let Some(conversion) = conversion else { continue };
            let Some(reading) = sensor.end(bus, conversion.answer).await else { continue };
            let reading = RailReading::new(reading, sensor.rail().shunt);
            meter.add(reading.power, time_us);
            (*latest, *place) = (Some(reading), Some(reading));
        }
        readings
    }

    /// Whether each can be believed, and its counters.
    #[must_use]
    pub fn statuses(&self) -> [Status; RAIL_COUNT] {
        self.sensors.each_ref().map(|sensor| *sensor.status())
    }

    /// What each said last.
    #[must_use]
    pub fn latest(&self) -> [Option<RailReading>; RAIL_COUNT] {
        self.latest
    }

    /// Delivered by each since start (Eq. 9: the positive part), J.
    #[must_use]
    pub fn energies(&self) -> [f32; RAIL_COUNT] {
        self.meters.map(|meter| meter.joules())
    }

    /// Of each, true power over measured power.
    #[must_use]
    pub fn power_factors(&self) -> [f32; RAIL_COUNT] {
        self.sensors.each_ref().map(|sensor| sensor.rail().shunt.power_factor)
    }

    /// A calibration from the store: true power over measured power of each.
    pub fn set_power_factors(&mut self, factors: [f32; RAIL_COUNT]) {
        for (sensor, factor) in self.sensors.iter_mut().zip(factors) {
            sensor.set_power_factor(factor);
        }
    }

    /// Gives the bus back.
    pub fn release(self) -> I {
        self.bus
    }
}

/// Polls between the turns of two silent sensors.
const TURNS: u32 = SENSOR_PROBE_SAMPLES / RAIL_COUNT as u32;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::power_sensors::Health;
    use crate::power_sensors::testing::Chips;
    use crate::testing::now;

    /// 10 mV over 0.1 Ω at 12 V: 1.2 W.
    fn powers(readings: [Option<RailReading>; RAIL_COUNT]) -> [Option<f32>; RAIL_COUNT] {
        readings.map(|reading| reading.map(|reading| (reading.power * 100.0).round() / 100.0))
    }

    #[test]
    fn reads_each_rail_from_its_own_sensor() {
        let chips = Chips::new();
        for (chip, shunt_10uv) in chips.chips.borrow_mut().iter_mut().zip([1000, -1000, 2000, 3000]) {
            chip.shunt_10uv = shunt_10uv;
        }
        let mut sensors = PowerSensors::new(&chips);
        assert_eq!(powers(now(sensors.poll(0))), [Some(1.2), Some(-1.2), Some(2.4), Some(3.6)]);
        sensors.set_power_factors([1.0, 1.0, 0.5, 1.5]);
        assert_eq!(powers(now(sensors.poll(5_000))), [Some(1.2), Some(-1.2), Some(1.2), Some(5.4)]);
    }

    /// One sensor is gone: the others go on with every poll, and the bus is asked for the lost one
    /// 3 times, then ten times a second.
    #[test]
    fn a_dead_sensor_costs_its_own_rail() {
        let chips = Chips::new();
        chips.chips.borrow_mut()[2].is_present = false;
        let mut sensors = PowerSensors::new(&chips);
        for poll in 0..200 {
            let readings = now(sensors.poll(poll * 5_000));
            assert_eq!(readings.map(|r| r.is_some()), [true, true, false, true], "poll {poll}");
        }
        assert_eq!(sensors.statuses()[2].health(), Health::Absent);
        assert_eq!(sensors.statuses()[2].counters().no_answer, 3 + 10);
        chips.chips.borrow_mut()[2].is_present = true;
        let back = (0..).position(|poll| now(sensors.poll(1_000_000 + poll * 5_000))[2].is_some());
        assert!(back < Some(SENSOR_PROBE_SAMPLES as usize), "{back:?}");
        assert!((0..40).all(|poll| now(sensors.poll(1_100_000 + poll * 5_000))[2].is_some()));
    }

    /// All gone, as with a bus held low: at most one of them is waited for in a poll.
    #[test]
    fn a_dead_bus_is_waited_for_once_a_poll() {
        let chips = Chips::new();
        chips.chips.borrow_mut().iter_mut().for_each(|chip| chip.is_present = false);
        let mut sensors = PowerSensors::new(&chips);
        for poll in 0..100 {
            let before = chips.transactions();
            now(sensors.poll(poll * 5_000));
            let transactions = chips.transactions() - before;
            assert!(transactions <= if poll < 3 { 4 } else { 1 }, "poll {poll}: {transactions}");
        }
        assert!(chips.transactions() >= 4 * (3 + 4));
    }
}
