//! Each effect against what physics says of it, worked out beside the plant.

mod dictionary;
mod mechanics;
mod power;
mod steady;

use super::super::{
    Kinematics, PayloadSchedule, PlantSet, Profile, ProfileKind, Record, Robot, Scenario, simulate,
};
use super::Effect;

/// Standard gravity, m/s².
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

/// A training drive of 3 kg with exact sensors, so that what effects add is exact to the last
/// digit.
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
