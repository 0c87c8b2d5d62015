//! The methods of the paper's Table 1 as data: which engine each runs, and with what.
//!
//! Kumar, Bensekrane and Merzouki (2022) are not among them. Their bond graph is a notation, not
//! another set of equations: its junctions, inertias, resistances and transformers give the
//! dynamics of a robot with friction and without motor losses, which is [`TOUZOUT`] for wheels that
//! do not steer. Their own part is a car-like robot with four steered wheels that changes its
//! structure: power of the steering, and kinematics that depend on steering angles. No log here has
//! steering angles, and R is one constant matrix: that part has neither input nor data. Without it
//! the baseline would be Touzout's under another name.

use super::card::{Card, Family, Layout, Need, PowerOfBraking, Preset};
use super::dynamics::Term as Torque;
use super::longitudinal::TERMS;
use super::network::{Input, MOTION_AND_MASS, Settings};
use super::physics::Term as Energy;
use super::regression::{Listed, Term};

/// Every baseline, in the order of lists and tables.
pub const ALL: &[&Card] = &[
    &KIM,
    &JARAMILLO,
    &MORALES,
    &YACOUB,
    &YAO,
    &SADRPOUR,
    &SADRPOUR_BAYES,
    &QUANN,
    &WAHAB,
    &TOUZOUT,
    &ANJUM,
    &DATOUO,
    &HOU,
    &DOGRU,
    &PENTZER,
    &EFFATI,
    &MEI,
    &JAIEM,
    &PARASURAMAN,
    &LENG,
    &LINEAR,
    &LIU_LINEAR,
    &LIU_POLYNOMIAL,
    &PERCEPTRON,
    &LIU_PERCEPTRON,
    &GORA,
    &SAKAYORI,
    &CHIKUSHI,
];

/// Methods that Table 1 does not name, for a fair comparison: they find the mass, too.
pub const BEYOND: &[&Card] = &[&VAHIDI, &VAHIDI_ROBUST];

/// Table 1's, then those beyond it.
pub fn every() -> impl Iterator<Item = &'static Card> + Clone {
    ALL.iter().chain(BEYOND).copied()
}

/// How many kinds of equations Table 1's are.
pub fn families() -> usize {
    let family = |place: usize| ALL[place].family;
    (0..ALL.len()).filter(|place| (0..*place).all(|before| family(before) != family(*place))).count()
}

/// What most cards have in common.
const REGRESSION: Card = Card {
    name: "",
    source: "",
    assumes: "",
    reduced: "",
    family: Family::Regression,
    takes_mass: false,
    needs: &[],
    layouts: &[],
    preset: Preset::Regression(&[]),
};

const DYNAMICS: Card = Card { family: Family::MotorDynamics, ..REGRESSION };

/// Three omni wheels in the source: only R depends on them.
///
/// The power is integrated with its sign, as the minimum-energy trajectories of the source do.
pub const KIM: Card = Card {
    name: "kim",
    source: "Kim and Kim 2012, 2017: dynamics of robot and DC motor, viscous friction and armature loss",
    assumes: "level ground; one mass; no Coulomb friction; braking power returns to the battery",
    preset: Preset::Dynamics(&[Torque::Viscous, Torque::Rotor, Torque::Body], PowerOfBraking::Regenerates),
    ..DYNAMICS
};

/// The only one of them with the payload as a variable: it acts on rolling friction and on the
/// inertia of the body.
///
/// The radius of gyration stays when the payload changes, as everywhere in this project.
pub const JARAMILLO: Card = Card {
    name: "jaramillo",
    source: "Jaramillo-Morales 2019, 2020: dynamics of robot and DC motor, variable acceleration and payload",
    assumes: "level ground; the payload is known",
    takes_mass: true,
    preset: Preset::Dynamics(
        &[Torque::Coulomb, Torque::Rolling, Torque::Viscous, Torque::Rotor, Torque::LoadedBody],
        PowerOfBraking::AsDriven,
    ),
    ..DYNAMICS
};

/// A simulation in the source, with power regeneration allowed.
pub const MORALES: Card = Card {
    name: "morales",
    source: "Morales and Mendoza 2018: mixed energy model, dynamics of robot and DC motor",
    assumes: "level ground; one mass; braking power returns to the battery",
    preset: Preset::Dynamics(
        &[Torque::Coulomb, Torque::Viscous, Torque::Rotor, Torque::Body],
        PowerOfBraking::Regenerates,
    ),
    ..DYNAMICS
};

