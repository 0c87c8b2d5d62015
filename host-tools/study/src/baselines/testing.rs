//! Data made by a baseline's own assumptions, for its test.

use logs::robot::Robot;
use logs::robot::chassis::Wheels;
use model_core::kinematics::{Kinematics, Twist};
use model_core::motion::Motion;

use super::{Card, Point, Readings};

/// Period of [`drive`]'s points, s.
pub(crate) const PERIOD_S: f64 = 0.05;

/// A robot for tests: the Burger.
pub(crate) fn burger() -> Robot {
    Robot::named("burger").expect("built in")
}

/// Numbers of NumPy and scikit-learn, by their name in `tests/reference/baselines/reference.json`.
pub(crate) fn reference(name: &str) -> serde_json::Value {
    let text = include_str!("../../../tests/reference/baselines/reference.json");
    let all: serde_json::Value = serde_json::from_str(text).expect("made by make.py");
    all[name].clone()
}

fn wave(i: usize, k: f64) -> f64 {
    (i as f64 * k).sin()
}

/// A drive of the Burger of so many points at 20 Hz. Speeds, turn rates and accelerations wander
/// independently, forwards and backwards, at 1 to 3 kg; every reading wanders, too. `power` gives
/// the power.
pub(crate) fn drive(count: usize, power: impl Fn(&Point) -> f64) -> Vec<Point> {
    let motion = |i: usize| {
        let speed = Twist { vx: 0.2 * wave(i, 0.11), vy: 0.0, omega: 2.0 * wave(i, 0.17) };
        let acceleration = Twist { vx: 0.5 * wave(i, 0.23), vy: 0.0, omega: 4.0 * wave(i, 0.31) };
        (speed, acceleration, wheels(speed, acceleration))
    };
    points(count, motion, power)
}

/// As [`drive`] for any robot: each wheel wanders independently, and every other second all turn
/// alike.
pub(crate) fn drive_on<const N: usize>(
    kinematics: &Kinematics<f64, N>,
    count: usize,
    power: impl Fn(&Point) -> f64,
) -> Vec<Point> {
    let matrix = kinematics.mass_matrix(0.06).expect("length");
    let motion = |i: usize| {
        let number = |wheel: usize| if (i / 20).is_multiple_of(2) { wheel as f64 } else { 0.0 };
        let speed = std::array::from_fn(|wheel| 6.0 * wave(i, 0.11 + 0.06 * number(wheel)));
        let acceleration = std::array::from_fn(|wheel| 12.0 * wave(i, 0.23 + 0.08 * number(wheel)));
        let motion: Motion<f64, N> = Motion::new(&speed, &acceleration, &matrix, 0.0);
        (kinematics.twist(&speed), kinematics.twist(&acceleration), Wheels::from(motion.wheels))
    };
    points(count, motion, power)
}

/// Points of such speeds and accelerations of the body, and wheels.
fn points(
    count: usize,
    motion: impl Fn(usize) -> (Twist<f64>, Twist<f64>, Wheels),
    power: impl Fn(&Point) -> f64,
) -> Vec<Point> {
    let point = |i: usize| {
        let (speed, acceleration, wheels) = motion(i);
        let mut point = Point {
            run: 0,
            time: PERIOD_S * i as f64,
            speed,
            acceleration,
            wheels,
            mass: 1.0 + (i % 3) as f64,
            power: 0.0,
            readings: Readings {
                command: Twist {
                    vx: speed.vx + 0.02 * wave(i, 0.41),
                    vy: speed.vy,
                    omega: speed.omega + 0.2 * wave(i, 0.43),
                },
                pitch: 0.1 * wave(i, 0.0131),
                slope_heading: std::f64::consts::PI * wave(i, 0.0171),
                vibration: [0.5, 0.6, 0.7].map(|k| wave(i, k)),
                rolling_friction: 0.03 + 0.01 * wave(i, 0.019),
                static_friction: 0.05 + 0.02 * wave(i, 0.023),
            },
        };
        point.power = power(&point);
        point
    };
    (0..count).map(point).collect()
}

/// The wheels of the Burger in such a motion of its body.
pub(crate) fn wheels(speed: Twist<f64>, acceleration: Twist<f64>) -> Wheels {
    let kinematics = Kinematics::<f64, 2>::differential(0.033, 0.16).expect("lengths");
    let matrix = kinematics.mass_matrix(0.06).expect("length");
    let turn = |twist: Twist<f64>| [-0.08, 0.08].map(|arm| (twist.vx + arm * twist.omega) / 0.033);
    let motion: Motion<f64, 2> = Motion::new(&turn(speed), &turn(acceleration), &matrix, 0.0);
    Wheels::from(motion.wheels)
}

/// A point of a robot that stands, without power.
pub(crate) fn still() -> Point {
    Point { readings: Readings::NONE, ..drive(1, |_| 0.0)[0] }
}

/// Fitted to these points, the baseline has these parameters, and predicts the points as exactly.
/// `within`: of the larger of a parameter and 1e-3.
pub(crate) fn recovers(card: &Card, points: &[Point], truth: &[f64], within: f64) {
    let mut model = card.make(&burger());
    model.fit(points).expect("its own data");
    let parameters = model.parameters();
    assert_eq!(parameters.len(), truth.len(), "{parameters:?}");
    for (parameter, truth) in parameters.iter().zip(truth) {
        let allowed = within * truth.abs().max(1e-3);
        assert!((parameter.value - truth).abs() <= allowed, "{parameter:?} {truth}");
    }
    let predicted = model.predict(points).expect("fitted");
    let peak = points.iter().map(|point| point.power.abs()).fold(0.0, f64::max);
    for (predicted, point) in predicted.iter().zip(points) {
        assert!((predicted - point.power).abs() <= 10.0 * within * peak, "{predicted} {}", point.power);
    }
}

/// One mass, one speed, no turns: the drive does not determine the constants of these baselines,
/// only the mean of the data, which they predict.
pub(crate) fn predict_one_speed(cards: &[&Card]) {
    let moving = drive(500, |_| 1.0).into_iter().find(|point| point.speed.vx > 0.1).unwrap();
    let at = |i: i32| Point { time: 0.05 * f64::from(i), power: 2.0 + 0.1 * f64::from(i % 3), ..moving };
    let one_speed: Vec<Point> = (0..200).map(at).collect();
    for card in cards {
        let mut model = card.make(&burger());
        model.fit(&one_speed).unwrap();
        let predicted = model.predict(&one_speed).unwrap();
        assert!(predicted.iter().all(|power| (power - 2.1).abs() < 0.01), "{}: {predicted:?}", card.name);
    }
}
