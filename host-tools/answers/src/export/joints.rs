//! Wheel joints of Gazebo (SDF) and MuJoCo (MJCF): friction, damping and armature of a fit.

use std::fmt::Write as _;

use logs::robot::Robot;
use model::coefficients::FittedModel;
use model_core::model::Model;
use serde::Serialize;
use support::error::{Error, Result};

use super::{Lost, drives_lost};

/// Which program's words.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Language {
    /// Gazebo.
    Sdf,
    /// MuJoCo.
    Mjcf,
}

/// What a wheel's joint has.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Export {
    /// Version of this object.
    pub version: u32,
    /// The robot.
    pub robot: String,
    /// Total mass that the friction is for, kg.
    pub mass_kg: f64,
    /// Wheels whose joints these are: the log's columns.
    pub wheels: usize,
    /// Torque against any motion, N·m: Coulomb's and the rolling resistance at this mass.
    pub friction_nm: f64,
    /// N·m·s/rad
    pub damping_nm_s_rad: f64,
    /// Inertia of rotor and gear at the wheel, kg·m².
    pub armature_kg_m2: f64,
    /// What the engines have no word for.
    pub lost: Vec<Lost>,
}

/// The joints of a fit at a mass, kg.
///
/// # Errors
/// Eq. 18 has no torques.
pub fn export(robot: &Robot, coefficients: &FittedModel, mass_kg: f64) -> Result<Export> {
    let Model::Signed { torque, .. } = &coefficients.model else {
        let message = "model eq18 has powers, no torques; expected coefficients of gmr fit --model signed";
        return Err(Error::failed(message));
    };
    // What the supply pays for: a gear with a loss of its own passes less.
    let rolling = torque.supplied_rolling();
    let mut lost = vec![
        Lost {
            what: "rolling resistance",
            so: format!(
                "{:.5} N·m/kg of it are in the friction at {mass_kg} kg: another payload needs another file",
                rolling
            ),
        },
        Lost {
            what: "inertia_gain",
            so: format!(
                "{:.3}: the fit's torques are what the supply pays for; where that is above 1 the gear wastes the difference, and the joint's \
                 own torques are smaller by it",
                torque.load_gain()
            ),
        },
    ];
    lost.extend(drives_lost(coefficients));
    Ok(Export {
        version: 1,
        robot: robot.name().to_owned(),
        mass_kg,
        wheels: coefficients.robot.wheels(),
        friction_nm: torque.supplied_coulomb() + rolling * mass_kg,
        damping_nm_s_rad: torque.supplied_viscous(),
        armature_kg_m2: torque.rotor_inertia,
        lost,
    })
}

impl Export {
    /// A fragment for the robot's file.
    pub fn text(&self, language: Language) -> String {
        let Self { friction_nm, damping_nm_s_rad, armature_kg_m2, .. } = self;
        let mut text = format!(
            "<!-- {}: from a fit, at {} kg; for each of {} wheel joints.\n",
            self.robot.replace("--", "-"),
            self.mass_kg,
            self.wheels
        );
        text.push_str("     What the engine cannot express:\n");
        for Lost { what, so } in &self.lost {
            // Writing to a String cannot fail.
            let _ = writeln!(text, "     {what}: {so}");
        }
        if language == Language::Sdf {
            let _ = writeln!(
                text,
                "     rotor inertia: SDF's joints have none; add {armature_kg_m2:.3e} kg m² to the wheel's inertia about its axle"
            );
        }
        text.push_str("-->\n");
        let _ = match language {
            Language::Sdf => write!(
                text,
                "<axis>\n  <dynamics>\n    <friction>{friction_nm:.6}</friction>\n    <damping>{damping_nm_s_rad:.6}</damping>\n  </dynamics>\n</axis>\n"
            ),
            Language::Mjcf => writeln!(
                text,
                "<default class=\"wheel\">\n  <joint frictionloss=\"{friction_nm:.6}\" damping=\"{damping_nm_s_rad:.6}\" armature=\"{armature_kg_m2:.3e}\"/>\n</default>"
            ),
        };
        text
    }
}