/// Straight ahead on a road of given grade; level where a log has no grade.
///
/// The wheels keep their speeds, so a turn costs friction, but no inertia. For robots whose wheels
/// all turn forwards when it drives ahead.
pub const YACOUB: Card = Card {
    name: "yacoub",
    source: "Yacoub, Necsulescu and Sasiadek 2013: dynamics of robot and DC motor, straight on a road grade",
    assumes: "straight driving; one mass; the grade is known, or the road is level",
    layouts: &[Layout::Differential, Layout::SkidSteer],
    preset: Preset::Dynamics(
        &[Torque::Coulomb, Torque::Viscous, Torque::Straight, Torque::Grade],
        PowerOfBraking::AsDriven,
    ),
    ..DYNAMICS
};

/// For paths that a local planner predicts at one v and one ω each: no accelerations, so no power
/// below 0 either.
pub const YAO: Card = Card {
    name: "yao",
    source: "Yao 2024: dynamics of robot and DC motor at constant v and ω",
    assumes: "level ground; one mass; no acceleration",
    preset: Preset::Dynamics(&[Torque::Coulomb, Torque::Viscous], PowerOfBraking::Regenerates),
    ..DYNAMICS
};

/// b: power at rest, f: rolling resistance, M: effective mass, both at the battery.
pub(super) const LONGITUDINAL: [Listed; TERMS] =
    [("b", "W", Term::One), ("f", "N", Term::Rolling), ("M", "kg", Term::Inertial)];

/// The energy of a mission of an unmanned ground vehicle. Its mass is known and constant in the
/// source; here it is in the lumped parameters, and no input.
pub const SADRPOUR: Card = Card {
    name: "sadrpour-rls",
    source: "Sadrpour 2012/2013: longitudinal dynamics, recursive least squares while driving (forgetting over 60 s)",
    assumes: "turns cost nothing; past powers of the drive are known; level ground where the log has no pitch_rad",
    family: Family::LongitudinalDynamics,
    preset: Preset::Recursive(&LONGITUDINAL),
    ..REGRESSION
};

/// [`SADRPOUR`] by Bayesian estimation: the prior is the distribution of the parameters on earlier
/// drives over such ground.
pub const SADRPOUR_BAYES: Card = Card {
    name: "sadrpour-bayes",
    source: "Sadrpour 2012/2013: longitudinal dynamics, Bayesian estimation with a prior from the training drives",
    assumes: "turns cost nothing; past powers of the drive are known; its parameters are drawn as those of the training were",
    preset: Preset::Bayes,
    ..SADRPOUR
};

/// [`SADRPOUR`] with the parameters of the training, whatever the drive shows.
pub(crate) const SADRPOUR_OFFLINE: Card = Card {
    name: "sadrpour-offline",
    source: "Sadrpour 2012/2013: longitudinal dynamics, least squares",
    assumes: "turns cost nothing; level ground where the log has no pitch_rad",
    preset: Preset::Regression(&LONGITUDINAL),
    ..SADRPOUR
};

/// Vahidi, Stefanopoulou and Peng 2005 estimate mass and grade of a truck from its engine's torque;
/// here from the power.
pub const VAHIDI: Card = Card {
    name: "vahidi",
    source: "Vahidi 2005: longitudinal dynamics, the mass by recursive least squares with several forgetting factors",
    assumes: "turns cost nothing; past powers of the drive are known; a payload stays for a minute, ground for ten seconds",
    reduced: "the grade of the source is the resistance of the ground here; memories are a choice of this project",
    preset: Preset::Forgetting { robust: false },
    ..SADRPOUR
};

/// [`VAHIDI`] with bounded residuals.
pub const VAHIDI_ROBUST: Card = Card {
    name: "vahidi-robust",
    source: "Vahidi 2005 with residuals bounded as by Huber 1964",
    preset: Preset::Forgetting { robust: true },
    ..VAHIDI
};

/// The Gaussian process.
pub const QUANN: Card = Card {
    name: "quann",
    source: "Quann 2020: Gaussian-process regression on v, ω, v̇ and grade about the longitudinal dynamics",
    assumes: "one mass; test drives resemble the training; level ground where the log has no pitch_rad",
    reduced: "a process of the residual about the longitudinal dynamics; without place and terrain as inputs, which logs do not tell",
    family: Family::GaussianProcess,
    preset: Preset::Process,
    ..REGRESSION
};

