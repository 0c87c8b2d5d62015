//! The networks of the literature: what each sees, and how large it is.

use super::super::{Card, Need, Point};
use super::{Network, Settings};

/// The network that the paper compares itself with.
pub const PERCEPTRON: Card = Card {
    name: "mlp",
    source: "multilayer perceptron of Section 7.2, seven hidden ReLU layers on motion and mass, after Liu 2023 (Eq. 32)",
    assumes: "test drives resemble the training",
    takes_mass: true,
    network: true,
    needs: &[],
    layouts: &[],
    make: |_| Box::new(perceptron(Settings::PERCEPTRON)),
};

/// The network of Section 7.2 with settings of one's own.
pub fn perceptron(settings: Settings) -> Network {
    Network::new(PERCEPTRON.name, motion_and_mass, settings)
}

fn motion_and_mass(point: &Point) -> Vec<f64> {
    let Point { speed, acceleration, mass, .. } = point;
    vec![speed.vx, speed.vy, speed.omega, acceleration.vx, acceleration.vy, acceleration.omega, *mass]
}

/// Liu 2023 as Eq. 32 has it: the same network on what motors are told and what they report.
pub const LIU: Card = Card {
    name: "liu-perceptron",
    source: "Liu 2023: multilayer perceptron on motor commands and feedback (Eq. 32), seven hidden ReLU layers",
    assumes: "commands and wheel speeds tell the power; the payload of the training",
    takes_mass: false,
    network: true,
    needs: &[Need::Command],
    layouts: &[],
    make: |_| Box::new(Network::new(LIU.name, commands_and_feedback, Settings::PERCEPTRON)),
};

/// Commands of the body stand for those of the motors: by the kinematics the ones follow from the others.
fn commands_and_feedback(point: &Point) -> Vec<f64> {
    let command = point.readings.command;
    let feedback = point.wheels.iter().map(|wheel| wheel.speed);
    [command.vx, command.vy, command.omega].into_iter().chain(feedback).collect()
}

/// Góra 2021.
pub const GORA: Card = Card {
    name: "gora",
    source: "Góra 2021: neural network on v, ω, rolling friction, static friction and mass (two hidden layers of 16)",
    assumes: "floor and mass are known; steady motion, no accelerations",
    takes_mass: true,
    network: true,
    needs: &[Need::RollingFriction, Need::StaticFriction],
    layouts: &[],
    make: |_| Box::new(Network::new(GORA.name, motion_floor_and_mass, Settings::SMALL)),
};

fn motion_floor_and_mass(point: &Point) -> Vec<f64> {
    let (speed, floor) = (point.speed, point.readings);
    vec![speed.vx, speed.vy, speed.omega, floor.rolling_friction, floor.static_friction, point.mass]
}

/// Sakayori and Ishigami 2021. ReLU in middle and output layers: Section 2 of the paper.
pub const SAKAYORI: Card = Card {
    name: "sakayori",
    source: "Sakayori 2021: feed-forward network with back-propagation on speed, slope and heading, ReLU output (two hidden layers of 16)",
    assumes: "a rover in steady traverse of a slope; the payload of the training; no braking power",
    takes_mass: false,
    network: true,
    needs: &[Need::Pitch, Need::SlopeHeading],
    layouts: &[],
    make: |_| {
        Box::new(Network::new(
            SAKAYORI.name,
            speed_and_slope,
            Settings { rectified: true, ..Settings::SMALL },
        ))
    },
};

/// The heading as cosine and sine: it has no jump at ±180°.
fn speed_and_slope(point: &Point) -> Vec<f64> {
    let (sin, cos) = point.readings.slope_heading.sin_cos();
    vec![point.speed.vx, point.speed.vy, point.readings.pitch, cos, sin]
}

/// Chikushi 2024. ReLU in middle and output layers: Section 2 of the paper.
pub const CHIKUSHI: Card = Card {
    name: "chikushi",
    source: "Chikushi 2024: network on commanded v and ω and the vibration along X, Y and Z, ReLU output (two hidden layers of 16)",
    assumes: "the robot does as commanded, vibration tells the floor; the payload of the training; no braking power",
    takes_mass: false,
    network: true,
    needs: &[Need::Command, Need::Vibration],
    layouts: &[],
    make: |_| {
        let settings = Settings { rectified: true, ..Settings::SMALL };
        Box::new(Network::new(CHIKUSHI.name, command_and_vibration, settings))
    },
};

fn command_and_vibration(point: &Point) -> Vec<f64> {
    let (command, [x, y, z]) = (point.readings.command, point.readings.vibration);
    vec![command.vx, command.vy, command.omega, x, y, z]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::baselines::Readings;
    use crate::baselines::testing::{burger, drive};
    use crate::metrics::Metrics;

    /// Trained on 2000 points of a power that its own inputs tell, it explains the next 1000 but for 3 %, and what it
    /// does not take makes no difference. (Waves are incommensurable: the next points are others.)
    fn learns_its_own(card: &Card, power: fn(&Point) -> f64, change_the_rest: fn(&mut Point)) {
        let mut points = drive(3000, power);
        let mut model = (card.make)(&burger());
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

    /// Rolling at the mass, and what the body's inertia takes and gives.
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

    /// Motors that lag behind what they are told draw more.
    #[test]
    fn liu_learns_from_commands_and_feedback() {
        learns_its_own(
            &LIU,
            |point| {
                let lag = point.readings.command.vx - point.speed.vx;
                0.5 + 0.05 * point.wheels.iter().map(|wheel| wheel.speed.abs()).sum::<f64>() + 10.0 * lag
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

    /// Climbing costs, driving along the contour costs a little of it, and the way down is free.
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

    /// Networks with a ReLU at the output never predict a power below 0, even where training has it.
    #[test]
    fn a_rectified_output_is_never_negative() {
        let points = drive(2000, |point| 20.0 * point.readings.pitch * point.speed.vx.signum());
        for (card, rectified) in [(&SAKAYORI, true), (&PERCEPTRON, false)] {
            let mut model = (card.make)(&burger());
            model.fit(&points).unwrap();
            let least = model.predict(&points).unwrap().into_iter().fold(f64::INFINITY, f64::min);
            assert_eq!(least >= 0.0, rectified, "{}: {least}", card.name);
        }
    }
}
