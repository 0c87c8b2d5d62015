//! A baseline whose parameters recursive least squares follow while it drives.

use super::recursive::Recursive;
use super::regression::{Symbol, Terms, named, rows, unfitted};
use super::{Baseline, Parameter, Point};
use crate::error::Result;

/// How long it remembers, s: the forgetting factor is λ = exp(-Δt / 60 s) between two points Δt apart, 0.9992 at 20 Hz, so
/// that it means the same in logs of any rate. The sources give no figure; a minute holds several manoeuvres, and is shorter
/// than what stays on one ground.
pub const MEMORY_S: f64 = 60.0;

/// Terms of a power that is linear in them, and what is known of their coefficients.
pub struct Online<const TERMS: usize> {
    /// In refusals.
    name: &'static str,
    symbols: [Symbol; TERMS],
    terms: Terms<[f64; TERMS]>,
    known: Option<Recursive<TERMS>>,
}

impl<const TERMS: usize> Online<TERMS> {
    /// Not fitted.
    pub fn new(
        name: &'static str,
        symbols: [Symbol; TERMS],
        terms: impl Fn(&Point) -> [f64; TERMS] + 'static,
    ) -> Self {
        Self { name, symbols, terms: Box::new(terms), known: None }
    }
}

impl<const TERMS: usize> Baseline for Online<TERMS> {
    /// The training gives the parameters with which a drive begins. All of it weighs alike, and no more than one memory
    /// of driving, or a long training would hold on against what the drive shows.
    fn fit(&mut self, training: &[Point]) -> Result<()> {
        self.known = None;
        let mut known = Recursive::diffuse();
        for (terms, power) in rows(self.name, training, &self.terms)? {
            known.update(&terms, power, 1.0);
        }
        self.known = Some(known.forget(MEMORY_S / duration(training).max(MEMORY_S)));
        Ok(())
    }

    fn predict(&self, points: &[Point]) -> Result<Vec<f64>> {
        let known = self.known.ok_or_else(|| unfitted(self.name))?;
        Ok(known.drive(points, MEMORY_S, &self.terms))
    }

    fn parameters(&self) -> Vec<Parameter> {
        self.known.map_or(Vec::new(), |known| named(&self.symbols, &known.estimate()))
    }
}

/// From the first to the last point of each run, s.
fn duration(points: &[Point]) -> f64 {
    let runs = points.chunk_by(|a, b| a.run == b.run);
    runs.filter_map(|run| Some(run.last()?.time - run.first()?.time)).sum()
}

#[cfg(test)]
mod tests {
    use super::{MEMORY_S, Online};
    use crate::baselines::testing::{PERIOD_S, drive};
    use crate::baselines::{Baseline, Point, longitudinal};

    fn online() -> Online<{ longitudinal::TERMS }> {
        Online::new("online", longitudinal::SYMBOLS, longitudinal::terms)
    }

    /// After ten minutes at 3 N the ground becomes one of 6 N. The training weighs one memory T, which has decayed to
    /// T exp(-t/T) after a time t in which the drive has collected T (1 - exp(-t/T)). Where all terms are as excited in both,
    /// 3 memories leave exp(-3) = 5 % of the training, so the estimate is within 5 % of the step (doubled: they are not
    /// quite); with the training's full ten minutes (weight 10 T) a third would be left.
    #[test]
    fn follows_a_change_of_ground_within_its_memory() {
        let minute = (60.0 / PERIOD_S) as usize;
        let ground = |force: f64| move |point: &Point| 1.0 + force * longitudinal::terms(point)[1];
        let mut model = online();
        model.fit(&drive(10 * minute, ground(3.0))).unwrap();
        assert!((model.parameters()[1].value - 3.0).abs() < 1e-3);
        let points = drive((3.2 * MEMORY_S / PERIOD_S) as usize, ground(6.0));
        let predicted = model.predict(&points).unwrap();
        let late = (3.0 * MEMORY_S / PERIOD_S) as usize;
        let implied = |i: usize| (predicted[i] - 1.0) / longitudinal::terms(&points[i])[1];
        let fast = |range: std::ops::Range<usize>| range.filter(|i| points[*i].speed.vx.abs() > 0.15);
        let first = fast(0..40).next().unwrap();
        assert!((implied(first) - 3.0).abs() < 0.5, "it starts as trained");
        for i in fast(late..points.len()) {
            let force = implied(i);
            assert!((force - 6.0).abs() < 0.1 * 3.0, "{force} at {}", points[i].time);
        }
    }

    #[test]
    fn refuses_what_it_cannot_learn_from() {
        let mut points = drive(100, |_| 1.0);
        assert!(online().predict(&points).unwrap_err().to_string().contains("not fitted"));
        assert!(online().fit(&points[..2]).unwrap_err().to_string().contains("2 training points"));
        points[3].acceleration.vx = f64::NAN;
        assert!(online().fit(&points).unwrap_err().to_string().starts_with("online: training point 3 has"));
    }

    /// A robot that only stood has no figure for motion: it keeps 0 there, and predicts standing power at rest.
    #[test]
    fn learns_standing_from_standing() {
        let mut points = drive(100, |_| 0.7);
        points.iter_mut().for_each(|point| point.speed = Default::default());
        let mut model = online();
        model.fit(&points).unwrap();
        let values: Vec<f64> = model.parameters().iter().map(|parameter| parameter.value).collect();
        assert!((values[0] - 0.7).abs() < 1e-6 && values[1..] == [0.0, 0.0], "{values:?}");
    }
}
