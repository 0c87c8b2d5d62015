//! The runs over time, for any number of wheels.

use logs::runs::Runs;

use crate::report::Report;
use crate::report::localise::{self, Map};

/// One run: power as measured and as predicted.
#[derive(Debug, Clone, PartialEq)]
pub struct Course {
    /// Its name.
    pub name: String,
    /// Whether it was locked.
    pub locked: bool,
    /// Time since its start, s; a step after which the filter starts again is marked by a row of
    /// NaN powers.
    pub time_s: Vec<f64>,
    /// Actuation power after the filter, W.
    pub measured_w: Vec<f64>,
    /// Predicted before anything is added, W.
    pub before_w: Vec<f64>,
    /// Predicted with the effects, W; `None` where none was added.
    pub after_w: Option<Vec<f64>>,
}

/// What the page draws of the runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Every run.
    pub courses: Vec<Course>,
    /// Over two axes.
    pub map: Map,
}

impl Picture {
    /// Of the runs that a report is about.
    pub fn of(runs: &Runs, report: &Report) -> Self {
        let (before, after) = &report.residuals;
        let courses = runs.runs.iter().enumerate().map(|(place, run)| {
            let power = |residual: &[f64]| {
                let predicted = run.rows.iter().zip(residual);
                with_holes(
                    run.rows.iter().map(|row| row.starts),
                    predicted.map(|(row, residual)| row.power - residual),
                )
            };
            Course {
                name: run.name.clone(),
                locked: report.split.locked.contains(&place),
                time_s: {
                    let mut last = 0.0;
                    let mut times = Vec::with_capacity(run.rows.len());
                    for row in &run.rows {
                        if row.starts && !times.is_empty() {
                            times.push(last);
                        }
                        last = row.time;
                        times.push(last);
                    }
                    times
                },
                measured_w: with_holes(
                    run.rows.iter().map(|row| row.starts),
                    run.rows.iter().map(|row| row.power),
                ),
                before_w: power(&before[place]),
                after_w: after.as_ref().map(|after| power(&after[place])),
            }
        });
        Self { courses: courses.collect(), map: localise::map(runs, before, after.as_ref()) }
    }
}

/// A NaN before each row that does not continue the one before: no line is drawn across.
fn with_holes(starts: impl Iterator<Item = bool>, values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut all = Vec::new();
    for (starts, value) in starts.zip(values) {
        if starts && !all.is_empty() {
            all.push(f64::NAN);
        }
        all.push(value);
    }
    all
}

impl Course {
    /// Root mean square of measured less predicted power before and after, W.
    pub fn gaps(&self) -> (f64, Option<f64>) {
        let rms = |predicted: &[f64]| {
            let residual =
                self.measured_w.iter().zip(predicted).map(|(m, p)| m - p).filter(|x| x.is_finite());
            let (count, sum) = residual.fold((0.0, 0.0), |(count, sum), x| (count + 1.0, sum + x * x));
            (sum / f64::max(count, 1.0)).sqrt()
        };
        (rms(&self.before_w), self.after_w.as_deref().map(rms))
    }
}

#[cfg(test)]
mod tests {
    use super::{Course, with_holes};

    #[test]
    fn no_line_crosses_a_gap_and_the_gap_counts_for_nothing() {
        let starts = || [true, false, true, false].into_iter();
        let measured_w = with_holes(starts(), [1.0, 2.0, 3.0, 4.0].into_iter());
        assert!(measured_w[2].is_nan() && measured_w.len() == 5);
        let before_w = with_holes(starts(), [0.0, 1.0, 2.0, 3.0].into_iter());
        let time_s = vec![0.0; 5];
        let course =
            Course { name: String::new(), locked: true, time_s, measured_w, before_w, after_w: None };
        assert_eq!(course.gaps(), (1.0, None));
    }
}
