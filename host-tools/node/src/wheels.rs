//! Messages about the wheels, as speeds in the order of a log's columns.

use logs::foreign::wheel_joints;
use logs::robot::Robot;
use logs::robot::chassis::PerWheel;
use nalgebra::DMatrix;

/// A message about the wheels.
#[derive(Debug, Clone, PartialEq)]
pub struct WheelMessage {
    /// Who sent it.
    pub from: [u8; 16],
    /// When, on the sender's clock, s; none where it says nothing.
    pub stamp_s: Option<f64>,
    /// What it says.
    pub motion: Motion,
}

/// What is said of motion.
#[derive(Debug, Clone, PartialEq)]
pub enum Motion {
    /// `sensor_msgs/JointState`: names, and speeds in rad/s, which may be missing.
    Joints(Vec<String>, Vec<f64>),
    /// `nav_msgs/Odometry`: forward and to the left, m/s, and the turn rate, rad/s.
    Twist([f64; 3]),
}

/// Makes speeds of messages.
#[derive(Debug, Clone)]
pub(super) struct Wheels {
    /// Sets of joints that may carry the wheels: for each column those whose mean it is.
    sets: Vec<Vec<Vec<String>>>,
    of_twist: DMatrix<f64>,
    scale: Vec<f64>,
}

impl Wheels {
    pub(super) fn of(robot: &Robot) -> Self {
        let given = &robot.node().joints;
        let wheels = robot.wheels();
        let sets = if given.len() == wheels {
            vec![given.iter().map(|joint| vec![joint.clone()]).collect()]
        } else {
            let owned = |joints: Vec<&str>| joints.into_iter().map(str::to_owned).collect();
            wheel_joints(wheels).into_iter().map(|set| set.into_iter().map(owned).collect()).collect()
        };
        Self {
            sets,
            of_twist: robot.wheel_speeds_of_motion(),
            scale: (0..wheels).map(|wheel| robot.log_speed_scale(wheel)).collect(),
        }
    }

    /// rad/s, or why there are none.
    pub(super) fn speeds(&self, message: &WheelMessage) -> Result<PerWheel<f64>, &'static str> {
        let speeds = match &message.motion {
            Motion::Twist(twist) => PerWheel::new(self.scale.len(), |wheel| {
                twist.iter().enumerate().map(|(axis, value)| self.of_twist[(wheel, axis)] * value).sum()
            }),
            Motion::Joints(names, velocities) => {
                let place = |joint: &String| names.iter().position(|name| name == joint);
                let is_there =
                    |set: &&Vec<Vec<String>>| set.iter().flatten().all(|joint| place(joint).is_some());
                let set = self.sets.iter().find(is_there).ok_or("joint states without these wheels")?;
                if velocities.len() != names.len() {
                    return Err("joint states without velocities");
                }
                PerWheel::new(self.scale.len(), |wheel| {
                    let of_wheel = set[wheel].iter().filter_map(place).map(|place| velocities[place]);
                    self.scale[wheel] * of_wheel.sum::<f64>() / set[wheel].len() as f64
                })
            }
        };
        if speeds.iter().all(|speed| speed.is_finite()) {
            Ok(speeds)
        } else {
            Err("speeds that are no numbers")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn joints(names: &[&str], speeds: &[f64]) -> WheelMessage {
        let names = names.iter().map(|name| (*name).to_owned()).collect();
        WheelMessage { from: [0; 16], stamp_s: None, motion: Motion::Joints(names, speeds.to_vec()) }
    }

    #[test]
    fn wheels_are_found_by_name_in_any_order() {
        let burger = Wheels::of(&Robot::named("burger").unwrap());
        let right_first = joints(&["wheel_right_joint", "arm", "wheel_left_joint"], &[2.0, 9.0, 1.0]);
        assert_eq!(burger.speeds(&right_first), Ok([1.0, 2.0].into()));
        // Four wheels of a robot with a column a side are averaged.
        let four = joints(
            &[
                "front_left_wheel_joint",
                "front_right_wheel_joint",
                "rear_left_wheel_joint",
                "rear_right_wheel_joint",
            ],
            &[1.0, 2.0, 3.0, 6.0],
        );
        assert_eq!(burger.speeds(&four), Ok([2.0, 4.0].into()));
        assert!(burger.speeds(&joints(&["arm"], &[1.0])).is_err());
        assert!(burger.speeds(&joints(&["wheel_right_joint", "wheel_left_joint"], &[])).is_err());
        let no_number = joints(&["wheel_right_joint", "wheel_left_joint"], &[1.0, f64::NAN]);
        assert!(burger.speeds(&no_number).is_err());
    }

    /// v = r (wl + wr) / 2, ω = r (wr − wl) / b with r = 0.033 m, b = 0.16 m.
    #[test]
    fn odometry_goes_through_the_kinematics() {
        let burger = Wheels::of(&Robot::named("burger").unwrap());
        let motion = Motion::Twist([0.033 * 3.0, 0.0, 0.033 * 2.0 / 0.16]);
        let speeds = burger.speeds(&WheelMessage { from: [0; 16], stamp_s: None, motion }).unwrap();
        let [left, right] = speeds.array();
        assert!((left - 2.0).abs() < 1e-9 && (right - 4.0).abs() < 1e-9, "{left} {right}");
    }
}
