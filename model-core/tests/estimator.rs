//! The whole pipeline on synthetic drives: schedules, changes, gaps and energy.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, reason = "tests")]

mod common;

use common::{Rng, burger, coefficients, range, servo};
use model_core::adapt::{Adaptive, Ground};
use model_core::coefficients::{Coefficients, Robot};
use model_core::effects::live::Outside;
use model_core::effects::{Cause, Column, Columns, Term};
use model_core::eq18::Gate;
use model_core::estimator::{Conditioner, Estimate, Estimator, Sample, Timing};
use model_core::model::Model;
use model_core::motion::Motion;
use model_core::payload::schedule::Schedule;
use model_core::payload::window::{Sums, Window};
use model_core::payload::{Beyond, Bucket, MassEstimate, Method, Noise, Place, Unknown};
use model_core::slip::SlipMemory;
use model_core::torque::Drive;

const PERIOD: f64 = 0.01;
const PER_BUCKET: usize = 100;
const RING: usize = 8;
/// Standard deviation of the measured power, W; it is white, so its density is σ² Δt.
const SIGMA: f64 = 0.03;

type Pipeline = Estimator<f64, Window<f64>, 2, RING>;

fn robot() -> Coefficients<f64, 2> {
    let base = coefficients();
    // Little delay, so that P(filtered speed) and filtered P(speed) are the same to a mW.
    let robot = Robot { cutoff_hz: 20.0, ..base.robot };
    Coefficients {
        robot,
        noise: Noise { density: SIGMA * SIGMA * PERIOD, model_std: 0.0, tail: 1.0, residual_std: 0.0 },
        ..base
    }
}

/// All residuals squared, as the sums by hand have them.
fn method() -> Window<f64> {
    Window { linear_beyond: f64::INFINITY, ..robot().window(PERIOD) }
}

fn pipeline(schedule: Schedule, detect_changes: bool) -> Pipeline {
    let timing = Timing { period_s: PERIOD, bucket_s: 1.0, schedule, detect_changes };
    Estimator::new(&robot(), method(), &timing).unwrap()
}

/// A drive that never stands still: speed changes smoothly, power follows the model at `mass` with
/// white noise.
struct Driver {
    rng: Rng,
    time: f64,
    /// Of the measured power, W.
    sigma: f64,
}

impl Driver {
    fn new(seed: u64) -> Self {
        Self { rng: Rng::new(seed), time: 0.0, sigma: SIGMA }
    }

    fn sample(&mut self, mass: f64) -> Sample<f64, 2> {
        let t = self.time;
        self.time += PERIOD;
        let speed = [4.0 + 1.5 * (0.9 * t).sin(), 4.0 + 1.5 * (0.7 * t).cos()];
        let acceleration = [1.5 * 0.9 * (0.9 * t).cos(), -1.5 * 0.7 * (0.7 * t).sin()];
        let (_, matrix) = burger();
        let power = robot().model.power(&Motion::new(&speed, &acceleration, &matrix, 0.02), mass).unwrap();
        Sample { wheel_speed: speed, wheel_acceleration: None, power: power + self.sigma * self.rng.normal() }
    }

    /// Drives for so many buckets; what came of the last sample of each.
    fn run(&mut self, pipeline: &mut Pipeline, mass: f64, buckets: usize) -> Vec<Estimate<f64, 2>> {
        let mut closed = vec![];
        for _ in 0..buckets * PER_BUCKET {
            let sample = self.sample(mass);
            let out = pipeline.push(&sample, PERIOD);
            if out.closed {
                closed.push(out);
            }
        }
        closed
    }

    /// The same drive cut into buckets by hand.
    fn buckets(&mut self, conditioner: &mut Conditioner<f64, 2>, mass: f64, count: usize) -> Vec<Sums<f64>> {
        let model = robot().model;
        let mut buckets = vec![Sums::default(); count];
        for i in 0..count * PER_BUCKET {
            let out = conditioner.push(&self.sample(mass), PERIOD).unwrap();
            if out.settled {
                let response = model.response(&out.motion, &range());
                method().add(
                    &mut buckets[i / PER_BUCKET],
                    out.power,
                    &response,
                    out.motion.mean_speed(),
                    f64::NAN,
                );
            }
        }
        buckets
    }
}

