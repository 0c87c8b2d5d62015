//! What the robot carries: where it lies, and what the log says of it.

use super::super::kinematics::{Geometry, Kinematics, MAX_WHEELS};
use super::cause::{Cause, Listed, Onset, onset};
use super::conditions::{Conditions, Now};
use super::entry::{Choice, Entry, Values};
use super::options::AT;

pub(super) const OFFSET: Listed = Listed {
    entry: Entry {
        id: "payload-offset",
        meaning: "The load lies off centre: the wheels of one side carry more of it.",
        unit: "how far the centre of the total mass lies to the left, m",
        range: (-0.1, 0.1),
        options: &[
            Choice {
                name: "inertia",
                values: Values::Word(&["no", "yes"]),
                default: Some(0.0),
                meaning: "whether turning also moves the load's mass forward and back",
            },
            AT,
        ],
    },
    build: |effect, setting| {
        let geometry = setting.scenario.robot.geometry;
        let lever = levers(&geometry);
        let share = setting.scenario.robot.wheels.map(|wheel| wheel.load_share);
        let lifted = (0..geometry.wheels()).any(|i| share[i] + effect.size() * lever[i] < 0.0);
        if lifted {
            return Err(effect.refuse("a wheel would lift off; allowed: a centre between the wheels"));
        }
        let inertia = effect.number("inertia") == 1.0;
        Ok(Box::new(Offset { offset: onset(effect), lever, inertia }))
    },
};

#[derive(Debug, Clone)]
struct Offset {
    offset: Onset,
    lever: [f64; MAX_WHEELS],
    inertia: bool,
}

impl Cause for Offset {
    fn act(&mut self, now: &Now, conditions: &mut Conditions) {
        let offset = self.offset.at(now.time_s);
        if self.inertia {
            conditions.loads.offset_m += offset;
        }
        for (wheel, lever) in conditions.wheels.iter_mut().zip(self.lever) {
            wheel.load_share += offset * lever;
        }
    }
}

/// Share of the weight that a wheel carries more per metre of offset to the left, 1/m.
///
/// Moments about the robot's axis: Σ share_i y_i = offset. With three and more wheels the stiffest
/// floor is taken, on which loads differ in proportion to y.
fn levers(geometry: &Geometry) -> [f64; MAX_WHEELS] {
    let half = geometry.track_m / 2.0;
    let y: [f64; MAX_WHEELS] = match geometry.kinematics {
        Kinematics::Differential => [half, -half, 0.0, 0.0],
        Kinematics::Skid | Kinematics::Mecanum => [half, -half, half, -half],
        Kinematics::Omni => {
            let at = |degrees: f64| half * degrees.to_radians().sin();
            [at(60.0), at(180.0), at(300.0), 0.0]
        }
    };
    let square: f64 = y.iter().map(|y| y * y).sum();
    y.map(|y| y / square)
}

pub(super) const MISLABEL: Listed = Listed {
    entry: Entry {
        id: "payload-mislabel",
        meaning: "The robot carries another mass than the log notes.",
        unit: "true mass minus the noted mass, kg",
        range: (-5.0, 20.0),
        options: &[AT],
    },
    build: |effect, setting| {
        let noted = setting.scenario.payload.least_kg();
        if noted + effect.size() <= 0.0 {
            return Err(
                effect.refuse(format_args!("the noted mass is {noted} kg; allowed: more than -{noted}"))
            );
        }
        Ok(Box::new(Mislabel { unnoted: onset(effect) }))
    },
};

#[derive(Debug, Clone)]
struct Mislabel {
    unnoted: Onset,
}

impl Cause for Mislabel {
    fn act(&mut self, now: &Now, conditions: &mut Conditions) {
        conditions.unnoted_kg += self.unnoted.at(now.time_s);
    }
}