/// Also the model of Mohammadpour et al. 2021.
///
/// For robots without a model of their own in this family.
pub const WAHAB: Card = Card {
    name: "wahab",
    source: "Wahab 2015, Mohammadpour 2021: kinetic and traction energy and the losses of the motors",
    assumes: "level ground; one mass; braking energy is lost",
    family: Family::EnergyBalance,
    layouts: &[Layout::Differential, Layout::SkidSteer, Layout::Matrix],
    preset: Preset::Physics(&WITH_MOTORS),
    ..REGRESSION
};

const WITH_MOTORS: [Energy; 7] = [
    Energy::Translation,
    Energy::Rotation,
    Energy::Traction,
    Energy::Viscous,
    Energy::FrictionHeat,
    Energy::CommonHeat,
    Energy::InertiaHeat,
];

/// [`WAHAB`] for three omni wheels: kinetic energy of sideways motion, too, and three wheels with
/// their own speeds.
pub const DATOUO: Card = Card {
    name: "datouo",
    source: "Datouo 2017: kinetic and traction energy and the losses of the motors, three omni wheels",
    layouts: &[Layout::Omni],
    ..WAHAB
};

/// [`WAHAB`] for four mecanum wheels. No log has the source's motor temperature, terrains and
/// shifted centre of gravity: its constants are those of one temperature, terrain and load.
pub const HOU: Card = Card {
    name: "hou",
    source: "Hou 2021: kinetic and traction energy and the losses of the motors, four mecanum wheels",
    assumes: "level ground; one mass, terrain and motor temperature; braking energy is lost",
    reduced: "without the source's factors of terrain, motor temperature and shifted centre of gravity: no log tells them",
    layouts: &[Layout::Mecanum],
    ..WAHAB
};

/// [`WAHAB`] for skid steer: wheels dragged sideways in turns, and a slope if the log has one.
///
/// σ shares the scrub among the wheels, so that Σ σ w is in proportion to |ω|. Chosen here: the
/// lateral friction is the same in every turn, whatever its radius.
pub const DOGRU: Card = Card {
    name: "dogru",
    source: "Dogru and Marques 2018: kinetic, traction, scrub and slope energy and the losses of the motors, skid steer",
    assumes: "one mass and terrain; the grade is known, or the ground is level; braking energy is lost",
    reduced: "one lateral friction for every turn; the source's depends on the turning radius",
    layouts: &[Layout::SkidSteer],
    preset: Preset::Physics(&SKID_STEER),
    ..WAHAB
};

const SKID_STEER: [Energy; 10] = [
    Energy::Translation,
    Energy::Rotation,
    Energy::Traction,
    Energy::Viscous,
    Energy::FrictionHeat,
    Energy::CommonHeat,
    Energy::InertiaHeat,
    Energy::Scrub,
    Energy::ScrubHeat,
    Energy::Grade,
];

/// Without the electrical losses of the motors.
pub const TOUZOUT: Card = Card {
    name: "touzout",
    source: "Touzout, Benazzouz and Benmoussa 2022: kinetic and traction energy, without electrical losses",
    assumes: "level ground; one mass; braking energy is lost; motors without electrical losses",
    layouts: &[],
    preset: Preset::Physics(&[Energy::Translation, Energy::Rotation, Energy::Traction, Energy::Viscous]),
    ..WAHAB
};

/// [`TOUZOUT`] with LuGre friction in place of a constant one.
pub const ANJUM: Card = Card {
    name: "anjum",
    source: "Anjum, Khalid and Manzoor 2024: Touzout 2022 with LuGre friction",
    preset: Preset::Physics(&[
        Energy::Translation,
        Energy::Rotation,
        Energy::Traction,
        Energy::Stribeck,
        Energy::Viscous,
    ]),
    ..TOUZOUT
};

const CENTRES_OF_ROTATION: Card = Card {
    family: Family::CentresOfRotation,
    layouts: &[Layout::SkidSteer, Layout::Differential],
    ..REGRESSION
};

