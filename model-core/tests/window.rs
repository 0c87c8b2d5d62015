//! The window estimator against brute force, its indifference to the buckets' borders, and its
//! refusals.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

mod common;

use common::{Rng, burger, range, servo};
use model_core::eq18::Gate;
use model_core::model::{MassRange, Model, Response};
use model_core::motion::Motion;
use model_core::payload::roots::RootMean;
use model_core::payload::window::{Sums, Window};
use model_core::payload::{Beyond, Bucket, Mass, MassEstimate, Method, Noise, Unknown};
use model_core::polynomial::Polynomial;
use model_core::real::Real;
use model_core::torque::Drive;
use proptest::prelude::*;

fn window() -> Window<f64> {
    Window {
        range: range(),
        noise: Noise { density: 1e-6, model_std: 0.0, tail: 1.0, residual_std: 0.0 },
        period: 0.02,
        linear_beyond: f64::INFINITY,
    }
}

/// A sample: power and the response of the model.
type Seen = (f64, Response<f64>);

fn buckets(window: &Window<f64>, samples: &[Seen], cuts: &[usize]) -> Vec<Sums<f64>> {
    let mut buckets = vec![];
    let mut from = 0;
    for to in cuts.iter().copied().chain([samples.len()]) {
        let mut sums = Sums::default();
        for (power, response) in &samples[from..to] {
            window.add(&mut sums, *power, response, 1.0, f64::NAN);
        }
        buckets.push(sums);
        from = to;
    }
    buckets
}

fn even_cuts(count: usize, per_bucket: usize) -> Vec<usize> {
    (1..).map(|i| i * per_bucket).take_while(|cut| *cut < count).collect()
}

fn models() -> [Model<f64>; 3] {
    [
        Model::Signed { torque: servo(), drive: Drive::Dissipative },
        Model::Eq18 { gate: Gate::Corrected, beta: servo().expand() },
        Model::Eq18 { gate: Gate::Published, beta: servo().expand() },
    ]
}

/// Drives at random speeds and accelerations; measured power has noise of `sigma` W.
fn drive(model: &Model<f64>, mass: f64, sigma: f64, count: usize, seed: u64) -> Vec<Seen> {
    let mut rng = Rng::new(seed);
    let (_, matrix) = burger();
    (0..count)
        .map(|_| {
            let (v, a) = (rng.uniform(-6.0, 6.0), rng.uniform(-40.0, 40.0));
            let motion = Motion::new(
                &[v + rng.uniform(-1.0, 1.0), v],
                &[a, a + rng.uniform(-1.0, 1.0)],
                &matrix,
                0.02,
            );
            (model.power(&motion, mass).unwrap() + sigma * rng.normal(), model.response(&motion, &range()))
        })
        .collect()
}

/// Σ (P − P(m))² over the samples that count, by definition.
fn sum_of_squares(samples: &[Seen], mass: f64) -> f64 {
    let counted = samples.iter().filter(|(_, response)| !response.may_clamp);
    counted.map(|(power, response)| (power - response.polynomial.at(mass - range().middle())).powi(2)).sum()
}

