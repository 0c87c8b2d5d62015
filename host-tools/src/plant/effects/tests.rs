//! Each effect against physics.

use super::super::{Kinematics, PlantSet, ProfileKind, Record, Scenario, Sensors, simulate};
use super::{DICTIONARY, Effect};

fn drive(kinematics: Kinematics, effects: &[Effect]) -> Record {
    let mut scenario = Scenario::new(PlantSet::Servo, kinematics, ProfileKind::Training, 20.0, 6);
    scenario.payload = super::super::PayloadSchedule::constant(3.0);
    scenario.sensors = Sensors::servo(scenario.rate_hz);
    scenario.effects = effects.to_vec();
    simulate(&scenario).unwrap()
}

/// Whatever an effect does it does by its size.
#[test]
fn an_effect_of_size_0_changes_not_a_byte() {
    for kinematics in [Kinematics::Differential, Kinematics::Skid, Kinematics::Omni, Kinematics::Mecanum] {
        let clean = drive(kinematics, &[]);
        for entry in &DICTIONARY {
            assert!(drive(kinematics, &[Effect::new(entry.id, 0.0).unwrap()]) == clean, "{}", entry.id);
        }
    }
}
