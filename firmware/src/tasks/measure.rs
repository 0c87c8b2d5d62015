//! Takes the samples, on time.

use embassy_time::{Instant, Timer};
use embedded_hal_async::delay::DelayNs;

use super::deadline::Schedule;
use super::sensor_bus::BusCounters;
use super::shared::{Reporter, Shared};
use super::supply::Supply;
use crate::control_table::Reason;
use crate::log::{Shown, info, warning};
use crate::measurement::{Sampler, Snapshot};
use crate::parameters::SAMPLE_RATE_HZ;
use crate::power_sensors::Convert;
use crate::wheels::SwitchedPort;

/// Missed deadlines are logged once in so many samples: ten seconds.
const SAMPLES_PER_REPORT: u32 = 10 * SAMPLE_RATE_HZ;

/// Samples at the rate of the parameters file and drives as the host asks, for good.
pub async fn measure<I, P, D>(mut sampler: Sampler<I, P, D>, bus: &BusCounters, shared: &Shared) -> !
where
    I: Convert,
    P: SwitchedPort,
    D: DelayNs,
{
    let mut schedule = Schedule::new(Instant::now().as_micros());
    let mut settings = None;
    let mut report = Report::default();
    let mut supply = Supply::default();
    loop {
        let next_us = schedule.next_us();
        // A heartbeat that ends between two samples ends the motion then, not with the next one.
        if let Some(stop_us) = shared.with(|state| state.pilot.stop_us()).filter(|stop_us| *stop_us < next_us)
        {
            Timer::at(Instant::from_micros(stop_us)).await;
            let now_us = Instant::now().as_micros();
            let orders = shared.with(|state| state.pilot.orders(now_us));
            // No packet while the flash is written, and none is begun while one is on the bus: then
            // the next sample stops the wheels.
            shared.set_sampling(true);
            if !shared.is_held() {
                sampler.hurry(now_us, &orders).await;
            }
            shared.set_sampling(false);
            continue;
        }
        Timer::at(Instant::from_micros(next_us)).await;
        let now_us = Instant::now().as_micros();
        let missed = schedule.begin(now_us);
        shared.report(Reporter::Measure, now_us);
        shared.set_sampling(true);
        if shared.is_held() {
            shared.set_sampling(false);
            continue;
        }
        // The flash was written: nothing could be on time.
        let missed = if shared.take_stall() { 0 } else { missed };

        let changes = shared.with(|state| state.settings().changes());
        if settings != Some(changes) {
            settings = Some(changes);
            use_settings(&mut sampler, shared);
        }
        sampler.set_servo_supply(shared.with(|state| supply.is_wanted(state, now_us)));
        let orders = shared.with(|state| state.pilot.orders(now_us));

        let record = sampler.sample_and_drive(now_us, &orders).await;
        shared.set_sampling(false);
        let snapshot = sampler.snapshot();
        shared.with(|state| {
            state.fifo.push(record);
            report.add(&state.snapshot, &snapshot, missed);
            state.show(&snapshot);
            state.counters.missed_deadlines = state.counters.missed_deadlines.saturating_add(missed);
            state.counters.bus_errors = bus.errors();
            state.counters.bus_recoveries = bus.recoveries();
        });
    }
}

/// Estimates with what is stored now, or not at all.
fn use_settings<I, P, D>(sampler: &mut Sampler<I, P, D>, shared: &Shared)
where
    I: Convert,
    P: SwitchedPort,
    D: DelayNs,
{
    shared.with(|state| {
        let settings = state.settings();
        sampler.set_power_factors(settings.calibration().power_factors);
        // Cannot fail: coefficients whose cutoff the sample rate cannot have are not in use.
        let _ = sampler.set_coefficients(settings.coefficients().ok());
        log_coefficients(settings.coefficients().err());
    });
}

fn log_coefficients(reason: Option<Reason>) {
    match reason {
        None => info!("coefficients: in use"),
        Some(reason) => warning!("coefficients: none, {=str}", reason.text()),
    }
}

/// Logs what is news.
#[derive(Default)]
struct Report {
    samples: u32,
    missed: u32,
}

impl Report {
    fn add(&mut self, before: &Snapshot, now: &Snapshot, missed: u32) {
        for (index, (before, now)) in before.rails.iter().zip(&now.rails).enumerate() {
            if before.health != now.health {
                info!("rail {=usize}: {}", index, Shown(&now.health));
            }
        }
        for (index, (before, now)) in before.wheels.iter().zip(&now.wheels).enumerate() {
            if before.health != now.health {
                info!("wheel {=usize}: {}", index, Shown(&now.health));
            }
        }
        if before.estimate.changes != now.estimate.changes {
            info!("the payload has changed: {=u32}", now.estimate.changes.count);
        }
        self.missed = self.missed.saturating_add(missed);
        self.samples += 1;
        if self.samples >= SAMPLES_PER_REPORT {
            if self.missed > 0 {
                warning!("{=u32} deadlines missed in {=u32} samples", self.missed, self.samples);
            }
            (self.samples, self.missed) = (0, 0);
        }
    }
}
