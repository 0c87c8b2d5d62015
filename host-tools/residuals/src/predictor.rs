//! What the fitted model, extended by effects, predicts along the wheel speeds of a run.

use logs::robot::chassis::Together;
use logs::runs::{Run, Runs};
use logs::with_core;
use model::effects::{Regressor, Switched};
use model_core::coefficients::Robot as CoreRobot;
use model_core::delay::cubic;
use model_core::effects::{Effect, Extended, Heat, Layout, Scene, Side, Term};
use model_core::motion::{Motion, Wheel};
use model_core::torque::{Drive, PARAMETERS, TorqueModel};

use super::noise::whiten::Signal;
use super::thresholds::detect::INEXACT;

/// When something is on.
#[derive(Debug, Clone, Copy)]
enum When {
    /// From a time on.
    From(Switched, f64),
    /// While the robot moves, and some seconds longer.
    Moving(f64),
}

/// An effect that switches at once and shows gradually after the filter.
struct Switching {
    when: When,
    coefficient: f64,
}

impl Switching {
    fn is(&self, what: Switched) -> bool {
        matches!(self.when, When::From(switched, _) if switched == what)
    }
}

fn switching(term: &Term<f64>) -> Option<When> {
    match term {
        Term::StepAt(from) => Some(When::From(Switched::Static, *from)),
        Term::RollingFrom(from) => Some(When::From(Switched::Rolling, *from)),
        Term::WithMotion(hold) => Some(When::Moving(*hold)),
        _ => None,
    }
}

/// Parameters of base and effects.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// The base.
    pub torque: TorqueModel<f64>,
    /// Regressors and their coefficients.
    pub effects: Vec<(Regressor, f64)>,
}

/// Predicts power, W.
#[derive(Debug, Clone, Copy)]
pub struct Predictor<'a> {
    /// The runs.
    pub runs: &'a Runs,
    /// Whether the drives clamp.
    pub drive: Drive,
    /// Delay of power after speed in clean runs, s: sensors average before a sample.
    pub clean_delay: f64,
    /// Delay already taken out of the measured power of the field runs, s.
    pub removed_delay: f64,
}

impl<'a> Predictor<'a> {
    /// Without delays.
    pub fn new(runs: &'a Runs, drive: Drive) -> Self {
        Self { runs, drive, clean_delay: 0.0, removed_delay: 0.0 }
    }

    /// Power of one run, W, one value a row.
    pub fn predict(&self, place: usize, state: &State) -> Vec<f64> {
        self.predict_later(place, state, [0.0]).next().unwrap_or_default()
    }

    /// The same, later by further delays, s.
    pub fn predict_later(
        &self,
        place: usize,
        state: &State,
        by: impl IntoIterator<Item = f64>,
    ) -> impl Iterator<Item = Vec<f64>> {
        let in_time = with_core!(&self.runs.robot, core => self.in_time(core, place, state));
        let run = &self.runs.runs[place];
        let delay = self.delay(run, state);
        by.into_iter().map(move |by| match delay + by {
            0.0 => in_time.clone(),
            delay => delayed(run, &in_time, delay),
        })
    }

    /// How late the power of a run is after its speed, s.
    fn delay(&self, run: &Run, state: &State) -> f64 {
        let in_state = state.effects.iter().filter(|(regressor, _)| *regressor == Regressor::Delay);
        let in_field = in_state.map(|(_, delay)| delay).sum::<f64>() - self.removed_delay;
        self.clean_delay + if run.clean { 0.0 } else { in_field }
    }