fn conditioner() -> Conditioner<f64, 2> {
    Conditioner::new(&robot().robot, PERIOD).unwrap()
}

fn mass(estimate: &MassEstimate<f64>) -> f64 {
    estimate.known().unwrap().mass
}

#[test]
fn moving_window_is_the_method_over_the_latest_buckets() {
    let window = 5;
    let mut pipeline = pipeline(Schedule::Moving { window }, false);
    let outputs = Driver::new(1).run(&mut pipeline, 3.3, 30);
    let buckets = Driver::new(1).buckets(&mut conditioner(), 3.3, 30);
    assert_eq!(outputs.len(), 30);
    for (i, out) in outputs.iter().enumerate() {
        let from = (i + 1).saturating_sub(window);
        let expected = method().estimate(buckets[from..=i].iter());
        assert_eq!(out.mass.best(), expected.best(), "bucket {i}");
        // Where buckets scattered more than the fit's noise says, what is known of that widens the
        // interval.
        let width = |of: &MassEstimate<f64>| of.known().map_or(0.0, |known| known.high - known.low);
        assert!((1.0..1.3).contains(&(width(&out.mass) / width(&expected))), "bucket {i}");
        assert!(i < 2 || (mass(&out.mass) - 3.3).abs() < 0.2, "{:?}", out.mass);
        assert_eq!(out.power.is_some(), i > 0 && outputs[i - 1].mass.known().is_some());
    }
    // Whatever the schedule, any number of the latest that the ring still has.
    for count in 1..=RING {
        let expected = method().estimate(buckets[30 - count..].iter());
        assert_eq!(pipeline.over_latest(count).unwrap().best(), expected.best(), "{count}");
    }
    assert_eq!(pipeline.over_latest(0), None);
    assert_eq!(pipeline.over_latest(RING + 1), None);
}

/// Ten spikes of 2 W within five seconds, in the first of which nothing is known of the mass:
/// squared they move it by percents, but not where what is beyond the noise counts linearly. Once
/// later samples tell the mass, the first second is forgotten.
#[test]
fn what_is_beyond_the_noise_hardly_moves_the_mass() {
    let timing = Timing {
        period_s: PERIOD,
        bucket_s: 1.0,
        schedule: Schedule::Moving { window: 5 },
        detect_changes: false,
    };
    let masses = |method: Window<f64>| -> Vec<f64> {
        let mut pipeline: Pipeline = Estimator::new(&robot(), method, &timing).unwrap();
        let mut driver = Driver::new(3);
        let mut masses = vec![];
        for i in 0..5 * PER_BUCKET {
            let mut sample = driver.sample(3.3);
            sample.power += if i % 50 == 49 { 2.0 } else { 0.0 };
            let out = pipeline.push(&sample, PERIOD);
            masses.extend(out.closed.then(|| mass(&out.mass)));
        }
        assert_eq!(pipeline.over_latest(5).map(|of| mass(&of)), masses.last().copied());
        masses
    };
    let [squared, robust] = [method(), robot().window(PERIOD)].map(masses);
    assert_eq!(squared[0], robust[0]);
    let error = |masses: &[f64]| (masses[4] / 3.3 - 1.0).abs();
    assert!(error(&squared) > 0.03 && error(&robust) < 0.3 * error(&squared), "{squared:?} {robust:?}");
}

