//! Laws of the effects: none without a coefficient, the model's own parameters where they say the
//! same, and what a calculation by hand gives.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

mod common;

use common::{burger, close, range, servo, wheel};
use model_core::effects::{Effect, Extended, GRAVITY, Layout, Scene, Term};
use model_core::kinematics::Kinematics;
use model_core::model::Model;
use model_core::motion::{Motion, Wheel};
use model_core::torque::{Drive, TorqueModel};
use proptest::prelude::*;

const DEAD_BAND: f64 = 0.02;

fn layout() -> Layout<f64, 2> {
    Layout::new(&Kinematics::differential(0.033, 0.16).unwrap())
}

fn scene() -> Scene<f64, 2> {
    Scene {
        mass: 3.0,
        time: 40.0,
        pitch: 0.05,
        heading: [0.6, 0.8],
        warmth: [30.0, 10.0],
        still: 0.0,
        driver: 50.0,
    }
}

fn power(torque: TorqueModel<f64>, effects: &[Effect<f64>], motion: &Motion<f64, 2>) -> f64 {
    let drive = Drive::Dissipative;
    let extended = Extended { torque, drive, layout: layout(), dead_band: DEAD_BAND, effects };
    extended.power(motion, &scene())
}

fn effect(term: Term<f64>, coefficient: f64) -> Effect<f64> {
    Effect { term, coefficient }
}

fn all_terms() -> [Term<f64>; 24] {
    [
        Term::GradeByPitch,
        Term::GradeAhead,
        Term::GradeAlong([1.0, 0.0]),
        Term::Winding,
        Term::Windage,
        Term::Stribeck(0.5),
        Term::Viscous,
        Term::WarmUp(60.0),
        Term::Rolling,
        Term::RollingFrom(30.0),
        Term::Offset,
        Term::Drag(1),
        Term::Scrub,
        Term::ScrubPerKg,
        Term::Sliding(0.5),
        Term::GearLoad,
        Term::GearShare,
        Term::Sag(0.0),
        Term::Return,
        Term::Gain(0.0),
        Term::Constant,
        Term::StepAt(30.0),
        Term::WithMotion(1.0),
        Term::Driver,
    ]
}

fn motion(speed: [f64; 2], acceleration: [f64; 2]) -> Motion<f64, 2> {
    let (_, matrix) = burger();
    Motion::new(&speed, &acceleration, &matrix, DEAD_BAND)
}

proptest! {
    /// Coefficients of 0 leave the model to the last bit.
    #[test]
    fn nothing_is_added_by_nothing(wheels in proptest::array::uniform2(wheel())) {
        let motion = Motion { wheels };
        let none = all_terms().map(|term| effect(term, 0.0));
        let model = Model::Signed { torque: servo(), drive: Drive::Dissipative };
        prop_assert_eq!(power(servo(), &none, &motion), model.power(&motion, 3.0).unwrap());
    }

    /// Viscous and rolling terms are parameters of the model: adding to one or to the other is the
    /// same.
    #[test]
    fn terms_that_the_model_has_are_the_models(wheels in proptest::array::uniform2(wheel()), size in 0.0..0.02_f64) {
        let motion = Motion { wheels };
        let base = servo();
        let pairs = [
            (Term::Viscous, TorqueModel { viscous: base.viscous + size, ..base }),
            (Term::Rolling, TorqueModel { rolling: base.rolling + size, ..base }),
            (Term::RollingFrom(39.9), TorqueModel { rolling: base.rolling + size, ..base }),
            (Term::WarmUp(1e12), TorqueModel { viscous: base.viscous + size, ..base }),
        ];
        for (term, other) in pairs {
            let (drawn, expected) = (power(base, &[effect(term, size)], &motion), power(other, &[], &motion));
            // A dozen operations on sums whose parts may cancel in the torque.
            prop_assert!(close(drawn, expected, expected.abs().max(1.0), 1e-9), "{:?} {} {}", term, drawn, expected);
        }
    }
}

/// A coefficient of each term that is large but plausible for this robot.
fn size(term: Term<f64>) -> f64 {
    match term {
        Term::GradeByPitch => 1.3,
        Term::GradeAhead | Term::GradeAlong(_) => 0.03,
        Term::Winding => 0.0039,
        Term::GearLoad => 2.0,
        Term::GearShare => 0.1,
        Term::Sag(0.0) => 0.05,
        Term::Return => 0.4,
        Term::Gain(0.0) => -0.1,
        Term::Constant | Term::StepAt(_) | Term::WithMotion(_) => 0.3,
        Term::Driver => 0.005,
        _ => 0.004,
    }
}

fn extended(effects: &[Effect<f64>]) -> Extended<'_, f64, 2> {
    Extended { torque: servo(), drive: Drive::Dissipative, layout: layout(), dead_band: DEAD_BAND, effects }
}