    /// Power of one run before any delay, W.
    fn in_time<const N: usize>(&self, core: &CoreRobot<f64, N>, place: usize, state: &State) -> Vec<f64> {
        let layout = Layout::new(&core.kinematics);
        let CoreRobot { conditioning, dead_band, .. } = core;
        let run = &self.runs.runs[place];
        let mut effects: Vec<Effect<f64>> = Vec::new();
        let (mut shift, mut scales, mut softer) = (0.0, Vec::new(), 0.0);
        let mut warm = None;
        let mut switched: Vec<Switching> = Vec::new();
        let present: &[(Regressor, f64)] = if run.clean { &[] } else { &state.effects };
        for (regressor, coefficient) in present {
            let coefficient = *coefficient;
            match regressor {
                Regressor::InRun(at, _) if *at != place => {}
                Regressor::Term(term) | Regressor::InRun(_, term) => match switching(term) {
                    Some(when) => switched.push(Switching { when, coefficient }),
                    None => effects.push(Effect { term: *term, coefficient }),
                },
                Regressor::Switch(what, times) => {
                    let when = When::From(*what, times.get(place).copied().unwrap_or(f64::INFINITY));
                    switched.push(Switching { when, coefficient });
                }
                Regressor::Mass(at) if *at == place => shift += coefficient,
                Regressor::Masses => shift += coefficient,
                Regressor::Scale(side) => scales.push((*side, coefficient)),
                Regressor::HalfSlip => softer += coefficient,
                Regressor::Heat(_) | Regressor::Warming(_) | Regressor::Temperature(..) | Regressor::Hot => {
                    warm = Some(regressor);
                    effects.push(Effect { term: Term::Winding, coefficient });
                }
                _ => {}
            }
        }
        let steady = effects.len();
        // What a switch adds to rolling resistance: as much of it as the filter shows at each row.
        let rolling = switched.iter().filter(|switch| switch.is(Switched::Rolling));
        effects.extend(rolling.map(|_| Effect { term: Term::Rolling, coefficient: 0.0 }));
        // Clean runs may lack it: they are level.
        let pitch = self.runs.columns.iter().position(|name| name == model::effects::PITCH);
        let pitch = pitch.map(|column| run.extra(column)).filter(|pitch| !pitch.is_empty());
        let mut heat = [Heat::default(); N];
        let mut last = 0.0;
        let mut power: Vec<f64> = Vec::with_capacity(run.rows.len());
        for (index, row) in run.rows.iter().enumerate() {
            let mass = row.mass + shift;
            let mut motion = row.wheels.motion::<N>();
            if !scales.is_empty() {
                motion = scaled(core, &layout, &motion, &scales);
            }
            let slips = switched.iter().filter(|switch| switch.is(Switched::HalfSlip));
            let softer = slips
                .map(|switch| switch.coefficient * self.shown(run, switch.when, row.time))
                .fold(softer, |sum, shown| sum + shown);
            if softer != 0.0 {
                layout.soften(&mut motion, &conditioning.slip, softer, *dead_band);
            }
            let warmth = match warm {
                Some(Regressor::Heat(time)) => {
                    for (heat, wheel) in heat.iter_mut().zip(&motion.wheels) {
                        let torque = state.torque.torque(wheel, mass);
                        heat.take(state.torque.winding_loss * torque * torque, row.time - last, *time);
                    }
                    last = row.time;
                    heat.map(|heat| heat.level())
                }
                Some(Regressor::Warming(time)) => [-(-row.time / time).exp_m1(); N],
                Some(Regressor::Temperature(column, cold)) => {
                    // The temperatures of a planned drive are unknown: its motors count as cold.
                    std::array::from_fn(|wheel| {
                        run.extra(*column + wheel).get(index).map_or(0.0, |temperature| *temperature - *cold)
                    })
                }
                _ => [1.0; N],
            };
            let pitch = pitch.map_or(0.0, |pitch| pitch[index]);
            let rolling = switched.iter().filter(|switch| switch.is(Switched::Rolling));
            for (effect, switch) in effects[steady..].iter_mut().zip(rolling) {
                effect.coefficient = switch.coefficient * self.shown(run, switch.when, row.time);
            }
            let extended = Extended {
                torque: state.torque,
                drive: self.drive,
                layout,
                dead_band: *dead_band,
                effects: &effects,
            };
            let (time, heading, still) = (row.time, row.heading, row.still);
            let scene = Scene { mass, time, pitch, heading, warmth, still, driver: 0.0 };
            let mut sum = extended.power(&motion, &scene);
            let of_power =
                |switch: &&Switching| !switch.is(Switched::Rolling) && !switch.is(Switched::HalfSlip);
            for switch in switched.iter().filter(of_power) {
                sum += switch.coefficient * self.shown(run, switch.when, row.time);
            }
            power.push(sum);
        }
        for (regressor, coefficient) in present {
            if let Regressor::Column(column) = regressor {
                add(&mut power, run.extra(*column), *coefficient);
            }
        }
        self.runs.smoothed(run, power)
    }

    /// How much of what is switched the filter shows at a time.
    fn shown(&self, run: &Run, when: When, time: f64) -> f64 {
        match when {
            When::From(_, from) => self.runs.step.at(time - from),
            When::Moving(hold) => run.motions.shown(&self.runs.step, hold, time),
        }
    }

