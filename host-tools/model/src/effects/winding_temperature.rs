//! Hot copper: the winding loss is greater, by measured temperatures, by its own heat, with time,
//! or throughout.

use model_core::effects::{Cause, Term};
use support::error;

use super::candidate::Way;
use super::column::temperature;
use super::detail::{BY_TIME, Detail, FROM_START, Heated};
use super::entry::Entry;
use super::fields::{Fields, Read};
use super::key;
use super::physical::Conversion;
use super::plant::{Finding, PlantCause};
use super::regressor::Regressor;
use super::scope::{Scope, ScopeColumn};
use super::sign::Sign;

pub(super) const WINDING_TEMPERATURE: Entry = Entry {
    id: "winding-temperature",
    meaning: "copper heats, and its resistance rises",
    unit: "1",
    sign: Sign::Positive,
    needs: "",
    single_runs: false,
    shows_in: "work the motors hard for minutes, or log motor1_temp_c …",
    typical: &["winding-temperature=60:loss=0.05"],
    physical: |detail| {
        matches!(detail, Detail::Heated(Heated::FromStart | Heated::WithTime(_))).then_some(RISE)
    },
    candidates,
    owns: |cause| {
        matches!(
            cause,
            Cause::Hot
                | Cause::Heat(_)
                | Cause::Warming(_)
                | Cause::Temperature(_)
                | Cause::Term(Term::Winding)
        )
    },
    read,
    cause,
};

/// Temperature coefficient of copper's resistance at 20 °C, 1/K (IEC 60028).
const COPPER_PER_K: f64 = 0.0039;

/// A share of the winding loss as the rise of copper's temperature.
const RISE: Conversion = Conversion { unit: "K", of: |coefficient, _| Some(coefficient / COPPER_PER_K) };

/// Time constants that are tried, as shares of the longest run; the best is searched between them.
const TIMES: [f64; 3] = [0.15, 0.5, 1.5];

/// Most that a kelvin adds: five times copper's.
const MOST_PER_K: f64 = 0.02;

/// Most that a winding's resistance rises, as a share: copper some 250 K warmer, which no enamel
/// survives.
const MOST_RISE: f64 = 1.0;

fn candidates(scope: &Scope) -> Result<Vec<Way>, String> {
    let columns = |wheel: usize| scope.column(&temperature(wheel + 1));
    let columns: Option<Vec<&ScopeColumn>> = (0..scope.sides.len()).map(columns).collect();
    if let Some(columns) = columns
        && columns.windows(2).all(|pair| pair[1].place == pair[0].place + 1)
        && let Some(first) = columns.first()
    {
        let coldest = columns.iter().map(|column| column.least).fold(f64::INFINITY, f64::min);
        let measured = Way::new(Regressor::Temperature(first.place, coldest), (0.0, MOST_PER_K));
        return Ok(vec![measured.with(Detail::Heated(Heated::Measured(coldest)))]);
    }
    let hot = Way::new(Regressor::Hot, (0.0, MOST_RISE)).with(Detail::Heated(Heated::FromStart));
    // Per watt of mean loss, at the torque of steady driving: what accelerating adds to the loss
    // makes the bound wider than it is.
    let most = MOST_RISE / (scope.base.winding_loss * scope.torque.powi(2));
    let by_loss = |share: f64| {
        let time = share * scope.duration;
        let way = Way::new(Regressor::Heat(time), (0.0, most));
        way.with(Detail::Heated(Heated::ByLoss(time))).one_of_many()
    };
    let with_time = |share: f64| {
        let time = share * scope.duration;
        let way = Way::new(Regressor::Warming(time), (0.0, MOST_RISE));
        way.with(Detail::Heated(Heated::WithTime(time))).one_of_many()
    };
    let throughout = [hot.one_of_many()].into_iter();
    Ok(throughout.chain(TIMES.map(by_loss)).chain(TIMES.map(with_time)).collect())
}

fn read(fields: &Fields<'_>) -> Read {
    if fields.text(key::FROM) == Some(FROM_START) {
        return fields.one(Cause::Hot);
    }
    if fields.has(key::FROM_C) {
        return fields.one(Cause::Temperature(fields.number(key::FROM_C)?));
    }
    if fields.text(key::BY) == Some(BY_TIME) {
        return fields.one(Cause::Warming(fields.number(key::TIME_CONSTANT)?));
    }
    fields.one(Cause::Heat(fields.number(key::TIME_CONSTANT)?))
}

/// Loss at which a winding's rise settles, W: small, so that any heating is within the plant's
/// range of rises.
const SETTLED_LOSS_W: f64 = 0.01;

fn cause(finding: &Finding<'_>) -> error::Result<Result<PlantCause, String>> {
    match finding.candidate.detail {
        Detail::Heated(Heated::ByLoss(time)) => {
            let tau = time.clamp(1.0, 3600.0);
            let cause = finding.acting(|effect| effect.with("loss", SETTLED_LOSS_W)?.with("tau", tau))?;
            Ok(cause.map(|cause| PlantCause { range: (0.0, cause.range.1), ..cause }))
        }
        Detail::Heated(Heated::FromStart) => {
            finding.acting(|effect| effect.with("heat", 1.0)?.with("tau", 1.0))
        }
        Detail::Heated(Heated::WithTime(time)) => {
            finding.acting(|effect| effect.with("heat", 1.0)?.with("tau", time.clamp(1.0, 3600.0)))
        }
        _ => Ok(Err("temperatures were measured along the way; the plant has its own".to_owned())),
    }
}
