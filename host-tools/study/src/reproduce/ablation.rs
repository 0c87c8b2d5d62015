//! Eq. 18 with some of its print and some of its derivation: fitted, and judged.

use fit::dataset::{Dataset, Kept, Row, Stretch};
use fit::gram::Gram;
use fit::linear;
use logs::robot::chassis::Together;
use model_core::eq18::{self, Gate, REGRESSORS};
use model_core::model::Response;
use model_core::payload::roots::{RootMean, Sums};
use model_core::payload::{self, Method};
use support::error::{Error, Result};
use support::metrics::Metrics;

/// One training log and one test log of a plant, as one seed drew them.
#[derive(Debug, Clone)]
pub(super) struct Pair {
    /// The plant, as tables name it.
    pub(super) plant: &'static str,
    /// Payload known.
    pub(super) training: Dataset,
    /// Payload to be found.
    pub(super) test: Dataset,
    /// Power below which relative errors mean nothing, W.
    pub(super) floor_w: f64,
}

/// Which places are as printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Variant {
    /// (2 + s) and (2 + r), or (1 + s) and (1 + r).
    gates: Gate,
    /// Powers of the mass: β5's is 1 or 2.
    powers: Gate,
}

/// How good a variant is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Figures {
    /// At the true mass; NaN where the power never changes.
    pub(super) r2: f64,
    /// At the true mass; NaN without a sample above the floor.
    pub(super) mape_percent: f64,
    /// Mean over windows in which the mass does not change; NaN where no window knows it.
    pub(super) mass_percent: f64,
}

/// Section 6's window, s.
const WINDOW_S: f64 = 10.0;

impl Variant {
    /// As derived, the gates alone as printed, the power of the mass alone as printed, all as
    /// printed.
    pub(super) const ALL: [Self; 4] = [
        Self { gates: Gate::Corrected, powers: Gate::Corrected },
        Self { gates: Gate::Published, powers: Gate::Corrected },
        Self { gates: Gate::Corrected, powers: Gate::Published },
        Self { gates: Gate::Published, powers: Gate::Published },
    ];

    fn regressors(self, row: Kept<'_>) -> [f64; REGRESSORS] {
        eq18::regressors(self.powers, &row.products(self.gates), row.mass)
    }

    /// Fits the training log, and looks at the test log.
    ///
    /// # Errors
    /// A log without rows, or a fit that is not finite.
    pub(super) fn figures(self, pair: &Pair) -> Result<Figures> {
        let refused = |what: &str| Error::failed(format!("{}: {what}", pair.plant));
        if pair.training.store.is_empty() || pair.test.store.is_empty() {
            return Err(refused("no row to fit or to judge; expected a training log and a test log"));
        }
        let mut gram = Gram::default();
        gram.extend(pair.training.store.iter().map(|row| (self.regressors(row), row.power)));
        let beta: [f64; REGRESSORS] = linear::by_nnls(&gram).0.into();
        if !beta.iter().all(|beta| beta.is_finite()) {
            return Err(refused(
                "the coefficients of Eq. 18 are not finite; expected finite speeds and powers",
            ));
        }
        let mut metrics = Metrics::new(pair.floor_w);
        for row in pair.test.store.iter() {
            let predicted: f64 = self.regressors(row).iter().zip(&beta).map(|(x, beta)| x * beta).sum();
            metrics.add(row.power, predicted);
        }
        let quality = metrics.quality();
        Ok(Figures {
            r2: quality.and_then(|quality| quality.r2).unwrap_or(f64::NAN),
            mape_percent: quality.and_then(|quality| quality.mape_percent).unwrap_or(f64::NAN),
            mass_percent: self.mass_error(pair, &beta),
        })
    }

    /// Mean |m̂ − m| ∕ m over consecutive windows, %.
    fn mass_error(self, pair: &Pair, beta: &[f64; REGRESSORS]) -> f64 {
        let range = pair.test.robot.range();
        let roots = RootMean { range };
        let window = |row: &Row<()>| (row.run, (row.time / WINDOW_S).floor() as i64);
        let (mut sum, mut count) = (0.0, 0.0);
        for rows in pair.test.store.all().chunk_by(|a, b| window(a) == window(b)) {
            // Buckets of a second, as on the board: their scatter shows whether the mean is known.
            let second = |row: &Row<()>| row.time.floor() as i64;
            let buckets: Vec<_> = rows
                .chunk_by(|a, b| second(a) == second(b))
                .map(|rows| self.bucket(&roots, rows, beta))
                .collect();
            let total = payload::total::<f64, _, _>([&buckets]);
            let (Some(first), Some(estimate)) =
                (rows.others().first(), roots.estimate_of(&total, [&buckets], 1.0).known())
            else {
                continue;
            };
            if rows.others().iter().all(|row| row.mass == first.mass) {
                sum += 100.0 * (estimate.mass / first.mass - 1.0).abs();
                count += 1.0;
            }
        }
        sum / count
    }

    /// Sums over the roots of some rows.
    fn bucket(self, roots: &RootMean<f64>, rows: Stretch<'_>, beta: &[f64; REGRESSORS]) -> Sums<f64> {
        let mut sums = Sums::default();
        for row in rows.iter() {
            let products = row.products(self.gates);
            let polynomial = eq18::polynomial(self.powers, &products, beta).about(roots.range.middle());
            let response = Response { polynomial, may_clamp: false };
            roots.add(&mut sums, row.power, &response, row.wheels.mean_speed(), f64::NAN);
        }
        sums
    }
}
