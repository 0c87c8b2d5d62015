//! Each effect against what physics says of it, worked out beside the plant.

use super::super::body::{Body, Loads, Wheel};
use super::super::{
    Kinematics, MAX_WHEELS, PayloadSchedule, PlantSet, Profile, ProfileKind, Record, Robot, Scenario,
    Sensors, simulate,
};
use super::{DICTIONARY, Effect};

const G: f64 = 9.80665;

fn effects(texts: &[&str]) -> Vec<Effect> {
    texts.iter().map(|text| Effect::parse(text).unwrap()).collect()
}

/// 3 kg on servos, without loop noise, at one twist for 20 s.
fn steady_scenario(twist: [f64; 3], texts: &[&str]) -> Scenario {
    let kind = ProfileKind::Constant;
    let mut scenario = Scenario::new(PlantSet::Servo, Kinematics::Differential, kind, 20.0, 1);
    let Robot { geometry, limits, .. } = scenario.robot;
    scenario.robot.loop_noise_rad_s = 0.0;
    scenario.profile = Profile::constant(&geometry, &limits, twist);
    scenario.payload = PayloadSchedule::constant(3.0);
    scenario.effects = effects(texts);
    scenario
}

fn steady(twist: [f64; 3], texts: &[&str]) -> Record {
    simulate(&steady_scenario(twist, texts)).unwrap()
}

/// Mean of the last second of a column.
fn settled(column: &[f64]) -> f64 {
    column[column.len() - 100..].iter().sum::<f64>() / 100.0
}

/// The servo as its balance of torques and voltages has it when nothing accelerates.
#[derive(Clone, Copy)]
struct Servo {
    ohm: f64,
    efficiency: f64,
    viscous: f64,
}

impl Servo {
    /// From the data sheet's figures (see `sets`): R = 11.1/1.3; K = 6.91711e-3; half of K · 0.05 A is viscous at
    /// 1543.006 rad/s, half Coulomb; η = 0.614097.
    const K: f64 = 6.917_09e-3;
    const RATIO: f64 = 258.5;
    const COULOMB: f64 = 0.5 * Self::K * 0.05;

    fn new() -> Self {
        Self { ohm: 11.1 / 1.3, efficiency: 0.614_097, viscous: Self::COULOMB / 1543.006 }
    }

    fn current(self, torque: f64, speed: f64, air: f64) -> f64 {
        let shaft = torque / (Self::RATIO * self.efficiency)
            + Self::COULOMB
            + self.viscous * Self::RATIO * speed
            + air;
        shaft / Self::K
    }

    /// Power, W, that turns a wheel at `speed` against `torque` behind the gear and `air` at the rotor.
    fn power(self, torque: f64, speed: f64, air: f64) -> f64 {
        let current = self.current(torque, speed, air);
        current * (self.ohm * current + Self::K * Self::RATIO * speed)
    }
}

/// Rolling resistance of one of two wheels that share 3 kg, N·m, for a coefficient.
fn rolling(coefficient: f64) -> f64 {
    coefficient * 1.5 * G * 0.033
}

const ROLLING: f64 = 0.032;

fn assert_near(found: f64, expected: f64, what: &str) {
    // The hand's six digits.
    assert!((found / expected - 1.0).abs() < 3e-5, "{what}: {found}, by hand {expected}");
}

