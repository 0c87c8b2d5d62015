//! The sizes of runs and base by which effects say what can show and what is plausible.

use logs::robot::chassis::Together;
use logs::runs::Runs;
use model::effects::{self, Candidate, NotTestable, Scope, ScopeColumn};
use model_core::torque::Drive;

use super::identifiable::{has_one_mass, unidentifiable};
use super::types::{Base, Options};

/// Effects that may show in some runs, and those that cannot.
#[derive(Debug, Clone)]
pub struct Testable {
    /// Those that may, the user's own included.
    pub list: Vec<Candidate>,
    /// Ids of those that are not asked for.
    pub removed: Vec<String>,
    /// Those that cannot.
    pub not_testable: Vec<NotTestable>,
}

impl Testable {
    /// In `shown` of all `runs`.
    pub fn of(shown: &Runs, runs: &Runs, base: &Base, options: &Options) -> Self {
        let (mut list, mut not_testable) = effects::candidates(&scope(shown, base));
        list.extend_from_slice(&options.user.candidates);
        not_testable.extend_from_slice(&options.user.not_testable);
        let mut removed = options.removed.clone();
        for missing in unidentifiable(&base.masses_kg, runs) {
            removed.push(missing.id.clone());
            not_testable.push(missing);
        }
        list.retain(|candidate| !removed.contains(&candidate.id));
        Self { list, removed, not_testable }
    }
}

fn scope(runs: &Runs, known: &Base) -> Scope {
    let base = &known.torque;
    let rows = || runs.runs.iter().flat_map(|run| &run.rows);
    let mut speeds: Vec<f64> = rows()
        .flat_map(|row| row.wheels.iter().map(|wheel| wheel.speed.abs()))
        .filter(|speed| *speed > 0.0)
        .collect();
    let rank = speeds.len() * 95 / 100;
    let speed = match speeds.len() {
        0 => 1.0,
        _ => *speeds.select_nth_unstable_by(rank, f64::total_cmp).1,
    };
    let count = rows().count().max(1) as f64;
    let mass = rows().map(|row| row.mass).sum::<f64>() / count;
    let moving: Vec<f64> = rows().filter(|row| row.wheels.is_moving()).map(|row| row.power.abs()).collect();
    let torque = (base.supplied_coulomb() + base.supplied_rolling() * mass + base.supplied_viscous() * speed)
        * (1.0 + f64::EPSILON);
    let last = runs.runs.iter().filter_map(|run| run.rows.last());
    let column = |name: &String| {
        let place = runs.column(name)?;
        let values = runs.runs.iter().flat_map(|run| run.extra(place).iter().copied());
        Some(ScopeColumn { name: name.clone(), place, least: values.fold(f64::INFINITY, f64::min) })
    };
    Scope {
        base: *base,
        regenerative: known.drive == Drive::Regenerative,
        one_mass: has_one_mass(&known.masses_kg, runs),
        scrubs: runs.robot.scrubs(),
        slips: !runs.robot.conditioning().slip.is_off(),
        static_power: runs.robot.static_power(),
        sides: runs.robot.sides(),
        columns: runs.columns.iter().filter_map(column).collect(),
        speed,
        torque: torque.max(1e-6),
        mass,
        empty: runs.robot.range().no_load(),
        lightest: rows().map(|row| row.mass).fold(f64::INFINITY, f64::min),
        duration: last.map(|row| row.time).fold(1.0, f64::max),
        power: moving.iter().sum::<f64>() / moving.len().max(1) as f64,
    }
}
