//! Axes that end where a labelled tick is.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

/// An axis: its ends, and where it has ticks.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axis {
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) ticks: Vec<f64>,
    /// Values are powers of ten.
    decades: bool,
}

/// Ticks at most, beside the first.
const MOST_TICKS: f64 = 10.0;

impl Axis {
    /// Over these values and a margin of this share of their range, on to the next ticks at both
    /// ends.
    pub(super) fn over(values: impl IntoIterator<Item = f64>, margin: f64) -> Self {
        let (from, to) = range(values, margin);
        Self::to_ticks(from, to)
    }

    /// From and to these values, and on to the next ticks.
    pub(super) fn to_ticks(from: f64, to: f64) -> Self {
        let step = step(to - from);
        // Rounding must not add a step to an end that is a tick.
        let first = (from / step + 1e-6).floor();
        let last = (to / step - 1e-6).ceil();
        let ticks: Vec<f64> = (0..=(last - first) as usize).map(|k| (first + k as f64) * step).collect();
        Self { from: first * step, to: last * step, ticks, decades: false }
    }

    /// Exactly from and to here, with the ticks that are between.
    pub(super) fn exact(from: f64, to: f64) -> Self {
        let wide = Self::to_ticks(from, to);
        let slack = 1e-9 * (to - from);
        let ticks = wide.ticks.into_iter().filter(|tick| (from - slack..=to + slack).contains(tick));
        Self { from, to, ticks: ticks.collect(), decades: false }
    }

    /// Without ticks.
    pub(super) fn bare(from: f64, to: f64) -> Self {
        Self { from, to, ticks: Vec::new(), decades: false }
    }

    /// Over these logarithms, with powers of ten at its ticks.
    pub(super) fn decades(logarithms: impl IntoIterator<Item = f64>) -> Self {
        let (from, to) = range(logarithms, 0.02);
        Self { decades: true, ..Self::to_ticks(from.floor(), to.ceil().max(from.floor() + 1.0)) }.whole()
    }

    /// Only whole powers.
    fn whole(mut self) -> Self {
        self.ticks.retain(|tick| (tick - tick.round()).abs() < 1e-6);
        self
    }

    /// A tick's label: as many digits as its axis needs to tell its ticks apart.
    pub(super) fn label(&self, value: f64) -> String {
        if self.decades {
            return format!("1e{}", value.round());
        }
        let step = self.ticks.windows(2).map(|pair| pair[1] - pair[0]).next().unwrap_or(1.0);
        let digits = (-(step.log10() + 1e-6).floor()).clamp(0.0, 9.0) as usize;
        let text = format!("{value:.digits$}");
        // Rounded to zero from below.
        if text.strip_prefix('-').is_some_and(|rest| rest.chars().all(|c| matches!(c, '0' | '.'))) {
            return text[1..].to_owned();
        }
        text
    }
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (first, last): (i32, i32)) -> i32 {
        let share = (value - self.from) / (self.to - self.from);
        first + (share * f64::from(last - first)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() { Vec::new() } else { self.ticks.clone() }
    }

    fn range(&self) -> Range<f64> {
        self.from..self.to
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, value: &f64) -> String {
        self.label(*value)
    }
}

/// 1, 2 or 5 times a power of ten, so that a span has no more ticks than there may be.
fn step(span: f64) -> f64 {
    let least = span / MOST_TICKS;
    let decade = 10_f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|step| step * decade)
        .find(|step| *step >= 0.999 * least)
        .unwrap_or(least)
}

/// The finite range of some values, widened by `margin` of itself on both sides; never empty.
pub(super) fn range(values: impl IntoIterator<Item = f64>, margin: f64) -> (f64, f64) {
    let finite = values.into_iter().filter(|value| value.is_finite());
    let (low, high) =
        finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    if low > high {
        return (0.0, 1.0);
    }
    if low == high {
        let half = 0.5 * high.abs().max(1.0);
        return (low - half, high + half);
    }
    let span = high - low;
    (low - margin * span, high + margin * span)
}

#[cfg(test)]
mod tests {
    use super::Axis;

    fn labels(axis: &Axis) -> Vec<String> {
        axis.ticks.iter().map(|tick| axis.label(*tick)).collect()
    }

    #[test]
    fn the_first_and_the_last_tick_are_the_ends() {
        let axis = Axis::over([0.4, 199.95], 0.0);
        assert_eq!((axis.from, axis.to), (0.0, 200.0));
        assert_eq!(labels(&axis).first().map(String::as_str), Some("0"));
        assert_eq!(labels(&axis).last().map(String::as_str), Some("200"));
        let axis = Axis::over([-0.13, 0.31], 0.0);
        assert_eq!(
            labels(&axis),
            ["-0.15", "-0.10", "-0.05", "0.00", "0.05", "0.10", "0.15", "0.20", "0.25", "0.30", "0.35"]
        );
    }

    #[test]
    fn powers_of_ten_are_labelled_as_such() {
        assert_eq!(labels(&Axis::decades([-1.3, 0.7])), ["1e-2", "1e-1", "1e0", "1e1"]);
        assert_eq!(labels(&Axis::decades([0.2])), ["1e-1", "1e0", "1e1"]);
    }

    #[test]
    fn an_exact_axis_keeps_its_ends() {
        let axis = Axis::exact(0.33, 1.07);
        assert_eq!((axis.from, axis.to), (0.33, 1.07));
        assert_eq!(labels(&axis), ["0.4", "0.5", "0.6", "0.7", "0.8", "0.9", "1.0"]);
    }

    #[test]
    fn nothing_and_one_value_have_an_axis_too() {
        assert_eq!(labels(&Axis::over([], 0.1)).len(), 11);
        assert!(Axis::over([3.0], 0.0).from < 3.0);
        assert!(Axis::over([f64::NAN, f64::INFINITY], 0.0).to == 1.0);
    }
}
