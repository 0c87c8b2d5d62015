//! Steps after the filter: what was switched within one sample shows in the filtered power as the
//! filter's step response.

use model_core::filter::{Channel, LowPass};

/// The step response of the logs' filter.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Step {
    /// One value a sample, from the first that sees the step on; 1 behind the last.
    response: Vec<f64>,
    /// Time between samples, s.
    period_s: f64,
}

impl Step {
    /// Time between samples of the log, s.
    pub fn period_s(&self) -> f64 {
        self.period_s
    }

    /// Of a filter that is stepped every `period_s`.
    pub fn new(filter: &LowPass<f64>, period_s: f64) -> Self {
        let mut channel = Channel::default();
        filter.settle(&mut channel, 0.0);
        let count = 2 * filter.settling_samples();
        Self { response: (0..count).map(|_| filter.step(&mut channel, 1.0).value).collect(), period_s }
    }

    /// How much of a step is seen `since` seconds after it: 0 before, straight lines between
    /// samples.
    pub fn at(&self, since: f64) -> f64 {
        let place = since / self.period_s;
        // Written so that a step that never comes (−∞) is none.
        if place.is_nan() || place <= -1.0 {
            return 0.0;
        }
        let below = place.floor();
        let value = |index: f64| match index {
            index if index < 0.0 => 0.0,
            index => self.response.get(index as usize).copied().unwrap_or(1.0),
        };
        if below >= self.response.len() as f64 {
            return 1.0;
        }
        value(below) + (place - below) * (value(below + 1.0) - value(below))
    }
}

/// When a run's robot began and ceased to move, by the samples before the filter, s since the start
/// of the run.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Motions {
    /// From when to when, in order; the last may end at infinity.
    pub spans: Vec<[f64; 2]>,
}

impl Motions {
    /// From samples: time, and whether a wheel moves.
    pub fn new(samples: impl Iterator<Item = (f64, bool)>) -> Self {
        let mut spans: Vec<[f64; 2]> = Vec::new();
        let mut moved = false;
        for (time, moves) in samples {
            match (moved, moves) {
                (false, true) => spans.push([time, f64::INFINITY]),
                (true, false) => {
                    if let Some(last) = spans.last_mut() {
                        last[1] = time;
                    }
                }
                _ => {}
            }
            moved = moves;
        }
        Self { spans }
    }

    /// What is on while the robot moves and `hold` seconds longer, as it shows after the filter at
    /// `time`. A negative hold: it is off before the robot stands.
    pub fn shown(&self, step: &Step, hold: f64, time: f64) -> f64 {
        let mut sum = 0.0;
        let mut on_until = f64::NEG_INFINITY;
        for &[from, to] in &self.spans {
            if from > time + step.period_s {
                break;
            }
            let off = to + hold;
            if off <= from || off <= on_until {
                continue;
            }
            // While it is still held on, the next motion switches nothing.
            if from > on_until {
                sum += step.at(time - from);
            } else {
                sum += step.at(time - on_until);
            }
            sum -= step.at(time - off);
            on_until = off;
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step() -> Step {
        Step::new(&LowPass::new(2.0, 0.05).unwrap(), 0.05)
    }

    /// The response is that of the filter itself, sample by sample, and 1 in the end.
    #[test]
    fn a_step_shows_as_the_filter_makes_it() {
        let filter = LowPass::new(2.0, 0.05).unwrap();
        let mut channel = Channel::default();
        filter.settle(&mut channel, 0.0);
        let step = step();
        for k in 0..200 {
            let seen = filter.step(&mut channel, f64::from(u8::from(k >= 40))).value;
            let told = step.at(f64::from(k - 40) * 0.05);
            assert!((seen - told).abs() < 1e-3, "{k} {seen} {told}");
        }
        assert_eq!(step.at(f64::NEG_INFINITY), 0.0);
    }

    /// Two motions, 1 s apart: with a hold of 2 s they are one, and it ends 2 s after the second.
    #[test]
    fn a_hold_bridges_rests() {
        let samples = (0..400).map(|k| {
            let time = f64::from(k) * 0.05;
            (time, (2.0..4.0).contains(&time) || (5.0..7.0).contains(&time))
        });
        let motions = Motions::new(samples);
        assert_eq!(motions.spans.len(), 2);
        let step = step();
        for (hold, time, expected) in [(0.0, 4.9, 0.0), (2.0, 4.9, 1.0), (2.0, 8.5, 1.0), (2.0, 12.0, 0.0)] {
            let shown = motions.shown(&step, hold, time);
            assert!((shown - expected).abs() < 0.02, "{hold} {time} {shown}");
        }
        // On for ever from the first motion on.
        assert!((motions.shown(&step, f64::INFINITY, 19.0) - 1.0).abs() < 0.02);
    }
}