    /// ∂P/∂θ of one run: one vector a parameter of the base. Effects shift the torque about which
    /// the base is linear, too.
    pub fn base_slopes(&self, place: usize, state: &State, at: &[f64], parameters: usize) -> Vec<Vec<f64>> {
        let values = state.torque.to_array();
        (0..parameters.min(PARAMETERS))
            .map(|parameter| {
                let step = self.base_step(parameter, values[parameter]);
                let mut moved = values;
                moved[parameter] += step;
                let state = State { torque: state.torque.with_array(moved), ..state.clone() };
                slope(&self.predict(place, &state), at, step)
            })
            .collect()
    }

    /// ∂P/∂coefficient of an effect that is in the state already, or of a further one; 0 at rows
    /// that jump however small the step is.
    pub fn effect_slope(&self, place: usize, state: &State, regressor: &Regressor, at: &[f64]) -> Vec<f64> {
        if self.runs.runs[place].clean || regressor.run().is_some_and(|run| run != place) {
            return vec![0.0; at.len()];
        }
        let mut step = step_of(regressor);
        let most = |values: &[f64]| values.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let small = INEXACT * most(at).max(1e-9);
        let mut before = f64::INFINITY;
        loop {
            let mut moved = state.clone();
            match moved.effects.iter_mut().find(|(present, _)| present == regressor) {
                Some((_, coefficient)) => *coefficient += step,
                None => moved.effects.push((regressor.clone(), step)),
            }
            let slope = slope(&self.predict(place, &moved), at, step);
            let change = step * most(&slope);
            if change <= small || change.is_nan() || change > 0.5 * before {
                let is_smooth = |slope: f64| step * slope.abs() <= small;
                return slope.into_iter().map(|slope| if is_smooth(slope) { slope } else { 0.0 }).collect();
            }
            // A robot with tiny torques needs a tiny step.
            step *= 0.5 * small / change;
            before = change;
        }
    }

    /// Measured less predicted power of each run, W.
    pub fn residual(&self, state: &State) -> Signal {
        (0..self.runs.runs.len()).map(|place| self.left_by(place, &self.predict(place, state))).collect()
    }

    /// Measured power of one run less what is predicted, W.
    pub(crate) fn left_by(&self, place: usize, predicted: &[f64]) -> Vec<f64> {
        let rows = self.runs.runs[place].rows.iter();
        rows.zip(predicted).map(|(row, predicted)| row.power - predicted).collect()
    }

    /// Columns of one run before whitening: ∂P/∂ the first `base` parameters, ∂P/∂ the regressors'
    /// coefficients, and the residual.
    pub fn columns(
        &self,
        place: usize,
        state: &State,
        base: usize,
        regressors: &[Regressor],
    ) -> Vec<Vec<f64>> {
        let at = self.predict(place, state);
        let mut columns: Vec<Vec<f64>> = self.base_slopes(place, state, &at, base);
        columns.extend(regressors.iter().map(|regressor| self.effect_slope(place, state, regressor, &at)));
        columns.push(self.left_by(place, &at));
        columns
    }

    fn base_step(&self, parameter: usize, value: f64) -> f64 {
        // Typical sizes, for zero: N·m, N·m/kg, N·m·s/rad, kg·m², 1, W/(N·m)², N·m/kg.
        let typical = [1e-2, 1e-2, 1e-3, 1e-3, 1.0, 1.0, 1e-2][parameter];
        1e-4 * value.abs().max(1e-2 * typical)
    }
}

/// The motion when the encoders of a side show more than there is.
fn scaled<const N: usize>(
    core: &CoreRobot<f64, N>,
    layout: &Layout<f64, N>,
    motion: &Motion<f64, N>,
    scales: &[(f64, f64)],
) -> Motion<f64, N> {
    let mut factors = [1.0; N];
    for &(side, share) in scales {
        layout.scale(&mut factors, side_of(side), share);
    }
    // Torques are changed, not computed anew: the motion has lost the acceleration of a wheel at
    // rest, but the torques of the other wheels still include it.
    let added = std::array::from_fn(|i| motion.wheels[i].acceleration * (factors[i] - 1.0));
    let torques = core.mass_matrix.torque_per_kg(&added);
    let wheels = std::array::from_fn(|i| {
        let wheel = motion.wheels[i];
        let more = if wheel.direction == 0.0 { 0.0 } else { torques[i] };
        Wheel {
            speed: wheel.speed * factors[i],
            acceleration: wheel.acceleration + added[i],
            inertial_torque: wheel.inertial_torque + more,
            ..wheel
        }
    });
    Motion { wheels }
}

