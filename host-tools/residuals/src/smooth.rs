//! Some forty smooth functions of what a drive does: structure in the residual shows against them,
//! whatever its cause.

use logs::robot::chassis::Together;
use logs::runs::Runs;

use super::thresholds::problem::NEXT_TO_NONE;
use crate::noise::whiten::Signal;

/// The functions, one signal each, as the filter of the power shows them. They vary about as gently
/// as effects, and need no model.
pub fn functions(runs: &Runs) -> Vec<Signal> {
    let rows = || runs.runs.iter().flat_map(|run| &run.rows);
    let most = |values: &dyn Fn(&logs::runs::Row) -> f64| rows().map(values).fold(1e-9, f64::max);
    let wheels = |row: &logs::runs::Row| row.wheels.mean_speed();
    let gain = |row: &logs::runs::Row| row.wheels.mean(|wheel| wheel.speed * wheel.acceleration);
    let (top, top_turn) = (most(&wheels), most(&|row| row.turn_rate.abs()));
    let top_gain = most(&|row| gain(row).abs());
    let (heaviest, longest) = (most(&|row| row.mass), most(&|row| row.time));
    let lightest = rows().map(|row| row.mass).fold(f64::INFINITY, f64::min);
    let middle = 0.5 * (heaviest + lightest);
    let reach = (0.5 * (heaviest - lightest)).max(1e-9);
    let sides = runs.robot.sides();
    let mut values: Vec<Vec<Vec<f64>>> = Vec::new();
    for run in &runs.runs {
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for row in &run.rows {
            let s = wheels(row) / top;
            let moving = f64::from(u8::from(row.wheels.is_moving()));
            let o = row.turn_rate.abs() / top_turn;
            let signed_turn = row.turn_rate / top_turn;
            let g = gain(row) / top_gain;
            let m = (row.mass - middle) / reach;
            let t = row.time / longest - 0.5;
            let direction = row.speed / (runs.robot.rows()[0].iter().map(|r| r.abs()).sum::<f64>() * top);
            let side: f64 =
                row.wheels.iter().zip(&sides).map(|(wheel, side)| side * wheel.speed.abs()).sum::<f64>()
                    / (sides.len() as f64 * top);
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
    let column = |place: usize| runs.runs.iter().map(|run| run.extra(place).to_vec()).collect();
    functions.extend(further(runs).into_iter().map(column));
    let filtered = |function: Signal| -> Signal {
        function.into_iter().zip(&runs.runs).map(|(values, run)| runs.smoothed(run, values)).collect()
    };
    functions.into_iter().map(filtered).collect()
}

/// How many of the [`functions`] need no further column.
pub fn count_of_motion(runs: &Runs, functions: &[Signal]) -> usize {
    functions.len() - further(runs).len()
}

/// Places of the further columns that every run has and that may explain the power. A current that
/// follows the power, or another power, explains nothing: it changes with every cause.
pub fn further(runs: &Runs) -> Vec<usize> {
    let is_there = |place: &usize| runs.runs.iter().all(|run| !run.extra(*place).is_empty());
    let is_electric =
        |place: usize| runs.columns[place].ends_with("_a") || runs.columns[place].ends_with("_w");
    let is_reading = |place: &usize| is_electric(*place) && follows_power(runs, *place) > NEXT_TO_NONE;
    (0..runs.columns.len()).filter(is_there).filter(|place| !is_reading(place)).collect()
}

/// Squared correlation of a column with the power: on the clean runs, where there are any.
fn follows_power(runs: &Runs, place: usize) -> f64 {
    let has_clean = runs.runs.iter().any(|run| run.clean);
    let pairs = || {
        let runs = runs.runs.iter().filter(move |run| run.clean || !has_clean);
        runs.flat_map(move |run| run.rows.iter().map(|row| row.power).zip(run.extra(place).iter().copied()))
    };
    let count = pairs().count().max(1) as f64;
    let (power, value) = pairs().fold((0.0, 0.0), |sum, (p, x)| (sum.0 + p / count, sum.1 + x / count));
    let (mut pp, mut px, mut xx) = (0.0, 0.0, 0.0);
    for (p, x) in pairs() {
        let (p, x) = (p - power, x - value);
        (pp, px, xx) = (pp + p * p, px + p * x, xx + x * x);
    }
    if pp * xx > 0.0 { px * px / (pp * xx) } else { 0.0 }
}

/// The signals that vary in clean runs, too. One that hardly varies there (a door that was shut, a
/// slope on level ground) would otherwise count as an error of the base, whatever it does in the
/// field.
pub fn shown_by_clean(runs: &Runs, signals: Vec<Signal>) -> Vec<Signal> {
    let variance = |signal: &Signal, clean: bool| {
        let values = || {
            let runs = runs.runs.iter().zip(signal).filter(move |(run, _)| run.clean == clean);
            runs.flat_map(|(_, values)| values)
        };
        let count = values().count().max(1) as f64;
        let mean = values().sum::<f64>() / count;
        values().map(|x| (x - mean).powi(2)).sum::<f64>() / count
    };
    let is_shown = |signal: &Signal| variance(signal, true) >= NEXT_TO_NONE * variance(signal, false);
    signals.into_iter().filter(is_shown).collect()
}

#[cfg(test)]
mod tests {
    use logs::robot::Robot;
    use logs::runs::{RawRun, Runs};
    use model_core::estimator::Sample;

    use super::further;

    /// The motors' current is the power over the battery's 12 V; an arm draws when it likes; the
    /// light has nothing to do with either.
    #[test]
    fn a_current_that_follows_the_power_is_no_cause() {
        let burger = Robot::named("burger").unwrap().chassis(2.0).unwrap();
        let rows = (0..600).map(|i| {
            let time = 0.05 * f64::from(i);
            let power = 1.0 + (0.9 * time).sin();
            let sample = Sample { wheel_speed: [3.0, 2.0], wheel_acceleration: None, power };
            (time, sample.into(), 1.0, vec![power / 12.0, (0.31 * time).cos(), power])
        });
        let columns = ["motors_a", "arm_a", "light"].map(str::to_owned).into();
        let raw = RawRun { name: "run".to_owned(), rows: rows.collect(), columns, period_s: 0.05 };
        let runs = Runs::condition(&burger, vec![raw]).unwrap();
        let names: Vec<&str> = further(&runs).into_iter().map(|place| runs.columns[place].as_str()).collect();
        assert_eq!(names, ["arm_a", "light"]);
    }
}
