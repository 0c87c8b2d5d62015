//! From robot.toml to what model-core computes with.

use model_core::coefficients::{Name, Robot as CoreRobot};
use model_core::conditioning::Conditioning;
use model_core::kinematics::{InvalidLength, Kinematics};
use model_core::model::MassRange;
use model_core::torque::Drive;
use nalgebra::DMatrix;
use support::error::{Error, Result};

use super::chassis::Chassis;
use super::{Geometry, Robot};

/// Calls a generic function with the robot's number of wheels as its const argument.
///
/// # Errors
/// More wheels than the coefficient image holds.
#[macro_export]
macro_rules! with_wheels {
    ($robot:expr, $function:ident ( $($argument:expr),* $(,)? )) => {
        match $robot.wheels() {
            1 => $function::<1>($($argument),*),
            2 => $function::<2>($($argument),*),
            3 => $function::<3>($($argument),*),
            4 => $function::<4>($($argument),*),
            5 => $function::<5>($($argument),*),
            6 => $function::<6>($($argument),*),
            wheels => Err(support::error::Error::failed(format!(
                "robot {} has {wheels} wheels; expected 1 to 6",
                $robot.name()
            ))),
        }
    };
}

/// A function of the number of wheels whose instances are compiled where this stands: calling it
/// from another crate compiles nothing again. `$function` is the generic function itself; `N` is 1
/// to 6, as [`with_wheels!`] gives it.
#[macro_export]
macro_rules! compiled_here {
    ($(#[$about:meta])* $view:vis fn $name:ident<$n:ident>($($argument:ident: $type:ty),* $(,)?) -> $answer:ty = $function:ident;) => {
        $(#[$about])*
        $view fn $name<const $n: usize>($($argument: $type),*) -> $answer {
            type Function<const $n: usize> = fn($($type),*) -> $answer;
            static HERE: [&(dyn std::any::Any + Send + Sync); 6] = [
                &($function::<1> as Function<1>),
                &($function::<2> as Function<2>),
                &($function::<3> as Function<3>),
                &($function::<4> as Function<4>),
                &($function::<5> as Function<5>),
                &($function::<6> as Function<6>),
            ];
            let here = HERE.get($n.wrapping_sub(1)).and_then(|here| here.downcast_ref::<Function<$n>>());
            let Some(here) = here else { panic!("{} wheels; expected 1 to 6", $n) };
            here($($argument),*)
        }
    };
}

impl Robot {
    /// Whether its drives clamp braking power.
    pub fn drive(&self) -> Drive {
        if self.regeneration { Drive::Regenerative } else { Drive::Dissipative }
    }

    /// The robot as model-core knows it.
    ///
    /// # Errors
    /// A dimension that no robot can have.
    ///
    /// # Panics
    /// If `N` is not its number of wheels.
    pub fn core<const N: usize>(&self, cutoff_hz: f64) -> Result<CoreRobot<f64, N>> {
        core(self, cutoff_hz)
    }

    /// The same, whatever its number of wheels.
    ///
    /// # Errors
    /// As [`core`](Self::core); more wheels than the coefficient image holds.
    pub fn chassis(&self, cutoff_hz: f64) -> Result<Chassis> {
        fn chassis<const N: usize>(robot: &Robot, cutoff_hz: f64) -> Result<Chassis> {
            Ok(Chassis::new(&robot.core::<N>(cutoff_hz)?))
        }
        with_wheels!(self, chassis(self, cutoff_hz))
    }

    fn invalid(&self, error: InvalidLength) -> Error {
        Error::failed(format!("robot {}: {} has to be finite and above zero", self.name(), error.name))
    }

    fn mass_range(&self) -> Result<MassRange<f64>> {
        let (name, least, most) = (self.name(), self.mass_no_load_kg, self.mass_full_load_kg);
        MassRange::new(least, most).ok_or_else(|| {
            Error::failed(format!(
                "robot {name}: expected 0 < mass_no_load_kg < mass_full_load_kg, found {least} and {most}"
            ))
        })
    }

    /// R⁺, which makes wheel speeds (rad/s), a row a wheel, of vx, vy (m/s) and ω (rad/s): of those
    /// with that motion the smallest. NaN for a robot that has no R: logs of such a robot cannot be
    /// read.
    pub fn wheel_speeds_of_motion(&self) -> DMatrix<f64> {
        let unknown = || DMatrix::from_element(self.wheels(), 3, f64::NAN);
        with_wheels!(self, inverse(self)).ok().flatten().unwrap_or_else(unknown)
    }

    fn kinematics<const N: usize>(&self) -> std::result::Result<Kinematics<f64, N>, InvalidLength> {
        let rows = self.rows()?.map(|row| std::array::from_fn(|wheel| row[wheel]));
        let scrubs = matches!(self.geometry, Geometry::SkidSteer { .. });
        Ok(Kinematics::from_rows(rows)?.with_scrub(scrubs))
    }

    fn rows(&self) -> std::result::Result<[Vec<f64>; 3], InvalidLength> {
        fn rows<const N: usize>(kinematics: &Kinematics<f64, N>) -> [Vec<f64>; 3] {
            kinematics.rows().map(|row| row.to_vec())
        }
        Ok(match &self.geometry {
            Geometry::DifferentialDrive { wheel_radius_m, track_m }
            | Geometry::SkidSteer { wheel_radius_m, track_m, wheels: 2 } => {
                rows(&Kinematics::differential(*wheel_radius_m, *track_m)?)
            }
            Geometry::SkidSteer { wheel_radius_m, track_m, .. } => {
                rows(&Kinematics::skid_steer(*wheel_radius_m, *track_m)?)
            }
            Geometry::ThreeWheelOmni { wheel_radius_m, arm_m } => {
                rows(&Kinematics::omni(*wheel_radius_m, *arm_m)?)
            }
            Geometry::FourMecanum { wheel_radius_m, half_length_m, half_width_m } => {
                rows(&Kinematics::mecanum(*wheel_radius_m, *half_length_m, *half_width_m)?)
            }
            Geometry::Matrix { rows: given, .. } => match &given[..] {
                [ahead, turn] => [ahead.clone(), vec![0.0; ahead.len()], turn.clone()],
                given => [0, 1, 2].map(|row| given[row].clone()),
            },
        })
    }
}

compiled_here! {
    fn core<N>(robot: &Robot, cutoff_hz: f64) -> Result<CoreRobot<f64, N>> = core_here;
}

fn core_here<const N: usize>(robot: &Robot, cutoff_hz: f64) -> Result<CoreRobot<f64, N>> {
    assert_eq!(robot.wheels(), N, "as many wheels as the robot has");
    let invalid = |error| robot.invalid(error);
    let kinematics = robot.kinematics::<N>().map_err(invalid)?;
    let range = robot.mass_range()?;
    Ok(CoreRobot {
        name: Name::new(robot.name()),
        kinematics,
        gyration_radius: robot.gyration_radius_m,
        mass_matrix: kinematics.mass_matrix(robot.gyration_radius_m).map_err(invalid)?,
        dead_band: robot.speed_dead_band_rad_s,
        cutoff_hz,
        conditioning: Conditioning::PLAIN,
        range,
        static_power: robot.static_power_w.unwrap_or(0.0),
    })
}

fn inverse<const N: usize>(robot: &Robot) -> Result<Option<DMatrix<f64>>> {
    // Any cutoff: only R is wanted.
    let core = robot.core::<N>(1.0)?;
    let rows = core.kinematics.rows();
    let matrix = DMatrix::from_fn(3, N, |component, wheel| rows[component][wheel]);
    // Below any difference that lengths in metres can make.
    Ok(matrix.pseudo_inverse(1e-12).ok())
}
