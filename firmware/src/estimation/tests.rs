//! The board's estimates against model-core's double precision, fed as the host's replay feeds it.

use model_core::adapt::{Adaptive, Ground};
use model_core::coefficients::{Name, Robot};
use model_core::conditioning::Conditioning;
use model_core::effects::live::{Live, Outside};
use model_core::effects::{Cause, Column, Columns, Side, Term};
use model_core::estimator::{Estimator, Timing};
use model_core::kinematics::Kinematics;
use model_core::model::MassRange;
use model_core::motion::Motion;
use model_core::payload::roots::RootMean;
use model_core::payload::schedule::Schedule;
use model_core::payload::window::Window;
use model_core::payload::{Method, Noise};
use model_core::torque::{Drive, TorqueModel};

use super::*;
use crate::parameters::SAMPLE_PERIOD_US;

/// A small servo's parameters, and the coefficients of Eq. 18 that follow from them:
/// tests/reference/power.py.
const TORQUE: [f32; 7] = [0.04, 0.012, 0.006, 0.0081, 1.33, 6.5, 0.0];
const BETA: [f32; 15] = [
    0.0104,
    0.00624,
    0.000936,
    0.006234,
    0.000_852_93,
    22.9957,
    0.04312,
    0.012936,
    0.004212,
    0.001_263_6,
    0.6916,
    0.20748,
    0.008_731_8,
    1.43374,
    0.140_049,
];

const STATIC_W: f32 = 1.25;
const NOISE_W: f64 = 0.1;

pub(crate) fn signed() -> Model<f32> {
    Model::Signed { torque: TorqueModel::from_array(TORQUE), drive: Drive::Dissipative }
}

pub(crate) fn coefficients(model: Model<f32>) -> Coefficients<f32, WHEELS> {
    let kinematics = Kinematics::differential(0.033, 0.16).unwrap();
    Coefficients {
        robot: Robot {
            name: Name::new("test"),
            kinematics,
            gyration_radius: 0.064,
            mass_matrix: kinematics.mass_matrix(0.064).unwrap(),
            dead_band: 0.02,
            cutoff_hz: 2.0,
            conditioning: Conditioning::PLAIN,
            range: MassRange::new(1.0, 6.0).unwrap(),
            static_power: STATIC_W,
        },
        model,
        noise: Noise {
            density: (NOISE_W * NOISE_W * 0.005) as f32,
            model_std: 0.01,
            tail: 1.0,
            residual_std: 0.0,
        },
        columns: Columns::NONE,
        identifies_mass: true,
        ground_adapts: false,
    }
}

/// A sample as the sensors give it.
#[derive(Debug, Clone, Copy)]
struct Measured {
    time_us: u64,
    wheel_speed: Option<[f32; WHEELS]>,
    power: Option<f32>,
}

/// Standard normal enough: the sum of twelve uniform numbers, from SplitMix64.
struct Noisy(u64);