fn brute_force(samples: &[Seen]) -> f64 {
    let masses = (0..=5000).map(|i| 1.0 + f64::from(i) * 1e-3);
    let least = |x: &f64, y: &f64| sum_of_squares(samples, *x).total_cmp(&sum_of_squares(samples, *y));
    masses.min_by(least).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// The least sum of squares lies within a step of 1 g of the grid's best.
    #[test]
    fn finds_the_least_sum_of_squares(mass in 1.0..6.0_f64, sigma in 0.0..0.05_f64, seed in any::<u64>()) {
        for model in models() {
            let samples = drive(&model, mass, sigma, 200, seed);
            let window = window();
            let estimate = window.estimate(buckets(&window, &samples, &even_cuts(200, 10)).iter());
            // Noise may put a mass at the edge beyond it: then it is held there.
            let (MassEstimate::Known(nearest) | MassEstimate::Beyond(Beyond { mass: nearest, .. })) = estimate
            else {
                return Err(TestCaseError::fail(format!("{estimate:?}")));
            };
            let Mass { mass: estimated, low, high } = nearest;
            let best = brute_force(&samples);
            prop_assert!((estimated - best).abs() <= 1e-3, "{:?}: {} by brute force {}", model, estimated, best);
            prop_assert!(low <= estimated && estimated <= high && (1.0..=6.0).contains(&estimated));
            // What lies inside is cut to the range; what seems to lie beyond is not.
            prop_assert!((1.0 <= low || estimated == 1.0) && (high <= 6.0 || estimated == 6.0));
            if sigma == 0.0 {
                prop_assert!((estimated - mass).abs() < 1e-9);
            }
        }
    }

    /// Where the samples are cut into buckets changes what is known of their scatter, not the mass.
    #[test]
    fn cuts_do_not_move_the_estimate(
        mass in 1.0..6.0_f64, seed in any::<u64>(), cuts in proptest::collection::btree_set(1..300_usize, 7..40),
    ) {
        let model = models()[0];
        let samples = drive(&model, mass, 0.02, 300, seed);
        let window = window();
        let cuts: Vec<_> = cuts.into_iter().collect();
        let estimate = |cuts: &[usize]| {
            window.estimate(buckets(&window, &samples, cuts).iter()).known().map(|known| known.mass)
        };
        let (even, uneven) = (estimate(&even_cuts(300, 30)).unwrap(), estimate(&cuts));
        // Fewer effective buckets than three besides the prior's do not occur with seven cuts and
        // more.
        prop_assert!((even - uneven.unwrap()).abs() < 1e-9, "{} {:?}", even, uneven);
    }

    /// Any coefficients that a fit can give (not negative, about a mass of 0) have one minimum.
    #[test]
    fn any_parabola(
        seed in any::<u64>(), mass in 1.0..6.0_f64, size in 0.0..1.0_f64,
    ) {
        let mut rng = Rng::new(seed);
        let samples: Vec<Seen> = (0..100).map(|_| {
            let a = size * rng.uniform(0.0, 1.0);
            let about_zero = Polynomial { a, b: rng.uniform(0.0, 1.0), c: rng.uniform(0.0, 1.0) };
            let polynomial = about_zero.about(range().middle());
            (about_zero.at(mass) + 0.1 * rng.normal(), Response { polynomial, may_clamp: false })
        }).collect();
        let window = window();
        let estimate = window.estimate(buckets(&window, &samples, &even_cuts(100, 5)).iter());
        let estimate = estimate.known().unwrap().mass;
        prop_assert!((estimate - brute_force(&samples)).abs() <= 1e-3, "{}", estimate);
    }

    /// Nothing that a sample can hold makes a panic or a mass outside the range, or one that is not
    /// a number.
    #[test]
    fn any_numbers(
        values in proptest::collection::vec(proptest::array::uniform4(any::<f32>()), 1..30), speed in any::<f32>(),
    ) {
        let range = MassRange::new(1.0_f32, 6.0).unwrap();
        let window = Window { range, noise: Noise { density: 1e-4, model_std: 0.1, tail: 1.0, residual_std: 0.0 }, period: 0.02, linear_beyond: 0.3 };
        let roots = RootMean { range };
        let mut sums = (vec![], vec![]);
        for [power, a, b, c] in values {
            let response = Response { polynomial: Polynomial { a, b, c }, may_clamp: false };
            let (mut of_window, mut of_roots) = Default::default();
            window.add(&mut of_window, power, &response, speed, speed);
            roots.add(&mut of_roots, power, &response, speed, speed);
            sums.0.push(of_window);
            sums.1.push(of_roots);
        }
        for estimate in [window.estimate(sums.0.iter()), roots.estimate(sums.1.iter())] {
            if let MassEstimate::Known(Mass { mass, low, high }) = estimate {
                prop_assert!(low <= mass && mass <= high && (1.0..=6.0).contains(&mass), "{:?}", estimate);
            }
        }
    }
}

fn estimate(samples: &[Seen]) -> MassEstimate<f64> {
    let window = window();
    window.estimate(buckets(&window, samples, &even_cuts(samples.len(), 10)).iter())
}

