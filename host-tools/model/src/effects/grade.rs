//! A road that slopes: gravity along the way, by a measured pitch, ahead, or in a direction of the
//! world.

use model_core::effects::{Cause, Term};
use support::error;

use super::candidate::Way;
use super::column::PITCH;
use super::detail::{Along, Detail};
use super::entry::Entry;
use super::fields::{Fields, Read};
use super::key;
use super::physical::{Conversion, World};
use super::plant::{Finding, PlantCause};
use super::regressor::Regressor;
use super::scope::Scope;
use super::sign::Sign;

pub(super) const GRADE: Entry = Entry {
    id: "grade",
    meaning: "the road slopes: gravity pulls along the way",
    unit: "1",
    sign: Sign::Either,
    needs: "",
    single_runs: false,
    shows_in: "drive the same way there and back, or log pitch_rad",
    typical: &["grade=0.03", "grade=0.03:along=travel"],
    physical: |detail| Some(slope(detail)),
    candidates,
    owns: |cause| matches!(cause, Cause::Term(Term::GradeByPitch | Term::GradeAhead | Term::GradeAlong(_))),
    read,
    cause,
};

/// Gravity along the way is the weight times the sine of the slope; by a measured pitch the
/// coefficient says how much of it there is.
fn slope(detail: &Detail) -> Conversion {
    if *detail == Detail::Slope(Along::Pitch) {
        return Conversion::of_torque("1");
    }
    let of = |coefficient: f64, world: &World| {
        let sine = coefficient / world.torque.load_gain();
        (sine.abs() < 1.0).then(|| sine.asin())
    };
    Conversion { unit: "rad", of }
}

/// A slope of 0.35 rad is a steep ramp; drives pass a third of the torque at worst.
const STEEP: f64 = 0.35 * 3.0;

/// Gravity's share that the drive may feel of a measured pitch: losses, and a mass or a pitch that
/// is somewhat off.
const BY_PITCH: (f64, f64) = (0.2, 5.0);

fn candidates(scope: &Scope) -> Result<Vec<Way>, String> {
    if scope.column(PITCH).is_some() {
        let by = Way::new(Regressor::Term(Term::GradeByPitch), BY_PITCH);
        return Ok(vec![by.with(Detail::Slope(Along::Pitch))]);
    }
    let range = (-STEEP, STEEP);
    let ahead = Way::new(Regressor::Term(Term::GradeAhead), range);
    let axes = [[1.0, 0.0], [0.0, 1.0]].map(|axis| Regressor::Term(Term::GradeAlong(axis)));
    Ok(vec![
        ahead.with(Detail::Slope(Along::Ahead)),
        Way::of_several(axes.into(), range).with(Detail::Slope(Along::World)),
    ])
}

fn read(fields: &Fields<'_>) -> Read {
    let (ahead, world) = (Along::Ahead.name(), Along::World.name());
    match (fields.text(key::BY), fields.text(key::ALONG)) {
        (Some(PITCH), None) => fields.term(Term::GradeByPitch),
        (None, Some(along)) if along == ahead => fields.term(Term::GradeAhead),
        (None, Some(along)) if along == world => {
            let both = fields.list(key::COEFFICIENTS);
            let Some([along, across]) = both.as_deref() else {
                let expected =
                    format!("grade along {world}; expected coefficients = [along, across] in `detail`");
                return Err((key::COEFFICIENTS, expected));
            };
            let column = |axis, coefficient: &f64| (Cause::Term(Term::GradeAlong(axis)), *coefficient);
            Ok(vec![column([1.0, 0.0], along), column([0.0, 1.0], across)])
        }
        _ => fields.unclear(&format!("by = {PITCH:?}, along = {ahead:?} or along = {world:?}")),
    }
}

/// The plant's slopes are constant ones: ahead, or towards a heading.
fn cause(finding: &Finding<'_>) -> error::Result<Result<PlantCause, String>> {
    match (&finding.candidate.detail, finding.coefficients) {
        (Detail::Slope(Along::Pitch), _) => {
            Ok(Err("the slope was measured along the way; the plant has constant ones".to_owned()))
        }
        (_, [x, y]) => {
            let cause = finding.acting(|effect| effect.with("heading", y.atan2(*x)))?;
            Ok(cause.map(|cause| PlantCause { range: (0.0, cause.range.1), ..cause }))
        }
        _ => finding.acting(|effect| effect.with("along", 1.0)),
    }
}
