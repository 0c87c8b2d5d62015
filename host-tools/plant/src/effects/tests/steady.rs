//! Steady drives against the balance of torques and voltages.

use super::{G, settled, steady};

/// The servo as its balance of torques and voltages has it when nothing accelerates.
#[derive(Clone, Copy)]
struct Servo {
    ohm: f64,
    efficiency: f64,
    viscous: f64,
}

impl Servo {
    /// From the data sheet's figures (see `sets`): R = 11.1/1.3; K = 6.91711e-3; half of K · 0.05 A
    /// is viscous at 1543.006 rad/s, half Coulomb; η = 0.614097.
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

    /// Power, W, that turns a wheel at `speed` against `torque` after the gear and `air` at the
    /// rotor.
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

fn assert_near(value: f64, expected: f64, what: &str) {
    // The hand's six digits.
    assert!((value / expected - 1.0).abs() < 3e-5, "{what}: {value}, by hand {expected}");
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
    // The last second's hundred readings, each with what is left of the cold; so slow that the
    // speed loop keeps up.
    let cold = (1..=100).map(|k| {
        let cold = (-(19.0 + f64::from(k) / 100.0) / 200.0).exp();
        let servo = Servo { viscous: servo.viscous * (1.0 + 0.5 * cold), ..servo };
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
    // The wheel whose encoder reads 10 % more turns slower by that; now it is a curve, which costs
    // nothing more.
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

/// Gearing to 1 m/s² in a second: the leads' voltage, the reading and what the drives get fit
/// together at every sample.
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

/// In a curve the outer wheel carries more or less. Axle 160 mm, 3 kg, 30 mm to the left: 1.5 kg ±
/// 3·0.03/0.16.
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
