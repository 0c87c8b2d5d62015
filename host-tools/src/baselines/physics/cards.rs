//! The sources that look at the power from outside, and what each of them counts.

use super::{Physics, Term};
use crate::baselines::{Card, Layout};

/// Also the model of Mohammadpour et al. 2021.
///
/// For robots that have no model of this family of their own.
pub const WAHAB: Card = Card {
    name: "wahab",
    source: "Wahab 2015, Mohammadpour 2021: kinetic and traction energy and the losses of the motors",
    assumes: "level ground; one mass; braking energy is lost",
    takes_mass: false,
    network: false,
    needs: &[],
    layouts: &[Layout::Differential, Layout::SkidSteer, Layout::Matrix],
    make: |_| Box::new(Physics::new("wahab", WITH_MOTORS)),
};

const WITH_MOTORS: [Term; 7] = [
    Term::Translation,
    Term::Rotation,
    Term::Traction,
    Term::Viscous,
    Term::FrictionHeat,
    Term::CommonHeat,
    Term::InertiaHeat,
];

/// [`WAHAB`] for three omni wheels: kinetic energy of sideways motion, too, and three wheels with their own speeds.
pub const DATOUO: Card = Card {
    name: "datouo",
    source: "Datouo 2017: kinetic and traction energy and the losses of the motors, three omni wheels",
    layouts: &[Layout::Omni],
    make: |_| Box::new(Physics::new("datouo", WITH_MOTORS)),
    ..WAHAB
};

/// [`WAHAB`] for four mecanum wheels. The source's temperature of the motors, its terrains and its shifted centre of
/// gravity are in no log: its constants are those of one temperature, terrain and load.
pub const HOU: Card = Card {
    name: "hou",
    source: "Hou 2021: kinetic and traction energy and the losses of the motors, four mecanum wheels",
    assumes: "level ground; one mass, terrain and motor temperature; braking energy is lost",
    layouts: &[Layout::Mecanum],
    make: |_| Box::new(Physics::new("hou", WITH_MOTORS)),
    ..WAHAB
};

/// [`WAHAB`] for skid steer: wheels dragged sideways in turns, and a slope where the log tells it.
///
/// σ shares the scrub among the wheels, so that Σ σ w is in proportion to |ω|. Chosen here: the lateral friction is the
/// same in every turn, whatever its radius.
pub const DOGRU: Card = Card {
    name: "dogru",
    source: "Dogru and Marques 2018: kinetic, traction, scrub and slope energy and the losses of the motors, skid steer",
    assumes: "one mass and terrain; the grade is known, or the ground is level; braking energy is lost",
    layouts: &[Layout::SkidSteer],
    make: |_| Box::new(Physics::new("dogru", SKID_STEER)),
    ..WAHAB
};

const SKID_STEER: [Term; 10] = [
    Term::Translation,
    Term::Rotation,
    Term::Traction,
    Term::Viscous,
    Term::FrictionHeat,
    Term::CommonHeat,
    Term::InertiaHeat,
    Term::Scrub,
    Term::ScrubHeat,
    Term::Grade,
];

/// Without the electrical losses of the motors.
pub const TOUZOUT: Card = Card {
    name: "touzout",
    source: "Touzout, Benazzouz and Benmoussa 2022: kinetic and traction energy, without electrical losses",
    assumes: "level ground; one mass; braking energy is lost; motors without electrical losses",
    layouts: &[],
    make: |_| {
        Box::new(Physics::new("touzout", [Term::Translation, Term::Rotation, Term::Traction, Term::Viscous]))
    },
    ..WAHAB
};

/// [`TOUZOUT`] with LuGre friction in place of a constant one.
pub const ANJUM: Card = Card {
    name: "anjum",
    source: "Anjum, Khalid and Manzoor 2024: Touzout 2022 with LuGre friction",
    make: |robot| Box::new(Physics::with_bristles("anjum", WITH_BRISTLES, robot)),
    ..TOUZOUT
};

const WITH_BRISTLES: [Term; 5] =
    [Term::Translation, Term::Rotation, Term::Traction, Term::Stribeck, Term::Viscous];