/// Both wheels alike, at 0.15 m/s.
#[test]
fn straight_on_the_power_is_that_of_the_balance_of_torques() {
    let w = 0.15 / 0.033;
    let servo = Servo::new();
    let clean = 2.0 * servo.power(rolling(ROLLING), w, 0.0);
    let pull = |slope: f64| rolling(ROLLING) * slope.cos() + G * 3.0 * slope.sin() * 0.033 / 2.0;
    let hot = Servo { ohm: servo.ohm * (1.0 + 0.0039 * 40.0), ..servo };
    let thick = Servo { viscous: 1.5 * servo.viscous, ..servo };
    // The last second's hundred readings, each with what is left of the cold; so slow that the speed loop keeps up.
    let cold = (1..=100).map(|k| {
        let left = (-(19.0 + f64::from(k) / 100.0) / 200.0).exp();
        let servo = Servo { viscous: servo.viscous * (1.0 + 0.5 * left), ..servo };
        2.0 * servo.power(rolling(ROLLING), w, 0.0) / 100.0
    });
    let rubbing = Servo { efficiency: servo.efficiency / (1.0 + 2.0 * rolling(ROLLING)), ..servo };
    let slower = servo.power(rolling(ROLLING), w / 1.1, 0.0) + servo.power(rolling(ROLLING), w, 0.0);
    let offset = ROLLING * 3.0 * 0.03 / 0.16 * G * 0.033;
    // E I − R I² = P, by halves: I = (E − √(E² − 4 R P))/2R.
    let current = (12.0 - (144.0 - 4.0 * 1.5 * clean).sqrt()) / 3.0;
    let cases: [(&[&str], f64); 17] = [
        (&[], clean),
        (&["grade=0.05:along=travel"], 2.0 * servo.power(pull(0.05), w, 0.0)),
        (&["grade=-0.02"], 2.0 * servo.power(pull(-0.02), w, 0.0)),
        (&["grade=0.02:heading=3.141592653589793"], 2.0 * servo.power(pull(-0.02), w, 0.0)),
        (&["winding-temperature=40:heat=room:tau=1"], 2.0 * hot.power(rolling(ROLLING), w, 0.0)),
        (&["windage=0.0005"], 2.0 * servo.power(rolling(ROLLING), w, 5e-4 * w * w / 258.5)),
        (
            &["stribeck=0.1:width=5"],
            2.0 * servo.power(rolling(ROLLING) + 0.1 * (-w * w / 25.0).exp(), w, 0.0),
        ),
        (
            &["stribeck=0.1:width=5:exponent=1"],
            2.0 * servo.power(rolling(ROLLING) + 0.1 * (-w / 5.0).exp(), w, 0.0),
        ),
        (&["viscous-change=0.5"], 2.0 * thick.power(rolling(ROLLING), w, 0.0)),
        (&["lubricant-warm-up=0.5:tau=200"], cold.sum()),
        (&["rolling-resistance-change=0.02"], 2.0 * servo.power(rolling(ROLLING + 0.02), w, 0.0)),
        (&["surface-switch=0.02:at=10"], 2.0 * servo.power(rolling(ROLLING + 0.02), w, 0.0)),
        (
            &["wheel-drag=0.05:side=right"],
            servo.power(rolling(ROLLING), w, 0.0) + servo.power(rolling(ROLLING) + 0.05, w, 0.0),
        ),
        (&["gear-load-loss=2"], 2.0 * rubbing.power(rolling(ROLLING), w, 0.0)),
        (&["supply-sag=1.5"], 12.0 * current),
        (&["payload-mislabel=1.2"], 2.0 * servo.power(rolling(ROLLING) * 4.2 / 3.0, w, 0.0)),
        // Straight on, one wheel rolls harder by what the other saves; copper loses a little more.
        (
            &["payload-offset=-0.03"],
            servo.power(rolling(ROLLING) + offset, w, 0.0) + servo.power(rolling(ROLLING) - offset, w, 0.0),
        ),
    ];
    for (texts, by_hand) in cases {
        let record = steady([0.15, 0.0, 0.0], texts);
        assert_near(settled(&record.power_w), by_hand, &format!("{texts:?}"));
        assert_near(settled(&record.wheel_rad_s[1]), w, &format!("{texts:?}"));
        assert_eq!(record.mass_kg[0], 3.0);
    }
    // The wheel whose encoder reads 10 % more turns slower by that; now it is a curve, which costs nothing more.
    let record = steady([0.15, 0.0, 0.0], &["speed-scale=0.1:side=right"]);
    assert_near(settled(&record.power_w), slower, "speed-scale");
    assert_near(settled(&record.wheel_rad_s[1]), w, "speed-scale");
}

