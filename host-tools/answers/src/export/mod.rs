//! A fit in the words of other programs: Open-RMF's vehicle parameters, VDA 5050's battery and
//! load, joints of Gazebo and MuJoCo; with what they cannot express said.

mod answer;
pub mod joints;
pub mod rmf;
pub mod vda5050;

use logs::robot::Robot;
use logs::with_core;
use model::coefficients::FittedModel;
use model_core::coefficients::Coefficients;
use model_core::effects::live::{Additions as _, Live};
use model_core::estimator::Conditioned;
use model_core::model::Model;
use model_core::motion::Motion;
use support::error::{Error, Result};

pub use self::answer::{Answer, Request, Target, allowed, export};

/// Share of the robot's greatest speed that is taken for cruising by default, and that speed where
/// robot.toml has none, m/s.
const CRUISE_SHARE: f64 = 0.8;
const CRUISE_M_S: f64 = 0.2;

/// What of the model another program has no word for.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Lost {
    /// Which part.
    pub what: &'static str,
    /// What comes of leaving it out.
    pub so: String,
}

/// The speed for which formulas with one friction are made, m/s.
pub fn cruise_m_s(robot: &Robot) -> f64 {
    robot.limits().speed_m_s.map_or(CRUISE_M_S, |most| CRUISE_SHARE * most)
}

/// What driving straight at an even speed takes, W.
///
/// # Errors
/// The model gives no power there.
pub fn straight_w(robot: &Robot, coefficients: &FittedModel, mass_kg: f64, speed_m_s: f64) -> Result<f64> {
    let wheels = robot.wheel_speeds_of_motion();
    let speed = |wheel: usize| wheels[(wheel, 0)] * speed_m_s;
    let watts = with_core!(&coefficients.robot, core => even_w(&coefficients.of(core), speed, mass_kg));
    let none = || Error::failed(format!("the model gives no power at {speed_m_s} m/s and {mass_kg} kg"));
    watts.ok_or_else(none)
}

/// What turning the wheels at even speeds, rad/s, takes, W.
fn even_w<const N: usize>(
    coefficients: &Coefficients<f64, N>,
    speed: impl Fn(usize) -> f64,
    mass_kg: f64,
) -> Option<f64> {
    let speeds = std::array::from_fn(speed);
    let core = &coefficients.robot;
    let motion = Motion::new(&speeds, &[0.0; N], &core.mass_matrix, core.dead_band);
    match &coefficients.model {
        model if coefficients.columns.is_empty() => model.power(&motion, mass_kg),
        model => {
            let now = Conditioned { motion, power: 0.0, settled: true };
            let live = Live::new(coefficients, 0.05).ok();
            let answer =
                live.map(|live| live.respond(model, &now, &core.range, mass_kg - core.range.middle()));
            answer.map(|answer| answer.power).filter(|power| power.is_finite())
        }
    }
}

/// What every program loses: how drives turn torque into power.
fn drives_lost(coefficients: &FittedModel) -> Vec<Lost> {
    let Model::Signed { torque, .. } = &coefficients.model else { return Vec::new() };
    let lost = |what, so: String| Lost { what, so };
    let mut all = vec![
        lost(
            "winding_loss",
            format!("{:.4} W/(N·m)² of torque squared: power is not torque times speed", torque.winding_loss),
        ),
        lost(
            "braking",
            "drives that give no power back: braking is not free of charge, nor does it charge".to_owned(),
        ),
    ];
    let delay = coefficients.robot.conditioning().delay;
    if delay != 0.0 {
        all.push(lost("power_delay_s", format!("power {delay:.3} s behind the speeds")));
    }
    if coefficients.robot.scrubs() {
        all.push(lost(
            "scrub",
            format!("{:.4} N·m/kg that turning drags, built up over the way rolled", torque.scrub),
        ));
    }
    if torque.imbalance != 0.0 {
        all.push(lost("imbalance", format!("{:.4} N·m between the sides", torque.imbalance)));
    }
    if torque.gear_loss != 0.0 {
        let whose = if torque.wheel_friction_share > 0.0 { "friction included" } else { "friction apart" };
        let so = format!("{:.3} of what passes the gear, {whose}, either way", torque.gear_loss);
        all.push(lost("gear_loss", so));
    }
    if torque.bridge_drop != 0.0 {
        all.push(lost(
            "bridge_drop",
            format!("{:.3} W/(N·m) of torque, whichever way it acts", torque.bridge_drop),
        ));
    }
    if !coefficients.columns.is_empty() {
        all.push(lost("effects", "what gmr gap added".to_owned()));
    }
    all
}
