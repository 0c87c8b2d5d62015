//! Changes of a physics engine's model of the robot that give it the named effects: MuJoCo's MJCF,
//! or Gazebo's SDF.
//!
//! Joints, contacts, bodies and gravity are elements of the engine. Power, and what measures it,
//! are not: their changes are formulas for whatever computes the power beside the engine.

use std::fmt::Write as _;

use answers::export::joints::Language;
use logs::robot::Robot;
use model::effects::{Detail, find};
use model_core::effects::GRAVITY;
use numerics::robust::NORMAL_95;
use serde::Serialize;

use crate::report::Report;
use crate::words;
use residuals::types::Named;

/// One change of the model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Change {
    /// The effect.
    pub effect: String,
    /// Element and attribute, or element, of the engine's file; null where the engine has none.
    pub element: Option<String>,
    /// Of which part of the robot or the world.
    pub part: String,
    /// What to do with the number that is there: `add`, or the formula of a power.
    pub change: String,
    /// By how much.
    pub value: f64,
    /// Its 95 % interval.
    pub interval: [f64; 2],
    /// Its unit.
    pub unit: String,
    /// What else to mind.
    pub note: String,
}

/// All changes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Changes {
    /// `mjcf` or `sdf`.
    pub language: Language,
    /// One an element.
    pub changes: Vec<Change>,
}

/// What of the robot the changes need.
struct Scene {
    radius_m: Option<f64>,
    /// Usual total mass, kg.
    mass_kg: f64,
    wheels: usize,
    /// Torque at the supply per torque at the wheel: the drive's losses, as the base has them.
    gain: f64,
    language: Language,
}

impl Changes {
    /// Of the effects that a report names, for a robot of usually this total mass, kg.
    pub fn of(report: &Report, robot: &Robot, mass_kg: f64, language: Language) -> Self {
        let gain = report.base[0].load_gain();
        let gain = if gain > 0.0 { gain } else { 1.0 };
        let scene =
            Scene { radius_m: robot.wheel_radius_m(), mass_kg, wheels: robot.wheels(), gain, language };
        Self { language, changes: report.effects.iter().flat_map(|named| changes(named, &scene)).collect() }
    }

    /// For people, and for whoever edits the file: a comment with a line a change.
    pub fn text(&self, robot: &Robot) -> String {
        let name = match self.language {
            Language::Mjcf => "MuJoCo (MJCF)",
            Language::Sdf => "Gazebo (SDF)",
        };
        let mut text = format!(
            "<!-- {}: what this {name} model lacks, with 95 % intervals.\n",
            robot.name().replace("--", "-")
        );
        for change in &self.changes {
            let Change { effect, element, part, change: how, value, interval: [low, high], unit, note } =
                change;
            let element = element.as_deref().unwrap_or("no element of the engine");
            let unit = if unit == "1" { "" } else { unit };
            // Writing to a String cannot fail.
            let _ = writeln!(
                text,
                "  {effect}: {part}: {element}: {how} {value:.6} ({low:.6} to {high:.6}) {unit}"
            );
            if !note.is_empty() {
                let _ = writeln!(text, "    {note}");
            }
        }
        if self.changes.is_empty() {
            text.push_str("  nothing was named\n");
        }
        text.push_str("-->\n");
        text
    }
}

