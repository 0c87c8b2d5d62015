//! The sources that combine known dynamics of robot and DC motor.
//!
//! Where a source does not say where braking power goes, it goes where the robot's own drives send it.

use super::{Braking, Dynamics, Term};
use crate::baselines::{Card, Layout};
use crate::robot::Robot;

/// Three omni wheels in the source; nothing but R knows of them.
///
/// The power is integrated with its sign, as the minimum-energy trajectories of the source do.
pub const KIM: Card = Card {
    name: "kim",
    source: "Kim and Kim 2012, 2017: dynamics of robot and DC motor, viscous friction and armature loss",
    assumes: "level ground; one mass; no Coulomb friction; braking power returns to the battery",
    takes_mass: false,
    network: false,
    needs: &[],
    layouts: &[],
    make: |_| Box::new(Dynamics::new("kim", &KIM_TERMS, Braking::Regenerates)),
};

const KIM_TERMS: [Term; 3] = [Term::Viscous, Term::Rotor, Term::Body];

/// The only one of them with the payload as a variable: it bears on rolling friction and on the inertia of the body.
///
/// The radius of gyration stays when the payload changes, as everywhere in this project.
pub const JARAMILLO: Card = Card {
    name: "jaramillo",
    source: "Jaramillo-Morales 2019, 2020: dynamics of robot and DC motor, variable acceleration and payload",
    assumes: "level ground; the payload is known",
    takes_mass: true,
    network: false,
    needs: &[],
    layouts: &[],
    make: |robot| Box::new(Dynamics::new("jaramillo", &JARAMILLO_TERMS, as_driven(robot))),
};

const JARAMILLO_TERMS: [Term; 5] =
    [Term::Coulomb, Term::Rolling, Term::Viscous, Term::Rotor, Term::LoadedBody];

/// A simulation in the source, with power regeneration allowed.
pub const MORALES: Card = Card {
    name: "morales",
    source: "Morales and Mendoza 2018: mixed energy model, dynamics of robot and DC motor",
    assumes: "level ground; one mass; braking power returns to the battery",
    takes_mass: false,
    network: false,
    needs: &[],
    layouts: &[],
    make: |_| Box::new(Dynamics::new("morales", &MORALES_TERMS, Braking::Regenerates)),
};

const MORALES_TERMS: [Term; 4] = [Term::Coulomb, Term::Viscous, Term::Rotor, Term::Body];

/// Straight ahead on a road of given grade; level where a log does not tell.
///
/// The speeds of the wheels stay their own, so that a turn costs friction, but no inertia. For robots whose wheels all
/// turn forwards when it drives ahead.
pub const YACOUB: Card = Card {
    name: "yacoub",
    source: "Yacoub, Necsulescu and Sasiadek 2013: dynamics of robot and DC motor, straight on a road grade",
    assumes: "straight driving; one mass; the grade is known, or the road is level",
    takes_mass: false,
    network: false,
    needs: &[],
    layouts: &[Layout::Differential, Layout::SkidSteer],
    make: |robot| Box::new(Dynamics::new("yacoub", &YACOUB_TERMS, as_driven(robot))),
};

const YACOUB_TERMS: [Term; 4] = [Term::Coulomb, Term::Viscous, Term::Straight, Term::Grade];

/// For paths that a local planner predicts at one v and one ω each: no accelerations, so no power below 0 either.
pub const YAO: Card = Card {
    name: "yao",
    source: "Yao 2024: dynamics of robot and DC motor at constant v and ω",
    assumes: "level ground; one mass; no acceleration",
    takes_mass: false,
    network: false,
    needs: &[],
    layouts: &[],
    make: |_| Box::new(Dynamics::new("yao", &YAO_TERMS, Braking::Regenerates)),
};

const YAO_TERMS: [Term; 2] = [Term::Coulomb, Term::Viscous];

fn as_driven(robot: &Robot) -> Braking {
    if robot.regeneration() { Braking::Regenerates } else { Braking::Dissipates }
}