#[test]
fn not_finite_is_unknown() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e200] {
        for place in 0..4 {
            let mut samples = drive(&models()[0], 3.0, 0.01, 100, 1);
            let (power, response) = &mut samples[42];
            response.may_clamp = false;
            // A slope and a curvature that reach every sum.
            response.polynomial.b = 0.1;
            match place {
                0 => *power = bad,
                1 => response.polynomial.a = bad,
                2 => response.polynomial.b = bad,
                _ => response.polynomial.c = bad,
            }
            let unknown = estimate(&samples);
            assert!(matches!(unknown, MassEstimate::Unknown(_)), "{bad} at {place}: {unknown:?}");
        }
    }
    let mut samples = drive(&models()[0], 3.0, 0.01, 100, 1);
    samples[42] = (f64::NAN, Response { may_clamp: false, ..samples[42].1 });
    samples[42].1.polynomial.b = 0.1;
    assert_eq!(estimate(&samples), MassEstimate::Unknown(Unknown::NotFinite));
}

/// Standing still says nothing about the mass, in any model: Eq. 18's constants for the mass
/// included.
#[test]
fn standing_still_is_unknown() {
    let (_, matrix) = burger();
    let rest = Motion::new(&[0.01, -0.01], &[0.5, 0.3], &matrix, 0.02);
    let range = range();
    for model in models() {
        for power in [0.0, 0.3] {
            let response = model.response(&rest, &range);
            let (window, roots) = (window(), RootMean { range });
            let (mut of_window, mut of_roots) = Default::default();
            for _ in 0..1000 {
                window.add(&mut of_window, power, &response, rest.mean_speed(), f64::NAN);
                roots.add(&mut of_roots, power, &response, rest.mean_speed(), f64::NAN);
            }
            assert_eq!(
                window.estimate([of_window; 20].iter()),
                MassEstimate::Unknown(Unknown::NoMotion),
                "{model:?}"
            );
            assert_eq!(
                roots.estimate([of_roots; 20].iter()),
                MassEstimate::Unknown(Unknown::NoMotion),
                "{model:?}"
            );
        }
    }
    let window = window();
    assert_eq!(window.estimate([].iter()), MassEstimate::Unknown(Unknown::NoMotion));
}

/// A wheel that may be clamped hides the mass: such samples count for nothing, whatever they hold.
#[test]
fn clamped_samples_do_not_count() {
    let mut samples = drive(&models()[0], 3.0, 0.01, 100, 2);
    assert!(samples.iter().any(|(_, response)| response.may_clamp));
    let before = estimate(&samples);
    for (power, response) in &mut samples {
        if response.may_clamp {
            *power = f64::NAN;
        }
    }
    assert_eq!(estimate(&samples), before);
    for (_, response) in &mut samples {
        response.may_clamp = true;
    }
    assert_eq!(estimate(&samples), MassEstimate::Unknown(Unknown::NoMotion));
}

/// Noise that drowns the mass, of either kind, is admitted.
#[test]
fn too_much_noise_is_unknown() {
    let samples = drive(&models()[0], 3.0, 0.01, 100, 3);
    let with = |noise| {
        let window = Window { noise, ..window() };
        window.estimate(buckets(&window, &samples, &even_cuts(100, 10)).iter())
    };
    assert!(with(Noise { density: 1e-6, model_std: 1e-3, tail: 1.0, residual_std: 0.0 }).known().is_some());
    assert_eq!(
        with(Noise { density: 10.0, model_std: 0.0, tail: 1.0, residual_std: 0.0 }),
        MassEstimate::Unknown(Unknown::TooWide)
    );
    assert_eq!(
        with(Noise { density: 1e-6, model_std: 10.0, tail: 1.0, residual_std: 0.0 }),
        MassEstimate::Unknown(Unknown::TooWide)
    );
    assert_eq!(
        with(Noise { density: f64::NAN, model_std: 0.0, tail: 1.0, residual_std: 0.0 }),
        MassEstimate::Unknown(Unknown::TooWide)
    );
}

