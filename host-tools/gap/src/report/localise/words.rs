//! Cells in words.

use super::axes::round_step;

/// A cell of an axis that reaches from `least` to `most`.
pub(super) fn of(axis: &str, (from, to): (f64, f64), (least, most): (f64, f64)) -> String {
    let (first, last) = (from <= least, to >= most);
    match axis {
        "standing" => "standing still".to_owned(),
        "speed" if to <= 0.0 => span("backward driving", "m/s", (-to, -from), (to == 0.0, first)),
        "speed" if from >= 0.0 => span("forward driving", "m/s", (from, to), (from == 0.0, last)),
        "acceleration" if to <= 0.0 => span("braking", "m/s²", (-to, -from), (to == 0.0, first)),
        "acceleration" if from >= 0.0 => span("speeding up", "m/s²", (from, to), (from == 0.0, last)),
        "side" if to < 0.0 => "right turns".to_owned(),
        "side" if from > 0.0 => "left turns".to_owned(),
        "side" => "straight ahead".to_owned(),
        "turn-rate" if to <= 0.0 => span("right turns", "rad/s", (-to, -from), (to == 0.0, first)),
        "turn-rate" if from >= 0.0 => span("left turns", "rad/s", (from, to), (from == 0.0, last)),
        "speed-turning-left" => span("left turns", "m/s", (from, to), (first, last)),
        "speed-turning-right" => span("right turns", "m/s", (from, to), (first, last)),
        "mass" => span("total mass", "kg", (from, to), (first, last)),
        "time" if first => format!("the first {} s", plain(to, to)),
        "time" if last => format!("after {} s", plain(from, to)),
        "time" => format!("{} to {} s after the start", plain(from, to), plain(to, to)),
        "heading" => span("heading", "rad from the start's", (from, to), (first, last)),
        other => span(other, "", (from, to), (first, last)),
    }
}

/// `left turns above 0.3 m/s`: an open end is not written.
fn span(what: &str, unit: &str, (from, to): (f64, f64), (open_below, open_above): (bool, bool)) -> String {
    let scale = from.abs().max(to.abs());
    let (low, high) = (plain(from, scale), plain(to, scale));
    let text = match (open_below, open_above) {
        (true, true) => format!("{what}, at most {high} {unit}"),
        (true, false) => format!("{what} below {high} {unit}"),
        (false, true) => format!("{what} above {low} {unit}"),
        (false, false) => format!("{what} at {low} to {high} {unit}"),
    };
    text.trim_end().to_owned()
}

/// A number with as many digits as a hundredth of `scale` needs.
pub(super) fn plain(value: f64, scale: f64) -> String {
    let step = round_step(scale.abs() / 100.0);
    let digits = if scale == 0.0 { 0 } else { (-step.log10().floor()).clamp(0.0, 9.0) as usize };
    let text = format!("{value:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::of;

    #[test]
    fn cells_are_said_as_one_would() {
        let all = (-0.5, 0.5);
        for (axis, cell, extent, words) in [
            ("speed", (0.3, 0.5), all, "forward driving above 0.3 m/s"),
            ("speed", (-0.5, -0.25), all, "backward driving above 0.25 m/s"),
            ("speed", (0.0, 0.1), all, "forward driving below 0.1 m/s"),
            ("speed", (-0.2, -0.1), all, "backward driving at 0.1 to 0.2 m/s"),
            ("speed-turning-left", (0.3, 0.5), (0.01, 0.5), "left turns above 0.3 m/s"),
            ("acceleration", (-0.5, -0.2), all, "braking above 0.2 m/s²"),
            ("turn-rate", (0.1, 0.2), all, "left turns at 0.1 to 0.2 rad/s"),
            ("side", (-0.5, -0.05), all, "right turns"),
            ("side", (-0.05, 0.05), all, "straight ahead"),
            ("mass", (1.2, 2.4), (1.2, 5.6), "total mass below 2.4 kg"),
            ("mass", (4.0, 5.6), (1.2, 5.6), "total mass above 4 kg"),
            ("time", (0.95, 10.0), (0.95, 60.0), "the first 10 s"),
            ("time", (50.0, 60.0), (0.95, 60.0), "after 50 s"),
            ("time", (20.0, 30.0), (0.95, 60.0), "20 to 30 s after the start"),
            ("heading", (0.0, 0.2), all, "heading at 0 to 0.2 rad from the start's"),
            ("standing", (0.0, 0.0), (0.0, 0.0), "standing still"),
            ("arm_a", (0.5, 2.0), (0.0, 2.0), "arm_a above 0.5"),
        ] {
            assert_eq!(of(axis, cell, extent), words);
        }
    }
}
