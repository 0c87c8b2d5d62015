//! Reads the inertial sensor and keeps the orientation.

use embassy_time::{Delay, Duration, Instant, Timer};
use embedded_hal_async::spi::SpiDevice;

use super::shared::{Reporter, Shared};
use crate::inertial::{Chip, Fault, InertialHealth, InertialSnapshot, Motion, Tracker};
use crate::log::{info, warning};
use crate::parameters::SAMPLE_PERIOD_US;
use crate::wheels::WheelHealth;

/// Between two readings.
const PERIOD: Duration = Duration::from_micros(SAMPLE_PERIOD_US);
/// A sensor that does not answer is asked again after this time.
const RETRY: Duration = Duration::from_secs(1);
/// Longest time that one reading stands for, s: the flash may have been written meanwhile, at a
/// standstill.
const LONGEST_S: f32 = 0.5;

/// Reads the sensor on `spi` as often as samples are taken, for good. Whatever it does costs nobody
/// else more than its share of the processor: its bus is its own.
pub async fn orient<S: SpiDevice>(spi: S, shared: &Shared) -> ! {
    let mut sensor =
        Sensor { chip: Chip::new(spi), known: InertialSnapshot::UNKNOWN, read: None, retry: Instant::MIN };
    let mut tracker = Tracker::new();
    let mut due = Instant::MIN;
    loop {
        // Readings missed while a chip starts or the flash is written are not made up for. In one
        // go they would all be the same, and a chip that gives the same reading counts as stuck.
        due = (due + PERIOD).max(Instant::now());
        Timer::at(due).await;
        if shared.with(|state| state.take_calibration()) {
            tracker.calibrate();
        }
        let reading = sensor.read().await;
        // Without wheels nobody else knows whether it stands: its own readings have to tell.
        let (heading, is_standing) = shared.with(|state| {
            let wheels = &state.snapshot.wheels;
            let are_absent = wheels.iter().all(|wheel| wheel.health == WheelHealth::Absent);
            (state.heading.quaternion(), state.snapshot.is_standing || are_absent)
        });
        let known = &mut sensor.known;
        known.rotation = match reading {
            Some((motion, elapsed_s)) => tracker.feel(motion, elapsed_s, is_standing),
            None => {
                tracker.lose();
                None
            }
        };
        if known.rotation.is_none() {
            tracker.roll(heading);
        }
        known.health = match (reading, known.rotation, known.model) {
            (Some(_), Some(_), _) => InertialHealth::Ok,
            (Some(_), None, _) => InertialHealth::Settling,
            (None, _, Some(_)) => InertialHealth::Lost,
            (None, _, None) => InertialHealth::Absent,
        };
        known.acceleration = reading.map(|(motion, _)| motion.acceleration);
        known.bias = tracker.bias();
        known.is_calibrating = reading.is_some() && tracker.is_calibrating();
        known.orientation = Some(tracker.quaternion());
        shared.with(|state| state.inertial = sensor.known);
        shared.report(Reporter::Orient, Instant::now().as_micros());
    }
}

struct Sensor<S> {
    chip: Chip<S>,
    known: InertialSnapshot,
    /// When it was read last; `None` while it has to be started.
    read: Option<Instant>,
    retry: Instant,
}

impl<S: SpiDevice> Sensor<S> {
    /// What it feels, and since when, s; `None` while it does not answer.
    async fn read(&mut self) -> Option<(Motion, f32)> {
        if self.read.is_none() {
            self.start().await;
        }
        let before = self.read?;
        let motion = self.chip.motion().await;
        let now = Instant::now();
        match motion {
            Ok(motion) => {
                self.read = Some(now);
                let elapsed = now.saturating_duration_since(before).as_micros() as f32 * 1e-6;
                Some((motion, elapsed.min(LONGEST_S)))
            }
            Err(fault) => {
                self.fail(fault);
                // It may have been a glitch: asked at once, and then once a second.
                self.retry = now;
                None
            }
        }
    }

    async fn start(&mut self) {
        if Instant::now() < self.retry {
            return;
        }
        match self.chip.start(&mut Delay).await {
            Ok(model) => {
                info!("inertial sensor: {=u8}", model as u8);
                if self.known.model.replace(model).is_some() {
                    self.known.restarts = self.known.restarts.saturating_add(1);
                }
                self.read = Some(Instant::now());
            }
            Err(fault) => {
                self.fail(fault);
                self.retry = Instant::now() + RETRY;
            }
        }
    }

    fn fail(&mut self, fault: Fault) {
        self.read = None;
        // Where none was ever there, nothing has failed.
        if self.known.model.is_some() {
            self.known.errors = self.known.errors.saturating_add(1);
            warning!("inertial sensor: fault {=u8}", fault as u8);
        }
    }
}