/// −1 left, 1 right, 0 both.
pub fn side_of(side: f64) -> Side {
    match side {
        side if side < 0.0 => Side::Left,
        side if side > 0.0 => Side::Right,
        _ => Side::Both,
    }
}

/// Steps of a numerical derivative, small against any plausible coefficient and large against
/// rounding.
fn step_of(regressor: &Regressor) -> f64 {
    match regressor {
        Regressor::Heat(_) | Regressor::Warming(_) | Regressor::Hot => 1e-4,
        Regressor::Temperature(..) => 1e-6,
        Regressor::Mass(_) | Regressor::Masses => 1e-3,
        Regressor::Delay => 1e-3,
        Regressor::Scale(_) | Regressor::HalfSlip | Regressor::Switch(Switched::HalfSlip, _) => 1e-4,
        _ => 1e-5,
    }
}

fn slope(moved: &[f64], at: &[f64], step: f64) -> Vec<f64> {
    moved.iter().zip(at).map(|(moved, at)| (moved - at) / step).collect()
}

fn add(power: &mut [f64], column: &[f64], coefficient: f64) {
    for (power, value) in power.iter_mut().zip(column) {
        *power += coefficient * value;
    }
}

/// The power, later by `delay` s: cubics through four rows, held at the ends of a run. Straight
/// lines would smooth the power between rows, which looks like an effect.
pub fn delayed(run: &Run, power: &[f64], delay: f64) -> Vec<f64> {
    let rows = &run.rows;
    let last = rows.len() - 1;
    let mut from = 0;
    rows.iter()
        .map(|row| {
            let wanted = row.time - delay;
            while from + 1 < last && rows[from + 1].time <= wanted {
                from += 1;
            }
            while from > 0 && rows[from].time > wanted {
                from -= 1;
            }
            let next = (from + 1).min(last);
            let span = rows[next].time - rows[from].time;
            let share = if span > 0.0 { ((wanted - rows[from].time) / span).clamp(0.0, 1.0) } else { 0.0 };
            let (before, after) = (power[from.saturating_sub(1)], power[(next + 1).min(last)]);
            cubic([before, power[from], power[next], after], share)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use logs::runs::{RawRun, Rows};
    use model_core::conditioning::Conditioning;
    use model_core::estimator::Sample;
    use model_core::slip::SlipMemory;

    use super::*;

    /// A Husky's curves of many radii, its scrub following at once, with this half slip.
    fn curves(half_slip: f64) -> Runs {
        let slip = SlipMemory { half_slip, ..SlipMemory::OFF };
        let husky = logs::robot::Robot::named("husky").unwrap().chassis(2.0).unwrap();
        let husky = husky.with_conditioning(Conditioning { slip, ..*husky.conditioning() });
        Runs::condition(&husky, vec![raw_curves()]).unwrap()
    }

    /// Curves of many radii, as recorded.
    fn raw_curves() -> RawRun {
        let rows = (0..600).map(|k| {
            let time = 0.05 * f64::from(k);
            let (forward, turn) = (3.0 + (0.6 * time).sin(), 0.8 * (0.37 * time).sin());
            let wheel_speed = [forward - turn, forward + turn];
            (time, Sample { wheel_speed, wheel_acceleration: None, power: 0.0 }.into(), 75.0, Vec::new())
        });
        RawRun { name: "run".to_owned(), rows: rows.collect(), columns: Vec::new(), period_s: 0.05 }
    }

    /// A model that is asked before the filter gives its power to the filter.
    #[test]
    fn power_passes_the_filter_after_the_model() {
        let torque = TorqueModel::from_array([3.0, 0.03, 0.2, 0.7, 1.1, 0.03, 0.57]);
        let state = State { torque, effects: Vec::new() };
        let husky = logs::robot::Robot::named("husky").unwrap().chassis(2.0).unwrap();
        let runs = Runs::condition_to(&husky, vec![raw_curves()], Rows::Before).unwrap();
        let before = Runs { smoothing: None, ..runs.clone() };
        let [shown, asked] =
            [&runs, &before].map(|runs| Predictor::new(runs, Drive::Dissipative).predict(0, &state));
        assert_ne!(shown, asked);
        assert_eq!(shown, runs.smoothed(&runs.runs[0], asked));
    }

    /// Of 40 % more winding loss, 1 − exp(−t/T) after t: at T itself 1 − 1/e of what windings take
    /// that are as hot from the start.
    #[test]
    fn windings_warm_towards_what_they_are_when_hot() {
        let torque = TorqueModel::from_array([3.0, 0.03, 0.2, 0.7, 1.1, 0.03, 0.57]);
        let runs = curves(0.0);
        let predictor = Predictor::new(&runs, Drive::Regenerative);
        let power = |effects: Vec<(Regressor, f64)>| predictor.predict(0, &State { torque, effects });
        let (cold, hot) = (power(Vec::new()), power(vec![(Regressor::Hot, 0.4)]));
        let warm = power(vec![(Regressor::Warming(10.0), 0.4)]);
        for (k, row) in runs.runs[0].rows.iter().enumerate() {
            let share = (warm[k] - cold[k]) / (hot[k] - cold[k]);
            assert!((share - (1.0 - (-row.time / 10.0).exp())).abs() < 1e-9, "{}: {share}", row.time);
        }
        assert!(hot.iter().zip(&cold).all(|(hot, cold)| hot > cold));
    }

    /// Tyres softer by 60 % give the power of a base fitted with 60 % more half slip; softened from
    /// 15 s on, they do so after the filter has settled.
    #[test]
    fn a_greater_half_slip_is_another_bases() {
        let torque = TorqueModel::from_array([3.0, 0.03, 0.2, 0.7, 1.1, 0.03, 0.57]);
        let powers = |half_slip: f64, effects: Vec<(Regressor, f64)>| {
            let runs = curves(half_slip);
            let predictor = Predictor::new(&runs, Drive::Dissipative);
            predictor.predict(0, &State { torque, effects })
        };
        let (base, softer) = (powers(0.1, Vec::new()), powers(0.16, Vec::new()));
        let close = |a: f64, b: f64| (a - b).abs() < 1e-9 * b.abs().max(1.0);
        let extended = powers(0.1, vec![(Regressor::HalfSlip, 0.6)]);
        assert!(extended.iter().zip(&softer).all(|(a, b)| close(*a, *b)));
        let from = Regressor::Switch(Switched::HalfSlip, [15.0].into());
        let switched = powers(0.1, vec![(from, 0.6)]);
        let times: Vec<f64> = curves(0.1).runs[0].rows.iter().map(|row| row.time).collect();
        for (k, time) in times.iter().enumerate().filter(|(_, time)| (**time - 15.0).abs() > 2.0) {
            let expected = if *time < 15.0 { base[k] } else { softer[k] };
            assert!((switched[k] - expected).abs() < 1e-3 * expected, "{time}: {} {expected}", switched[k]);
        }
        assert!(base.iter().zip(&softer).any(|(a, b)| (a - b).abs() > 5.0));
    }

    /// One wheel rests while the other speeds up, as at the start of a pivot. A scale of 0.001
    /// changes the power by 0.001 times the slope.
    #[test]
    fn scales_of_encoders_show_beside_wheels_at_rest() {
        let torque = TorqueModel::from_array([3.0, 0.03, 0.2, 0.7, 1.1, 0.03, 0.0]);
        let husky = logs::robot::Robot::named("husky").unwrap().chassis(2.0).unwrap();
        let rows = (0..600).map(|k| {
            let time = 0.05 * f64::from(k);
            // Within the dead band, and yet with an acceleration of its own.
            let wheel_speed = [1e-3 * (8.0 * time).sin(), 2.0 + (0.6 * time).sin()];
            (time, Sample { wheel_speed, wheel_acceleration: None, power: 0.0 }.into(), 75.0, Vec::new())
        });
        let raw =
            RawRun { name: "run".to_owned(), rows: rows.collect(), columns: Vec::new(), period_s: 0.05 };
        let runs = Runs::condition(&husky, vec![raw]).unwrap();
        let predictor = Predictor::new(&runs, Drive::Dissipative);
        let state = State { torque, effects: Vec::new() };
        let at = predictor.predict(0, &state);
        let slope = predictor.effect_slope(0, &state, &Regressor::Scale(0.0), &at);
        let moved = predictor.predict(0, &State { torque, effects: vec![(Regressor::Scale(0.0), 1e-3)] });
        for ((at, slope), moved) in at.iter().zip(&slope).zip(&moved) {
            assert!((moved - at - 1e-3 * slope).abs() < 1e-5 * at.abs().max(1.0), "{at} {slope} {moved}");
        }
        // Friction's power goes with the speed.
        assert!(slope.iter().zip(&at).all(|(slope, at)| *slope > 0.5 * at));
    }
}
