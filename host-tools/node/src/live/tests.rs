//! Lost and late messages, other clocks, restarts: nothing is invented, and all comes back.

use model_core::effects::Columns;
use model_core::model::Model;
use model_core::payload::Noise;
use model_core::torque::{Drive, TorqueModel};

use super::*;
use crate::Motion;

const STEP_S: f64 = 0.05;
/// Total mass of the robot that is simulated here, kg.
const MASS_KG: f64 = 3.0;

/// A wheel's torque is (0.05 + 0.008 m) sgn w, and nothing else.
fn coefficients(robot: &Robot) -> FittedModel {
    let torque = TorqueModel { coulomb: 0.05, rolling: 0.008, inertia_gain: 1.0, ..TorqueModel::default() };
    FittedModel {
        robot: robot.chassis(2.0).unwrap(),
        model: Model::Signed { torque, drive: Drive::Dissipative },
        noise: Noise { density: 1e-6, model_std: 1e-4, tail: 1.0, residual_std: 0.0 },
        columns: Columns::NONE,
        identifies_mass: true,
    }
}

fn robot() -> Robot {
    Robot::parse(
        "name = \"r\"\nkinematics = \"differential\"\nwheel_radius_m = 0.033\ntrack_m = 0.16\nmass_no_load_kg = 1\nmass_full_load_kg = 6\n\
         static_power_w = 2\n[battery]\ncapacity_ah = 1.8\ncells = 3\n",
    )
    .unwrap()
}

/// Drives at steady speed: a robot of so many kilograms, as the model has it.
struct Driven<'a> {
    node: Node<'a>,
    now_s: f64,
    /// The sender of speeds, and how far its clock is off, s.
    sender: u8,
    offset_s: f64,
}

impl Driven<'_> {
    fn message(&self) -> WheelMessage {
        let names = ["wheel_left_joint", "wheel_right_joint"].map(str::to_owned).to_vec();
        WheelMessage {
            from: [self.sender; 16],
            stamp_s: Some(self.now_s + self.offset_s),
            motion: Motion::Joints(names, vec![5.0, 5.0]),
        }
    }

    /// For so long; what is cut off does not come.
    fn go(&mut self, seconds: f64, has_speeds: bool, has_power: bool) -> State {
        for _ in 0..(seconds / STEP_S).round() as u32 {
            self.now_s += STEP_S;
            if has_power {
                let power_w = 2.0 + 2.0 * 5.0 * (0.05 + 0.008 * MASS_KG);
                self.node.reading(self.now_s, Reading { power_w, voltage_v: 12.0 });
            }
            if has_speeds {
                let message = self.message();
                self.node.wheels(self.now_s, &message);
            }
        }
        self.node.state(self.now_s)
    }
}

fn with_drive(test: impl FnOnce(Driven<'_>)) {
    let robot = robot();
    let coefficients = coefficients(&robot);
    let node = Node::new(&robot, Some(&coefficients), None);
    test(Driven { node, now_s: 0.0, sender: 1, offset_s: 1e9 });
}

/// Payload 2 kg beyond the 1 kg of the robot, within its interval.
fn knows(state: &State) {
    assert_eq!(state.state, Health::Ok, "{state:?}");
    let payload = state.payload_kg.unwrap();
    assert!((payload - (MASS_KG - 1.0)).abs() < 0.05, "{state:?}");
    assert!(state.payload_low_kg.unwrap() <= payload && payload <= state.payload_high_kg.unwrap());
}

fn knows_no_payload(state: &State, health: Health, why: &str) {
    assert_eq!(state.state, health, "{state:?}");
    assert!(state.why.as_ref().unwrap().contains(why), "{state:?}");
    let numbers =
        [state.payload_kg, state.payload_low_kg, state.payload_high_kg, state.measured_w, state.predicted_w];
    assert_eq!(numbers, [None; 5], "{state:?}");
}

#[test]
fn the_payload_is_that_of_the_model_behind_a_window() {
    with_drive(|mut drive| {
        knows_no_payload(&drive.go(1.0, false, true), Health::NoSpeeds, "no wheel speeds have come");
        knows_no_payload(&drive.go(1.0, true, true), Health::Unknown, "rate");
        let state = drive.go(40.0, true, true);
        knows(&state);
        assert!((state.rate_hz.unwrap() - 20.0).abs() < 0.01 && state.faults.is_empty(), "{state:?}");
        // 2.74 W at 12 V; the charge of a battery that nobody told of is not known at once.
        assert!((state.current_a.unwrap() - 2.74 / 12.0).abs() < 1e-9);
    });
}

#[test]
fn speeds_that_stop_are_not_remembered_for_long() {
    with_drive(|mut drive| {
        knows(&drive.go(40.0, true, true));
        knows(&drive.go(0.9, false, true));
        let lost = drive.go(3.0, false, true);
        knows_no_payload(&lost, Health::NoSpeeds, "no wheel speeds for 3.9 s");
        // The battery does not need them.
        assert!(lost.current_a.is_some() && lost.voltage_v == Some(12.0));
        knows(&drive.go(30.0, true, true));
    });
}

#[test]
fn power_that_stops_is_not_remembered_for_long() {
    with_drive(|mut drive| {
        knows(&drive.go(40.0, true, true));
        let lost = drive.go(5.0, true, false);
        knows_no_payload(&lost, Health::NoPower, "no power for 5.0 s");
        let battery =
            [lost.power_w, lost.voltage_v, lost.current_a, lost.charge, lost.remaining_j, lost.remaining_s];
        assert_eq!(battery, [None; 6], "{lost:?}");
        assert!(lost.faults["speeds without power"] > 50, "{lost:?}");
        knows(&drive.go(30.0, true, true));
    });
}

#[test]
fn another_sender_waits_until_the_first_has_gone() {
    with_drive(|mut drive| {
        knows(&drive.go(40.0, true, true));
        // Restarted at once, with a clock that begins at 0: nothing until the first is known to be
        // lost.
        (drive.sender, drive.offset_s) = (2, -drive.now_s);
        let state = drive.go(0.5, true, true);
        assert!(state.faults["speeds from another sender"] == 10, "{state:?}");
        let state = drive.go(30.0, true, true);
        knows(&state);
        assert_eq!(state.faults["new sender of speeds"], 1, "{state:?}");
        assert!(!state.faults.contains_key("jumps of the speeds' clock"), "{state:?}");
    });
}

#[test]
fn a_clock_that_jumps_costs_one_step() {
    with_drive(|mut drive| {
        let before = drive.go(40.0, true, true);
        drive.offset_s += 3600.0;
        let after = drive.go(1.0, true, true);
        knows(&after);
        assert_eq!(after.faults["jumps of the speeds' clock"], 1);
        assert_eq!(after.samples, before.samples + 20);
        // Energy is counted by receipts then, not for an hour: 0.74 W for 1 s.
        let energy = after.energy_j.unwrap() - before.energy_j.unwrap();
        assert!((energy - 0.74).abs() < 0.08, "{energy}");
    });
}

#[test]
fn without_coefficients_there_is_a_battery() {
    let robot = robot();
    let node = Node::new(&robot, None, Some(Charge { share: 0.8, std: 0.05 }));
    let mut drive = Driven { node, now_s: 0.0, sender: 1, offset_s: 0.0 };
    let state = drive.go(60.0, true, true);
    knows_no_payload(&state, Health::Unknown, "coefficients");
    assert!(
        state.charge.unwrap() > 0.5 && state.remaining_j.unwrap() > 0.0 && state.remaining_s.unwrap() > 0.0
    );
    assert!(state.no_charge.is_none());
}