impl Noisy {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

/// 300 s of winding forward and back with 3 kg, and with 4.5 kg from 120 s on, with 0.1 W of noise
/// and jitter of up to 0.4 ms.
fn drive(model: &Model<f32>) -> Vec<Measured> {
    let truth: Coefficients<f64, WHEELS> = coefficients(*model).convert().unwrap();
    let mut noise = Noisy(3);
    (0..60_000_u64)
        .map(|i| {
            let time_us = SAMPLE_PERIOD_US * i + (noise.uniform() * 400.0) as u64;
            let t = time_us as f64 * 1e-6;
            let wheel = |amplitude: f64, rate: f64| {
                let slow = (0.2 * t).sin();
                (
                    amplitude * slow + (rate * t).sin(),
                    amplitude * 0.2 * (0.2 * t).cos() + rate * (rate * t).cos(),
                )
            };
            let ((left, left_rate), (right, right_rate)) = (wheel(4.0, 1.9), wheel(4.0, 2.7));
            let motion =
                Motion::new(&[left, right], &[left_rate, right_rate], &truth.robot.mass_matrix, 0.02);
            let power = truth.model.power(&motion, if t < 120.0 { 3.0 } else { 4.5 }).unwrap();
            let power = power + f64::from(STATIC_W) + NOISE_W * noise.normal();
            Measured { time_us, wheel_speed: Some([left as f32, right as f32]), power: Some(power as f32) }
        })
        .collect()
}

/// The same with what goes wrong: readings that did not come, alone and for a while, and gaps up to
/// beyond the buckets' ring.
fn disturbed(model: &Model<f32>) -> Vec<Measured> {
    let mut drive = drive(model);
    for (i, sample) in drive.iter_mut().enumerate() {
        let t = i / 200;
        if i % 97 == 13 || (40..42).contains(&t) || (150..163).contains(&t) {
            sample.power = None;
        }
        if i % 331 == 7 || (200..241).contains(&t) {
            sample.wheel_speed = None;
        }
    }
    // Not even tried.
    drive.retain(|sample| !(70_000_000..70_310_000).contains(&sample.time_us));
    drive
}

/// What both sides know after a sample.
struct Known {
    mass: MassEstimate<f64>,
    power: Option<f64>,
    changed: Option<usize>,
}

/// An estimate in double precision, and the energies up to it, J.
type Replayed = (Estimate<f64, WHEELS>, (f64, f64));

/// As `answers::estimate` replays a recorded log: rows that lack something are not there, steps are
/// differences of times, and the ring has room for 512 buckets.
fn replay(
    mut push: impl FnMut(&Sample<f64, WHEELS>, f64) -> Replayed,
    static_power: f64,
    samples: &[Measured],
) -> (Vec<Option<Known>>, (f64, f64)) {
    let (mut last, mut energy) = (None, (0.0, 0.0));
    let known = samples.iter().map(|sample| {
        let (speed, power) = (sample.wheel_speed?, sample.power?);
        let time = sample.time_us as f64 * 1e-6;
        let elapsed = time - last.unwrap_or(time);
        last = Some(time);
        let sample = Sample {
            wheel_speed: speed.map(f64::from),
            wheel_acceleration: None,
            power: f64::from(power) - static_power,
        };
        let (estimate, sums) = push(&sample, elapsed);
        energy = sums;
        Some(Known { mass: estimate.mass, power: estimate.power, changed: estimate.changed })
    });
    (known.collect(), energy)
}

/// What single precision may lose of a mass, kg, and of a power, W: five times the largest
/// difference found.
///
/// It could be more. Were all roundings of the sign that hurts, the filter at 2 Hz of 200 would
/// lose 5e-4 of the largest value (tests/tests/filter.rs): some 3 mW of 6 W. What is wrong by more
/// than rounding is seen: a window of 24 buckets instead of 25, or steps that are off by a sample.
const MASS_KG: f64 = 5e-4;
/// Where the ground adapts: three states are carried on from second to second for minutes, none is
/// summed anew.
const ADAPTED_KG: f64 = 3e-3;
/// Share of an interval's width. It goes by how many samples are within the noise: one on the edge
/// may be so in one precision only, and a bucket has 200.
const ONE_SAMPLE: f64 = 0.005;
const POWER_W: f64 = 1e-3;
/// Of an energy: the same loss, of a sum of one sign.
const ENERGY: f64 = 1e-5;

const TIMING: Timing = Timing {
    period_s: 0.005,
    bucket_s: 1.0,
    schedule: Schedule::Moving { window: 25 },
    detect_changes: true,
};

fn compare<M: Method<f64>>(
    model: Model<f32>,
    method: impl Fn(&Coefficients<f64, WHEELS>) -> M,
    samples: &[Measured],
) -> u32 {
    let coefficients = coefficients(model);
    let double = coefficients.convert().unwrap();
    let mut estimator = Estimator::<_, _, WHEELS, 512>::new(&double, method(&double), &TIMING).unwrap();
    let push = |sample: &_, elapsed| (estimator.push(sample, elapsed), estimator.energy());
    compare_with(&coefficients, push, samples, MASS_KG, 0.0)
}

fn compare_with(
    coefficients: &Coefficients<f32, WHEELS>,
    push: impl FnMut(&Sample<f64, WHEELS>, f64) -> Replayed,
    samples: &[Measured],
    most_kg: f64,
    edge: f64,
) -> u32 {
    let (replayed, energy) = replay(push, f64::from(coefficients.robot.static_power), samples);
    let mut board = Estimation::default();
    board.set_coefficients(Some(coefficients)).unwrap();
    let (mut worst_kg, mut worst_w, mut known) = (0.0_f64, 0.0_f64, 0);
    for (sample, replayed) in samples.iter().zip(&replayed) {
        let estimated = board.sample(sample.wheel_speed, sample.power, sample.time_us);
        assert_eq!(estimated.taken, replayed.is_some());
        let Some(replayed) = replayed else { continue };
        assert_eq!(estimated.changed, replayed.changed.is_some(), "{} µs", sample.time_us);
        match (estimated.mass, replayed.mass) {
            (MassEstimate::Known(mass), MassEstimate::Known(expected)) => {
                worst_kg = worst_kg.max((f64::from(mass.mass) - expected.mass).abs());
                let on_edge = edge * (expected.high - expected.low);
                for (end, expected) in [(mass.low, expected.low), (mass.high, expected.high)] {
                    let stray = (f64::from(end) - expected).abs();
                    worst_kg = worst_kg.max(stray - on_edge);
                }
                known += 1;
            }
            (MassEstimate::Beyond(mass), MassEstimate::Beyond(expected)) => {
                assert_eq!(mass.place, expected.place);
                worst_kg = worst_kg.max((f64::from(mass.best) - expected.best).abs());
            }
            (MassEstimate::Unknown(reason), MassEstimate::Unknown(expected)) => assert_eq!(reason, expected),
            (mass, expected) => panic!("{} µs: {mass:?} for {expected:?}", sample.time_us),
        }
        match (estimated.predicted_power, replayed.power) {
            (Some(power), Some(expected)) => worst_w = worst_w.max((f64::from(power) - expected).abs()),
            (power, expected) => assert_eq!(power.is_some(), expected.is_some()),
        }
    }
    let (measured, predicted) = board.energy().unwrap();
    assert!((f64::from(measured) / energy.0 - 1.0).abs() < ENERGY);
    assert!((f64::from(predicted) / energy.1 - 1.0).abs() < ENERGY);
    assert!(worst_kg < most_kg, "{worst_kg} kg");
    assert!(worst_w < POWER_W, "{worst_w} W");
    // Equality of nothing would be no equality; nor would two runs of the same precision.
    assert!(known > samples.len() / 3, "{known}");
    assert!(worst_kg > 1e-9);
    board.changes().count
}

fn window(coefficients: &Coefficients<f64, WHEELS>) -> Window<f64> {
    coefficients.window(0.005)
}

fn roots(coefficients: &Coefficients<f64, WHEELS>) -> RootMean<f64> {
    RootMean { range: coefficients.robot.range }
}

#[test]
fn equals_the_host_with_the_signed_model() {
    let samples = drive(&signed());
    assert_eq!(compare(signed(), window, &samples), 1);
}

#[test]
fn equals_the_host_with_eq18() {
    for gate in [Gate::Corrected, Gate::Published] {
        let model = Model::Eq18 { gate, beta: BETA };
        assert_eq!(compare(model, roots, &drive(&model)), 0);
    }
}

#[test]
fn equals_the_host_on_what_is_left_of_a_disturbed_drive() {
    compare(signed(), window, &disturbed(&signed()));
    let model = Model::Eq18 { gate: Gate::Corrected, beta: BETA };
    compare(model, roots, &disturbed(&model));
}

/// Every kind of effect that a board can have, four at a time, on a drive with gaps up to beyond
/// the buckets' ring.
#[test]
fn equals_the_host_with_effects() {
    let samples = disturbed(&signed());
    let sets: [&[(Cause<f32>, f32)]; 7] = [
        &[(Cause::Term(Term::GradeAhead), 0.002), (Cause::Heat(90.0), 0.3), (Cause::Delay, 0.0437)],
        &[
            (Cause::Term(Term::GradeAlong([1.0, 0.0])), 0.003),
            (Cause::Term(Term::GradeAlong([0.0, 1.0])), -0.002),
            (Cause::Term(Term::Sag(0.0)), 0.01),
            (Cause::Scale(Side::Left), 0.01),
        ],
        &[(Cause::Hot, 0.1), (Cause::Term(Term::Windage), 1e-4), (Cause::Term(Term::Stribeck(0.4)), 0.004)],
        &[(Cause::Term(Term::WarmUp(60.0)), 1e-3), (Cause::Term(Term::RollingFrom(130.0)), 5e-4)],
        &[
            (Cause::Term(Term::StepAt(50.0)), 0.05),
            (Cause::Term(Term::WithMotion(1.0)), 0.02),
            (Cause::Term(Term::Gain(0.0)), 0.01),
            (Cause::Term(Term::Constant), -0.01),
        ],
        &[(Cause::Term(Term::GearLoad), 0.2), (Cause::Term(Term::Return), 0.3), (Cause::Delay, -0.081)],
        &[
            (Cause::Term(Term::Offset), 1e-3),
            (Cause::Term(Term::Drag(1)), 2e-3),
            // Where the turn rate is at the dead band's edge, rounding decides whether they act: a
            // mW is 2 κ τ times their sum.
            (Cause::Term(Term::Scrub), 3e-4),
            (Cause::Term(Term::ScrubPerKg), 1e-4),
        ],
    ];
    for set in sets {
        let list: Vec<_> = set.iter().map(|&(cause, coefficient)| Column { cause, coefficient }).collect();
        let columns = Columns::new(&list, WHEELS).unwrap();
        let coefficients = Coefficients { columns, ..coefficients(signed()) };
        let double: Coefficients<f64, WHEELS> = coefficients.convert().unwrap();
        let mut estimator = Estimator::<_, _, WHEELS, 512>::new(&double, window(&double), &TIMING).unwrap();
        let mut live = Live::new(&double, TIMING.period_s).unwrap();
        let push = |sample: &_, elapsed| {
            (estimator.push_with(&mut live, sample, &Outside::UNKNOWN, elapsed), estimator.energy())
        };
        compare_with(&coefficients, push, &samples, MASS_KG, ONE_SAMPLE);
    }
}

/// Three states and their covariance, believed anew for minutes, across the same gaps.
#[test]
fn equals_the_host_on_ground_that_adapts() {
    let coefficients = Coefficients { ground_adapts: true, ..coefficients(signed()) };
    let double: Coefficients<f64, WHEELS> = coefficients.convert().unwrap();
    let mut adaptive = Adaptive::new(&double, &Ground::usual(), TIMING.period_s, TIMING.bucket_s).unwrap();
    let push = |sample: &_, elapsed| (adaptive.push(sample, elapsed), adaptive.energy());
    assert_eq!(compare_with(&coefficients, push, &disturbed(&signed()), ADAPTED_KG, 0.0), 0);
    let mut board = Estimation::default();
    board.set_coefficients(Some(&coefficients)).unwrap();
    assert_eq!(board.model(), 3);
}

/// An hour on the charger, in which somebody has taken the payload off: what was known before is
/// not shown, by any model.
#[test]
fn a_gap_of_an_hour_forgets_the_mass() {
    let plain = coefficients(signed());
    for ground_adapts in [false, true] {
        let mut board = Estimation::default();
        board.set_coefficients(Some(&Coefficients { ground_adapts, ..plain })).unwrap();
        let samples = &drive(&signed())[..20_000];
        let before = samples.iter().map(|s| board.sample(s.wheel_speed, s.power, s.time_us)).last().unwrap();
        assert!(before.mass.known().is_some());
        // The same 3 kg again: only what was seen since counts.
        let mut first = None;
        for (i, s) in samples.iter().enumerate() {
            let estimated = board.sample(s.wheel_speed, s.power, s.time_us + 3_700_000_000);
            assert!(estimated.taken);
            let Some(mass) = estimated.mass.known() else { continue };
            first = first.or(Some(i));
            assert!(mass.low <= 3.05 && mass.high >= 2.95, "{ground_adapts}: {mass:?}");
        }
        // Not before the filter has settled, and a bucket is full.
        let first = first.unwrap();
        assert!((200..6_000).contains(&first), "{ground_adapts}: {first}");
    }
}

#[test]
fn without_coefficients_nothing_is_estimated() {
    let mut board = Estimation::default();
    assert!(!board.has_coefficients());
    assert_eq!((board.model(), board.energy(), board.dead_band()), (NO_MODEL, None, 0.02));
    for sample in &drive(&signed())[..1000] {
        let estimated = board.sample(sample.wheel_speed, sample.power, sample.time_us);
        assert_eq!(estimated, Estimated::default());
        assert_eq!(mass_code(&estimated.mass), 1);
    }
}

/// Noticed at the end of a bucket, within 10 s, and dated to within a few.
#[test]
fn dates_a_change_of_payload() {
    let mut board = Estimation::default();
    board.set_coefficients(Some(&coefficients(signed()))).unwrap();
    let mut noticed = Vec::new();
    for sample in drive(&signed()) {
        if board.sample(sample.wheel_speed, sample.power, sample.time_us).changed {
            noticed.push(sample.time_us);
        }
    }
    assert!(matches!(noticed[..], [noticed] if (120_000_000..130_000_000).contains(&noticed)), "{noticed:?}");
    let Changes { count: 1, last_us: Some(since) } = board.changes() else { panic!("{:?}", board.changes()) };
    assert!((117_000_000..123_000_000).contains(&since), "{since}");
}

/// Sensors that stay silent: the mass is held for as long as its window, then it is nobody's.
#[test]
fn a_mass_outlives_its_samples_by_a_window_at_most() {
    let samples = drive(&signed());
    let mut board = Estimation::default();
    board.set_coefficients(Some(&coefficients(signed()))).unwrap();
    let mut last = Estimated::default();
    for sample in &samples[..8000] {
        last = board.sample(sample.wheel_speed, sample.power, sample.time_us);
    }
    let end = samples[7999].time_us;
    let held = board.sample(None, Some(5.0), end + 24_999_999);
    assert_eq!((held.mass, held.taken), (last.mass, false));
    assert!(held.mass.known().is_some() && held.predicted_power.is_none());
    let gone = board.sample(Some([1.0; 2]), None, end + 25_000_000);
    assert_eq!(gone, Estimated::default());
}

/// New coefficients start anew; what was counted goes on. Those that cannot run change nothing.
#[test]
fn coefficients_can_be_replaced() {
    let samples = drive(&signed());
    let mut board = Estimation::default();
    board.set_coefficients(Some(&coefficients(signed()))).unwrap();
    let run = |board: &mut Estimation| {
        samples[..8000].iter().map(|s| board.sample(s.wheel_speed, s.power, s.time_us)).last().unwrap()
    };
    run(&mut board);
    let (measured, predicted) = board.energy().unwrap();

    let mut impossible = coefficients(signed());
    impossible.robot.cutoff_hz = 150.0;
    assert!(board.set_coefficients(Some(&impossible)).is_err());
    assert_eq!((board.model(), board.energy()), (2, Some((measured, predicted))));

    let eq18 = Model::Eq18 { gate: Gate::Published, beta: BETA };
    board.set_coefficients(Some(&coefficients(eq18))).unwrap();
    assert_eq!((board.model(), board.energy()), (0, Some((measured, predicted))));
    assert!(board.sample(None, None, 0).mass.known().is_none());
    assert!(run(&mut board).mass.known().is_some());
    let both = board.energy().unwrap();
    assert!((both.0 / measured - 2.0).abs() < 1e-5 && both.1 > predicted);

    board.set_coefficients(None).unwrap();
    assert_eq!((board.has_coefficients(), board.energy()), (false, Some(both)));
}
