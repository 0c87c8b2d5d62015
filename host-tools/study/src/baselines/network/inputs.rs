//! What networks see of a point.

use crate::baselines::point::Point;

/// One or more numbers of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Input {
    /// vx, vy and ω.
    Speed,
    /// vx and vy.
    PathSpeed,
    /// Their derivatives, of ω too.
    Acceleration,
    /// True total mass.
    Mass,
    /// Commanded vx, vy and ω, which determine the motors' commands by the kinematics.
    Command,
    /// Measured speed of every wheel.
    Wheels,
    /// Coefficients of rolling and of static friction.
    Friction,
    /// Road grade.
    Pitch,
    /// Heading on the slope as cosine and sine: it has no jump at ±180°.
    SlopeHeading,
    /// Acceleration along X, Y and Z.
    Vibration,
}

impl Input {
    /// Adds its numbers: as many for every point of a robot.
    pub(super) fn see(self, point: &Point, seen: &mut Vec<f64>) {
        let Point { speed, acceleration, readings, .. } = point;
        let command = readings.command;
        match self {
            Self::Speed => seen.extend([speed.vx, speed.vy, speed.omega]),
            Self::PathSpeed => seen.extend([speed.vx, speed.vy]),
            Self::Acceleration => seen.extend([acceleration.vx, acceleration.vy, acceleration.omega]),
            Self::Mass => seen.push(point.mass),
            Self::Command => seen.extend([command.vx, command.vy, command.omega]),
            Self::Wheels => seen.extend(point.wheels.iter().map(|wheel| wheel.speed)),
            Self::Friction => seen.extend([readings.rolling_friction, readings.static_friction]),
            Self::Pitch => seen.push(readings.pitch),
            Self::SlopeHeading => {
                let (sin, cos) = readings.slope_heading.sin_cos();
                seen.extend([cos, sin]);
            }
            Self::Vibration => seen.extend(readings.vibration),
        }
    }
}

#[cfg(test)]
mod tests {
    use support::metrics::Metrics;

    use crate::baselines::cards::{CHIKUSHI, GORA, LIU_PERCEPTRON, PERCEPTRON, SAKAYORI};
    use crate::baselines::testing::{burger, drive};
    use crate::baselines::{Card, Point, Readings};

    /// Trained on 2000 points of a power that depends on its inputs, it explains the next 1000 but
    /// for 3 %. What is no input makes no difference. (Waves are incommensurable: the next points
    /// are others.)
    fn learns_its_own(card: &Card, power: fn(&Point) -> f64, change_the_rest: fn(&mut Point)) {
        let mut points = drive(3000, power);
        let mut model = card.make(&burger());
        model.fit(&points[..2000]).unwrap();
        let test = &mut points[2000..];
        let predicted = model.predict(test).unwrap();
        let mut metrics = Metrics::new(0.0);
        for (point, predicted) in test.iter().zip(&predicted) {
            metrics.add(point.power, *predicted);
        }
        let r2 = metrics.quality().unwrap().r2.unwrap();
        assert!(r2 > 0.97, "{}: {r2}", card.name);
        test.iter_mut().for_each(change_the_rest);
        assert_eq!(model.predict(test).unwrap(), predicted, "{}", card.name);
    }

    /// Rolling in proportion to the mass, and the power of the body's inertia.
    #[test]
    fn the_perceptron_learns_from_motion_and_mass() {
        learns_its_own(
            &PERCEPTRON,
            |point| {
                let (v, dv) = (point.speed.vx, point.acceleration.vx);
                0.3 + point.mass * (2.0 * v.abs() + dv * v) + 0.1 * point.speed.omega.abs()
            },
            |point| point.readings = Readings::NONE,
        );
    }

    /// Motors behind their command draw more.
    #[test]
    fn liu_learns_from_commands_and_feedback() {
        learns_its_own(
            &LIU_PERCEPTRON,
            |point| {
                let missing = point.readings.command.vx - point.speed.vx;
                0.5 + 0.05 * point.wheels.iter().map(|wheel| wheel.speed.abs()).sum::<f64>() + 10.0 * missing
            },
            |point| {
                (point.mass, point.acceleration.vx) = (9.0, 7.0);
                (point.readings.vibration, point.readings.pitch) = ([1.0; 3], 1.0);
            },
        );
    }

    /// Rolling friction at every metre, static friction in every turn.
    #[test]
    fn gora_learns_from_floor_and_mass() {
        learns_its_own(
            &GORA,
            |point| {
                let floor = point.readings;
                let weight = 9.8 * point.mass;
                weight * floor.rolling_friction * point.speed.vx.abs()
                    + 0.1 * weight * floor.static_friction * point.speed.omega.abs()
            },
            |point| {
                (point.acceleration.vx, point.readings.pitch) = (7.0, 1.0);
                (point.readings.command.vx, point.readings.vibration) = (1.0, [1.0; 3]);
            },
        );
    }

    /// Climbing costs, driving along the contour costs little of that, and the way down is free.
    #[test]
    fn sakayori_learns_from_the_slope() {
        learns_its_own(
            &SAKAYORI,
            |point| {
                let Readings { pitch, slope_heading, .. } = point.readings;
                let v = point.speed.vx;
                (0.5 + 5.0 * v.abs() + 20.0 * pitch * v + 0.2 * slope_heading.sin()).max(0.0)
            },
            |point| {
                (point.mass, point.acceleration.vx, point.speed.omega) = (9.0, 7.0, 1.0);
                point.readings.vibration = [1.0; 3];
            },
        );
    }

    /// Speed as commanded, on a floor that shakes.
    #[test]
    fn chikushi_learns_from_commands_and_vibration() {
        learns_its_own(
            &CHIKUSHI,
            |point| {
                let Readings { command, vibration: [x, y, z], .. } = point.readings;
                0.2 + 5.0 * command.vx.abs() + 0.1 * command.omega.abs() + 0.2 * (x - y) + 0.3 * z.abs()
            },
            |point| {
                (point.mass, point.acceleration.vx, point.speed.vx) = (9.0, 7.0, 1.0);
                point.readings.pitch = 1.0;
            },
        );
    }

    /// Networks with a ReLU at the output never predict a power below 0, even where training has
    /// it.
    #[test]
    fn a_rectified_output_is_never_negative() {
        let points = drive(2000, |point| 20.0 * point.readings.pitch * point.speed.vx.signum());
        for (card, rectified) in [(&SAKAYORI, true), (&PERCEPTRON, false)] {
            let mut model = card.make(&burger());
            model.fit(&points).unwrap();
            let least = model.predict(&points).unwrap().into_iter().fold(f64::INFINITY, f64::min);
            assert_eq!(least >= 0.0, rectified, "{}: {least}", card.name);
        }
    }
}
