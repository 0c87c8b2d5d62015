//! Effects as coefficient files hold them, and what estimator and board make of them: the one place
//! that maps the dictionary's ids and details to columns of model-core and back.
//!
//! An `[[effects]]` entry of coefficients.toml has the keys of the JSON: `id`, `coefficient`,
//! `unit`, `std_err`, and in `detail` what is special about it:
//!
//! | id | `detail` |
//! |---|---|
//! | `grade` | `by = "pitch_rad"`; or `along = "the way ahead"`; or `along = "a direction of the world"`, `coefficients = [along, across]` the heading at the start, `std_errs` |
//! | `winding-temperature` | `from = "the start"`; or `time_constant_s`, and `by = "time"` where it is not their own heat; or `by = "motor temperatures"`, `from_c` |
//! | `stribeck` | `speed_rad_s` |
//! | `lubricant-warm-up` | `time_constant_s` |
//! | `surface-switch` | `at_s`, since the start of the run |
//! | `wheel-drag` | `wheel`, from 1 |
//! | `supply-sag`, `sensor-gain` | `with_static_w`, the static power that is measured along; 0 where there is none |
//! | `turning-scrub` | `depends_on_mass`; and `half_slip` where it shares the ground's grip with rolling; or `with = "half_slip"` as below |
//! | `rolling-resistance-change` | nothing; or `with = "half_slip"`, `coefficients = [its own, share by which the base's half slip is greater]`, `std_errs` |
//! | `payload-offset` | nothing; or `empty_kg`, the mass of the empty robot, where it lowers the scrub |
//! | `gear-load-loss` | `in_proportion = true`, or nothing |
//! | `static-step` | `at_s`; or `with = "motion"`, `hold_s`; or `from = "the first motion on"` |
//! | `speed-scale` | `side`: left, right or both |
//!
//! The others have none. Further keys are for people. What concerns single runs
//! (`payload-mislabel`, steps at a time of their own in each run) says something about those runs
//! and nothing about the robot: no file holds it.

use model_core::effects::{Cause, Column, Columns, InvalidColumns, Needs};
use model_core::real::Real;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use super::fields::{Fields, Unread};
use super::payload_mislabel::PAYLOAD_MISLABEL;
use super::{Candidate, Detail, ENTRIES, PITCH, PROCESSOR, Regressor, TEMPERATURES, find, key};

/// An effect as a file holds it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Written {
    /// Its id in the dictionary.
    pub id: String,
    /// Its coefficient; the first where `detail` has several.
    pub coefficient: f64,
    /// Unit of the coefficients.
    pub unit: String,
    /// Standard error of the coefficient.
    pub std_err: f64,
    /// What is special about it.
    #[serde(default, skip_serializing_if = "Map::is_empty")]
    pub detail: Map<String, Value>,
}

/// What is wrong with an effect of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Wrong {
    /// Which, from 0.
    pub place: usize,
    /// Its key.
    pub key: &'static str,
    /// What was found, and what was expected.
    pub message: String,
}

/// Ids that files may hold.
fn allowed() -> String {
    let ids: Vec<&str> =
        ENTRIES.iter().map(|entry| entry.id).filter(|id| *id != PAYLOAD_MISLABEL.id).collect();
    ids.join(", ")
}

impl Written {
    /// What the estimator makes of it: one column, or two.
    fn columns(&self) -> Result<Vec<Column<f64>>, Unread> {
        let entry = find(&self.id)
            .ok_or_else(|| ("id", format!("effect `{}`; expected one of {}", self.id, allowed())))?;
        let fields = Fields { id: &self.id, coefficient: self.coefficient, detail: &self.detail };
        let columns = (entry.read)(&fields)?;
        Ok(columns.into_iter().map(|(cause, coefficient)| Column { cause, coefficient }).collect())
    }
}

/// What estimator and board make of effects, for a robot with so many wheels.
///
/// # Errors
/// The first effect that is not known, lacks a detail, or cannot stand with the others.
pub fn columns(effects: &[Written], wheels: usize) -> Result<Columns<f64>, Wrong> {
    let mut all = Vec::new();
    let mut owners = Vec::new();
    for (place, effect) in effects.iter().enumerate() {
        let of_effect = effect.columns().map_err(|(key, message)| Wrong { place, key, message })?;
        owners.extend(of_effect.iter().map(|_| place));
        all.extend(of_effect);
    }
    Columns::new(&all, wheels).map_err(|invalid| {
        let of = |column: usize| owners.get(column).copied().unwrap_or(0);
        let id = |column| effects.get(of(column)).map_or("", |effect| effect.id.as_str());
        match invalid {
            InvalidColumns::TooMany => Wrong {
                place: of(model_core::effects::MOST_COLUMNS),
                key: "id",
                message: format!(
                    "{} coefficients of effects; expected at most {}, as many as a board holds",
                    all.len(),
                    model_core::effects::MOST_COLUMNS
                ),
            },
            InvalidColumns::Twice(column) => Wrong {
                place: of(column),
                key: "id",
                message: format!("{} stands here twice; expected each effect once", id(column)),
            },
            InvalidColumns::Value(column) => Wrong {
                place: of(column),
                key: "coefficient",
                message: format!(
                    "{} has a coefficient or a detail that no robot has; expected finite numbers, losses not below 0, \
                     factors above -1, times and speeds above 0, a wheel of the robot",
                    id(column)
                ),
            },
        }
    })
}

