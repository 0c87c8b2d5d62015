//! Every register is shown, where and as the table says.

use model_core::charge::{Charge, Remaining};
use model_core::payload::{Beyond, Mass, MassEstimate, Place, Unknown};
use proptest::prelude::*;

use super::*;
use crate::control_table::{END, REGISTERS, UPLOAD_BYTES};
use crate::estimation::{Changes, Counted};
use crate::inertial::{ChipModel, InertialHealth};
use crate::items::ItemBytes;
use crate::measurement::{Snapshot, WheelSnapshot};
use crate::power_sensors::{self, Health};
use crate::record::Record;
use crate::reset::{ResetCause, ResetReport};
use crate::totals::Totals;
use crate::wheels::{ServoCounters, WheelHealth};

/// A state in which nothing is zero that can be something else.
fn state() -> State<'static> {
    let mut state = State::new(200, 25, Box::leak(Box::new([[0; _]; 20])));
    state.time_us = 0x0001_0203_0405_0607;
    for (i, rail) in (1_u8..).zip(&mut state.snapshot.rails) {
        let value = f32::from(i);
        let count = u32::from(i);
        *rail = RailSnapshot {
            power: Some(value),
            voltage: Some(10.0 * value),
            current: Some(100.0 * value),
            energy: 1000.0 * value,
            health: [Health::Stale, Health::Overflow, Health::Absent, Health::LostCalibration]
                [usize::from(i) - 1],
            counters: power_sensors::Counters {
                fresh: count,
                not_ready: 10 + count,
                clipped: 20 + count,
                no_answer: 30 + count,
                set_up_lost: 40 + count,
                implausible: 50 + count,
            },
            power_factor: 1.0,
        };
    }
    state.snapshot.wheels = [
        WheelSnapshot {
            health: WheelHealth::Alert,
            hardware_error: 0x20,
            speed: Some(1.5),
            acceleration: Some(-2.5),
            position: Some(-4096),
            odometer: Some(-70_000),
            velocity_code: -100,
            load_code: -250,
            misfit: 11,
        },
        WheelSnapshot { health: WheelHealth::Absent, hardware_error: 4, ..WheelSnapshot::UNKNOWN },
    ];
    let estimate = &mut state.snapshot.estimate;
    estimate.mass = MassEstimate::Known(Mass { mass: 3.0, low: 2.5, high: 3.5 });
    estimate.measured_power = Some(4.5);
    estimate.predicted_power = Some(5.5);
    estimate.measured_energy = Some(6.5);
    estimate.predicted_energy = Some(7.5);
    estimate.counted = Counted { measured: 71, predicted: 70 };
    estimate.changes = Changes { count: 2, last_us: Some(0x0807_0605_0403_0201) };
    state.snapshot.is_standing = true;
    state.snapshot.samples = 11;
    state.snapshot.servo_bus = ServoCounters { timeouts: 13, broken: 14, ..ServoCounters::NONE };
    let counters = &mut state.counters;
    counters.missed_deadlines = 12;
    (counters.bus_errors, counters.bus_recoveries) = (15, 16);
    (counters.link_packets, counters.link_broken, counters.store_writes) = (17, 18, 19);
    state.settings.load(Item::Robot, Ok(ItemBytes::new(&[0xA1, 0xA2]).unwrap()));
    state.upload.item = Item::Robot as u8;
    state.upload.length = 0x0102;
    state.upload.window = core::array::from_fn(|i| i as u8);
    state.supply_voltage = Some(11.4);
    state.inertial = InertialSnapshot {
        health: InertialHealth::Lost,
        model: Some(ChipModel::Icm20648),
        errors: 21,
        restarts: 22,
        bias: Some([0.1, 0.2, 0.3]),
        ..InertialSnapshot::UNKNOWN
    };
    state.snapshot.battery = BatterySnapshot {
        charge: Some(Charge { share: 0.6, std: 0.03 }),
        resistance: Some((0.25, 0.05)),
        remaining: Some(Remaining {
            energy: 10_800.0,
            energy_low: 7_200.0,
            energy_high: 14_400.0,
            time: Some(1800.0),
            load: 6.0,
        }),
    };
    state.pilot.beat(7, 1_000_000);
    state.pilot.command([Some(-5), Some(0), Some(0), Some(0), Some(0), Some(60)], 1_000_000);
    state.pilot.set_profile([Some(20), Some(30)]);
    state.reset = ResetReport { cause: ResetCause::Fault, address: 0x0804_1234, failures: 3 };
    state.snapshot.time_us = 9_000_000;
    let before =
        Totals { energy_mj: [0, 0, 0, 0x0001_0000_0000_0000], distance_cm: 51, driving_s: 52, on_s: 53 };
    state.ledger.load(Ok(Some(before)));
    state.ledger.written(Ok(()), 0);
    state.ledger.written(Err(Reason::Erase), 0);
    (state.counters.store_erases, state.is_store_prepared) = (54, true);
    (state.needs_signature, state.upload.signature) = (true, [0x55; 64]);
    state.settings.load_previous(ItemBytes::new(&[1, 2, 3, 4]).unwrap());
    (0..25).for_each(|time_us| _ = state.fifo.push(Record { time_us, ..Record::default() }));
    state.fifo.acknowledge(7);
    state
}