/// P = g + G (|V_l| + |V_r|) + F |V_r − V_l|, with a gain constant g, taken as an offset, the
/// resistance G of a side, and friction.
///
/// The source learns the centres of rotation from the robot's track over the ground by an extended
/// Kalman filter. Logs of wheel speeds and power do not hold that track: since ω = (V_r − V_l) ∕ B,
/// friction and centres act on the power only as the product F = μ m g a ∕ B, which is learned
/// instead of its factors. Overhead imagery, from which the source refines the friction ahead of
/// the robot, is left out.
pub const PENTZER: Card = Card {
    name: "pentzer",
    source: "Pentzer 2022: skid steer by unknown centres of rotation, recursive least squares while driving",
    assumes: "level ground, one mass, no inertia; past powers of the drive are known",
    reduced: "without its Kalman filter for the centres and its imagery: logs hold no track over the ground; friction and centres are one parameter",
    preset: Preset::Recursive(&[
        ("g", "W", Term::One),
        ("G", "N", Term::Sides),
        ("F", "N", Term::SideDifference),
    ]),
    ..CENTRES_OF_ROTATION
};

/// P = G (|V_l| + |V_r|) + μ m g a |ω|, the centres known from the slip-track.
///
/// Without an offset the energy of a path does not depend on the speed along it: the source builds
/// its energy-optimal paths on that.
pub const EFFATI: Card = Card {
    name: "effati",
    source: "Effati 2023: skid steer by known centres of rotation",
    assumes: "level ground, one mass, no inertia, no power at rest",
    reduced: "the distance of a contact from its centre is half the slip-track of the robot's file, which does not tell where wheels stand",
    preset: Preset::Regression(&[("G", "N", Term::Sides), ("μ", "1", Term::Sliding)]),
    ..CENTRES_OF_ROTATION
};

/// P = c0 + c1 |v|, fitted to straight drives and circles at constant speed; only the speed along
/// the path enters (Table 1: "longitudinal speed"), so that a spin on the spot is predicted as
/// standing.
pub const MEI: Card = Card {
    name: "mei",
    source: "Mei 2005: first-order regression on the speed",
    assumes: "level ground; turning, accelerating and the payload cost nothing",
    reduced: "one line for all payloads, where Table 1 counts the payload as variable",
    preset: Preset::Regression(&[("c0", "W", Term::One), ("c1", "W s/m", Term::Path)]),
    ..REGRESSION
};

/// P = c0 + c1 |v| + c2 v².
pub const JAIEM: Card = Card {
    name: "jaiem",
    source: "Jaiem 2016/2021: second-order polynomial regression on the speed",
    assumes: "level ground, one mass; turning and accelerating cost nothing",
    preset: Preset::Regression(&[
        ("c0", "W", Term::One),
        ("c1", "W s/m", Term::Path),
        ("c2", "W s²/m²", Term::PathSquare),
    ]),
    ..REGRESSION
};

/// P = c0 + c1 |v| + c2 m. The mass is added, not multiplied by the speed: Leng's regression has it
/// the same way (Eq. 31).
pub const PARASURAMAN: Card = Card {
    name: "parasuraman",
    source: "Parasuraman 2012/2014: first-order regression on speed and mass",
    assumes: "level ground; a kilogram costs the same power at any speed; turning and accelerating cost nothing",
    takes_mass: true,
    preset: Preset::Regression(&[
        ("c0", "W", Term::One),
        ("c1", "W s/m", Term::Path),
        ("c2", "W/kg", Term::Mass),
    ]),
    ..REGRESSION
};

/// Eq. 30, without the mass.
pub const LENG: Card = Card {
    name: "leng",
    source: "Leng 2024 (Eq. 30): linear in v, ω, gated v̇ v, ω̇ ω and sin φ v",
    assumes: "one mass; level ground where the log has no pitch_rad",
    reduced: "the source's robot steers by an Ackermann axle; here it is fitted to any wheels",
    preset: Preset::Regression(&[
        ("c0", "W", Term::One),
        ("c1", "W s/m", Term::Speed),
        ("c2", "W s³/m²", Term::Faster),
        ("c3", "W s³/m²", Term::Slower),
        ("c4", "W s", Term::Turn),
        ("c5", "W s³", Term::TurnFaster),
        ("c6", "W s³", Term::TurnSlower),
        ("c7", "W s/m", Term::Climb),
        ("c8", "W s/m", Term::Descent),
    ]),
    ..REGRESSION
};