fn changes(named: &Named, scene: &Scene) -> Vec<Change> {
    let (coefficient, coefficient_err) = words::headline(named);
    let (value, error, unit) = match &named.physical {
        Some(physical) => (physical.value, physical.std_err, physical.unit.clone()),
        None => (coefficient, coefficient_err, named.candidate.unit.clone()),
    };
    let change = |element: Option<&str>, part: &str, how: &str, factor: f64, unit: &str, note: &str| {
        let (value, error) = (value * factor, NORMAL_95 * error * factor.abs());
        Change {
            effect: named.candidate.id.clone(),
            element: element.map(str::to_owned),
            part: part.to_owned(),
            change: how.to_owned(),
            value,
            interval: [value - error, value + error],
            unit: unit.to_owned(),
            note: note.to_owned(),
        }
    };
    let mjcf = scene.language == Language::Mjcf;
    let by_language = |mujoco: &'static str, gazebo: &'static str| Some(if mjcf { mujoco } else { gazebo });
    let friction = by_language("joint/@frictionloss", "joint/axis/dynamics/friction");
    let damping = by_language("joint/@damping", "joint/axis/dynamics/damping");
    let one = match named.candidate.id.as_str() {
        "wheel-drag" => {
            let part = named.candidate.detail.words();
            change(friction, &part, "add", 1.0, "N·m", "")
        }
        // As seen by the supply: it includes the drive's losses, like the base.
        "viscous-change" => change(damping, "each wheel's joint", "add", 1.0 / scene.gain, "N·m·s/rad", ""),
        "rolling-resistance-change" => match (mjcf, scene.radius_m) {
            (true, Some(radius)) => change(
                Some("geom/@friction[2]"),
                "wheels, or their contact pairs",
                "add",
                radius,
                "m",
                "rolling friction needs condim=\"6\"; a robot on casters rolls on less than its weight",
            ),
            (false, Some(radius)) => change(
                friction,
                "each wheel's joint",
                "add",
                scene.mass_kg * GRAVITY * radius / scene.wheels as f64,
                "N·m",
                "as friction of the joint at the runs' mean mass: ODE and DART have no rolling friction",
            ),
            (_, None) => change(None, "the floor", "friction coefficient of rolling, add", 1.0, "1", ""),
        },
        "turning-scrub" => {
            // M = μ_spin Σ N: a moment about the centre, as the torsional friction of all contacts.
            let per_weight = match named.candidate.detail {
                Detail::DependsOnMass(true) | Detail::Sliding { .. } | Detail::WithHalfSlip => 1.0 / GRAVITY,
                _ => 1.0 / (GRAVITY * scene.mass_kg),
            };
            let note = "a moment against turning, as torsional friction of all contacts; skid-steered robots have it from sliding friction \
                        as well: there raise friction[0] until a spin draws as much";
            if mjcf {
                change(
                    Some("geom/@friction[1]"),
                    "wheels, or their contact pairs",
                    "add",
                    per_weight,
                    "m",
                    note,
                )
            } else {
                let note = "times the contact's patch_radius and 3π/16; or slide's mu where the robot skids";
                let element = "collision/surface/friction/torsional/coefficient";
                change(Some(element), "wheels", "add (over patch_radius)", per_weight, "m", note)
            }
        }
        "payload-offset" if unit == "m" => change(
            by_language("body/inertial/@pos[1]", "link/inertial/pose[1]"),
            "the payload's body",
            "add",
            -1.0,
            "m",
            "to the left is positive",
        ),
        "grade" if unit == "rad" => {
            let towards = words::direction(named).map(|heading| {
                format!("uphill towards {:.1}° from the heading at the start", heading.to_degrees())
            });
            let note = "gravity = −9.80665 (sin φ cos h, sin φ sin h, cos φ), h the heading of the rise";
            let element = by_language("option/@gravity", "world/gravity");
            change(
                element,
                &towards.unwrap_or_else(|| "uphill ahead".to_owned()),
                "tilt by",
                1.0,
                "rad",
                note,
            )
        }
        _ => {
            let part = find(&named.candidate.id).map_or("", |entry| entry.meaning);
            let how = match named.candidate.steps_half_slip() {
                true => "slip at which half of the turn's friction is there, from a time on, times 1 +",
                false => formula(&named.candidate.id),
            };
            change(None, part, how, 1.0, &unit, &named.candidate.detail.words())
        }
    };
    vec![one]
}

/// How an effect changes the power; x is its size.
fn formula(id: &str) -> &'static str {
    match id {
        "winding-temperature" => "P + x/K · 0.0039 κτ² with x =",
        "windage" => "P + x |w|³ of each wheel with x =",
        "stribeck" => "friction torque x exp(−(w/w_s)²) of each wheel with x =",
        "lubricant-warm-up" => "P + x w² exp(−t/T) of each wheel with x =",
        "surface-switch" => "rolling friction coefficient from a time on, add",
        "gear-load-loss" => "the gear's efficiency falls per N·m by",
        "supply-sag" => "P + x P² with x =",
        "regeneration" => "of braking power comes back a share of",
        "payload-mislabel" => "the payload's mass in some runs, add",
        "static-step" | "sensor-offset" => "P +",
        "compute-load" => "P + x times the processor's load with x =",
        "sensor-gain" => "P (1 + x) with x =",
        "sensor-delay" => "P later by",
        "speed-scale" => "wheel radius, or the encoder's scale, times 1 + x with x =",
        _ => "P + x times its formula with x =",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::example::report;
    use residuals::types::Verdict;

    /// Every effect of the dictionary has an element or a formula, and a finite number either way.
    #[test]
    fn what_is_named_can_be_written_down() {
        let robot = Robot::named("burger").unwrap();
        for language in [Language::Mjcf, Language::Sdf] {
            let changes = Changes::of(&report(Verdict::Named), &robot, 1.5, language);
            assert_eq!(changes.changes.len(), report(Verdict::Named).effects.len());
            for change in &changes.changes {
                assert!(change.value.is_finite() && change.interval[0] <= change.value, "{change:?}");
                assert!(!change.change.is_empty(), "{change:?}");
            }
            let text = changes.text(&robot);
            assert!(text.starts_with("<!--") && text.trim_end().ends_with("-->"), "{text}");
            assert!(!text[4..text.len() - 4].contains("--"), "no comment within a comment: {text}");
        }
    }
}