/// The effect of a column, and the column of a log that it needs.
pub fn id_of<T: Real>(cause: &Cause<T>) -> (&'static str, &'static str) {
    let cause = cause.convert::<f64>();
    let entry = ENTRIES.iter().find(|entry| (entry.owns)(&cause));
    let Needs { pitch, temperatures, driver } = cause.needs();
    let needed = match (pitch, temperatures, driver) {
        (true, ..) => PITCH,
        (_, true, _) => TEMPERATURES,
        (.., true) => PROCESSOR,
        _ => "",
    };
    (entry.map_or("", |entry| entry.id), needed)
}

impl Written {
    /// A candidate with the coefficients that were found, and their standard errors.
    ///
    /// # Errors
    /// Why no file holds it: it is a finding about runs, or a formula that boards cannot compute.
    pub fn of(candidate: &Candidate, coefficients: &[f64], std_errs: &[f64]) -> Result<Self, String> {
        let id = &candidate.id;
        let of_runs = |regressor: &Regressor| {
            matches!(
                regressor,
                Regressor::InRun(..) | Regressor::Switch(..) | Regressor::Mass(_) | Regressor::Masses
            )
        };
        if candidate.regressors.iter().any(of_runs) {
            return Err(format!(
                "{id} is a finding about runs, not about the robot: coefficients do not hold it"
            ));
        }
        if find(id).is_none() {
            return Err(format!(
                "{id} is not of the dictionary: boards do not have it, and coefficients do not hold it"
            ));
        }
        let mut detail = candidate.detail.fields();
        if coefficients.len() > 1 {
            detail.insert(key::COEFFICIENTS.to_owned(), json!(coefficients));
            detail.insert(key::STD_ERRS.to_owned(), json!(std_errs));
        }
        // Switched off shortly before the robot stands, by what the runs say: a board that is not
        // ahead of its time, as it stands.
        if let Detail::WithMotion { hold_s } = candidate.detail {
            detail.insert(key::HOLD.to_owned(), json!(hold_s.max(0.0)));
        }
        Ok(Self {
            id: id.clone(),
            coefficient: coefficients.first().copied().unwrap_or(f64::NAN),
            unit: candidate.unit.clone(),
            std_err: std_errs.first().copied().unwrap_or(f64::NAN),
            detail,
        })
    }
}

#[cfg(test)]
mod tests {
    use model_core::effects::Term;

    use super::*;
    use crate::effects::STATIC_STEP;

    fn entry(id: &str, detail: Value) -> Written {
        let Value::Object(detail) = detail else { panic!("{detail}") };
        Written { id: id.to_owned(), coefficient: 0.01, unit: String::new(), std_err: 0.001, detail }
    }

    #[test]
    fn what_no_board_has_is_refused_by_name() {
        for (effect, key, says) in [
            (
                entry("perpetuum", json!({})),
                "id",
                "effect `perpetuum`; expected one of grade, winding-temperature",
            ),
            (entry("payload-mislabel", json!({"runs": "all"})), "id", "a finding about runs"),
            (entry("grade", json!({})), "detail", "by = \"pitch_rad\""),
            (entry("grade", json!({"along": "a direction of the world"})), "coefficients", "[along, across]"),
            (
                entry("stribeck", json!({"speed_rad_s": "fast"})),
                "speed_rad_s",
                "stribeck without speed_rad_s",
            ),
            (entry("stribeck", json!({"speed_rad_s": 0.0})), "coefficient", "stribeck has"),
            (entry("wheel-drag", json!({"wheel": 3})), "coefficient", "wheel-drag has"),
            (entry("wheel-drag", json!({"wheel": 0})), "wheel", "expected 1, 2"),
            (entry("speed-scale", json!({"side": "top"})), "detail", "\"left\""),
            (entry("static-step", json!({"runs": "all", "at_s": [1.0, 2.0]})), "at_s", "not a number"),
        ] {
            let wrong = columns(&[entry("windage", json!({})), effect], 2).unwrap_err();
            assert_eq!((wrong.place, wrong.key), (1, key), "{wrong:?}");
            assert!(wrong.message.contains(says), "{wrong:?}");
        }
        let same = [entry("windage", json!({})), entry("windage", json!({}))];
        assert!(columns(&same, 2).unwrap_err().message.contains("windage stands here twice"));
        let many = ["windage", "supply-sag", "sensor-gain", "sensor-offset", "viscous-change"];
        let wrong = columns(&many.map(|id| entry(id, json!({}))), 2).unwrap_err();
        assert_eq!(wrong.place, 4);
        assert!(wrong.message.contains("at most 4"), "{wrong:?}");
    }

    #[test]
    fn findings_about_runs_are_not_written() {
        let one = vec![Regressor::InRun(2, Term::StepAt(20.0))];
        let candidate = STATIC_STEP.candidate(one, (0.0, 1.0), Detail::Plain, 0.0);
        assert!(Written::of(&candidate, &[0.3], &[0.01]).unwrap_err().contains("a finding about runs"));
    }
}