/// Half of the samples lie above the model at the middle mass and half below, as far as `apart` W,
/// `slope` W/kg telling the mass.
fn of_two_minds<T: Real>(slope: f64, apart: f64, density: f64, linear_beyond: f64) -> MassEstimate<T> {
    let number = T::from_f64;
    let window = Window {
        range: MassRange::new(number(1.0), number(6.0)).unwrap(),
        noise: Noise {
            density: number(density),
            model_std: number(1e-3),
            tail: T::ONE,
            residual_std: T::ZERO,
        },
        period: number(0.02),
        linear_beyond: number(linear_beyond),
    };
    let polynomial = Polynomial { a: T::ZERO, b: number(slope), c: T::ZERO };
    let mut sums = Sums::default();
    for power in [apart, -apart] {
        let response = Response { polynomial, may_clamp: false };
        window.add(&mut sums, number(power), &response, T::ONE, T::ZERO);
    }
    window.estimate([sums; 20].iter())
}

/// A share of what tells how far off the mass is, of which nothing is left: x / 0 where noise is
/// known, 0 / 0 where there is none, and 0 / 0 again of information whose square is below the
/// smallest number. On the board as on the host that is "unknown", and no number.
#[test]
fn nothing_that_tells_how_far_off_is_unknown() {
    fn all<T: Real>(tiny: f64) {
        let (unknown, known) =
            (MassEstimate::Unknown(Unknown::TooWide), of_two_minds::<T>(0.1, 0.001, 1e-6, 0.01));
        assert!(matches!(known, MassEstimate::Known(_)), "{known:?}");
        for density in [1e-6, 0.0] {
            assert_eq!(of_two_minds::<T>(0.1, 0.02, density, 0.01), unknown, "{density}");
        }
        for apart in [0.0, 0.001, 0.02] {
            assert_eq!(of_two_minds::<T>(tiny, apart, 0.0, 0.01), unknown, "{apart}");
        }
    }
    all::<f32>(1e-12);
    all::<f64>(1e-85);
}

/// A robot of 60 kg that may weigh 6 is not said to weigh 6 ± 0.01: the interval is as wide as the
/// disagreement.
#[test]
fn a_mass_beyond_the_range_is_not_certain() {
    for (mass, bound) in [(60.0, 6.0), (6.5, 6.0), (0.5, 1.0)] {
        let samples = drive(&models()[0], mass, 0.001, 300, 4);
        if let MassEstimate::Known(known) = estimate(&samples) {
            assert!((known.mass - bound).abs() < 1e-12, "{known:?}");
            let outside = (mass - bound).abs().min(1.25);
            assert!(known.high - known.low >= 0.9 * outside, "{mass}: {known:?}");
            assert!(known.low <= bound && bound <= known.high);
        }
    }
    // Inside, nothing of this.
    let known = estimate(&drive(&models()[0], 5.9, 0.001, 300, 4)).known().unwrap();
    assert!(known.high - known.low < 0.1);
}

/// Score and information are the first and second derivatives of the sum of squares, but for
/// residual times curvature.
#[test]
fn sums_are_derivatives() {
    let samples = drive(&models()[0], 3.0, 0.0, 50, 5);
    let window = window();
    let mut total = Sums::default();
    for bucket in buckets(&window, &samples, &even_cuts(50, 10)) {
        total.merge(&bucket);
    }
    let step = 1e-4;
    for d in [-2.0, -0.5, 0.0, 1.7] {
        let at = |d: f64| sum_of_squares(&samples, d + range().middle());
        // A quartic: the central difference errs by step² f'''/6, a few 1e-8 of the slope here.
        let slope = (at(d + step) - at(d - step)) / (2.0 * step);
        assert!((total.score(d) + slope / 2.0).abs() < 1e-6 * (1.0 + slope.abs()), "{d}");
    }
    // At the truth no residual is left, so the curvature is twice the information.
    let truth = 3.0 - range().middle();
    let second = (total.score(truth + step) - total.score(truth - step)) / (2.0 * step);
    assert!((total.information(truth) + second).abs() < 1e-6 * total.information(truth));
    let slope: f64 = samples
        .iter()
        .filter(|(_, response)| !response.may_clamp)
        .map(|(_, response)| response.polynomial.slope(truth))
        .sum();
    assert!((total.slope_sum(truth) - slope).abs() < 1e-12 * slope.abs());
}