proptest! {
    /// What the estimator computes for an unknown mass is the power at every known one: exactly but
    /// for the gears' loss, whose square of the mass is a tangent at the mass in hand. One truth,
    /// two ways to it.
    #[test]
    fn the_polynomial_is_the_power_at_every_mass(
        wheels in proptest::array::uniform2(wheel()),
        in_hand in 1.0..6.0_f64,
        mass in 1.0..6.0_f64,
    ) {
        let motion = Motion { wheels };
        for term in all_terms() {
            let effects = [effect(term, size(term))];
            let extended = extended(&effects);
            let scene_of = |mass| Scene { mass, ..scene() };
            let answer = |at: f64| extended.response_and_power(&motion, &scene_of(in_hand), &range(), at - range().middle());
            let exact = |mass| extended.power(&motion, &scene_of(mass));
            let (response, answered) = answer(in_hand);
            prop_assert!(close(answered, exact(in_hand), answered.abs().max(1.0), 1e-9), "{:?} {}", term, answered);
            let (_, answered) = answer(mass);
            // What the motor gives the gear may turn between the two masses: the share of it keeps
            // the direction of the one in hand.
            let given = |wheel: &Wheel<f64>, mass| servo().torque(wheel, mass) - servo().rotor_inertia * wheel.acceleration;
            if term == Term::GearShare && motion.wheels.iter().any(|wheel| given(wheel, in_hand) * given(wheel, mass) < 0.0) {
                continue;
            }
            if term != Term::GearLoad {
                prop_assert!(close(answered, exact(mass), answered.abs().max(1.0), 1e-9), "{:?} {}", term, answered);
            } else if !response.may_clamp {
                // The tangent is short by c load² (m − m₀)² of torque, which the winding loss sees
                // as well: τ between the two.
                let mut bound = 0.0;
                for wheel in &motion.wheels {
                    let torque = servo();
                    let load = torque.passed(wheel, 1.0);
                    let short = size(term) * load * load * (mass - in_hand).powi(2);
                    let most = torque.torque(wheel, mass).abs() + size(term) * (load * mass).powi(2) + short;
                    bound += short * (wheel.speed.abs() + 2.0 * torque.winding_loss * most);
                }
                prop_assert!((answered - exact(mass)).abs() <= bound + 1e-9, "{} {}: {}", answered, exact(mass), bound);
            }
        }
    }

    /// What the supply's side adds is taken off again, all together.
    #[test]
    fn the_supply_is_inverted(wheels in proptest::array::uniform2(wheel()), sag in 0.0..0.1_f64, gain in -0.5..0.5_f64) {
        let motion = Motion { wheels };
        let pairs = [(Term::Sag(0.0), sag), (Term::Gain(0.0), gain), (Term::Constant, 0.7), (Term::Driver, 0.004)];
        let effects = pairs.map(|(term, coefficient)| effect(term, coefficient));
        let (with, without) = (extended(&effects), extended(&[]));
        let (measured, drawn) = (with.power(&motion, &scene()), without.power(&motion, &scene()));
        let inverted = with.drawn_of(measured, &scene());
        prop_assert!(close(inverted, drawn, drawn.max(1.0), 1e-9), "{} {}", inverted, drawn);
        prop_assert!(with.drawn_of(-1e6, &scene()).is_finite());
    }

    /// A sample may only count for the mass where no wheel brakes at any mass of the range.
    #[test]
    fn what_may_clamp_is_left_out(wheels in proptest::array::uniform2(wheel())) {
        let motion = Motion { wheels };
        let layout = layout();
        for slope in [-0.1, 0.1] {
            let effects = [effect(Term::GradeAhead, slope)];
            let (response, _) =
                extended(&effects).response_and_power(&motion, &scene(), &range(), 0.0);
            let brakes = [1.0, 2.3, 6.0].iter().any(|mass| {
                motion.wheels.iter().zip(layout.forward).any(|(wheel, forward)| {
                    let torque = servo().torque(wheel, *mass) + slope * mass * GRAVITY * forward;
                    torque * wheel.direction < -1e-9
                })
            });
            prop_assert!(response.may_clamp || !brakes);
        }
    }
}

