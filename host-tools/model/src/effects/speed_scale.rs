//! Encoders that show more or less than there is: wheel radius or scale.

use model_core::effects::{Cause, Side};
use support::error;

use super::candidate::Way;
use super::detail::{Detail, WheelSide};
use super::entry::Entry;
use super::fields::{Fields, Read};
use super::key;
use super::plant::{Finding, PlantCause};
use super::regressor::Regressor;
use super::scope::Scope;
use super::sign::Sign;

pub(super) const SPEED_SCALE: Entry = Entry {
    id: "speed-scale",
    meaning: "wheel radius or encoder scale is off",
    unit: "1",
    sign: Sign::Either,
    needs: "",
    single_runs: false,
    shows_in: "measure the way of a straight drive and the angle of ten spins",
    typical: &["speed-scale=0.05"],
    physical: |_| None,
    candidates,
    owns: |cause| matches!(cause, Cause::Scale(_)),
    read,
    cause,
};

/// From half the speed to twice.
const RANGE: (f64, f64) = (-0.5, 1.0);

fn candidates(scope: &Scope) -> Result<Vec<Way>, String> {
    let sides: &[(WheelSide, f64)] = if scope.has_sides() {
        &[(WheelSide::Left, -1.0), (WheelSide::Right, 1.0), (WheelSide::Both, 0.0)]
    } else {
        &[(WheelSide::Both, 0.0)]
    };
    let way =
        |(name, side): &(WheelSide, f64)| Way::new(Regressor::Scale(*side), RANGE).with(Detail::Side(*name));
    Ok(sides.iter().map(way).collect())
}

fn read(fields: &Fields<'_>) -> Read {
    match fields.text(key::SIDE) {
        Some("left") => fields.one(Cause::Scale(Side::Left)),
        Some("right") => fields.one(Cause::Scale(Side::Right)),
        Some("both") => fields.one(Cause::Scale(Side::Both)),
        _ => fields.unclear("side = \"left\", \"right\" or \"both\""),
    }
}

/// The plant's option for the right side.
const RIGHT: f64 = 1.0;

fn cause(finding: &Finding<'_>) -> error::Result<Result<PlantCause, String>> {
    match finding.candidate.detail {
        Detail::Side(WheelSide::Both) => {
            finding.acting_each(|effect| Ok(vec![effect.clone().with("side", RIGHT)?, effect]))
        }
        Detail::Side(WheelSide::Right) => finding.acting(|effect| effect.with("side", RIGHT)),
        _ => finding.everywhere(),
    }
}
