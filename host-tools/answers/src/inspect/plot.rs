//! The figure of an inspection.

use report::{Band, Gaussian, Histogram, Line, Page, Stroke, TimeSeries, palette};

use super::blocks::Block;
use super::report::Report;
use super::static_power::StaticState;

/// Histogram of power at standstill with the fitted Gaussians, and power over time with the states
/// in colour.
pub(super) fn page(report: &Report) -> Page {
    let levels: Vec<(&StaticState, &str)> = report
        .static_states
        .iter()
        .map(|state| (state, ""))
        .chain(report.moving_levels.iter().map(|state| (state, ", moving")))
        .collect();
    let name = |(state, suffix): &(&StaticState, &str)| {
        format!("{:.2} ± {:.2} W ({:.0} %{suffix})", state.mean_w, state.std_w, 100.0 * state.share)
    };
    let still: Vec<&Block> = report.blocks.iter().filter(|block| block.still).collect();
    let gaussians = levels.iter().enumerate().map(|(index, level)| Gaussian {
        name: name(level),
        mean: level.0.mean_w,
        std: level.0.std_w.max(1e-6),
        share: level.0.share,
        colour: palette(index + 1),
    });
    let title = format!("Power at standstill, told from {} (Eq. 29 per state)", report.standstill_from);
    let histogram = Histogram::new(title, "power (W)", samples(&still), gaussians.collect());

    let blocks = &report.blocks;
    let broken = |points: &mut Vec<(f64, f64)>, block: &Block| {
        if block.starts {
            points.push((block.from_s, f64::NAN));
        }
    };
    let mut mean = Vec::new();
    let mut extremes = Vec::new();
    for block in blocks {
        let middle = 0.5 * (block.from_s + block.to_s);
        broken(&mut mean, block);
        mean.push((middle, block.mean));
        if block.starts {
            extremes.push((block.from_s, f64::NAN, f64::NAN));
        }
        extremes.push((middle, block.min, block.max));
    }
    let states = levels.iter().enumerate().map(|(index, level)| Line {
        name: name(level),
        points: level
            .0
            .visits
            .iter()
            .flat_map(|&(from, to)| [(from, level.0.mean_w), (to, level.0.mean_w), (to, f64::NAN)])
            .collect(),
        colour: palette(index + 1),
        stroke: Stroke::Solid,
    });
    let line = Line { name: "mean".to_owned(), points: mean, colour: palette(0), stroke: Stroke::Faint };
    let series = TimeSeries {
        title: "Power over time, with its states".to_owned(),
        y_label: "power (W)".to_owned(),
        bands: vec![Band { name: "least to greatest".to_owned(), points: extremes, colour: palette(5) }],
        lines: std::iter::once(line).chain(states).collect(),
        ..TimeSeries::default()
    };
    Page::new([histogram.into(), series.into()])
}

/// Values distributed as the samples of the blocks are: for every block quantiles of its Gaussian.
fn samples(blocks: &[&Block]) -> Vec<f64> {
    use statrs::distribution::{ContinuousCDF, Normal};
    let standard = Normal::standard();
    let quantiles: Vec<f64> = (0..16).map(|k| standard.inverse_cdf((f64::from(k) + 0.5) / 16.0)).collect();
    let spread = |block: &Block| {
        let (mean, std) = (block.mean, block.std());
        quantiles.iter().map(move |z| mean + std * z).collect::<Vec<_>>()
    };
    blocks.iter().flat_map(|block| spread(block)).collect()
}