fn whole(state: &State<'_>) -> Vec<u8> {
    let mut bytes = vec![0x55; usize::from(END)];
    render(state, 0, &mut bytes);
    bytes
}

/// Collects what is shown.
#[derive(Default)]
struct Shown(Vec<(Register, Kind, usize)>);

impl Sink for Shown {
    fn put(&mut self, register: Register, kind: Kind, pieces: impl Iterator<Item = impl AsRef<[u8]>>) {
        self.0.push((register, kind, pieces.map(|piece| piece.as_ref().len()).sum()));
    }

    fn wants(&self, _: Register, _: Register) -> bool {
        true
    }
}

/// All of them once, of the type and with as many values as declared; only what is stored, and
/// records, may be fewer.
#[test]
fn every_register_is_shown_as_declared() {
    let mut shown = Shown::default();
    show(&state(), &mut shown);
    shown.0.sort_by_key(|(register, ..)| register.address);
    let registers: Vec<Register> = shown.0.iter().map(|(register, ..)| *register).collect();
    assert_eq!(registers, REGISTERS);
    for (register, kind, length) in shown.0 {
        assert_eq!(kind, register.kind, "{}", register.name);
        let may_be_shorter = [table::STORED_WINDOW, table::FIFO_WINDOW].contains(&register);
        assert!(length == register.size().into() || may_be_shorter, "{}: {length}", register.name);
    }
}

