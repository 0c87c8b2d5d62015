//! Some forty smooth functions of what a drive does: structure in the residual shows against them, whatever its cause.

use super::thresholds::problem::LEAST_SHOWN;
use crate::gap::noise::whiten::Signal;
use crate::log::runs::Runs;

/// The functions, one signal each. All vary about as gently as an effect would, and none asks for the model.
pub fn functions<const N: usize>(runs: &Runs<N>) -> Vec<Signal> {
    let rows = || runs.runs.iter().flat_map(|run| &run.rows);
    let most = |values: &dyn Fn(&crate::log::runs::Row<N>) -> f64| rows().map(values).fold(1e-9, f64::max);
    let wheels = |row: &crate::log::runs::Row<N>| {
        row.motion.wheels.iter().map(|wheel| wheel.speed.abs()).sum::<f64>() / N as f64
    };
    let gain = |row: &crate::log::runs::Row<N>| {
        row.motion.wheels.iter().map(|wheel| wheel.speed * wheel.acceleration).sum::<f64>() / N as f64
    };
    let (top, top_turn) = (most(&wheels), most(&|row| row.turn_rate.abs()));
    let top_gain = most(&|row| gain(row).abs());
    let (heaviest, longest) = (most(&|row| row.mass), most(&|row| row.time));
    let lightest = rows().map(|row| row.mass).fold(f64::INFINITY, f64::min);
    let middle = 0.5 * (heaviest + lightest);
    let reach = (0.5 * (heaviest - lightest)).max(1e-9);
    let mut values: Vec<Vec<Vec<f64>>> = Vec::new();
    for run in &runs.runs {
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for row in &run.rows {
            let s = wheels(row) / top;
            let moving = f64::from(u8::from(row.motion.is_moving()));
            let o = row.turn_rate.abs() / top_turn;
            let signed_turn = row.turn_rate / top_turn;
            let g = gain(row) / top_gain;
            let m = (row.mass - middle) / reach;
            let t = row.time / longest - 0.5;
            let direction =
                row.speed / (runs.robot.kinematics.rows()[0].iter().map(|r| r.abs()).sum::<f64>() * top);
            let side: f64 = row
                .motion
                .wheels
                .iter()
                .zip(runs.layout.side)
                .map(|(wheel, side)| side * wheel.speed.abs())
                .sum::<f64>()
                / (N as f64 * top);
            let slow = |share: f64| moving * (-(s / share).powi(2)).exp();
            let [cos, sin] = row.heading;
            let braking = g.min(0.0);
            let all = [
                1.0,
                moving,
                f64::from(u8::from(row.still.is_finite())),
                s,
                s * s,
                s * s * s,
                slow(0.08),
                slow(0.2),
                slow(0.4),
                o,
                o * o,
                signed_turn,
                side,
                side * m,
                direction,
                direction * direction.abs(),
                direction * m,
                direction * cos,
                direction * sin,
                direction * cos * m,
                direction * sin * m,
                g,
                g.abs(),
                braking,
                braking * m,
                g * m,
                m * s,
                m * s * s,
                m * moving,
                m * o,
                t,
                t * moving,
                t * s,
                t * m * s,
                t * t,
                t * t * s,
                (-8.0 * (t + 0.5)).exp() * s,
                (-3.0 * (t + 0.5)).exp() * s * s,
                o * s,
                g * s,
            ];
            if columns.is_empty() {
                columns = vec![Vec::with_capacity(run.rows.len()); all.len()];
            }
            for (column, value) in columns.iter_mut().zip(all) {
                column.push(value);
            }
        }
        values.push(columns);
    }
    let count = values.first().map_or(0, Vec::len);
    let mut functions: Vec<Signal> =
        (0..count).map(|function| values.iter().map(|run| run[function].clone()).collect()).collect();
    for place in 0..runs.columns.len() {
        if runs.runs.iter().all(|run| !run.extra(place).is_empty()) {
            functions.push(runs.runs.iter().map(|run| run.extra(place).to_vec()).collect());
        }
    }
    functions
}

/// How many of the [`functions`] ask for no further column.
pub fn count_own<const N: usize>(runs: &Runs<N>, functions: &[Signal]) -> usize {
    let is_there = |place: &usize| runs.runs.iter().all(|run| !run.extra(*place).is_empty());
    functions.len() - (0..runs.columns.len()).filter(is_there).count()
}

/// Those of some signals of field and clean runs that clean runs say something about. What hardly varies in them (a door that was shut,
/// a slope on level ground) would else be taken for what the base gets wrong anyway, whatever it does in the field.
pub fn shown_by_clean<const N: usize>(runs: &Runs<N>, signals: Vec<Signal>) -> Vec<Signal> {
    let variance = |signal: &Signal, clean: bool| {
        let values = || {
            let runs = runs.runs.iter().zip(signal).filter(move |(run, _)| run.clean == clean);
            runs.flat_map(|(_, values)| values)
        };
        let count = values().count().max(1) as f64;
        let mean = values().sum::<f64>() / count;
        values().map(|x| (x - mean).powi(2)).sum::<f64>() / count
    };
    let is_shown = |signal: &Signal| variance(signal, true) >= LEAST_SHOWN * variance(signal, false);
    signals.into_iter().filter(is_shown).collect()
}
