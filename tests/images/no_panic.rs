//! Everything that the board calls of model-core, and the link, in an image that links only without
//! panics: see panic_probe.
//!
//! Never run; building it in release is the test. It says nothing of debug builds, which check for
//! overflow.
//!
//! The filter is designed in double precision, so the image also shows whether the compiler knows
//! that the board's core has none: it then calls __aeabi_dmul.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod panic_probe;

use core::hint::black_box;

use firmware::control_table::Item;
use firmware::items::ItemBytes;
use firmware::link::{Device, LONGEST_ANSWER, State};
use firmware::record::Record;
use firmware::totals::Totals;
use model_core::coefficients::{Coefficients, Name};
use model_core::effects::live::{Live, Outside};
use model_core::estimator::{Estimator, Sample, Timing};
use model_core::payload::Method;
use model_core::payload::roots::RootMean;
use model_core::payload::schedule::Schedule;

const WHEELS: usize = 2;
const BUCKETS: usize = 60;

/// Anything at all: [`black_box`] keeps the compiler from knowing more.
fn timing() -> Timing {
    black_box(Timing {
        period_s: 0.005,
        bucket_s: 1.0,
        schedule: Schedule::Moving { window: 25 },
        detect_changes: true,
    })
}

fn estimate<M: Method<f32>>(coefficients: &Coefficients<f32, WHEELS>, method: M) {
    let estimator = Estimator::<f32, M, WHEELS, BUCKETS>::new(coefficients, method, &timing());
    let Ok(mut estimator) = estimator else { return };
    let Ok(mut live) = Live::new(coefficients, timing().period_s) else { return };
    loop {
        let sample = Sample {
            wheel_speed: [black_box(0.0); WHEELS],
            wheel_acceleration: black_box(None),
            power: black_box(0.0),
        };
        black_box(estimator.push(&sample, black_box(0.005)));
        live.pass(black_box(0.0));
        black_box(estimator.push_with(&mut live, &sample, &black_box(Outside::UNKNOWN), black_box(0.005)));
        black_box(estimator.over_latest(black_box(10)));
        black_box(estimator.energy());
        if black_box(false) {
            estimator.payload_changed();
        }
        if black_box(true) {
            return;
        }
    }
}

/// Any bytes from the host, any items from the flash.
fn serve() {
    let mut records = [[0; _]; 64];
    let (mut device, mut state) = (Device::new(), State::new(black_box(200), 25, &mut records));
    let mut answer = [0; LONGEST_ANSWER];
    loop {
        state.fifo.push(Record { time_us: black_box(0), ..Record::default() });
        let received = black_box([0; 64]);
        device.feed(black_box(&received));
        while let Some(length) = device.answer(&mut state, &mut answer) {
            black_box(answer.get(..length));
        }
        if let Some((item, bytes)) = state.take_pending() {
            black_box(bytes.as_slice());
            state.stored(item, black_box(Ok(())));
        }
        if let Some(totals) = state.due_totals() {
            state.ledger.load(Ok(Some(Totals::decode(black_box(&totals.encode())))));
            state.ledger.written(black_box(Ok(())), black_box(0));
        }
        if let Some(bytes) = ItemBytes::new(black_box(&received)) {
            state.load_previous(bytes);
            state.load(black_box(Item::Robot), Ok(bytes));
        }
        if black_box(true) {
            return;
        }
    }
}

fn everything() {
    serve();
    let image = [0; 256];
    let Ok(coefficients) = Coefficients::<f32, WHEELS>::decode(black_box(&image)) else { return };
    let range = coefficients.robot.range;
    estimate(&coefficients, coefficients.window(black_box(0.005)));
    estimate(&coefficients, RootMean { range });
    black_box(Name::new(black_box("burger")).as_str());
    black_box(coefficients.encode());
}

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    loop {
        everything();
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    everything();
}