/// Addresses as docs/link.md gives them, not as the code does.
#[test]
fn values_stand_at_their_addresses() {
    let bytes = whole(&state());
    let half = |at: usize| u16::from_le_bytes(bytes[at..at + 2].try_into().unwrap());
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let float = |at: usize| f32::from_bits(word(at));
    let long = |at: usize| u64::from(word(at)) | u64::from(word(at + 4)) << 32;
    assert_eq!((half(0), word(2), bytes[6], bytes[7]), (0x5000, 1, 1, 200));
    let time = 0x0001_0203_0405_0607_u64;
    assert_eq!((word(10), word(14)), ((time / 1000) as u32, time as u32));
    assert_eq!((half(512), half(514), half(516)), (5, 200, 25));
    // No coefficients: model 255, state 1 "none stored".
    assert_eq!((bytes[518], bytes[519], word(520)), (255, 1, 0));
    assert_eq!(bytes[524..548], *b"TurtleBot3 Burger\0\0\0\0\0\0\0");
    assert_eq!(long(548), time);
    assert_eq!([float(556), float(568), float(572), float(584), float(600)], [1.0, 4.0, 10.0, 40.0, 400.0]);
    assert_eq!((float(604), float(616)), (1000.0, 4000.0));
    assert_eq!(bytes[620..624], [1, 2, 3, 4]);
    assert_eq!([word(624), word(628), word(632), word(636), word(640), word(644)], [1, 11, 21, 31, 41, 2]);
    assert_eq!(word(700), 44);
    assert_eq!([float(704), float(716)], [1.0, 1.0]);
    assert_eq!(bytes[720..724], [1, 3, 0x20, 4]);
    assert_eq!([float(724), float(732)], [1.5, -2.5]);
    assert!(float(728).is_nan() && float(736).is_nan());
    assert_eq!((word(740) as i32, word(744)), (-4096, 0));
    assert_eq!((bytes[748], bytes[749]), (0, 1));
    assert_eq!([float(752), float(756), float(760)], [3.0, 2.5, 3.5]);
    assert_eq!([float(764), float(768), float(772), float(776)], [4.5, 5.5, 6.5, 7.5]);
    assert_eq!((word(780), long(784)), (2, 0x0807_0605_0403_0201));
    let counters = [792, 796, 800, 804, 808, 812, 816, 820].map(word);
    assert_eq!(counters, [11, 12, 13, 14, 15, 16, 17, 18]);
    assert_eq!((word(824), word(828)), (0, 19));
    assert_eq!((bytes[832], bytes[833], half(834)), (3, 0, 0x0102));
    assert_eq!((bytes[836], bytes[837], half(838)), (0, 0, 2));
    assert!(bytes[840..1096].iter().zip(0..).all(|(byte, i)| *byte == i as u8));
    assert_eq!(bytes[1096..1100], [0xA1, 0xA2, 0, 0]);
    // Twenty of 25 records are left, and number 7 is the first that is not acknowledged.
    assert_eq!([word(1352), word(1356), word(1360)], [7, 5, 25]);
    assert_eq!((half(1364), half(1366)), (16, 60));
    assert_eq!((word(1368), word(1368 + 15 * 60)), (7, 22));
    // 60 % ± 3 %, 0.25 Ω ± 0.05 Ω, 3, 2 and 4 Wh, 1800 s at 6 W.
    assert_eq!([float(2380), float(2384)].map(f32::round), [60.0, 3.0]);
    assert_eq!([float(2388), float(2392)], [0.25, 0.05]);
    assert_eq!(
        [float(2396), float(2400), float(2404), float(2408), float(2412)],
        [3.0, 2.0, 4.0, 1800.0, 6.0]
    );
    assert_eq!((bytes[2416], bytes[2417], word(2420), word(2424)), (3, 2, 21, 22));
    assert_eq!([float(2428), float(2436)], [0.1, 0.3]);
    // 1000 and 4000 J since start; 9 s.
    assert_eq!((long(2440), long(2464)), (1_000_000, 0x0001_0000_0000_0000 + 4_000_000));
    assert_eq!([2472, 2476, 2480, 2484, 2488].map(word), [51, 52, 62, 1, 54]);
    assert_eq!((bytes[2492], bytes[2493], word(2496), bytes[2500]), (2, 1, 0x0403_0201, 3));
    assert_eq!((bytes[2501], bytes[2504], bytes[2567]), (1, 0x55, 0x55));
    assert_eq!([2568, 2572].map(word), [71, 70]);
    assert_eq!(bytes.len(), 2592);
    // Between registers.
    assert_eq!((bytes[8], bytes[24], bytes[500], bytes[750]), (0, 0, 0, 0));
    assert_eq!(UPLOAD_BYTES, 256);
}

/// Where the stock firmware has them: the node reads 10 … 181 as one block.
#[test]
fn the_node_finds_what_it_reads() {
    let bytes = whole(&state());
    let word = |at: usize| i32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let float = |at: usize| f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    // A wheel is absent: -1.
    assert_eq!((bytes[18], bytes[19], bytes[148], bytes[149]), (0xFF, 7, 0, 1));
    assert_eq!((word(42), word(46)), (1140, 6000));
    // 100 counts of 0.0239808 rad/s, the left wheel backwards: to the left, by 0.033 m over 0.160
    // m.
    assert!((float(68) - 2.398_08 * 0.033 / 0.160).abs() < 1e-5, "{}", float(68));
    assert_eq!([96, 100, 104, 108].map(float), [1.0, 0.0, 0.0, 0.0]);
    assert_eq!([120, 124, 128, 132, 136, 140].map(word), [-250, 0, -100, 0, -70_000, 0]);
    assert_eq!([150, 154, 158, 162, 166, 170, 174, 178].map(word), [-5, 0, 0, 0, 0, 60, 20, 30]);
    assert_eq!((bytes[2328], bytes[2329], bytes[2330], word(2332), word(2336)), (4, 1, 11, 0x0804_1234, 3));
}

