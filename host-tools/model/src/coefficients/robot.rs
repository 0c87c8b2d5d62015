//! The robot that coefficients were fitted for, and what makes another of it.

use logs::robot::Robot;
use logs::robot::chassis::Chassis;
use logs::with_wheels;
use model_core::coefficients::{Name, Robot as CoreRobot};
use model_core::kinematics::Kinematics;
use model_core::model::MassRange;

use super::document::RobotSection;
use super::error::{Difference, InvalidCoefficients};

/// Numbers of two files that differ by no more than this share are one number, written with other
/// digits.
const SAME: f64 = 1e-6;

/// Refuses coefficients that were fitted for a different robot than `now`, whose file is `robot`.
/// Static power may differ: what was fitted to had its own taken off. Drives say whether braking
/// power returns, where the model has them (`drives`).
///
/// # Errors
/// The first difference.
pub(super) fn check(
    fitted: &Chassis,
    regenerated: bool,
    now: &Chassis,
    robot: &Robot,
    drives: bool,
) -> Result<(), Difference> {
    let body =
        |what| Difference::Body { what, robot: robot.name().to_owned(), fitted: fitted.name().to_owned() };
    let setting = |key, now: &dyn ToString, fitted: &dyn ToString| Difference::Setting {
        key,
        name: robot.name().to_owned(),
        now: now.to_string(),
        fitted: fitted.to_string(),
    };
    let close = |a: f64, b: f64| (a - b).abs() <= SAME * a.abs().max(b.abs());
    let (rows, rows_now) = (fitted.rows().concat(), now.rows().concat());
    if fitted.skids() != now.skids() {
        Err(body("the kind of steering"))
    } else if fitted.name() != now.name() {
        Err(body("the name"))
    } else if !rows.iter().zip(&rows_now).all(|(a, b)| close(*a, *b)) {
        Err(body("the wheels' geometry"))
    } else if !close(fitted.gyration_radius(), now.gyration_radius()) {
        Err(body("the gyration radius"))
    } else if !close(fitted.range().no_load(), now.range().no_load())
        || !close(fitted.range().full_load(), now.range().full_load())
    {
        Err(body("the masses"))
    } else if !close(fitted.dead_band(), now.dead_band()) {
        Err(setting("speed_dead_band_rad_s", &now.dead_band(), &fitted.dead_band()))
    } else if drives && regenerated != robot.regeneration() {
        Err(setting("regeneration", &robot.regeneration(), &regenerated))
    } else {
        Ok(())
    }
}

/// What a file says of a robot.
pub(super) fn section(robot: &Chassis, fitted_static_w: f64, regeneration: bool) -> RobotSection {
    let conditioning = robot.conditioning();
    RobotSection {
        name: robot.name().to_owned(),
        kinematics: robot.rows().iter().map(|row| row.to_vec()).collect(),
        gyration_radius_m: robot.gyration_radius(),
        mass_no_load_kg: robot.range().no_load(),
        mass_full_load_kg: robot.range().full_load(),
        speed_dead_band_rad_s: robot.dead_band(),
        filter_cutoff_hz: robot.cutoff_hz(),
        static_power_w: fitted_static_w,
        regeneration,
        scrubs: robot.skids(),
        power_delay_s: conditioning.delay,
        half_slip: conditioning.slip.half_slip,
        slip_relaxation_rad: conditioning.slip.relaxation,
        slip_rest_rad_s: conditioning.slip.rest,
        true_slip_s_rad: conditioning.true_slip,
    }
}

/// The robot that a file's section says.
///
/// # Errors
/// It is none, or has another number of wheels than the robot has now.
pub(super) fn of_section(
    section: &RobotSection,
    robot: &Robot,
) -> support::error::Result<Result<Chassis, InvalidCoefficients>> {
    fn of<const N: usize>(
        section: &RobotSection,
    ) -> support::error::Result<Result<Chassis, InvalidCoefficients>> {
        Ok(core::<N>(section).map(|core| Chassis::new(&core)))
    }
    with_wheels!(robot, of(section))
}

fn core<const N: usize>(section: &RobotSection) -> Result<CoreRobot<f64, N>, InvalidCoefficients> {
    let wrong = |message: &str| InvalidCoefficients::Robot(message.to_owned());
    let rows = section.kinematics.iter().map(|row| <[f64; N]>::try_from(row.as_slice()));
    let rows: Vec<[f64; N]> = rows.collect::<Result<_, _>>().map_err(|_| {
        let wheels = section.kinematics.first().map_or(0, Vec::len);
        InvalidCoefficients::OtherRobot(Difference::Wheels { wheels, expected: N })
    })?;
    let rows: [[f64; N]; 3] = rows.try_into().map_err(|_| wrong("kinematics: expected three rows"))?;
    let kinematics = Kinematics::from_rows(rows)
        .map_err(|error| wrong(&format!("{} is not finite", error.name)))?
        .with_scrub(section.scrubs);
    let mass_matrix = kinematics
        .mass_matrix(section.gyration_radius_m)
        .map_err(|error| wrong(&format!("{} is wrong", error.name)))?;
    if section.true_slip_s_rad != 0.0 && mass_matrix.sides().is_none() {
        return Err(wrong("true_slip_s_rad of a robot without two sides; expected none"));
    }
    let range = MassRange::new(section.mass_no_load_kg, section.mass_full_load_kg)
        .ok_or_else(|| wrong("expected 0 < mass_no_load_kg < mass_full_load_kg"))?;
    Ok(CoreRobot {
        name: Name::new(&section.name),
        kinematics,
        gyration_radius: section.gyration_radius_m,
        mass_matrix,
        dead_band: section.speed_dead_band_rad_s,
        cutoff_hz: section.filter_cutoff_hz,
        conditioning: section.conditioning(),
        range,
        static_power: section.static_power_w,
    })
}
