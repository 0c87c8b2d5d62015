//! A log over time, the methods' predictions, and the panels that several figures share.

use report::{Band, Colour, Line, Stroke, TimeSeries, Validated, Validation, palette};

use super::colours::{Colours, black};

/// One log after the filter.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Trace {
    /// Time since its start, s.
    pub(super) time_s: Vec<f64>,
    /// Speeds of the left and the right wheel, rad/s.
    pub(super) wheel_rad_s: [Vec<f64>; 2],
    /// Measured actuation power, W.
    pub(super) measured_w: Vec<f64>,
    /// True total mass, kg.
    pub(super) truth_kg: Vec<f64>,
}

/// A method's predictions of a log, sample by sample of its [`Trace`]; NaN where unknown.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Followed {
    /// The method, as tables name it.
    pub(super) method: String,
    /// P̂, W.
    pub(super) predicted_w: Vec<f64>,
    /// m̂, kg; empty for methods without one.
    pub(super) mass_kg: Vec<f64>,
    /// 95 % interval of m̂, kg; empty for methods without one.
    pub(super) interval_kg: Vec<(f64, f64)>,
}

/// A log, and what methods made of it.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Course {
    /// The log.
    pub(super) trace: Trace,
    /// Ours first, the paper's second, then the others.
    pub(super) methods: Vec<Followed>,
}

/// Methods that are drawn over time; more would hide each other.
const DRAWN: usize = 3;

/// Wheel speeds.
pub(super) fn speeds(title: &str, Course { trace, .. }: &Course) -> TimeSeries {
    // Sky blue and purple: no method's among the first three.
    let named = [("left", 5), ("right", 3)].into_iter().zip(&trace.wheel_rad_s);
    let line = |((name, colour), values): ((&str, usize), &Vec<f64>)| {
        Line::over(name, &trace.time_s, values, palette(colour), Stroke::Solid)
    };
    TimeSeries {
        title: title.to_owned(),
        y_label: "wheel speed (rad/s)".to_owned(),
        lines: named.map(line).collect(),
        ..TimeSeries::default()
    }
}

/// Predictions of ours and the paper's, ours on top; the measured power thin above them.
pub(super) fn powers(title: &str, Course { trace, methods }: &Course, colours: &Colours) -> TimeSeries {
    let measured = Line::over("measured", &trace.time_s, &trace.measured_w, black(), Stroke::Faint);
    let predicted = methods.iter().take(2).rev().map(|method| {
        let colour = colours.get(&method.method);
        Line::over(&method.method, &trace.time_s, &method.predicted_w, colour, Stroke::Solid)
    });
    TimeSeries {
        title: title.to_owned(),
        y_label: "actuation power (W)".to_owned(),
        lines: predicted.chain([measured]).collect(),
        ..TimeSeries::default()
    }
}

/// True and estimated mass, and the interval of the first.
pub(super) fn masses(title: &str, Course { trace, methods }: &Course, colours: &Colours) -> TimeSeries {
    let known: Vec<&Followed> =
        methods.iter().filter(|method| !method.mass_kg.is_empty()).take(DRAWN).collect();
    let bands = known.iter().take(1).map(|method| Band {
        name: format!("95 % interval, {}", method.method),
        points: trace
            .time_s
            .iter()
            .zip(&method.interval_kg)
            .map(|(time, ends)| (*time, ends.0, ends.1))
            .collect(),
        colour: colours.get(&method.method),
    });
    let line = |name: &str, values: &[f64], colour: Colour, stroke| {
        Line::over(name, &trace.time_s, values, colour, stroke)
    };
    let estimates = known
        .iter()
        .rev()
        .map(|method| line(&method.method, &method.mass_kg, colours.get(&method.method), Stroke::Solid));
    // The range follows the masses: the interval of a window that has just begun would hide
    // everything else.
    let values = known.iter().flat_map(|method| &method.mass_kg).chain(&trace.truth_kg);
    let ends = values.copied().filter(|mass| mass.is_finite()).fold(None, |ends, mass| match ends {
        None => Some((mass, mass)),
        Some((low, high)) => Some((mass.min(low), mass.max(high))),
    });
    TimeSeries {
        title: title.to_owned(),
        y_label: "total mass (kg)".to_owned(),
        y_range: ends.map(|(low, high)| (low - 0.05 * (high - low), high + 0.05 * (high - low))),
        bands: bands.collect(),
        lines: estimates.chain([line("truth", &trace.truth_kg, black(), Stroke::Dashed)]).collect(),
    }
}

/// Predicted over measured power of the first methods, ours on top.
pub(super) fn validation(Course { trace, methods }: &Course, colours: &Colours) -> Validation {
    let methods = methods.iter().take(2).rev().map(|method| Validated {
        name: method.method.clone(),
        colour: colours.get(&method.method),
        pairs: trace.measured_w.iter().copied().zip(method.predicted_w.iter().copied()).collect(),
    });
    Validation { quantity: "power (W)".to_owned(), methods: methods.collect() }
}