/// What the sensor says stands where the node looks; its calibration is under way until it is done.
#[test]
fn the_node_gets_what_the_sensor_says() {
    let mut state = state();
    state.inertial = InertialSnapshot {
        rotation: Some([0.1, 0.2, 0.3]),
        acceleration: Some([1.0, 2.0, 9.8]),
        orientation: Some([0.5, -0.5, 0.5, -0.5]),
        ..state.inertial
    };
    let bytes = whole(&state);
    let float = |at: usize| f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    assert_eq!([60, 68, 72, 80, 84, 96, 108].map(float), [0.1, 0.3, 1.0, 9.8, 0.0, 0.5, -0.5]);
    assert_eq!(bytes[59], 0);
    super::super::write(&mut state, 59, &[1]).unwrap();
    assert_eq!(whole(&state)[59], 1);
    assert!(state.take_calibration() && !state.take_calibration());
    state.inertial.is_calibrating = true;
    assert_eq!(whole(&state)[59], 1);
    state.inertial.is_calibrating = false;
    assert_eq!(whole(&state)[59], 0);
}

/// Where nobody knows the charge the node sees what the stock firmware would tell it: 11.4 V are
/// half of 10.5 to 12.3 V.
#[test]
fn without_a_gauge_the_percentage_is_the_stock_one() {
    let mut state = state();
    state.snapshot.battery = BatterySnapshot::UNKNOWN;
    assert_eq!(whole(&state)[46..50], 5000_i32.to_le_bytes());
    state.supply_voltage = None;
    state.snapshot.rails[0].voltage = None;
    assert_eq!(whole(&state)[46..50], [0; 4]);
}

#[test]
fn what_is_unknown_is_no_number() {
    let bytes = whole(&State::new(200, 25, &mut []));
    for at in [
        556, 560, 564, 568, 572, 588, 724, 728, 732, 752, 756, 760, 764, 768, 2380, 2388, 2396, 2408, 2412,
        2428, 2436,
    ] {
        let value = f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        assert!(value.is_nan(), "{at}: {value}");
    }
    // No samples.
    assert_eq!(bytes[748], 1);
    // No item, so nothing stored of it.
    assert_eq!(bytes[838..840], [0, 0]);
}

/// Nobody knows where a silent servo is; what it said last is the best there is.
#[test]
fn a_silent_wheel_stays_where_it_was() {
    let mut state = State::new(200, 25, &mut []);
    let mut snapshot = Snapshot::UNKNOWN;
    snapshot.wheels[0].position = Some(7);
    state.show(&snapshot);
    state.show(&Snapshot { samples: 2, ..Snapshot::UNKNOWN });
    let mut bytes = [0; 8];
    render(&state, table::WHEEL_POSITION.address, &mut bytes);
    assert_eq!((bytes[0], bytes[4], state.snapshot.samples), (7, 0, 2));
}

#[test]
fn payload_states_have_codes() {
    let codes = [
        Unknown::NoSamples,
        Unknown::NoMotion,
        Unknown::TooWide,
        Unknown::NotFinite,
        Unknown::NotIdentifiable,
    ]
    .map(|unknown| mass_code(&MassEstimate::Unknown(unknown)));
    assert_eq!(codes, [1, 2, 3, 4, 7]);
    let mass = Mass { mass: 6.0, low: 6.0, high: 7.5 };
    let codes = [Place::Below, Place::Above]
        .map(|place| mass_code(&MassEstimate::Beyond(Beyond { place, mass, best: 7.0 })));
    assert_eq!(codes, [5, 6]);
}

proptest! {
    /// Whatever part is read, it is that part of the whole; beyond the table there are zeros.
    #[test]
    fn any_part_is_that_of_the_whole(address in 0..END + 10, length in 0..2400_usize) {
        let state = state();
        let mut bytes = vec![0x55; length];
        render(&state, address, &mut bytes);
        let expected = whole(&state).into_iter().chain(core::iter::repeat(0));
        prop_assert!(bytes.into_iter().eq(expected.skip(address.into()).take(length)));
    }
}
