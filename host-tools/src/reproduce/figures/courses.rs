//! Panels over time that several figures share.

use crate::report::{Band, Line, Stroke, TimeSeries, Validated, Validation, legend_room, palette};

use super::{Colours, black};
use crate::reproduce::study::{Course, Followed, Trace};

/// Methods that are drawn over time; more would hide each other.
const DRAWN: usize = 3;

fn points(time_s: &[f64], values: &[f64]) -> Vec<(f64, f64)> {
    time_s.iter().copied().zip(values.iter().copied()).collect()
}

/// Over these values, with room for a legend above them in a panel of this height, pixels.
pub(super) fn with_room<'a>(
    values: impl Iterator<Item = &'a f64>,
    names: usize,
    height: u32,
) -> Option<(f64, f64)> {
    let finite = values.filter(|value| value.is_finite());
    let (low, high) = finite
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &value| (low.min(value), high.max(value)));
    let span = (high - low).max(1e-3);
    (low <= high).then_some((low - 0.05 * span, high + legend_room(names, height) * 1.05 * span))
}

/// Wheel speeds.
pub(super) fn speeds(title: &str, trace: &Trace, height: u32) -> TimeSeries {
    let [left, right] = &trace.wheel_rad_s;
    let line = |name: &str, values: &[f64], colour| Line {
        name: name.to_owned(),
        points: points(&trace.time_s, values),
        colour: palette(colour),
        stroke: Stroke::Solid,
    };
    TimeSeries {
        title: title.to_owned(),
        y_label: "wheel speed (rad/s)".to_owned(),
        y_range: with_room(left.iter().chain(right), 2, height),
        // Sky blue and purple: no method's among the first three.
        lines: vec![line("left", left, 5), line("right", right, 3)],
        ..TimeSeries::default()
    }
}

/// What the first methods predict, the first of them on top, and thinly over it the measured power.
pub(super) fn powers(
    title: &str,
    course: &Course,
    colours: &Colours,
    most: usize,
    height: u32,
) -> TimeSeries {
    let trace = &course.trace;
    let measured = Line {
        name: "measured".to_owned(),
        points: points(&trace.time_s, &trace.measured_w),
        colour: black(),
        stroke: Stroke::Faint,
    };
    let drawn = || course.methods.iter().take(most.min(DRAWN));
    let values = drawn().flat_map(|method| &method.predicted_w).chain(&trace.measured_w);
    let y_range = with_room(values, 1 + drawn().count(), height);
    let predicted = drawn().rev().map(|method| Line {
        name: method.method.clone(),
        points: points(&trace.time_s, &method.predicted_w),
        colour: colours.get(&method.method),
        stroke: Stroke::Solid,
    });
    TimeSeries {
        title: title.to_owned(),
        y_label: "actuation power (W)".to_owned(),
        y_range,
        lines: predicted.chain([measured]).collect(),
        ..TimeSeries::default()
    }
}

/// True and estimated mass with its interval.
pub(super) fn masses(title: &str, course: &Course, colours: &Colours, height: u32) -> TimeSeries {
    let trace = &course.trace;
    let known: Vec<&Followed> =
        course.methods.iter().filter(|method| !method.mass_kg.is_empty()).take(DRAWN).collect();
    let bands = known.iter().take(1).map(|method| {
        let ends = method.low_kg.iter().zip(&method.high_kg);
        Band {
            name: format!("95 % interval, {}", method.method),
            points: trace.time_s.iter().zip(ends).map(|(time, (low, high))| (*time, *low, *high)).collect(),
            colour: colours.get(&method.method),
        }
    });
    let found = known.iter().rev().map(|method| Line {
        name: method.method.clone(),
        points: points(&trace.time_s, &method.mass_kg),
        colour: colours.get(&method.method),
        stroke: Stroke::Solid,
    });
    let truth = Line {
        name: "truth".to_owned(),
        points: points(&trace.time_s, &trace.truth_kg),
        colour: black(),
        stroke: Stroke::Dashed,
    };
    TimeSeries {
        title: title.to_owned(),
        y_label: "total mass (kg)".to_owned(),
        // Of the masses themselves: the interval of a window that has just begun would leave nothing else to see.
        y_range: with_room(
            known.iter().flat_map(|method| &method.mass_kg).chain(&trace.truth_kg),
            known.len() + 2,
            height,
        ),
        bands: bands.collect(),
        lines: found.chain([truth]).collect(),
    }
}

/// Predicted over measured power of the first methods, ours on top.
pub(super) fn validation(course: &Course, colours: &Colours) -> Validation {
    let measured = &course.trace.measured_w;
    let methods = course.methods.iter().take(2).rev().map(|method| Validated {
        name: method.method.clone(),
        colour: colours.get(&method.method),
        pairs: measured.iter().copied().zip(method.predicted_w.iter().copied()).collect(),
    });
    Validation { quantity: "power (W)".to_owned(), methods: methods.collect() }
}