/// Both wheels at 4 rad/s without acceleration; a model without winding loss, so that power is
/// torque times speed.
#[test]
fn each_term_is_what_a_calculation_by_hand_gives() {
    let torque = TorqueModel { winding_loss: 0.0, ..servo() };
    let cruise = motion([4.0, 4.0], [0.0, 0.0]);
    let alone = power(torque, &[], &cruise);
    // v = 0.033 m · 4 rad/s = 0.132 m/s with 3 kg.
    let climb = 3.0 * GRAVITY * 0.132;
    // What passes a gear at constant speed: rolling resistance.
    let one_wheel = 3.0 * torque.rolling;
    let cases = [
        (Term::GradeByPitch, 1.2, 1.2 * 0.05 * climb),
        (Term::GradeAhead, 0.1, 0.1 * climb),
        (Term::GradeAlong([1.0, 0.0]), 0.1, 0.06 * climb),
        (Term::GradeAlong([0.0, 1.0]), 0.1, 0.08 * climb),
        (Term::Windage, 1e-3, 2.0 * 1e-3 * 64.0),
        (Term::Stribeck(4.0), 0.1, 2.0 * 0.4 * (-1.0_f64).exp()),
        (Term::WarmUp(40.0), 1e-3, 2.0 * 1e-3 * 16.0 * (-1.0_f64).exp()),
        (Term::RollingFrom(40.1), 0.1, 0.0),
        // Small enough that no wheel is clamped.
        (Term::Offset, 0.001, 0.0),
        (Term::Drag(1), 0.1, 0.4),
        (Term::Scrub, 0.1, 0.0),
        (Term::GearLoad, 0.5, 2.0 * 0.5 * one_wheel * one_wheel * 4.0),
        // At constant speed all of the torque passes the gear.
        (Term::GearShare, 0.1, 0.1 * alone),
        (Term::Sag(0.0), 0.1, 0.1 * alone * alone),
        (Term::Gain(0.0), 0.1, 0.1 * alone),
        (Term::Constant, 0.1, 0.1),
        (Term::StepAt(40.0), 0.1, 0.1),
        (Term::StepAt(40.1), 0.1, 0.0),
        (Term::WithMotion(0.0), 0.1, 0.1),
        (Term::Driver, 0.01, 0.5),
    ];
    for (term, coefficient, expected) in cases {
        let drawn = power(torque, &[effect(term, coefficient)], &cruise) - alone;
        assert!((drawn - expected).abs() < 1e-12, "{term:?}: {drawn} {expected}");
    }
}

/// κ (1 + c ΔT) τ² with 30 K on the left and 10 K on the right: copper's 0.0039/K.
#[test]
fn a_warm_winding_loses_more() {
    let torque = servo();
    let cruise = motion([4.0, 4.0], [0.0, 0.0]);
    let square = torque.torque(&cruise.wheels[0], 3.0).powi(2);
    let added = power(torque, &[effect(Term::Winding, 0.0039)], &cruise) - power(torque, &[], &cruise);
    let expected = torque.winding_loss * 0.0039 * (30.0 + 10.0) * square;
    assert!((added - expected).abs() < 1e-12, "{added} {expected}");
}

/// Offsets act with opposite signs left and right: only a difference of speeds shows them. The
/// right wheel is the fast one in a left turn, and carries what `Offset` adds.
#[test]
fn sides_are_told_apart() {
    let layout = layout();
    assert_eq!(layout.side, [-1.0, 1.0]);
    let torque = TorqueModel { winding_loss: 0.0, ..servo() };
    let left_turn = motion([2.0, 5.0], [0.0, 0.0]);
    let alone = power(torque, &[], &left_turn);
    let added = |term, coefficient| power(torque, &[effect(term, coefficient)], &left_turn) - alone;
    // 0.003 N·m more at 5 rad/s, as much less at 2 rad/s.
    assert!((added(Term::Offset, 0.001) - 0.009).abs() < 1e-12);
    assert!((added(Term::Drag(0), 0.1) - 0.2).abs() < 1e-12);
    // The outermost wheels share the turn's torque: 0.001 N·m · (5 − 2) rad/s.
    assert!((added(Term::Scrub, 0.001) - 0.003).abs() < 1e-12);
    assert!((added(Term::ScrubPerKg, 0.001) - 0.009).abs() < 1e-12);
    // Of it, at a slip of 3 / 3.5, with a half slip of 8 / 7 and the dead band: 3 /
    // √(3² + 4² + 0.02²).
    let share = 3.0 / (25.0 + DEAD_BAND * DEAD_BAND).sqrt();
    assert!((added(Term::Sliding(8.0 / 7.0), 0.001) - share * 0.009).abs() < 1e-12);
    // Two of three kilograms are load: (2/3)² of it.
    let load: f64 = (3.0 - 1.0) / 3.0;
    assert!((added(Term::OffCentre(1.0), 0.001) - load * load * 0.009).abs() < 1e-12);
    assert_eq!(added(Term::OffCentre(3.0), 0.001), 0.0);
}

/// A wheel that brakes gives nothing back, unless a share of it returns.
#[test]
fn a_share_of_braking_power_returns() {
    let braking = motion([4.0, 4.0], [-60.0, -60.0]);
    let regenerative = Model::Signed { torque: servo(), drive: Drive::Regenerative };
    let back = regenerative.power(&braking, 3.0).unwrap();
    assert!(back < 0.0);
    assert_eq!(power(servo(), &[], &braking), 0.0);
    let half = power(servo(), &[effect(Term::Return, 0.5)], &braking);
    assert!((half - 0.5 * back).abs() < 1e-12, "{half} {back}");
}

/// At rest there is no motion for a torque to act on, but the supply's side goes on.
#[test]
fn a_robot_at_rest_feels_the_supply_only() {
    let rest = Motion { wheels: [Wheel::default(); 2] };
    for term in all_terms() {
        let drawn = power(servo(), &[effect(term, 0.1)], &rest);
        let expected = match term {
            Term::Constant | Term::StepAt(_) | Term::WithMotion(_) => 0.1,
            Term::Driver => 5.0,
            _ => 0.0,
        };
        assert!((drawn - expected).abs() < 1e-12, "{term:?}: {drawn}");
    }
}
