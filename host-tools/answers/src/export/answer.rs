//! What `gmr export` asks of a fit, and what it is told.

use std::path::Path;

use logs::robot::Robot;
use model::coefficients::{CoefficientsFile, Taking};
use support::context::Context;
use support::error::{Error, Result};

use super::joints::{self, Language};
use super::{rmf, vda5050};

/// In whose words.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Target {
    /// Open-RMF: mass, friction, inertia, ambient and tool power, as YAML
    Rmf,
    /// VDA 5050: battery and load fields of a state
    Vda5050,
    /// Gazebo: friction and damping of a wheel's joint
    Sdf,
    /// MuJoCo: friction, damping and armature of a wheel's joint
    Mjcf,
}

/// What is asked for.
#[derive(Debug, Clone, Copy)]
pub struct Request<'a> {
    /// In whose words.
    pub target: Target,
    /// The robot.
    pub robot: &'a Robot,
    /// The coefficients.
    pub coeffs: &'a Path,
    /// Whether coefficients are taken that cannot be used.
    pub force: bool,
    /// Total mass, kg.
    pub mass_kg: f64,
    /// Speed for friction and reach, m/s.
    pub speed_m_s: f64,
    /// What the robot draws besides driving, W, where it is known.
    pub static_w: Option<f64>,
    /// Charge now, 0 to 1.
    pub charge: Option<f64>,
}

/// A fit in the words of another program.
#[derive(Debug, Clone)]
pub struct Answer {
    /// As that program reads it.
    pub text: String,
    /// Its figures as JSON.
    pub json: String,
}

/// A value from the least to the most that is allowed.
///
/// # Errors
/// Names the argument.
pub fn allowed(name: &str, value: f64, least: f64, most: f64) -> Result<f64> {
    if value >= least && value <= most {
        return Ok(value);
    }
    Err(Error::usage(format!("--{name} {value}; expected {least} to {most}")))
}

/// Says a fit in the words of another program.
///
/// # Errors
/// Coefficients that cannot be read or used, or that the program has no words for; what VDA 5050
/// needs and is not given.
pub fn export(context: &Context, request: &Request<'_>) -> Result<Answer> {
    let Request { target, robot, coeffs, force, mass_kg, speed_m_s, static_w, charge } = *request;
    let taking = Taking { not_usable: force.then_some(context), ..Taking::default() };
    let coefficients = CoefficientsFile::read_taking(coeffs, robot, taking)?.coefficients;
    let (text, json) = match target {
        Target::Rmf => {
            let export = rmf::export(robot, &coefficients, mass_kg, speed_m_s, static_w)?;
            (Some(export.yaml(robot)), pretty(&export))
        }
        Target::Sdf | Target::Mjcf => {
            let export = joints::export(robot, &coefficients, mass_kg)?;
            let language = if target == Target::Sdf { Language::Sdf } else { Language::Mjcf };
            (Some(export.text(language)), pretty(&export))
        }
        Target::Vda5050 => {
            let missing = |what: &str| Error::usage(format!("vda5050 needs {what}"));
            let charge = charge.ok_or_else(|| missing("--charge, 0 to 1"))?;
            let now = vda5050::Now {
                charge: allowed("charge", charge, 0.0, 1.0)?,
                mass_kg,
                static_w: static_w
                    .ok_or_else(|| missing("--static-power W, or static_power_w in robot.toml"))?,
                speed_m_s,
            };
            let pack = robot.battery().ok_or_else(|| missing("[battery] in robot.toml"))?;
            (None, pretty(&vda5050::state(robot, &coefficients, pack, &now)?))
        }
    };
    Ok(Answer { text: text.unwrap_or_else(|| json.clone()), json })
}

fn pretty(value: &impl serde::Serialize) -> String {
    // Numbers and strings only: there is nothing to refuse.
    serde_json::to_string_pretty(value).unwrap_or_default() + "\n"
}
