//! How far mass estimates and energies stray on windows that the fit has not seen, beyond what its
//! noise explains.
//!
//! Each window of the training logs is left out in turn: the coefficients move by one step of Gauss
//! and Newton without its rows, and what its own rows then say of the mass is held against the
//! noise of the fit. A model that lacks something errs alike for as long as a robot drives alike.
//! Residuals of the fit itself hide that: every window has pulled the coefficients its own way.
//!
//! The same is asked of each kind of driving ([`Kinds`]) in each run: a window of 25 s is mixed
//! where the training is, and in a mixed one errors of several kinds cancel. The energy of a task
//! is asked of the kinds alone: a task may be of one.

use std::collections::BTreeMap;

use logs::robot::chassis::Together;
use model_core::model::Model;
use model_core::payload::{Noise, huber};
use nalgebra::{DMatrix, DVector};
use numerics::intervals::student_95;
use numerics::robust::NORMAL_95;
use numerics::scaled_inverse::ScaledInverse;
use numerics::search::bisect;

use super::dataset::{Dataset, Kept};
use super::kinds::{Kinds, PAIRS};

/// Half a window, s. A window of 25 s is the estimators' default; every half of one ends a window.
const HALF_S: f64 = 12.5;

/// Whole windows below which nothing is concluded: the scatter of fewer is chance.
const LEAST_WINDOWS: f64 = 6.0;

/// Sums over rows: what they pulled the fit by, and what they say of mass and energy.
#[derive(Clone)]
struct Sums {
    /// Σ w x xᵀ with x = ∂P/∂θ and the fit's weights w.
    normal: DMatrix<f64>,
    /// Σ w x e, e being measured less predicted power.
    pull: DVector<f64>,
    /// Σ v g e with g = ∂P/∂m and the estimators' weights v.
    score: f64,
    /// Σ v g x: by what the score changes with the parameters.
    leverage: DVector<f64>,
    /// Σ v g².
    information: f64,
    /// Σ v g: what a constant error of 1 W adds to the score.
    slope: f64,
    /// Σ e and Σ x: the error of the energy, in rows of W, and by what it changes with the
    /// parameters.
    error: f64,
    along: DVector<f64>,
    /// How many rows there are, and how many in motion.
    rows: f64,
    moving: f64,
}

impl Sums {
    fn new(parameters: usize) -> Self {
        let (normal, none) = (DMatrix::zeros(parameters, parameters), DVector::zeros(parameters));
        Self {
            normal,
            pull: none.clone(),
            score: 0.0,
            leverage: none.clone(),
            information: 0.0,
            slope: 0.0,
            error: 0.0,
            along: none,
            rows: 0.0,
            moving: 0.0,
        }
    }

    fn merge(&mut self, other: &Self) {
        self.normal += &other.normal;
        self.pull += &other.pull;
        self.score += other.score;
        self.leverage += &other.leverage;
        self.information += other.information;
        self.slope += other.slope;
        self.error += other.error;
        self.along += &other.along;
        self.rows += other.rows;
        self.moving += other.moving;
    }

    /// By how much the parameters move once the rows are left out of the fit of all, whose normal
    /// matrix is `whole`, with the sign of the errors.
    fn left_out(&self, whole: &DMatrix<f64>) -> DVector<f64> {
        let others = ScaledInverse::of(&(whole - &self.normal));
        others.unscaled(&others.inverse) * &self.pull
    }

    /// The score by parameters that have moved.
    fn score_after(&self, moved: &DVector<f64>) -> f64 {
        self.score + self.leverage.dot(moved)
    }

    /// The error of the energy likewise, in rows of W.
    fn error_after(&self, moved: &DVector<f64>) -> f64 {
        self.error + self.along.dot(moved)
    }
}

/// The squared residual of a window by a fit without it, and what is expected of it: of the mass in
/// (W²/kg)², of the energy in rows² of W².
struct Stray {
    square: f64,
    /// By the fit's noise.
    expected: f64,
    /// By a constant error of 1 W.
    lasting: f64,
}

/// Constant errors of the power, W, that explain the errors on rows that the fit left out.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lasting {
    /// Mass estimates.
    pub(super) mass_w: f64,
    /// Energies, while the robot moves.
    pub(super) energy_w: f64,
}

