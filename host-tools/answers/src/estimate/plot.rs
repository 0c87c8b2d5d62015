//! A replay as a picture: power measured and predicted, and the mass with its interval.

use report::{Band, Line, Page, Stroke, TimeSeries, palette};

use super::Instant;

/// Most instants kept; beyond, every second one goes.
const MOST_INSTANTS: usize = 100_000;

/// Collects what a replay knew over time.
#[derive(Debug, Clone)]
pub struct Track {
    instants: Vec<Instant>,
    stride: usize,
    seen: usize,
}

impl Default for Track {
    fn default() -> Self {
        Self { instants: Vec::new(), stride: 1, seen: 0 }
    }
}

impl Track {
    /// One instant.
    pub fn add(&mut self, instant: &Instant) {
        if self.seen.is_multiple_of(self.stride) {
            if self.instants.len() == MOST_INSTANTS {
                let mut index = 0_usize;
                self.instants.retain(|_| {
                    index += 1;
                    index % 2 == 1
                });
                self.stride *= 2;
            }
            self.instants.push(*instant);
        }
        self.seen += 1;
    }

    /// The picture, titled by what it shows.
    pub fn page(&self, title: &str) -> Page {
        let or_gap = |value: Option<f64>| value.unwrap_or(f64::NAN);
        let line = |name: &str, colour, stroke, value: &dyn Fn(&Instant) -> f64| Line {
            name: name.to_owned(),
            points: self.instants.iter().map(|instant| (instant.time_s, value(instant))).collect(),
            colour: palette(colour),
            stroke,
        };
        let power = TimeSeries {
            title: title.to_owned(),
            y_label: "actuation power (W)".to_owned(),
            lines: vec![
                line("measured", 5, Stroke::Solid, &|instant| instant.measured_w),
                line("predicted with the estimated mass", 1, Stroke::Thin, &|instant| {
                    or_gap(instant.predicted_w)
                }),
            ],
            ..TimeSeries::default()
        };
        let interval = self.instants.iter().filter_map(|instant| {
            let (low, high) = instant.interval_kg?;
            Some((instant.time_s, low, high))
        });
        let mut lines = vec![line("estimate", 1, Stroke::Solid, &|instant| or_gap(instant.mass_kg))];
        if self.instants.iter().any(|instant| instant.truth_kg.is_some()) {
            lines.push(line("truth", 2, Stroke::Dashed, &|instant| or_gap(instant.truth_kg)));
        }
        let mass = TimeSeries {
            title: "Total mass".to_owned(),
            y_label: "mass (kg)".to_owned(),
            bands: vec![Band {
                name: "95 % interval".to_owned(),
                points: interval.collect(),
                colour: palette(1),
            }],
            lines,
            ..TimeSeries::default()
        };
        Page::new([power.into(), mass.into()])
    }
}
