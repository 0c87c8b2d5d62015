//! What the board makes of its samples: model-core's estimator, whichever model the coefficients
//! hold.
//!
//! Set up as `gmr estimate` replays a log unless told otherwise, so that the two agree: least
//! squares over the window for the signed torque model, with its effects where the coefficients
//! hold any, or with ground that adapts where they say so; the paper's averages of roots for Eq.
//! 18; a moving window; watching for changes. A sample that lacks the power or a wheel is left out,
//! as the log's reader leaves out such a row, and the next one's step reaches back to the last that
//! counted.

mod clock;
mod pipeline;
#[cfg(test)]
pub(crate) mod tests;

use model_core::coefficients::Coefficients;
use model_core::eq18::Gate;
use model_core::estimator::{Estimate, Sample, Unfit};
use model_core::model::Model;
use model_core::payload::{Beyond, MassEstimate, Place, Unknown};

use crate::parameters::{BUCKET_S, DEAD_BAND_RAD_S, WINDOW_S};
use crate::wheels::WHEELS;
use clock::Clock;
use pipeline::Pipeline;

/// A sample behind the filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Filtered {
    /// rad/s, positive forward; 0 within the dead band.
    pub speed: [f32; WHEELS],
    /// rad/s²
    pub acceleration: [f32; WHEELS],
    /// Actuation power, W: static power taken off.
    pub power: f32,
}

/// What is known after a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimated {
    /// The estimator took this sample.
    pub taken: bool,
    /// The sample behind the filter, once that has settled.
    pub filtered: Option<Filtered>,
    /// P̂_act, W.
    pub predicted_power: Option<f32>,
    /// Total mass, or why it is unknown.
    pub mass: MassEstimate<f32>,
    /// With this sample a payload change was noticed.
    pub changed: bool,
}

impl Default for Estimated {
    fn default() -> Self {
        Self {
            taken: false,
            filtered: None,
            predicted_power: None,
            mass: MassEstimate::Unknown(Unknown::NoSamples),
            changed: false,
        }
    }
}

/// The payload as the control table's `PAYLOAD_STATE` shows it.
#[must_use]
pub const fn mass_code(mass: &MassEstimate<f32>) -> u8 {
    match mass {
        MassEstimate::Known(_) => 0,
        MassEstimate::Unknown(Unknown::NoSamples) => 1,
        MassEstimate::Unknown(Unknown::NoMotion) => 2,
        MassEstimate::Unknown(Unknown::TooWide) => 3,
        MassEstimate::Unknown(Unknown::NotFinite) => 4,
        MassEstimate::Unknown(Unknown::NotIdentifiable) => 7,
        MassEstimate::Beyond(Beyond { place: Place::Below, .. }) => 5,
        MassEstimate::Beyond(Beyond { place: Place::Above, .. }) => 6,
        MassEstimate::Beyond(Beyond { place: Place::Within, .. }) => 0,
    }
}

/// The model as the control table's `MODEL` shows it; 255 for one that no image can hold.
#[must_use]
pub const fn model_code(coefficients: &Coefficients<f32, WHEELS>) -> u8 {
    match coefficients.model {
        Model::Eq18 { gate: Gate::Published, .. } => 0,
        Model::Eq18 { gate: Gate::Corrected, .. } => 1,
        Model::Signed { .. } if coefficients.ground_adapts => 3,
        Model::Signed { .. } => 2,
        Model::Eq18 { gate: Gate::Signed, .. } => NO_MODEL,
    }
}

/// `MODEL` without coefficients.
pub const NO_MODEL: u8 = 255;

/// Payload changes noticed since start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Changes {
    /// How many.
    pub count: u32,
    /// Since when the payload is another, by the last of them, µs since start.
    pub last_us: Option<u64>,
}

impl Changes {
    /// None yet.
    pub const NONE: Self = Self { count: 0, last_us: None };
}

/// The estimator with its coefficients, or without: then nothing is estimated.
#[derive(Debug, Clone, Copy, Default)]
pub struct Estimation {
    running: Option<Running>,
    changes: Changes,
    /// Actuation energy measured and predicted, J, by coefficients in use before.
    energy_before: Option<(f32, f32)>,
    counted: Counted,
}

/// Samples that the actuation energies count, since start: a sample of which speeds or power are
/// not known counts for neither, one at which the mass is unknown only for what is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counted {
    /// By [`Estimation::energy`], measured.
    pub measured: u32,
    /// Predicted.
    pub predicted: u32,
}

impl Counted {
    /// None yet.
    pub const NONE: Self = Self { measured: 0, predicted: 0 };
}

#[derive(Debug, Clone, Copy)]
struct Running {
    pipeline: Pipeline,
    clock: Clock,
    model: u8,
    static_power: f32,
    dead_band: f32,
    mass: MassEstimate<f32>,
}

