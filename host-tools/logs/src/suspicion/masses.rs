//! Masses in a different unit, of the payload alone, twice too large; and rows without any.

use super::doubt::{Kind, Suspicion};
use crate::robot::{MassUnit, Robot};

/// Scales and data sheets differ by this share.
const SPREAD: f64 = 0.1;

/// A share of rows without a mass that is more than a stray field.
const STRAY: f64 = 1e-3;

/// The masses of a log.
#[derive(Debug, Default)]
pub(super) struct Masses {
    told: u64,
    untold: u64,
    range: Option<(f64, f64)>,
}

impl Masses {
    pub(super) fn add(&mut self, mass_kg: f64) {
        if !mass_kg.is_finite() {
            self.untold += 1;
            return;
        }
        self.told += 1;
        let (least, most) = self.range.unwrap_or((mass_kg, mass_kg));
        self.range = Some((least.min(mass_kg), most.max(mass_kg)));
    }

    pub(super) fn suspicions(&self, robot: &Robot) -> Vec<Suspicion> {
        let mut suspicions = Vec::new();
        if let Some((least, most)) = self.range {
            suspicions.extend(of_range(robot, least, most));
            let share = self.untold as f64 / (self.told + self.untold) as f64;
            if share > STRAY {
                suspicions.push(Suspicion {
                    kind: Kind::Unlabelled,
                    text: format!("mass_kg is empty in {:.1} % of the rows", 100.0 * share),
                    remedy: "write the total mass into every row of a training log, or leave those rows out"
                        .to_owned(),
                });
            }
        }
        suspicions
    }
}

fn of_range(robot: &Robot, least: f64, most: f64) -> Option<Suspicion> {
    let (empty, full) = (robot.mass_no_load_kg(), robot.mass_full_load_kg());
    let fits =
        |factor: f64| factor * least >= empty * (1.0 - SPREAD) && factor * most <= full * (1.0 + SPREAD);
    if fits(1.0) {
        return None;
    }
    let masses = if least == most { format!("{least} kg") } else { format!("{least} to {most} kg") };
    let text = format!("mass_kg is {masses}, but robot.toml has {empty} to {full} kg for {}", robot.name());
    let (text, remedy) = if fits(MassUnit::Gram.in_kg()) {
        (format!("{text}: the masses look like grams"), "read them with --mass-unit g")
    } else if most <= (full - empty) * (1.0 + SPREAD) && least < empty {
        (
            format!("{text}: this looks like the payload alone"),
            "write the total mass, the robot and what it carries, or correct mass_no_load_kg",
        )
    } else if fits(0.5) {
        (
            format!("{text}: twice what it can be?"),
            "write the total mass, the robot and what it carries once, or correct mass_full_load_kg",
        )
    } else if fits(MassUnit::Pound.in_kg()) {
        (format!("{text}: the masses look like pounds"), "read them with --mass-unit lb")
    } else {
        (text, "correct the masses, or mass_no_load_kg and mass_full_load_kg in robot.toml")
    };
    Some(Suspicion { kind: Kind::Mass, text, remedy: remedy.to_owned() })
}