/// The mass of a first second that is wrong throughout is far off, and so are the weights by it.
/// The samples that they weigh are dropped as well.
#[test]
fn weights_by_a_mass_that_was_off_are_dropped() {
    let timing = Timing {
        period_s: PERIOD,
        bucket_s: 1.0,
        schedule: Schedule::Moving { window: 6 },
        detect_changes: false,
    };
    let quiet = Coefficients { noise: Noise { residual_std: 1e-3, ..robot().noise }, ..robot() };
    let mut pipeline: Pipeline = Estimator::new(&quiet, quiet.window(PERIOD), &timing).unwrap();
    let mut driver = Driver { sigma: 1e-3, ..Driver::new(3) };
    let mut masses = vec![];
    for i in 0..6 * PER_BUCKET {
        let mut sample = driver.sample(3.3);
        sample.power += if i < PER_BUCKET { 0.1 } else { 0.0 };
        let out = pipeline.push(&sample, PERIOD);
        let error = out.mass.known().map(|known| (known.mass / 3.3 - 1.0).abs());
        masses.extend(out.closed.then_some(error));
    }
    assert!(masses[0].is_some_and(|error| error > 0.1), "{masses:?}");
    // Beside a mass that is far off no sample is within the noise.
    assert_eq!(masses[1], None);
    assert!(masses[3..].iter().all(|error| error.is_some_and(|error| error < 0.002)), "{masses:?}");
}

/// Coefficients of one payload only know no mass, however well the samples would tell it: not from
/// the start, not over any window, and not for the power.
#[test]
fn coefficients_of_one_payload_know_no_mass() {
    let timing = Timing {
        period_s: PERIOD,
        bucket_s: 1.0,
        schedule: Schedule::Moving { window: 5 },
        detect_changes: true,
    };
    let blind = Coefficients { identifies_mass: false, ..robot() };
    let mut pipeline = Pipeline::new(&blind, method(), &timing).unwrap();
    let unknown = MassEstimate::Unknown(Unknown::NotIdentifiable);
    for out in Driver::new(1).run(&mut pipeline, 3.3, 30) {
        assert_eq!((out.mass, out.power, out.changed), (unknown, None, None));
    }
    assert_eq!(pipeline.over_latest(5), Some(unknown));
    assert_eq!(pipeline.energy().1, 0.0);
}

#[test]
fn over_latest_waits_for_its_buckets() {
    let mut pipeline = pipeline(Schedule::Cumulative, false);
    let mut driver = Driver::new(2);
    assert_eq!(pipeline.over_latest(1), None);
    driver.run(&mut pipeline, 3.0, 3);
    assert!(pipeline.over_latest(3).is_some());
    assert_eq!(pipeline.over_latest(4), None);
}

/// A hundred buckets in a ring of eight: merged, they still hold every sample.
#[test]
fn cumulative_beyond_the_ring_is_the_plain_sum() {
    let mut pipeline = pipeline(Schedule::Cumulative, false);
    let outputs = Driver::new(3).run(&mut pipeline, 4.4, 100);
    let buckets = Driver::new(3).buckets(&mut conditioner(), 4.4, 100);
    let mut narrowing = f64::INFINITY;
    for (i, out) in outputs.iter().enumerate() {
        let plain = method().estimate(buckets[..=i].iter());
        let (estimate, expected) = (out.mass.known().unwrap(), plain.known().unwrap());
        // The same sums in another order: some hundred roundings.
        assert!((estimate.mass - expected.mass).abs() < 1e-10, "bucket {i}: {estimate:?} {expected:?}");
        if i % 25 == 24 {
            assert!(estimate.high - estimate.low < narrowing, "bucket {i}");
            narrowing = estimate.high - estimate.low;
        }
    }
    assert!((mass(&outputs[99].mass) - 4.4).abs() < 0.03);
}

/// A window that the ring cannot hold is as long as the ring.
#[test]
fn window_beyond_the_ring_is_the_ring() {
    let mut pipeline = pipeline(Schedule::Moving { window: RING + 5 }, false);
    let mut driver = Driver::new(14);
    for i in 0..3 * RING {
        let outputs = driver.run(&mut pipeline, 3.0, 1);
        assert_eq!(Some(outputs[0].mass), pipeline.over_latest(RING.min(i + 1)), "bucket {i}");
    }
}

