//! Power and energy at a payload that somebody knows: the log, or who asks.

use logs::RawRow;
use model::coefficients::FittedModel;
use model::pipeline::{Estimated, Pipeline};
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
    /// ([`FittedModel::energy_floor`]).
    pub predicted_j: f64,
}

/// Collects it sample by sample.
pub(super) struct Telling {
    /// The least power that counts, W.
    floor_w: f64,
    given_kg: Option<f64>,
    /// Of the samples so far.
    mass_kg: Option<f64>,
    is_one: bool,
    pairs: Metrics,
    joules: f64,
}

impl Telling {
    /// At a given mass, kg, or else at what each row tells.
    pub(super) fn new(coefficients: &FittedModel, given_kg: Option<f64>, mape_floor_w: f64) -> Self {
        Self {
            floor_w: coefficients.energy_floor(),
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
        pipeline: &dyn Pipeline,
        row: &RawRow,
        estimate: &Estimated,
        step: f64,
    ) -> Option<f64> {
        let mass = self.given_kg.or(row.mass)?;
        let measured = estimate.measured?;
        let adapted = estimate.power.filter(|_| pipeline.is_told());
        let power = adapted.or_else(|| pipeline.power_at(mass))?;
        self.is_one &= self.mass_kg.is_none_or(|known| known == mass);
        self.mass_kg = Some(mass);
        self.pairs.add(measured, power);
        self.joules += self.floor_w.max(power) * step;
        Some(power)
    }

    /// `None` where no mass was known.
    pub(super) fn finish(self) -> Option<Told> {
        let mass_kg = self.mass_kg.filter(|_| self.is_one);
        Some(Told { mass_kg, quality: self.pairs.quality()?, predicted_j: self.joules })
    }
}
