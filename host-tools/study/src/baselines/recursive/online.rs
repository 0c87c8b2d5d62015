//! A baseline whose parameters recursive least squares follow while it drives.

use logs::robot::Robot;
use support::error::Result;

use super::estimator::Recursive;
use crate::baselines::baseline::{Baseline, Parameter, named};
use crate::baselines::point::Point;
use crate::baselines::regression::{Body, Listed, rows, unfitted};

/// How long it remembers, s: the forgetting factor is λ = exp(-Δt / 60 s) between two points Δt
/// apart, 0.9992 at 20 Hz, so that it means the same in logs of any rate. The sources give no
/// figure; a minute holds several manoeuvres, and is shorter than what stays on one ground.
pub const MEMORY_S: f64 = 60.0;

/// Terms of a power that is linear in them, and what is known of their coefficients.
pub struct Online<const TERMS: usize> {
    /// In refusals.
    name: &'static str,
    terms: &'static [Listed; TERMS],
    body: Body,
    known: Option<Recursive<TERMS>>,
}

impl<const TERMS: usize> Online<TERMS> {
    /// Not fitted.
    pub fn new(name: &'static str, terms: &'static [Listed; TERMS], robot: &Robot) -> Self {
        Self { name, terms, body: Body::of(robot), known: None }
    }

    fn terms(&self, point: &Point) -> [f64; TERMS] {
        self.terms.map(|(.., term)| term.of(point, &self.body))
    }
}

impl<const TERMS: usize> Baseline for Online<TERMS> {
    /// The training gives the parameters at the start of a drive. All of it has the same weight,
    /// together at most that of one memory: a long training would otherwise outweigh the drive.
    fn fit(&mut self, training: &[Point]) -> Result<()> {
        self.known = None;
        let mut known = Recursive::diffuse();
        for (terms, power) in rows(self.name, training, |point| self.terms(point))? {
            known.update(&terms, power, 1.0);
        }
        self.known = Some(known.forget(MEMORY_S / duration(training).max(MEMORY_S)));
        Ok(())
    }

    fn predict(&self, points: &[Point]) -> Result<Vec<f64>> {
        let known = self.known.ok_or_else(|| unfitted(self.name))?;
        Ok(known.drive(points, MEMORY_S, |point| self.terms(point)))
    }

    fn parameters(&self) -> Vec<Parameter> {
        self.known.map_or(Vec::new(), |known| {
            named(self.terms.map(|(name, unit, _)| (name, unit)), &known.estimate())
        })
    }
}

/// From the first to the last point of each run, s.
fn duration(points: &[Point]) -> f64 {
    let runs = points.chunk_by(|a, b| a.run == b.run);
    runs.filter_map(|run| Some(run.last()?.time - run.first()?.time)).sum()
}
