//! What `gmr predict` asks of a plan.

use std::path::Path;

use logs::robot::Robot;
use model::coefficients::CoefficientsFile;
use support::context::Context;
use support::error::{Error, Result};

use super::energy;
use super::load::Load;
use super::plan::Plan;
use super::reach::{Question, reach};
use super::report::Report;
use crate::export::rmf;

/// What is asked for.
#[derive(Debug, Clone, Copy)]
pub struct Request<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// The coefficients.
    pub coeffs: &'a Path,
    /// The plan.
    pub plan: &'a Path,
    /// What the robot carries, and draws besides driving.
    pub load: Load,
    /// Whether its battery has the energy.
    pub question: Option<Question>,
}

/// Predicts the energy of a plan.
///
/// # Errors
/// Coefficients or plan cannot be read, or the plan lasts too long; a filter that its samples
/// cannot have; a battery that is not described.
pub fn predict(context: &Context, request: &Request<'_>) -> Result<Report> {
    let Request { robot, coeffs, plan: plan_file, load, question } = *request;
    let pack = robot.battery();
    if question.is_some() && pack.is_none() {
        let message = format!(
            "robot {} has no [battery]; expected capacity_ah and cells in its robot.toml",
            robot.name()
        );
        return Err(Error::usage(message));
    }
    let file = CoefficientsFile::read(coeffs, robot)?;
    let plan = Plan::read(context, plan_file)?;
    let vehicle = rmf::vehicle(robot, &file.coefficients, load.mass_kg)?;
    let report = energy::predict(context, robot, &file, &plan, &load, &vehicle);
    let mut report = report.map_err(|error| error.in_file(plan_file))?;
    if let (Some(question), Some(pack)) = (&question, pack) {
        report.battery = Some(reach(&report.need(), pack, question)?);
    }
    Ok(report)
}
