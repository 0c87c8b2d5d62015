//! One wheel that drags: a dry torque at it.

use model_core::effects::{Cause, Term};
use support::error;

use super::candidate::Way;
use super::detail::{Detail, WheelSide};
use super::entry::Entry;
use super::fields::{Fields, Read};
use super::key;
use super::physical::Conversion;
use super::plant::{Finding, PlantCause};
use super::regressor::Regressor;
use super::scope::Scope;
use super::sign::Sign;

pub(super) const WHEEL_DRAG: Entry = Entry {
    id: "wheel-drag",
    meaning: "one wheel drags: brake, hair or bearing",
    unit: "N·m",
    sign: Sign::Positive,
    needs: "",
    single_runs: false,
    shows_in: "spin left and right on the spot, empty and fully loaded",
    typical: &["wheel-drag=0.03"],
    physical: |_| Some(Conversion::of_torque("N·m")),
    candidates,
    owns: |cause| matches!(cause, Cause::Term(Term::Drag(_))),
    read,
    cause,
};

fn candidates(scope: &Scope) -> Result<Vec<Way>, String> {
    let way = |(wheel, side): (usize, &f64)| {
        let regressor = Regressor::Term(Term::Drag(wheel as u8));
        let detail = Detail::Wheel { wheel: wheel + 1, side: WheelSide::of(*side) };
        Way::new(regressor, (0.0, scope.much())).with(detail)
    };
    Ok(scope.sides.iter().enumerate().map(way).collect())
}

fn read(fields: &Fields<'_>) -> Read {
    match fields.number(key::WHEEL)? {
        wheel if (1.0..=255.0).contains(&wheel) && wheel.fract() == 0.0 => {
            fields.term(Term::Drag(wheel as u8 - 1))
        }
        wheel => Err((key::WHEEL, format!("wheel {wheel}; expected 1, 2, …"))),
    }
}

fn cause(finding: &Finding<'_>) -> error::Result<Result<PlantCause, String>> {
    finding.acting(|effect| match finding.candidate.detail {
        Detail::Wheel { wheel, .. } => effect.with("wheel", wheel as f64),
        _ => Ok(effect),
    })
}
