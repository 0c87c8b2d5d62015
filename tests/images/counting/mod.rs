//! Counts the instructions of every `push` on one drive, for every model and method.

mod counter;
mod drive;
mod signature;

use core::hint::black_box;

use model_core::coefficients::{Coefficients, Name, Robot};
use model_core::conditioning::Conditioning;
use model_core::effects::Columns;
use model_core::eq18::Gate;
use model_core::estimator::{Estimator, Sample, Timing};
use model_core::kinematics::Kinematics;
use model_core::model::{MassRange, Model};
use model_core::payload::roots::RootMean;
use model_core::payload::schedule::Schedule;
use model_core::payload::{Method, Noise};
use model_core::torque::{Drive, TorqueModel};
use semihosting::println;

use counter::Counter;
use drive::{PERIOD_S, Profile, SAMPLES, SECONDS, WHEELS};

const WINDOW: usize = 25;

/// False where the counter does not count instructions.
pub(crate) fn run() -> bool {
    let Some(mut counter) = Counter::calibrated() else {
        println!("SysTick does not count instructions: run with -icount shift={}", counter::SHIFT);
        return false;
    };
    let Some(signed) = coefficients() else { return false };
    let corrected = eq18(&signed, Gate::Corrected);
    let published = eq18(&signed, Gate::Published);
    let range = signed.robot.range;
    let window = signed.window(PERIOD_S as f32);
    let roots = RootMean { range };
    measure::<_, 32>(&counter, "signed window", &signed, window);
    measure::<_, 60>(&counter, "signed window", &signed, window);
    measure::<_, 32>(&counter, "eq18 roots", &corrected, roots);
    measure::<_, 60>(&counter, "eq18 roots", &corrected, roots);
    measure::<_, 32>(&counter, "eq18 window", &corrected, window);
    measure::<_, 60>(&counter, "eq18 window", &corrected, window);
    measure::<_, 32>(&counter, "eq18-published roots", &published, roots);
    signature::count(&mut counter.syst)
}

/// One line of figures: of all samples, and of those that close a second.
#[inline(never)]
fn measure<M: Method<f32>, const B: usize>(
    counter: &Counter,
    name: &str,
    coefficients: &Coefficients<f32, WHEELS>,
    method: M,
) {
    let timing = Timing {
        period_s: PERIOD_S,
        bucket_s: 1.0,
        schedule: Schedule::Moving { window: WINDOW },
        detect_changes: true,
    };
    let estimator =
        Estimator::<f32, M, WHEELS, B>::new(black_box(coefficients), black_box(method), &black_box(timing));
    let Ok(mut estimator) = estimator else { return };
    let mut profile = Profile::new(coefficients.robot.mass_matrix);
    let mut all = [0; SAMPLES];
    let mut closing = [0; SECONDS];
    let mut closed = 0;
    let mut registers = Registers::default();
    for count in &mut all {
        let sample = black_box(profile.next());
        let elapsed = black_box(PERIOD_S as f32);
        *count = counter.count(|| push(&mut estimator, &sample, elapsed, &mut registers)).0;
        if registers.estimates as usize > closed
            && let Some(place) = closing.get_mut(closed)
        {
            *place = *count;
            closed += 1;
        }
    }
    all.sort_unstable();
    let closing = &mut closing[..closed];
    closing.sort_unstable();
    println!(
        "cost: {name}, {B} buckets: median {} p95 {} closing {} closing-worst {} worst {}",
        quantile(&all, 50),
        quantile(&all, 95),
        quantile(closing, 50),
        quantile(closing, 100),
        quantile(&all, 100),
    );
    // Whoever reads the figures sees that the estimator worked for them.
    let Registers { power, low, high, changes, .. } = registers;
    println!("    at the end {low:.4} … {high:.4} kg, {power:.4} W; {changes} changes noticed");
}

/// What the board keeps of an estimate.
#[derive(Default)]
struct Registers {
    power: f32,
    mass: f32,
    low: f32,
    high: f32,
    estimates: u32,
    changes: u32,
}

/// As a task of the firmware would do it: the estimator in memory, what came of the sample into
/// registers. The call counts too.
#[inline(never)]
fn push<M: Method<f32>, const B: usize>(
    estimator: &mut Estimator<f32, M, WHEELS, B>,
    sample: &Sample<f32, WHEELS>,
    elapsed: f32,
    registers: &mut Registers,
) {
    let estimate = estimator.push(sample, elapsed);
    registers.power = estimate.power.unwrap_or(f32::NAN);
    if estimate.closed {
        let mass = estimate.mass.known();
        registers.mass = mass.map_or(f32::NAN, |mass| mass.mass);
        registers.low = mass.map_or(f32::NAN, |mass| mass.low);
        registers.high = mass.map_or(f32::NAN, |mass| mass.high);
        registers.changes += u32::from(estimate.changed.is_some());
        registers.estimates += 1;
    }
}

/// The value that so many per cent of the sorted `counts` do not exceed.
fn quantile(counts: &[u16], percent: usize) -> u16 {
    let rank = (counts.len() * percent).div_ceil(100);
    counts.get(rank.saturating_sub(1)).copied().unwrap_or(0)
}

/// A small servo-driven robot, with noise of every kind that a fit finds.
fn coefficients() -> Option<Coefficients<f32, WHEELS>> {
    let kinematics = Kinematics::differential(0.033, 0.16).ok()?;
    let gyration_radius = 0.064;
    let torque = TorqueModel {
        coulomb: 0.03,
        rolling: 0.01,
        viscous: 0.01,
        rotor_inertia: 0.003,
        inertia_gain: 1.3,
        winding_loss: 3.0,
        scrub: 0.0,
        imbalance: 0.0,
        gear_loss: 0.0,
        bridge_drop: 0.0,
        wheel_friction_share: 0.0,
    };
    Some(Coefficients {
        robot: Robot {
            name: Name::new("burger"),
            kinematics,
            gyration_radius,
            mass_matrix: kinematics.mass_matrix(gyration_radius).ok()?,
            dead_band: 0.02,
            cutoff_hz: 2.0,
            conditioning: Conditioning::PLAIN,
            range: MassRange::new(1.0, 6.0)?,
            static_power: 0.0,
        },
        model: Model::Signed { torque, drive: Drive::Dissipative },
        noise: Noise { density: 5e-5, model_std: 2e-3, tail: 1.2, residual_std: 0.0 },
        columns: Columns::NONE,
        identifies_mass: true,
        ground_adapts: false,
    })
}

/// The same robot by Eq. 18.
fn eq18(signed: &Coefficients<f32, WHEELS>, gate: Gate) -> Coefficients<f32, WHEELS> {
    match signed.model {
        Model::Signed { torque, .. } => {
            let mut beta = torque.expand();
            // Gated products count twice where the gate is open.
            for j in [4, 5, 8, 9, 10, 11, 12, 13] {
                beta[j] *= 0.5;
            }
            beta[14] *= 0.25;
            Coefficients { model: Model::Eq18 { gate, beta }, ..*signed }
        }
        Model::Eq18 { .. } => *signed,
    }
}