impl Estimation {
    /// From now on with these coefficients, or with none. What the estimator knew is forgotten;
    /// changes and energies go on.
    ///
    /// # Errors
    /// A filter cutoff or effects that the sample rate cannot have. Everything stays as it was.
    pub fn set_coefficients(
        &mut self,
        coefficients: Option<&Coefficients<f32, WHEELS>>,
    ) -> Result<(), Unfit> {
        let energy = self.energy();
        // Set where it is to be: an estimator is large, and every hand that passes it on has a copy
        // on the stack.
        match coefficients {
            None => self.running = None,
            Some(coefficients) => self.running = Some(Running::new(coefficients)?),
        }
        self.energy_before = energy;
        Ok(())
    }

    /// Whether there are coefficients.
    #[must_use]
    pub const fn has_coefficients(&self) -> bool {
        self.running.is_some()
    }

    /// As the control table's `MODEL`.
    #[must_use]
    pub fn model(&self) -> u8 {
        self.running.as_ref().map_or(NO_MODEL, |running| running.model)
    }

    /// Wheels slower than this are at rest, rad/s.
    #[must_use]
    pub fn dead_band(&self) -> f32 {
        self.running.as_ref().map_or(DEAD_BAND_RAD_S, |running| running.dead_band)
    }

    /// Changes of the payload so far.
    #[must_use]
    pub const fn changes(&self) -> Changes {
        self.changes
    }

    /// Actuation energy since start, J, by Eq. 9: measured, and predicted while the mass was known.
    /// `None` as long as there were no coefficients: what of the motors' power is static was not
    /// known.
    #[must_use]
    pub fn energy(&self) -> Option<(f32, f32)> {
        let now = self.running.as_ref().map(|running| running.pipeline.energy());
        match (self.energy_before, now) {
            (Some((measured, predicted)), Some(now)) => Some((measured + now.0, predicted + now.1)),
            (before, now) => now.or(before),
        }
    }

    /// How many samples that energy counts.
    #[must_use]
    pub const fn counted(&self) -> Counted {
        self.counted
    }

    /// Takes a sample `time_us` since start: wheel speeds in rad/s and the power of the motors'
    /// rail in W, where they are known.
    pub fn sample(
        &mut self,
        wheel_speed: Option<[f32; WHEELS]>,
        motors_power: Option<f32>,
        time_us: u64,
    ) -> Estimated {
        let Some(running) = &mut self.running else { return Estimated::default() };
        let (Some(wheel_speed), Some(motors_power)) = (wheel_speed, motors_power) else {
            return running.hold(time_us);
        };
        let sample =
            Sample { wheel_speed, wheel_acceleration: None, power: motors_power - running.static_power };
        let estimate = running.pipeline.push(&sample, running.clock.advance(time_us));
        running.mass = estimate.mass;
        self.counted.measured += u32::from(estimate.conditioned.is_some());
        self.counted.predicted += u32::from(estimate.power.is_some());
        if let Some(ago) = estimate.changed {
            let length_us = (ago as u64).saturating_mul(BUCKET_S as u64 * 1_000_000);
            self.changes.count = self.changes.count.saturating_add(1);
            self.changes.last_us = Some(time_us.saturating_sub(length_us));
        }
        Estimated {
            taken: true,
            filtered: filtered(&estimate),
            predicted_power: estimate.power,
            mass: estimate.mass,
            changed: estimate.changed.is_some(),
        }
    }
}

impl Running {
    fn new(coefficients: &Coefficients<f32, WHEELS>) -> Result<Self, Unfit> {
        Ok(Self {
            pipeline: Pipeline::new(coefficients)?,
            clock: Clock::default(),
            model: model_code(coefficients),
            static_power: coefficients.robot.static_power,
            dead_band: coefficients.robot.dead_band,
            mass: MassEstimate::Unknown(Unknown::NoSamples),
        })
    }

    /// Without a new sample the mass is what it was, until no sample of its window is left.
    fn hold(&self, time_us: u64) -> Estimated {
        let mass = if self.clock.since_us(time_us) < WINDOW_S as u64 * 1_000_000 {
            self.mass
        } else {
            MassEstimate::Unknown(Unknown::NoSamples)
        };
        Estimated { mass, ..Estimated::default() }
    }
}

fn filtered(estimate: &Estimate<f32, WHEELS>) -> Option<Filtered> {
    let now = estimate.conditioned.as_ref().filter(|now| now.settled)?;
    Some(Filtered {
        speed: now.motion.wheels.map(|wheel| wheel.speed),
        acceleration: now.motion.wheels.map(|wheel| wheel.acceleration),
        power: now.power,
    })
}