/// The winding's own loss P heats it by size · P / loss, and its hotter copper loses more.
#[test]
fn windings_heat_by_their_loss() {
    let w = 0.15 / 0.033;
    let record = steady([0.15, 0.0, 0.0], &["winding-temperature=60:loss=0.1:tau=1.5"]);
    let current = Servo::new().current(rolling(ROLLING), w, 0.0);
    let mut rise = 0.0;
    for _ in 0..100 {
        rise = 60.0 * current * current * (11.1 / 1.3) * (1.0 + 0.0039 * rise) / 0.1;
    }
    let hot = Servo { ohm: 11.1 / 1.3 * (1.0 + 0.0039 * rise), ..Servo::new() };
    // Twelve time constants leave nothing; the start's higher current is long forgotten.
    assert!(rise > 5.0 && (settled(&record.motor_temp_c[0]) - 25.0 - rise).abs() < 1e-4 * rise, "{rise}");
    assert_near(settled(&record.power_w), 2.0 * hot.power(rolling(ROLLING), w, 0.0), "hot winding");
}

/// Gearing to 1 m/s² in a second: the leads' voltage, the reading and what the drives get fit together at every sample.
#[test]
fn the_supply_sags_by_its_current() {
    let clean = steady([0.15, 0.0, 0.0], &[]);
    let sagged = steady([0.15, 0.0, 0.0], &["supply-sag=1.5"]);
    for k in 0..clean.time_s.len() {
        let current = sagged.power_w[k] / 12.0;
        assert!((sagged.bus_v[k] - (12.0 - 1.5 * current)).abs() < 1e-9);
        assert!((sagged.bus_v[k] * current - clean.power_w[k]).abs() < 1e-9);
    }
    assert!(clean.bus_v.iter().all(|&v| v == 12.0));
}

/// In a curve the outer wheel carries more or less. Axle 160 mm, 3 kg, 30 mm to the left: 1.5 kg ± 3·0.03/0.16.
#[test]
fn the_side_that_carries_more_rolls_harder() {
    let (left, right) = ((0.12 - 0.08 * 0.5) / 0.033, (0.12 + 0.08 * 0.5) / 0.033);
    let shift = ROLLING * 3.0 * 0.03 / 0.16 * G * 0.033;
    let servo = Servo::new();
    let by_hand =
        servo.power(rolling(ROLLING) + shift, left, 0.0) + servo.power(rolling(ROLLING) - shift, right, 0.0);
    for text in ["payload-offset=0.03", "payload-offset=0.03:inertia=yes"] {
        assert_near(settled(&steady([0.12, 0.0, 0.5], &[text]).power_w), by_hand, text);
    }
}

/// Turning on the spot against M = μ m g arm: every wheel's rim pushes with M / track.
#[test]
fn tyres_that_scrub_resist_turning_alone() {
    let w = 0.08 * 1.5 / 0.033;
    let scrub = 0.1 * 3.0 * G * 0.05 / 0.16 * 0.033;
    let by_hand = 2.0 * Servo::new().power(rolling(ROLLING) + scrub, w, 0.0);
    let turning = steady([0.0, 0.0, -1.5], &["turning-scrub=0.1:arm=0.05"]);
    assert_near(settled(&turning.power_w), by_hand, "scrub");
    assert_near(settled(&turning.wheel_rad_s[0]), w, "scrub");
    let straight = steady([0.15, 0.0, 0.0], &["turning-scrub=0.1"]);
    assert_near(settled(&straight.power_w), settled(&steady([0.15, 0.0, 0.0], &[]).power_w), "straight");
}

/// On a plane that rises by φ towards a direction, a robot at the bearing θ from it has its nose up by asin(sin φ cos θ).
#[test]
fn the_pitch_follows_the_heading() {
    let record = steady([0.0, 0.0, 1.0], &["grade=0.1:heading=0.5"]);
    let mut turned = 0.0;
    for ((left, right), pitch) in
        record.wheel_rad_s[0].iter().zip(&record.wheel_rad_s[1]).zip(&record.pitch_rad)
    {
        turned += (right - left) * 0.033 / 0.16 * 0.01;
        // Rectangles of 10 ms miss a hundredth of the ramp's rad/s at most.
        assert!((pitch - (0.1_f64.sin() * (turned - 0.5).cos()).asin()).abs() < 1.5e-3, "{pitch} {turned}");
    }
    assert!(turned > 15.0);
}