/// The constant errors of the power that explain, with `noise`, how mass estimates and energies
/// stray on rows that the fit left out: masses on windows of 25 s or on one kind of driving in a
/// run, whichever stray more; energies on the kinds. 0 where noise alone explains it or windows are
/// too few.
///
/// `gradient` gives ∂P/∂θ of a row, 0 for parameters that are held; `weights` what each row of the
/// store counted for.
pub(super) fn lasting_errors(
    dataset: &Dataset,
    model: &Model<f64>,
    weights: &[f64],
    gradient: impl Fn(&Kept<'_>) -> DVector<f64>,
    noise: &Noise<f64>,
) -> Lasting {
    let by_place = sums_by_place(dataset, model, weights, gradient, noise);
    let Some(first) = by_place.values().next() else { return Lasting { mass_w: 0.0, energy_w: 0.0 } };
    let none = || Sums::new(first.pull.len());
    let (mut whole, mut halves) = (none(), BTreeMap::new());
    let (mut kinds, mut kinds_of_runs) = (BTreeMap::new(), BTreeMap::new());
    for (&Place { run, half, kind }, sums) in &by_place {
        whole.merge(sums);
        halves.entry((run, half)).or_insert_with(none).merge(sums);
        for pair in PAIRS {
            let kind = (pair, kind & pair);
            kinds.entry(kind).or_insert_with(none).merge(sums);
            kinds_of_runs.entry((kind, run)).or_insert_with(none).merge(sums);
        }
    }
    let whole = &whole.normal;
    let density = noise.density / dataset.store_period_s();
    let stray = |window: &Sums, moved: &DVector<f64>| Stray {
        square: window.score_after(moved).powi(2),
        expected: density * window.information,
        lasting: window.slope * window.slope,
    };
    let halves: Vec<((u32, i64), Sums)> = halves.into_iter().collect();
    let pairs = halves.windows(2).filter(|pair| pair[0].0.0 == pair[1].0.0);
    let windows = pairs.map(|pair| {
        let mut window = pair[0].1.clone();
        window.merge(&pair[1].1);
        stray(&window, &window.left_out(whole))
    });
    let of_energy = |kind: &Sums, moved: &DVector<f64>| Stray {
        square: kind.error_after(moved).powi(2),
        expected: density * kind.rows,
        lasting: kind.moving * kind.moving,
    };
    // The fit without the kind: the training may lack the kind of a task.
    let moved: BTreeMap<(u8, u8), DVector<f64>> =
        kinds.iter().map(|(kind, sums)| (*kind, sums.left_out(whole))).collect();
    let of_pair = |pair: u8, stray: &dyn Fn(&Sums, &DVector<f64>) -> Stray| {
        let of_runs = kinds_of_runs.iter().filter(|((kind, _), _)| kind.0 == pair);
        let strays = of_runs.filter_map(|((kind, _), sums)| Some(stray(sums, moved.get(kind)?)));
        constant(strays.collect(), 1.0)
    };
    // Each half is in two windows.
    let of_windows = constant(windows.collect(), 0.5);
    Lasting {
        mass_w: PAIRS.map(|pair| of_pair(pair, &stray)).into_iter().fold(of_windows, f64::max),
        energy_w: PAIRS.map(|pair| of_pair(pair, &of_energy)).into_iter().fold(0.0, f64::max),
    }
}

/// The constant error that explains these, W, each of which is `independent` of one of its own.
/// It is wider than the estimate by as much as Student's t is wider than the normal distribution:
/// few windows determine a scatter poorly.
fn constant(strays: Vec<Stray>, independent: f64) -> f64 {
    let strays: Vec<Stray> =
        strays.into_iter().filter(|stray| stray.expected > 0.0 && stray.lasting > 0.0).collect();
    let count = independent * strays.len() as f64;
    if count < LEAST_WINDOWS {
        return 0.0;
    }
    student_95(count).map_or(0.0, |student| between(&strays).sqrt() * student / NORMAL_95)
}

/// Whose rows are summed.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Place {
    run: u32,
    half: i64,
    kind: u8,
}

