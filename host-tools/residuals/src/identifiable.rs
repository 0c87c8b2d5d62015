//! Effects that a base cannot distinguish from its own parameters.

use logs::runs::Runs;
use model::effects::{Candidate, NotTestable};

use super::thresholds::problem::ONE_MASS;
use super::types::{Round, Scored, Status};

/// Effects that cannot be identified with a base fitted to these total masses, kg; to those of the
/// runs where there are none.
///
/// With one mass, friction that grows with mass cannot be distinguished from friction that does
/// not. The effect of a kilogram is then a guess, and a wrong mass explains any difference (−58.7
/// kg was ice).
pub fn unidentifiable(masses_kg: &[f64], runs: &Runs) -> Vec<NotTestable> {
    if !has_one_mass(masses_kg, runs) {
        return Vec::new();
    }
    let reason = "unidentifiable here: the base was fitted at one total mass, and does not know what a kilogram more does to the power; \
                  record clean runs with another payload, and fit again";
    vec![NotTestable { id: "payload-mislabel".to_owned(), reason: reason.to_owned() }]
}

/// Ids of effects that the names may stand for as well with a base of one mass, if they were
/// plausible in these rounds. More friction on one side is a drag, or another floor that the sides
/// meet unequally: only a second payload distinguishes them.
pub fn also_with_one_mass(named: &[Candidate], rounds: &[Round]) -> Vec<String> {
    let floor = "rolling-resistance-change";
    let is_plausible = |scored: &Scored| {
        scored.id == floor && scored.gain > 0.0 && matches!(scored.status, Status::Worse | Status::Tie)
    };
    let drags = named.iter().any(|effect| effect.id == "wheel-drag");
    let could_be = rounds.iter().flat_map(|round| &round.candidates).any(is_plausible);
    if drags && could_be { vec![floor.to_owned()] } else { Vec::new() }
}

/// Whether a base that was fitted to these total masses, kg, or to those of the runs where there
/// are none, knows one mass only.
pub fn has_one_mass(masses_kg: &[f64], runs: &Runs) -> bool {
    let of_runs: Vec<f64> = runs.runs.iter().flat_map(|run| &run.rows).map(|row| row.mass).collect();
    let known = if masses_kg.is_empty() { &of_runs } else { masses_kg };
    let (low, high) =
        known.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), mass| (low.min(*mass), high.max(*mass)));
    high - low <= ONE_MASS * high
}

#[cfg(test)]
mod tests {
    use logs::robot::Robot;
    use logs::runs::{RawRun, Runs};
    use model::effects::Detail;
    use model_core::estimator::Sample;

    use super::{also_with_one_mass, unidentifiable};
    use crate::problem::example::candidate;
    use crate::types::{Round, Scored, Status};

    fn runs(masses: [f64; 2]) -> Runs {
        let burger = Robot::named("burger").unwrap().chassis(2.0).unwrap();
        let raw = masses.map(|mass| {
            let sample = Sample { wheel_speed: [3.0, 2.0], wheel_acceleration: None, power: 1.0 };
            let rows = (0..400).map(|i| (0.05 * f64::from(i), sample.into(), mass, Vec::new())).collect();
            RawRun { name: "run".to_owned(), rows, columns: Vec::new(), period_s: 0.05 }
        });
        Runs::condition(&burger, raw.into()).unwrap()
    }

    /// By the masses of the base's fit; where they are not known, by the runs' own.
    #[test]
    fn a_base_of_one_mass_finds_no_wrong_one() {
        let ids = |base: &[f64], field| {
            let effects = unidentifiable(base, &runs(field));
            effects.into_iter().map(|missing| missing.id).collect::<Vec<_>>()
        };
        assert_eq!(ids(&[75.0], [75.0, 90.0]), ["payload-mislabel"]);
        assert_eq!(ids(&[75.0, 76.0], [75.0, 90.0]), ["payload-mislabel"]);
        assert!(ids(&[1.0, 6.0], [2.0, 2.0]).is_empty());
        assert_eq!(ids(&[], [2.0, 2.0]), ["payload-mislabel"]);
        assert!(ids(&[], [2.0, 3.0]).is_empty());
    }

    /// A Husky on sand, with a base of 75 kg on tiles: a drag on one side gains 443, another floor
    /// 347.
    #[test]
    fn with_one_mass_a_drag_may_be_a_floor() {
        let floor = |gain, status| Round {
            structure: 17.4,
            allowed: 5.3,
            candidates: vec![Scored {
                id: "rolling-resistance-change".to_owned(),
                detail: Detail::Plain,
                gain,
                coefficients: vec![0.05],
                status,
            }],
            outcome: String::new(),
        };
        let named = |id: &str| vec![candidate(id, Vec::new(), (0.0, 1.0))];
        let drag = named("wheel-drag");
        assert_eq!(also_with_one_mass(&drag, &[floor(347.0, Status::Worse)]), ["rolling-resistance-change"]);
        assert!(also_with_one_mass(&drag, &[floor(347.0, Status::Implausible)]).is_empty());
        assert!(also_with_one_mass(&drag, &[floor(-2.0, Status::Worse)]).is_empty());
        assert!(also_with_one_mass(&named("windage"), &[floor(347.0, Status::Worse)]).is_empty());
    }
}