/// Nothing but gravity: from rest, over s metres down a slope, v² = 2 g s sin φ; the plane keeps the energy.
#[test]
fn gravity_gives_what_the_height_is_worth() {
    let mut robot = Robot::new(PlantSet::Servo, Kinematics::Differential);
    for Wheel { motor, rolling_resistance, .. } in &mut robot.wheels {
        (motor.torque_constant, motor.coulomb, motor.viscous, motor.rotor_inertia) = (0.0, 0.0, 0.0, 0.0);
        *rolling_resistance = 0.0;
    }
    let mut body = Body::new(robot.geometry, robot.gyration_radius_m, robot.wheels);
    let force = [-3.0 * G * 0.2_f64.sin(), 0.0, 0.0];
    body.meet(&robot.wheels, &Loads { force, ..Loads::default() });
    for _ in 0..4000 {
        body.step(&[0.0; MAX_WHEELS], 3.0, 0.25e-3);
    }
    // After 1 s: v = g sin φ, s = v/2.
    assert!((body.twist()[0] + G * 0.2_f64.sin()).abs() < 1e-9);
}

/// A coasting robot slows down by everything that rubs, never speeds up, and stops for good.
#[test]
fn friction_only_takes() {
    let robot = Robot::new(PlantSet::Gearmotor, Kinematics::Differential);
    let mut wheels = robot.wheels;
    for wheel in &mut wheels {
        wheel.motor.torque_constant = 0.0;
        wheel.motor.windage = 1e-8;
    }
    let loads = Loads { wheel_friction: [0.02, 0.03, 0.0, 0.0], turning_friction: 0.05, ..Loads::default() };
    for twist in [[0.5, 0.0, 0.0], [0.0, 0.0, 4.0], [-0.3, 0.0, 2.0]] {
        let mut body = Body::new(robot.geometry, robot.gyration_radius_m, robot.wheels);
        body.meet(&wheels, &loads);
        body.set_twist(twist);
        let energy = |body: &Body| {
            let [x, _, turn] = body.twist();
            let rotors: f64 = body.wheel_speeds()[..2].iter().map(|w| 0.5 * 2e-6 * (30.0 * w).powi(2)).sum();
            0.5 * 2.0 * (x * x + (0.06 * turn).powi(2)) + rotors
        };
        let mut last = energy(&body);
        for _ in 0..8000 {
            body.step(&[0.0; MAX_WHEELS], 2.0, 0.25e-3);
            let now = energy(&body);
            assert!(now <= last + 1e-12, "{now} after {last}");
            last = now;
        }
        assert!(last < 1e-15, "{last}");
    }
}

/// A mass m beside the axle's middle by y: pushed straight, a free robot turns as a rigid body does about its centre of
/// mass, at F y / (m k²), towards the mass.
#[test]
fn an_off_centre_mass_turns_a_pushed_robot() {
    let mut robot = Robot::new(PlantSet::Servo, Kinematics::Omni);
    for Wheel { motor, rolling_resistance, .. } in &mut robot.wheels {
        (motor.torque_constant, motor.coulomb, motor.viscous, motor.rotor_inertia) = (0.0, 0.0, 0.0, 0.0);
        *rolling_resistance = 0.0;
    }
    let mut body = Body::new(robot.geometry, robot.gyration_radius_m, robot.wheels);
    body.meet(&robot.wheels, &Loads { force: [0.5, 0.0, 0.0], offset_m: 0.02, ..Loads::default() });
    body.step(&[0.0; MAX_WHEELS], 3.0, 0.25e-3);
    let alpha = 0.5 * 0.02 / (3.0 * 0.06 * 0.06);
    let [ahead, aside, turn] = body.twist();
    assert!((turn / 0.25e-3 - alpha).abs() < 1e-9, "{turn}");
    assert!((ahead / 0.25e-3 - (0.5 / 3.0 + 0.02 * alpha)).abs() < 1e-9 && aside == 0.0);
}