/// After a known change nothing of what was before counts, even when the ring has to make room.
#[test]
fn known_change_forgets() {
    for before in [3, 7, 8, 9, 20] {
        let mut pipeline = pipeline(Schedule::Cumulative, false);
        let mut driver = Driver::new(4);
        driver.run(&mut pipeline, 1.5, before);
        // Half a bucket more: it belongs to neither.
        for _ in 0..PER_BUCKET / 2 {
            let sample = driver.sample(1.5);
            pipeline.push(&sample, PERIOD);
        }
        pipeline.payload_changed();
        let first = {
            let sample = driver.sample(5.0);
            pipeline.push(&sample, PERIOD)
        };
        assert_eq!(first.mass, MassEstimate::Unknown(Unknown::NoSamples));
        assert_eq!(first.power, None);
        let outputs = driver.run(&mut pipeline, 5.0, 40);
        for (i, out) in outputs.iter().enumerate() {
            // The filter's memory of the old power, a tenth of a second, weighs most in the first
            // half bucket.
            let tolerance = if i < 2 { 0.6 } else { 0.15 };
            assert!((mass(&out.mass) - 5.0).abs() < tolerance, "{before}, bucket {i}: {:?}", out.mass);
        }
    }
}

#[test]
fn known_change_schedule_holds_its_first_window() {
    let mut pipeline = pipeline(Schedule::KnownChange { window: 4 }, false);
    let mut driver = Driver::new(5);
    let outputs = driver.run(&mut pipeline, 2.0, 20);
    let held = outputs[3].mass;
    assert!((mass(&held) - 2.0).abs() < 0.15);
    assert!(outputs[4..].iter().all(|out| out.mass == held));
    pipeline.payload_changed();
    let outputs = driver.run(&mut pipeline, 4.0, 20);
    assert!((mass(&outputs[3].mass) - 4.0).abs() < 0.15, "{:?}", outputs[3].mass);
    assert!(outputs[4..].iter().all(|out| out.mass == outputs[3].mass));
}

#[test]
fn periodic_schedule_estimates_anew_every_round() {
    let mut pipeline = pipeline(Schedule::Periodic { window: 3, every: 6 }, false);
    let mut driver = Driver::new(6);
    let mut outputs = driver.run(&mut pipeline, 2.0, 6);
    outputs.extend(driver.run(&mut pipeline, 5.0, 12));
    for (i, out) in outputs.iter().enumerate() {
        if i % 6 >= 3 {
            assert_eq!(out.mass, outputs[i - i % 6 + 2].mass, "bucket {i}");
        }
    }
    assert!((mass(&outputs[5].mass) - 2.0).abs() < 0.2);
    assert!((mass(&outputs[17].mass) - 5.0).abs() < 0.2);
}

/// Every change is noticed within four buckets; nine in ten are dated to the bucket. (Where the
/// noise leaned the same way just before, the sum had begun, and the change is dated too early.)
#[test]
fn unannounced_changes_are_noticed() {
    for schedule in [Schedule::Moving { window: 8 }, Schedule::Cumulative] {
        let mut well_dated = 0;
        for seed in 0..40 {
            let mut pipeline = pipeline(schedule, true);
            let mut driver = Driver::new(100 + seed);
            let quiet = driver.run(&mut pipeline, 2.5, 60);
            assert!(quiet.iter().all(|out| out.changed.is_none()), "seed {seed}: false alarm");
            let after = driver.run(&mut pipeline, 4.0, 10);
            let at = after.iter().position(|out| out.changed.is_some()).expect("the change is noticed");
            assert!(at < 4, "seed {seed}: after {at} buckets");
            if after[at].changed.unwrap().abs_diff(at + 1) <= 1 {
                well_dated += 1;
                // From then on the old load is gone but for one bucket: eight buckets of a moving
                // window alone would still hold five old ones and say 3.1.
                assert!((mass(&after[at + 2].mass) - 4.0).abs() < 0.6, "{:?}", after[at + 2].mass);
                assert!((mass(&after[9].mass) - 4.0).abs() < 0.3, "{:?}", after[9].mass);
            }
        }
        assert!(well_dated >= 36, "{schedule:?}: {well_dated} of 40");
    }
}