/// The sums of each kind of driving in each half window.
fn sums_by_place(
    dataset: &Dataset,
    model: &Model<f64>,
    weights: &[f64],
    gradient: impl Fn(&Kept<'_>) -> DVector<f64>,
    noise: &Noise<f64>,
) -> BTreeMap<Place, Sums> {
    let range = &dataset.robot.range();
    let linear_beyond = noise.linear_beyond(dataset.robot.cutoff_hz());
    let kinds = Kinds::of(&dataset.store);
    let mut by_place = BTreeMap::new();
    for (row, &weight) in dataset.store.iter().zip(weights) {
        let Some(predicted) = row.predicted(model) else { continue };
        let along = gradient(&row);
        let half = (row.time / HALF_S).floor() as i64;
        let place = Place { run: row.run, half, kind: kinds.kind(&row) };
        let sums = by_place.entry(place).or_insert_with(|| Sums::new(along.len()));
        let error = row.power - predicted;
        sums.error += error;
        sums.along += &along;
        sums.rows += 1.0;
        sums.moving += f64::from(row.wheels.is_moving());
        if weight > 0.0 {
            sums.normal.ger(weight, &along, &along, 1.0);
            sums.pull.axpy(weight * error, &along, 1.0);
        }
        let response = row.response(model, range);
        if !response.may_clamp {
            let slope = response.polynomial.slope(row.mass - range.middle());
            let weighted = huber(error, linear_beyond) * slope;
            sums.score += weighted * error;
            sums.leverage.axpy(weighted, &along, 1.0);
            sums.information += weighted * slope;
            sums.slope += weighted;
        }
    }
    by_place
}

/// The variance between windows by Paule and Mandel (1982), W²: that at which Σ s² / (expected + σ²
/// lasting) is the number of windows.
fn between(strays: &[Stray]) -> f64 {
    let excess = |variance: f64| {
        let ratio = |stray: &Stray| stray.square / (stray.expected + variance * stray.lasting);
        strays.iter().map(ratio).sum::<f64>() - strays.len() as f64
    };
    if strays.is_empty() || excess(0.0) <= 0.0 {
        return 0.0;
    }
    // There no window strays by more than its share.
    let most = strays.iter().map(|stray| stray.square / stray.lasting).sum::<f64>();
    bisect(0.0, most, excess)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physical;
    use logs::robot::Robot;
    use logs::robot::chassis::Chassis;
    use model_core::eq18::Gate;
    use model_core::motion::Motion;
    use model_core::torque::TorqueModel;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    /// Left out of least squares, a window's score is the one by the coefficients that the other
    /// windows alone give.
    #[test]
    fn a_window_left_out_is_judged_by_a_fit_of_the_others() {
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let mut normal = || -> f64 { random.sample(StandardNormal) };
        let windows: Vec<Vec<(DVector<f64>, f64)>> = (0..5)
            .map(|_| (0..20).map(|_| (DVector::from_fn(3, |_, _| normal()), normal())).collect())
            .collect();
        let fitted = |left_out: Option<usize>| {
            let (mut matrix, mut right) = (DMatrix::zeros(3, 3), DVector::zeros(3));
            for (number, rows) in windows.iter().enumerate() {
                for (x, y) in rows.iter().filter(|_| left_out != Some(number)) {
                    matrix.ger(1.0, x, x, 1.0);
                    right.axpy(*y, x, 1.0);
                }
            }
            let solution = matrix.clone().cholesky().unwrap().solve(&right);
            (matrix, solution)
        };
        let (whole, all) = fitted(None);
        for (number, rows) in windows.iter().enumerate() {
            let others = fitted(Some(number)).1;
            let mut sums = Sums::new(3);
            let (mut expected, mut error) = (0.0, 0.0);
            for (x, y) in rows {
                let slope = x[0] - 0.5 * x[2];
                sums.normal.ger(1.0, x, x, 1.0);
                sums.pull.axpy(y - x.dot(&all), x, 1.0);
                sums.score += slope * (y - x.dot(&all));
                sums.leverage.axpy(slope, x, 1.0);
                sums.error += y - x.dot(&all);
                sums.along += x;
                expected += slope * (y - x.dot(&others));
                error += y - x.dot(&others);
            }
            let moved = sums.left_out(&whole);
            let score = sums.score_after(&moved);
            assert!((score - expected).abs() < 1e-9 * expected.abs().max(1.0), "{score} {expected}");
            let error_after = sums.error_after(&moved);
            assert!((error_after - error).abs() < 1e-9 * error.abs().max(1.0), "{error_after} {error}");
        }
    }

    /// In one kind of driving the model errs by 0.1 W, in another by as much to the other side:
    /// windows of both see nothing of it, those of one kind do.
    #[test]
    fn errors_that_cancel_in_a_mixed_window_are_seen_by_kind() {
        // Straight on and turning, and steady and accelerating.
        for (apart, acceleration) in [([0.1, 1.0], [0.4, 0.4]), ([0.4, 0.4], [0.2, 0.9])] {
            let lasting = lasting_errors_of_kinds(apart, acceleration);
            assert!((0.05..0.5).contains(&lasting.mass_w), "{lasting:?}");
            // The energy of a kind is off by what the model errs by there.
            assert!((0.05..0.2).contains(&lasting.energy_w), "{lasting:?}");
        }
    }

    /// A second of each kind in turn, with these halves of the sides' difference in rad/s and
    /// accelerations in rad/s²; all drive faster and slower meanwhile.
    fn lasting_errors_of_kinds(apart: [f64; 2], acceleration: [f64; 2]) -> Lasting {
        let robot = Robot::named("burger").unwrap();
        let core = robot.core::<2>(4.0).unwrap();
        let torque = TorqueModel::from_array([0.05, 0.008, 0.007, 0.0065, 1.6, 2.5, 0.0]);
        let (model, drive) = (Model::Signed { torque, drive: robot.drive() }, robot.drive());
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let mut dataset = Dataset::empty(Chassis::new(&core), Gate::Signed);
        dataset.period_s = 0.05;
        for (run, mass) in [(0, 1.0), (1, 6.0)] {
            for index in 0..4000 {
                let time = 0.05 * f64::from(index);
                let kind = index as usize / 20 % 2;
                let speed = 3.0 + (0.37 * time).sin();
                let apart = apart[kind];
                let motion = Motion::with_scrub(
                    &[speed - apart, speed + apart],
                    &[acceleration[kind] * (0.37 * time).cos().abs(); 2],
                    &[0.0; 2],
                    &core.mass_matrix,
                    core.dead_band,
                );
                let noise: f64 = random.sample(StandardNormal);
                let error = [0.1, -0.1][kind];
                let power = model.power(&motion, mass).unwrap() + error + 0.01 * noise;
                dataset.store.push(Kept { wheels: &motion.wheels, power, mass, run, time });
            }
        }
        let weights = vec![1.0; dataset.store.len()];
        let noise = Noise { density: 1e-5, model_std: 0.0, tail: 1.0, residual_std: 0.0 };
        let gradient = |row: &Kept<'_>| {
            let slope = physical::gradient(&torque, row, drive);
            // One that the rows determine: Coulomb's.
            DVector::from_element(1, slope[0])
        };
        lasting_errors(&dataset, &model, &weights, gradient, &noise)
    }

    /// Scores by noise and by an error of their own in each window: its variance is found, and none
    /// where there is none.
    #[test]
    fn the_variance_between_windows_is_that_of_the_errors_that_last() {
        let mut random = ChaCha8Rng::seed_from_u64(11);
        let mut mean_of = |lasting_std: f64| {
            let one = |random: &mut ChaCha8Rng| {
                let strays: Vec<Stray> = (0..40)
                    .map(|window| {
                        let (expected, slope) = (f64::from(1 + window % 3), f64::from(1 + window % 4));
                        let noise: f64 = random.sample(StandardNormal);
                        let lasting: f64 = random.sample(StandardNormal);
                        let score = expected.sqrt() * noise + slope * lasting_std * lasting;
                        Stray { square: score * score, expected, lasting: slope * slope }
                    })
                    .collect();
                between(&strays)
            };
            (0..100).map(|_| one(&mut random)).sum::<f64>() / 100.0
        };
        let (none, two) = (mean_of(0.0), mean_of(2.0));
        // An estimate that cannot be below 0 is a little above it on average.
        assert!(none < 0.1, "{none}");
        assert!((two / 4.0 - 1.0).abs() < 0.1, "{two}");
    }
}