/// Eq. 31, the regression that the paper compares itself with.
pub const LINEAR: Card = Card {
    name: "linear",
    source: "Leng 2024 with the mass of Parasuraman 2014 (Eq. 31): linear in v, ω, gated v̇ v and ω̇ ω, and m",
    assumes: "level ground; a kilogram costs the same power at any speed",
    takes_mass: true,
    preset: Preset::Regression(&[
        ("c0", "W", Term::One),
        ("c1", "W s/m", Term::Speed),
        ("c2", "W s³/m²", Term::Faster),
        ("c3", "W s³/m²", Term::Slower),
        ("c4", "W s", Term::Turn),
        ("c5", "W s³", Term::TurnFaster),
        ("c6", "W s³", Term::TurnSlower),
        ("c7", "W/kg", Term::Mass),
    ]),
    ..REGRESSION
};

/// Linear in the magnitudes of the wheels' speeds.
pub const LIU_LINEAR: Card = Card {
    name: "liu-linear",
    source: "Liu 2023: linear regression on the wheels' commanded and measured speeds",
    assumes: "level ground, one mass",
    needs: &[Need::Command],
    preset: Preset::WheelSpeeds { products: false },
    ..REGRESSION
};

/// With all products of two.
pub const LIU_POLYNOMIAL: Card = Card {
    name: "liu-polynomial",
    source: "Liu 2023: second-order polynomial regression on the wheels' commanded and measured speeds",
    preset: Preset::WheelSpeeds { products: true },
    ..LIU_LINEAR
};

/// The network that the paper compares itself with.
pub const PERCEPTRON: Card = Card {
    name: "mlp",
    source: "multilayer perceptron of Section 7.2, seven hidden ReLU layers on motion and mass, after Liu 2023 (Eq. 32)",
    assumes: "test drives resemble the training",
    family: Family::Network,
    takes_mass: true,
    preset: Preset::Network(MOTION_AND_MASS, Settings::PERCEPTRON),
    ..REGRESSION
};

/// Liu 2023 as in Eq. 32: the same network on the motors' commands and feedback.
pub const LIU_PERCEPTRON: Card = Card {
    name: "liu-perceptron",
    source: "Liu 2023: multilayer perceptron on motor commands and feedback (Eq. 32), seven hidden ReLU layers",
    assumes: "commands and wheel speeds tell the power; the payload of the training",
    takes_mass: false,
    needs: &[Need::Command],
    preset: Preset::Network(&[Input::Command, Input::Wheels], Settings::PERCEPTRON),
    ..PERCEPTRON
};

/// Góra 2021.
pub const GORA: Card = Card {
    name: "gora",
    source: "Góra 2021: neural network on v, ω, rolling friction, static friction and mass (two hidden layers of 16)",
    assumes: "floor and mass are known; steady motion, no accelerations",
    needs: &[Need::RollingFriction, Need::StaticFriction],
    preset: Preset::Network(&[Input::Speed, Input::Friction, Input::Mass], Settings::SMALL),
    ..PERCEPTRON
};

/// Sakayori and Ishigami 2021. ReLU in middle and output layers: Section 2 of the paper.
pub const SAKAYORI: Card = Card {
    name: "sakayori",
    source: "Sakayori 2021: feed-forward network with back-propagation on speed, slope and heading, ReLU output (two hidden layers of 16)",
    assumes: "a rover in steady traverse of a slope; the payload of the training; no braking power",
    takes_mass: false,
    needs: &[Need::Pitch, Need::SlopeHeading],
    preset: Preset::Network(&[Input::PathSpeed, Input::Pitch, Input::SlopeHeading], Settings::RECTIFIED),
    ..PERCEPTRON
};

/// Chikushi 2024. ReLU in middle and output layers: Section 2 of the paper.
pub const CHIKUSHI: Card = Card {
    name: "chikushi",
    source: "Chikushi 2024: network on commanded v and ω and the vibration along X, Y and Z, ReLU output (two hidden layers of 16)",
    assumes: "the robot does as commanded, vibration tells the floor; the payload of the training; no braking power",
    takes_mass: false,
    needs: &[Need::Command, Need::Vibration],
    preset: Preset::Network(&[Input::Command, Input::Vibration], Settings::RECTIFIED),
    ..PERCEPTRON
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_families_counted() {
        for (place, card) in ALL.iter().enumerate() {
            assert!(ALL[..place].iter().all(|other| other.name != card.name), "{}", card.name);
        }
        assert_eq!((ALL.len(), families()), (28, 7));
    }
}