/// A sensor five times as noisy as in the fit: intervals widen, and no payload seems to change.
/// Samples since the change are weighed by what they leave at the mass before, until it is noticed.
/// They go when later ones tell the mass, and make no second change.
#[test]
fn a_change_is_noticed_once_where_samples_are_weighed_by_the_mass_known() {
    for (seed, [before, after]) in (1..).zip([[3.0, 5.0], [5.0, 3.0], [2.0, 5.5], [4.0, 2.5]]) {
        // Nearly exact, so that the sample within which the payload changes stands out.
        let sigma = 1e-3 * SIGMA;
        let noise = Noise { density: sigma * sigma * PERIOD, ..robot().noise };
        let coefficients = Coefficients { noise, ..robot() };
        let timing = Timing {
            period_s: PERIOD,
            bucket_s: 1.0,
            schedule: Schedule::Moving { window: RING },
            detect_changes: true,
        };
        let mut pipeline: Pipeline =
            Estimator::new(&coefficients, coefficients.window(PERIOD), &timing).unwrap();
        let mut driver = Driver { sigma, ..Driver::new(seed) };
        driver.run(&mut pipeline, before, 40);
        let closed = driver.run(&mut pipeline, after, 30);
        let noticed = closed.iter().filter(|out| out.changed.is_some()).count();
        assert_eq!(noticed, 1, "{before} to {after} kg");
        let at_last = mass(&closed.last().unwrap().mass);
        assert!((at_last - after).abs() < 0.1, "{at_last} {after}");
    }
}

#[test]
fn noise_beyond_the_fits_widens_intervals_and_is_no_change() {
    let (mut inside, mut known, mut alarms) = (0, 0, 0);
    for seed in 0..30 {
        let mut pipeline = pipeline(Schedule::Moving { window: 20 }, true);
        let mut driver = Driver::new(900 + seed);
        for bucket in 0..60 {
            let mut last = None;
            for _ in 0..PER_BUCKET {
                let sample = driver.sample(3.0);
                let noise = 24_f64.sqrt() * SIGMA * driver.rng.normal();
                last = Some(pipeline.push(&Sample { power: sample.power + noise, ..sample }, PERIOD));
            }
            let last = last.unwrap();
            alarms += usize::from(last.changed.is_some());
            // Windows that share no bucket.
            if let (19 | 39 | 59, Some(estimate)) = (bucket, last.mass.known()) {
                known += 1;
                inside += usize::from(estimate.low <= 3.0 && 3.0 <= estimate.high);
            }
        }
    }
    assert_eq!(alarms, 0);
    assert!(known >= 80 && inside * 100 >= known * 90, "{inside} of {known}");
}

/// A robot lighter or heavier than it can be is told so: the nearest end, an interval that reaches
/// out to its mass, and no change of payload. Its power is predicted all the same.
#[test]
fn masses_beyond_the_range_are_told() {
    for (truth, place, end) in [
        (0.8, Place::Below, 1.0),
        (0.9, Place::Below, 1.0),
        (7.0, Place::Above, 6.0),
        (9.0, Place::Above, 6.0),
        (15.0, Place::Above, 6.0),
    ] {
        let mut pipeline = pipeline(Schedule::Moving { window: 25 }, true);
        let outputs = Driver::new(77).run(&mut pipeline, truth, 60);
        for out in &outputs[26..] {
            let MassEstimate::Beyond(Beyond { place: side, mass, best }) = out.mass else {
                panic!("{truth}: {:?}", out.mass)
            };
            assert_eq!((side, mass.mass), (place, end), "{truth}");
            assert!((best - truth).abs() < 0.1_f64.max(0.03 * truth), "{truth}: {best}");
            assert!(
                mass.low.min(end) <= truth.min(end) + 0.05 && truth.max(end) - 0.3 <= mass.high,
                "{mass:?}"
            );
            assert_eq!(out.changed, None);
            let (measured, predicted) = (out.conditioned.unwrap().power, out.power.unwrap());
            assert!(
                (measured - predicted).abs() < 0.15_f64.max(0.05 * truth),
                "{truth}: {measured} {predicted}"
            );
        }
    }
    // A little outside, and as likely inside: no claim, and an interval that is not cut.
    let outputs = Driver::new(78).run(&mut pipeline(Schedule::Moving { window: 8 }, true), 1.0, 60);
    let places: Vec<_> = outputs[9..].iter().map(|out| out.mass.place().unwrap()).collect();
    assert!(places.iter().filter(|place| **place == Place::Within).count() >= 40, "{places:?}");
}