/// A training drive of 3 kg with exact sensors, so that what effects add can be told to the last digit.
fn drive(plant: PlantSet, texts: &[&str]) -> Record {
    let kind = ProfileKind::Training;
    let mut scenario = Scenario::new(plant, Kinematics::Differential, kind, 40.0, 4);
    scenario.payload = PayloadSchedule::constant(3.0);
    scenario.effects = effects(texts);
    simulate(&scenario).unwrap()
}

/// Largest difference between two columns.
fn apart<'a>(a: impl IntoIterator<Item = &'a f64>, b: impl IntoIterator<Item = &'a f64>) -> f64 {
    a.into_iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn wrong_sensors_change_what_is_read_and_nothing_else() {
    let clean = drive(PlantSet::Servo, &[]);
    let gain = drive(PlantSet::Servo, &["sensor-gain=-0.1"]);
    let offset = drive(PlantSet::Servo, &["sensor-offset=0.05"]);
    let late = drive(PlantSet::Servo, &["sensor-delay=0.03"]);
    let early = drive(PlantSet::Servo, &["sensor-delay=-0.03"]);
    for wrong in [&gain, &offset, &late, &early] {
        assert_eq!(wrong.true_power_w, clean.true_power_w);
    }
    for k in 0..clean.time_s.len() {
        assert!((gain.power_w[k] - 0.9 * clean.power_w[k]).abs() < 1e-12);
        assert!((offset.power_w[k] - clean.power_w[k] - 0.05).abs() < 1e-12);
    }
    // 0.03 s are three samples.
    assert!(apart(&late.power_w[3..], &clean.power_w) < 1e-12 && late.wheel_rad_s == clean.wheel_rad_s);
    assert!(
        apart(&early.wheel_rad_s[0][3..], &clean.wheel_rad_s[0]) < 1e-12 && early.power_w == clean.power_w
    );
    assert!(late.power_w[..3] == [0.0; 3] && early.wheel_rad_s[0][..3] == [0.0; 3]);
}

/// What the sensor averages is delayed, wrong and offset as what it reads at once: within its step of 1.2 mW.
#[test]
fn the_averaging_sensor_is_wrong_by_as_much() {
    let run = |texts: &[&str]| {
        let mut scenario = steady_scenario([0.15, 0.0, 0.0], texts);
        scenario.sensors = Sensors { power_noise_w: 0.0, ..Sensors::servo(scenario.rate_hz) };
        scenario.static_power_w = 2.0;
        simulate(&scenario).unwrap().power_w
    };
    let (clean, wrong) = (run(&[]), run(&["sensor-gain=0.2", "sensor-offset=-0.5", "static-step=0.4:at=0"]));
    assert!(apart(&wrong, &clean.iter().map(|p| 1.2 * (p + 0.4) - 0.5).collect::<Vec<_>>()) < 2.5e-3);
}

#[test]
fn static_power_steps_with_time_or_motion() {
    let clean = drive(PlantSet::Servo, &[]);
    let added = |texts: &[&str]| -> Vec<f64> {
        let with = drive(PlantSet::Servo, texts);
        assert_eq!(with.wheel_rad_s, clean.wheel_rad_s);
        with.power_w.iter().zip(&clean.power_w).map(|(with, clean)| with - clean).collect()
    };
    for (k, added) in added(&["static-step=0.7:at=12"]).into_iter().enumerate() {
        // A reading is that of the step before it.
        assert!((added - if k > 1200 { 0.7 } else { 0.0 }).abs() < 1e-12, "{k}: {added}");
    }
    let drawn = added(&["static-step=0.7"]);
    let begin = drawn.iter().position(|&added| added > 0.35).unwrap();
    assert!((1000..3000).contains(&begin), "{begin}");
    let moving = added(&["static-step=-0.3:on=motion:hold=0"]);
    for (k, added) in moving.into_iter().enumerate() {
        let fastest = clean.wheel_rad_s.iter().map(|wheel| wheel[k].abs()).fold(0.0, f64::max);
        // Near the threshold of 0.02 rad/s a quarter of a millisecond decides.
        if !(0.01..0.03).contains(&fastest) {
            assert!((added - if fastest > 0.02 { -0.3 } else { 0.0 }).abs() < 1e-12, "{k}: {added}");
        }
    }
}