/// The interval takes the bucket's own scatter: noise ten times the fit's is seen.
#[test]
fn scatter_widens_the_interval() {
    let width = |sigma| {
        let known = estimate(&drive(&models()[0], 3.0, sigma, 300, 6)).known().unwrap();
        known.high - known.low
    };
    assert!(width(0.05) > 5.0 * width(0.005));
}

/// One bucket has no scatter to show, so its interval is the fit's noise alone: Student's t for the
/// prior's six buckets times √(density / (Σ g² Δt) + (model error · Σ g / Σ g²)²), with g = dP/dm.
#[test]
fn one_bucket_has_the_fits_interval() {
    let samples: Vec<Seen> = (0..50)
        .map(|i| {
            let polynomial = Polynomial { a: 0.0, b: 0.1 + 0.002 * f64::from(i), c: 1.0 };
            (1.0, Response { polynomial, may_clamp: false })
        })
        .collect();
    let (mut sum, mut squares) = (0.0, 0.0);
    for (_, response) in &samples {
        sum += response.polynomial.b;
        squares += response.polynomial.b.powi(2);
    }
    for (density, model_std) in [(1e-3, 0.0), (0.0, 0.02), (2e-3, 0.03)] {
        let window = Window { noise: Noise { density, model_std, tail: 1.0, residual_std: 0.0 }, ..window() };
        let known = window.estimate(buckets(&window, &samples, &[]).iter()).known().unwrap();
        let variance: f64 = density / (squares * window.period) + (model_std * sum / squares).powi(2);
        // t.ppf(0.975, 6) of SciPy; the estimator's expansion of it is good to 1 %.
        let expected = 2.446_912 * variance.sqrt();
        let half_width = (known.high - known.low) / 2.0;
        assert!((half_width / expected - 1.0).abs() < 0.01, "{half_width} {expected}");
        // The surprise of a bucket is its error in units of the same two.
        let off = 1.5 * variance.sqrt();
        let mut sums = buckets(&window, &samples, &[])[0];
        let surprise = window.surprise(&sums, known.mass - off).unwrap();
        assert!((surprise - 1.5).abs() < 1e-9, "{surprise}");
        window.add(&mut sums, f64::NAN, &samples[0].1, 1.0, f64::NAN);
        assert_eq!(window.surprise(&sums, 3.0), None);
    }
}

/// A step too small to move the estimate ends the search: it once threw it to the middle of the
/// bracket and left the estimate wherever the last iteration then was.
#[test]
fn the_search_ends_at_the_minimum() {
    let samples = drive(&models()[0], 5.166250240976489, 0.02, 300, 11584987153609022412);
    let window = window();
    for cuts in [even_cuts(300, 30), vec![54, 88, 92, 107, 123, 133, 210]] {
        let buckets = buckets(&window, &samples, &cuts);
        let mut total = Sums::default();
        for bucket in &buckets {
            total.merge(bucket);
        }
        let d = window.estimate(buckets.iter()).known().unwrap().mass - range().middle();
        let off = total.score(d) / total.information(d);
        assert!(off.abs() < 1e-12, "{off} kg from the minimum");
    }
}

/// Residuals are held against those of most samples; without these against the density.
#[test]
fn what_counts_linearly_is_beyond_most_residuals() {
    let noise = Noise { density: 1e-4, model_std: 0.0, tail: 1.0, residual_std: 0.02 };
    assert!((noise.linear_beyond(4.0) - 1.345 * 0.02).abs() < 1e-12);
    let unknown = Noise { residual_std: 0.0, ..noise };
    assert!((unknown.linear_beyond(4.0) - 1.345 * (2.0 * 1.0166 * 4.0 * 1e-4_f64).sqrt()).abs() < 1e-12);
    assert_eq!(Noise { density: 0.0, ..unknown }.linear_beyond(4.0), f64::INFINITY);
}