#[test]
fn no_false_alarm_in_an_hour_of_driving() {
    for seed in 0..4 {
        let mut pipeline = pipeline(Schedule::Moving { window: 8 }, true);
        let alarms = Driver::new(200 + seed).run(&mut pipeline, 3.0, 900);
        assert_eq!(alarms.iter().filter(|out| out.changed.is_some()).count(), 0, "seed {seed}");
    }
}

/// Standing still, in every model: unknown, and no prediction, and a payload once known is let go.
#[test]
fn standing_still_is_unknown() {
    let beta = servo().expand();
    for model in [
        Model::Signed { torque: servo(), drive: Drive::Dissipative },
        Model::Eq18 { gate: Gate::Corrected, beta },
        Model::Eq18 { gate: Gate::Published, beta },
    ] {
        let robot = Coefficients { model, ..robot() };
        let timing = Timing {
            period_s: PERIOD,
            bucket_s: 1.0,
            schedule: Schedule::Moving { window: 5 },
            detect_changes: true,
        };
        let mut pipeline: Pipeline = Estimator::new(&robot, method(), &timing).unwrap();
        let mut rng = Rng::new(7);
        let mut still = |pipeline: &mut Pipeline| {
            let noise = [1e-3 * rng.normal(), 1e-3 * rng.normal()];
            let sample = Sample { wheel_speed: noise, wheel_acceleration: None, power: 0.01 * rng.normal() };
            pipeline.push(&sample, PERIOD)
        };
        for _ in 0..3000 {
            let out = still(&mut pipeline);
            assert_eq!((out.mass.known(), out.power), (None, None), "{model:?}");
        }
        assert!(Driver::new(8).run(&mut pipeline, 3.0, 5)[4].mass.known().is_some());
        let mut last = None;
        for _ in 0..3000 {
            last = Some(still(&mut pipeline));
        }
        assert_eq!(last.unwrap().mass, MassEstimate::Unknown(Unknown::NoMotion), "{model:?}");
    }
}

/// A gap empties the window; however long or odd it is, a window's worth of samples later all is
/// well again.
#[test]
fn gaps_of_any_kind_are_survived() {
    for elapsed in [30.0, 3600.0, 1e12, f64::INFINITY, f64::NAN, f64::NEG_INFINITY, -5.0, -1e9] {
        let mut pipeline = pipeline(Schedule::Moving { window: 5 }, false);
        let mut driver = Driver::new(9);
        driver.run(&mut pipeline, 2.0, 10);
        let sample = driver.sample(5.0);
        let behind = pipeline.push(&sample, elapsed);
        if elapsed > 20.0 {
            assert_eq!(behind.mass, MassEstimate::Unknown(Unknown::NoMotion), "{elapsed}");
        }
        let outputs = driver.run(&mut pipeline, 5.0, 12);
        assert!((11..=13).contains(&outputs.len()), "{elapsed}: {} buckets in 12 s", outputs.len());
        assert!((mass(&outputs.last().unwrap().mass) - 5.0).abs() < 0.2, "{elapsed}");
    }
}

/// Samples that are not finite are left out; a bucket of nothing else says nothing.
#[test]
fn not_finite_samples_are_left_out() {
    let mut pipeline = pipeline(Schedule::Moving { window: 4 }, true);
    let mut driver = Driver::new(10);
    driver.run(&mut pipeline, 3.0, 4);
    for i in 0..PER_BUCKET * 4 {
        let good = driver.sample(3.0);
        let bad = Sample { power: f64::NAN, ..good };
        let out = pipeline.push(if i % 3 == 0 { &bad } else { &good }, PERIOD);
        assert_eq!(out.conditioned.is_none(), i % 3 == 0);
        assert!(out.mass.known().is_some());
    }
    for _ in 0..PER_BUCKET * 5 {
        let bad = Sample { power: f64::INFINITY, ..driver.sample(3.0) };
        let out = pipeline.push(&bad, PERIOD);
        assert_eq!((out.conditioned, out.power), (None, None));
    }
    assert_eq!(pipeline.over_latest(4), Some(MassEstimate::Unknown(Unknown::NoMotion)));
    assert!(driver.run(&mut pipeline, 3.0, 6)[5].mass.known().is_some());
}

