//! Persistence: the prediction that power does not change. A yardstick for models that see power.

use support::metrics::Metrics;

use crate::baselines::Point;

/// R² of the power at least so long before, in the same run; `None` where no point has one.
pub fn persistence_r2(points: &[Point], horizon_s: f64) -> Option<f64> {
    let mut metrics = Metrics::new(0.0);
    for run in points.chunk_by(|a, b| a.run == b.run) {
        let mut before = 0;
        for point in run {
            // Rounding of times must not cost a sample.
            let due = point.time - horizon_s + 1e-6;
            while run.get(before + 1).is_some_and(|next| next.time <= due) {
                before += 1;
            }
            if run[before].time <= due {
                metrics.add(point.power, run[before].power);
            }
        }
    }
    metrics.quality()?.r2
}

#[cfg(test)]
mod tests {
    use super::persistence_r2;
    use crate::baselines::testing::drive;

    /// A sine of ω = 1 rad/s at a horizon τ: the mean square of the difference over the variance is
    /// 2 (1 − cos τ), over whole periods.
    #[test]
    fn a_sine_persists_as_its_autocorrelation() {
        let points = drive(20_000, |point| 5.0 + point.time.sin());
        for horizon_s in [0.05_f64, 1.0, 2.0] {
            let expected = 1.0 - 2.0 * (1.0 - horizon_s.cos());
            let r2 = persistence_r2(&points, horizon_s).unwrap();
            assert!((r2 - expected).abs() < 0.01, "{horizon_s}: {r2} {expected}");
        }
    }

    #[test]
    fn runs_do_not_meet() {
        let mut points = drive(100, |point| point.time);
        points[50..].iter_mut().for_each(|point| point.run = 1);
        assert!(persistence_r2(&points, 3.0).is_none(), "no run is that long");
    }
}
