//! Power and energy at a payload that somebody knows: the log, or who asks.

use logs::RawRow;
use model_core::coefficients::Coefficients;
use model_core::effects::live::{Additions, Live};
use model_core::estimator::Estimate;
use serde::Serialize;
use support::metrics::{Metrics, Quality};

/// The model at a known mass, against the measured power.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Told {
    /// The mass, kg; none where the log tells several.
    pub mass_kg: Option<f64>,
    /// P̂ at it against the measured power.
    #[serde(flatten)]
    pub quality: Quality,
    /// Actuation energy by the model, J: as the measured one counts
    /// ([`Coefficients::energy_floor`]).
    pub predicted_j: f64,
}

/// Collects it sample by sample.
pub(super) struct Telling<const N: usize> {
    coefficients: Coefficients<f64, N>,
    given_kg: Option<f64>,
    /// Of the samples so far.
    mass_kg: Option<f64>,
    is_one: bool,
    pairs: Metrics,
    joules: f64,
}

impl<const N: usize> Telling<N> {
    /// At a given mass, kg, or else at what each row tells.
    pub(super) fn new(coefficients: &Coefficients<f64, N>, given_kg: Option<f64>, mape_floor_w: f64) -> Self {
        Self {
            coefficients: *coefficients,
            given_kg,
            mass_kg: None,
            is_one: true,
            pairs: Metrics::new(mape_floor_w),
            joules: 0.0,
        }
    }

    /// A sample that passed the filter, `step` s after the one before: its power by the model, W,
    /// where a mass is known. By a floor that adapted at that mass, where it does.
    pub(super) fn add(
        &mut self,
        live: Option<&Live<f64, N>>,
        adapted_w: Option<f64>,
        row: &RawRow,
        estimate: &Estimate<f64, N>,
        step: f64,
    ) -> Option<f64> {
        let mass = self.given_kg.or(row.mass)?;
        let now = estimate.conditioned.filter(|now| now.settled)?;
        let Coefficients { robot, model, .. } = &self.coefficients;
        let beyond = mass - robot.range.middle();
        let power = match (adapted_w, live) {
            (Some(power), _) => power,
            (None, Some(live)) => live.respond(model, &now, &robot.range, beyond).power,
            (None, None) => ().respond(model, &now, &robot.range, beyond).power,
        };
        self.is_one &= self.mass_kg.is_none_or(|known| known == mass);
        self.mass_kg = Some(mass);
        self.pairs.add(now.power, power);
        self.joules += self.coefficients.energy_floor().max(power) * step;
        Some(power)
    }

    /// `None` where no mass was known.
    pub(super) fn finish(self) -> Option<Told> {
        let mass_kg = self.mass_kg.filter(|_| self.is_one);
        Some(Told { mass_kg, quality: self.pairs.quality()?, predicted_j: self.joules })
    }
}