/// Eq. 9 over the filtered power; what is predicted with the right mass agrees.
#[test]
fn energy_is_the_integral_of_the_power() {
    let mut pipeline = pipeline(Schedule::Moving { window: 5 }, false);
    let mut driver = Driver::new(11);
    let (mut measured, mut predicted) = (0.0, 0.0);
    for _ in 0..60 * PER_BUCKET {
        let sample = driver.sample(3.0);
        let out = pipeline.push(&sample, PERIOD);
        let now = out.conditioned.unwrap();
        measured += now.power.max(0.0) * PERIOD;
        if now.settled {
            predicted += out.power.unwrap_or(0.0).max(0.0) * PERIOD;
        }
    }
    let (measured_j, predicted_j) = pipeline.energy();
    assert!((measured_j - measured).abs() < 1e-9 * measured, "{measured_j} {measured}");
    assert!((predicted_j - predicted).abs() < 1e-9 * predicted, "{predicted_j} {predicted}");
    // Nothing is predicted in the first second of the 60, in which the mass is unknown.
    assert!((predicted_j / measured_j - 59.0 / 60.0).abs() < 0.01);
}

/// Where drives return braking power, energy is what the battery gives less what it takes; where
/// they burn it, Eq. 9, to the last digit as before.
#[test]
fn energy_is_net_where_drives_return_power() {
    let Model::Signed { torque, .. } = robot().model else { panic!("signed") };
    let timing = Timing {
        period_s: PERIOD,
        bucket_s: 1.0,
        schedule: Schedule::Moving { window: 5 },
        detect_changes: false,
    };
    let (_, matrix) = burger();
    let returns =
        |share| Columns::new(&[Column { cause: Cause::Term(Term::Return), coefficient: share }], 2).unwrap();
    for (drive, columns, is_net) in [
        (Drive::Dissipative, Columns::NONE, false),
        (Drive::Regenerative, Columns::NONE, true),
        (Drive::Dissipative, returns(0.5), true),
        (Drive::Dissipative, returns(0.0), false),
    ] {
        let model = Model::Signed { torque, drive };
        let coefficients = Coefficients { model, columns, ..robot() };
        let mut pipeline = Pipeline::new(&coefficients, method(), &timing).unwrap();
        let mut adaptive = Adaptive::new(&coefficients, &Ground::usual(), PERIOD, 1.0).ok();
        let (mut measured, mut braked) = (0.0, 0.0);
        for i in 0..60 * PER_BUCKET {
            let t = i as f64 * PERIOD;
            // Hard starts and stops: inertia drives the motors.
            let (speed, acceleration) = ([6.0 + 5.0 * (8.0 * t).sin(); 2], [40.0 * (8.0 * t).cos(); 2]);
            let regenerative = Model::Signed { torque, drive: Drive::Regenerative };
            let power = regenerative.power(&Motion::new(&speed, &acceleration, &matrix, 0.02), 5.0).unwrap();
            let sample = Sample { wheel_speed: speed, wheel_acceleration: None, power };
            let now = pipeline.push(&sample, PERIOD).conditioned.unwrap();
            if let Some(adaptive) = &mut adaptive {
                adaptive.push(&sample, PERIOD);
            }
            measured += now.power.max(if is_net { f64::NEG_INFINITY } else { 0.0 }) * PERIOD;
            braked += now.power.min(0.0) * PERIOD;
        }
        assert!(braked < -1.0, "{braked}");
        let (joules, _) = pipeline.energy();
        assert!((joules / measured - 1.0).abs() < 1e-9, "{drive:?} {is_net}: {joules} {measured}");
        if let Some(adaptive) = adaptive {
            assert!((adaptive.energy().0 / measured - 1.0).abs() < 1e-3, "{drive:?}");
        }
    }
}