#[test]
fn the_computer_draws_by_its_load() {
    let (clean, with) = (drive(PlantSet::Servo, &[]), drive(PlantSet::Servo, &["compute-load=3"]));
    assert_eq!(clean.cpu_percent, with.cpu_percent);
    let mut steps = 0;
    for k in 1..clean.time_s.len() {
        if with.cpu_percent[k] == with.cpu_percent[k - 1] {
            let added = with.power_w[k] - clean.power_w[k];
            assert!((added - 3.0 * with.cpu_percent[k] / 100.0).abs() < 1e-12);
        } else {
            steps += 1;
        }
    }
    // Loads of 6 s on average: seven in 40 s, 2.6 more or less.
    assert!((1..16).contains(&steps), "{steps}");
    assert!(clean.cpu_percent.iter().all(|load| (5.0..=95.0).contains(load)));
}

#[test]
fn braking_power_returns_by_its_share() {
    let clean = drive(PlantSet::Gearmotor, &[]);
    let half = drive(PlantSet::Gearmotor, &["regeneration=0.5"]);
    let whole = drive(PlantSet::Gearmotor, &["regeneration=1"]);
    let mut returned = 0;
    for k in 0..clean.time_s.len() {
        assert!(whole.power_w[k] <= clean.power_w[k]);
        assert!(
            (clean.power_w[k] - half.power_w[k] - 0.5 * (clean.power_w[k] - whole.power_w[k])).abs() < 1e-12
        );
        returned += usize::from(whole.power_w[k] < -0.01);
    }
    assert!(returned > 10, "{returned}");
    let mut drives_return =
        Scenario::new(PlantSet::Gearmotor, Kinematics::Differential, ProfileKind::Training, 40.0, 4);
    drives_return.payload = PayloadSchedule::constant(3.0);
    drives_return.drive.regeneration = true;
    assert_eq!(simulate(&drives_return).unwrap().power_w, whole.power_w);
}

/// A robot with another mass than noted is that robot; only the log differs.
#[test]
fn a_mislabelled_payload_moves_as_what_it_is() {
    let wrong = drive(PlantSet::Servo, &["payload-mislabel=2"]);
    let mut heavy = Scenario::new(PlantSet::Servo, Kinematics::Differential, ProfileKind::Training, 40.0, 4);
    heavy.payload = PayloadSchedule::constant(5.0);
    let heavy = simulate(&heavy).unwrap();
    assert!(wrong.power_w == heavy.power_w && wrong.wheel_rad_s == heavy.wheel_rad_s);
    assert!(wrong.mass_kg.iter().all(|&mass| mass == 3.0));
}

/// Until it begins, an effect is not there.
#[test]
fn effects_begin_when_told() {
    let clean = drive(PlantSet::Gearmotor, &[]);
    for entry in DICTIONARY.iter().filter(|entry| entry.options.iter().any(|choice| choice.name == "at")) {
        let size = 0.3 * entry.range.1;
        let with = drive(PlantSet::Gearmotor, &[&format!("{}={size}:at=20", entry.id)]);
        assert_eq!(with.power_w[..2000], clean.power_w[..2000], "{}", entry.id);
        assert_eq!(with.wheel_rad_s[0][..2000], clean.wheel_rad_s[0][..2000], "{}", entry.id);
        assert_ne!(with.power_w[2000..], clean.power_w[2000..], "{}", entry.id);
    }
}