/// The state does not grow: it is plain data of one size, and a copy of it goes on as the original
/// does.
#[test]
fn memory_is_constant() {
    let mut pipeline = pipeline(Schedule::Cumulative, true);
    let mut driver = Driver::new(12);
    driver.run(&mut pipeline, 3.0, 50);
    let mut copy = pipeline;
    for _ in 0..500 {
        let sample = driver.sample(3.0);
        assert_eq!(pipeline.push(&sample, PERIOD), copy.push(&sample, PERIOD));
    }
    fn sums<const B: usize>() -> usize {
        size_of::<Estimator<f32, Window<f32>, 2, B>>()
    }
    // A second more of window costs eight sums; two of them, so that no padding counts.
    assert_eq!(sums::<26>() - sums::<24>(), 2 * 8 * size_of::<f32>());
}

#[test]
fn sums_of_buckets_add_up() {
    let buckets = Driver::new(13).buckets(&mut conditioner(), 3.0, 6);
    let mut merged = buckets[2];
    merged.merge(&buckets[3]);
    for d in [-2.0, 0.0, 1.5] {
        let apart = buckets[2].score(d) + buckets[3].score(d);
        assert!((merged.score(d) - apart).abs() < 1e-12 * (1.0 + apart.abs()));
        assert!(
            (merged.information(d) - buckets[2].information(d) - buckets[3].information(d)).abs() < 1e-12
        );
    }
}

/// The way of most robots leaves delay, scrub and its memory out. Whoever has one of them takes the
/// other way, and without any both are the same, bit for bit: on a drive that stops, turns back and
/// spins, with a gap, a sample that is no number and time that runs backwards.
#[test]
fn the_straight_way_is_the_same() {
    let plain = robot();
    let scrubbing = plain.robot.kinematics.with_scrub(true);
    let with = |change: &dyn Fn(&mut Robot<f64, 2>)| {
        let mut changed = plain;
        change(&mut changed.robot);
        let Model::Signed { torque, .. } = &mut changed.model else { panic!("another model") };
        (torque.scrub, torque.imbalance) = (0.02, 0.004);
        changed
    };
    let scrubs = |robot: &mut Robot<f64, 2>| {
        (robot.kinematics, robot.mass_matrix) = (scrubbing, scrubbing.mass_matrix(0.064).unwrap());
    };
    let robots = [
        plain,
        with(&|_| ()),
        with(&|robot| robot.conditioning.delay = 0.013),
        with(&scrubs),
        with(&|robot| robot.conditioning.slip = SlipMemory { half_slip: 0.3, relaxation: 0.1, rest: 0.0 }),
        with(&|robot| {
            scrubs(robot);
            robot.conditioning.slip = SlipMemory { half_slip: 0.3, relaxation: 0.1, rest: 0.0 };
        }),
    ];
    for (index, coefficients) in robots.iter().enumerate() {
        let timing = Timing {
            period_s: PERIOD,
            bucket_s: 1.0,
            schedule: Schedule::Moving { window: 5 },
            detect_changes: true,
        };
        let new = || Pipeline::new(coefficients, coefficients.window(PERIOD), &timing).unwrap();
        let (mut straight, mut around, mut rng) = (new(), new(), Rng::new(5));
        for i in 0..3000 {
            let t = f64::from(i) * PERIOD;
            let level = if i % 700 < 500 { 3.0 } else { 0.0 };
            let speed = [level * (0.9 * t).sin(), level * (1.3 * t).cos()];
            let power = if i == 1200 { f64::NAN } else { 0.3 + level * 0.2 + 0.05 * rng.normal() };
            let sample = Sample { wheel_speed: speed, wheel_acceleration: None, power };
            let elapsed = match i {
                900 => 40.0 * PERIOD,
                1500 => -PERIOD,
                _ => PERIOD,
            };
            let one = straight.push(&sample, elapsed);
            let other = around.push_with(&mut (), &sample, &Outside::UNKNOWN, elapsed);
            // Text, since what is no number equals nothing.
            assert_eq!(format!("{one:?}"), format!("{other:?}"), "robot {index}, sample {i}");
        }
        assert_eq!(straight.energy(), around.energy(), "robot {index}");
    }
}