fn noisy(kinematics: Kinematics, effects: &[Effect], seed: u64) -> Record {
    let mut scenario = Scenario::new(PlantSet::Servo, kinematics, ProfileKind::Training, 20.0, seed);
    scenario.payload = PayloadSchedule::constant(3.0);
    scenario.sensors = Sensors::servo(scenario.rate_hz);
    scenario.effects = effects.to_vec();
    simulate(&scenario).unwrap()
}

/// Whatever an effect does it does by its size.
#[test]
fn an_effect_of_size_0_changes_not_a_byte() {
    for kinematics in [Kinematics::Differential, Kinematics::Skid, Kinematics::Omni, Kinematics::Mecanum] {
        let clean = noisy(kinematics, &[], 6);
        for entry in &DICTIONARY {
            assert!(noisy(kinematics, &[Effect::new(entry.id, 0.0).unwrap()], 6) == clean, "{}", entry.id);
        }
    }
}

/// All at once, in either order: the same run for the same seed.
#[test]
fn the_same_seed_gives_the_same_run() {
    let mut all: Vec<Effect> =
        DICTIONARY.iter().map(|entry| Effect::new(entry.id, 0.02 * entry.range.1).unwrap()).collect();
    let first = noisy(Kinematics::Differential, &all, 3);
    assert!(first == noisy(Kinematics::Differential, &all, 3));
    assert!(first != noisy(Kinematics::Differential, &all, 4));
    // Sums in another order differ by rounding; times that are drawn by place stay with those that have them.
    all.retain(|effect| effect.option("at").is_some() || effect.id() == "sensor-delay");
    let first = noisy(Kinematics::Differential, &all, 3);
    all.reverse();
    assert!(apart(&first.true_power_w, &noisy(Kinematics::Differential, &all, 3).true_power_w) < 1e-6);
}

#[test]
fn what_makes_no_sense_is_refused_by_name() {
    for (text, named) in [
        ("slope=1", "effect `slope`; allowed: grade, winding-temperature, windage"),
        ("grade", "allowed: ID=SIZE"),
        ("grade=", "effect grade=; allowed: -0.3 to 0.3 (slope angle, rad)"),
        ("grade=0.31", "effect grade=0.31; allowed: -0.3 to 0.3"),
        ("grade=nan", "allowed: -0.3 to 0.3"),
        ("stribeck=-0.1", "allowed: 0 to 0.5"),
        ("grade=0.1:side=left", "option `side`; allowed: along, heading, at"),
        ("wheel-drag=0.1:side=up", "side=up; allowed: left, right"),
        ("stribeck=0.1:width=0", "width=0; allowed: 0.05 to 20"),
        ("sensor-delay=0.1:at=3", "option `at`; allowed: none"),
    ] {
        let error = Effect::parse(text).unwrap_err();
        assert_eq!(error.exit_code(), 2, "{text}");
        assert!(error.to_string().contains(named), "{text}: {error}");
    }
    // What only the robot can tell.
    for (text, named) in [
        ("wheel-drag=0.1:wheel=3", "wheel=3; allowed: 1 to 2"),
        ("wheel-drag=0.1:wheel=1.5", "wheel=1.5; allowed: 1 to 2"),
        ("payload-offset=0.09", "a wheel would lift off"),
        ("payload-mislabel=-3", "the noted mass is 3 kg"),
        ("winding-temperature=-5", "cannot cool"),
    ] {
        let error = simulate(&steady_scenario([0.1, 0.0, 0.0], &[text])).unwrap_err();
        assert_eq!(error.exit_code(), 2, "{text}");
        assert!(error.to_string().contains(named), "{text}: {error}");
    }
    let mut smooth = steady_scenario([0.1, 0.0, 0.0], &["surface-switch=-0.02"]);
    smooth.robot.wheels[1].rolling_resistance = 0.01;
    assert!(simulate(&smooth).unwrap_err().to_string().contains("the robot's coefficient is 0.01"));
    let mut returns = steady_scenario([0.1, 0.0, 0.0], &["regeneration=1"]);
    returns.drive.regeneration = true;
    assert!(simulate(&returns).unwrap_err().to_string().contains("return all of it already"));
}
