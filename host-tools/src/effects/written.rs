//! Effects as coefficient files hold them, and what estimator and board make of them: the one place that maps the dictionary's ids and
//! details to columns of model-core and back.
//!
//! An `[[effects]]` entry of coefficients.toml has the keys of the JSON: `id`, `coefficient`, `unit`, `std_err`, and in `detail` what is
//! special about it:
//!
//! | id | `detail` |
//! |---|---|
//! | `grade` | `by = "pitch_rad"`; or `along = "the way ahead"`; or `along = "a direction of the world"`, `coefficients = [along, across]` the heading at the start, `std_errs` |
//! | `winding-temperature` | `from = "the start"`; or `time_constant_s`; or `by = "motor temperatures"`, `from_c` |
//! | `stribeck` | `speed_rad_s` |
//! | `lubricant-warm-up` | `time_constant_s` |
//! | `surface-switch` | `at_s`, since the start of the run |
//! | `wheel-drag` | `wheel`, from 1 |
//! | `supply-sag`, `sensor-gain` | `with_static_w`, the static power that is measured along; 0 where there is none |
//! | `turning-scrub` | `depends_on_mass` |
//! | `static-step` | `at_s`; or `with = "motion"`, `hold_s`; or `from = "the first motion on"` |
//! | `speed-scale` | `side`: left, right or both |
//!
//! The others have none. Further keys are for people. What concerns single runs (`payload-mislabel`, steps at a time of their own in
//! each run) says something about those runs and nothing about the robot: no file holds it.

use model_core::effects::{Cause, Column, Columns, InvalidColumns, Side, Term};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use super::{Candidate, ENTRIES, PITCH, PROCESSOR, Regressor, find};

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
        ENTRIES.iter().map(|entry| entry.id).filter(|id| *id != "payload-mislabel").collect();
    ids.join(", ")
}

/// What details do, as far as they do anything.
const ALONG_TRAVEL: &str = "the way ahead";
const ALONG_WORLD: &str = "a direction of the world";
/// Static power that passes the leads, or the sensor, with that of the wheels.
const STATIC: &str = "with_static_w";
const FROM_START: &str = "the start";
const FROM_MOTION: &str = "the first motion on";

impl Written {
    /// What the estimator makes of it: one column, or two.
    fn columns(&self) -> Result<Vec<Column<f64>>, (&'static str, String)> {
        let text = |key: &str| self.detail.get(key).and_then(Value::as_str);
        let number = |key: &'static str| {
            let found = self.detail.get(key).and_then(Value::as_f64);
            found
                .ok_or((key, format!("{} without {key}, or not a number; expected one in `detail`", self.id)))
        };
        let shaped = |key, cause: fn(f64) -> Cause<f64>| number(key).map(cause);
        let unclear = |what: &str| Err(("detail", format!("{} without a detail; expected {what}", self.id)));
        let plain = |term| Ok(Cause::Term(term));
        // Static power that the sensor sees as well; none where only actuation is measured.
        let with = self.detail.get(STATIC).and_then(Value::as_f64).unwrap_or(0.0);
        let cause = match self.id.as_str() {
            "grade" => match (text("by"), text("along")) {
                (Some(PITCH), None) => plain(Term::GradeByPitch),
                (None, Some(ALONG_TRAVEL)) => plain(Term::GradeAhead),
                (None, Some(ALONG_WORLD)) => return self.grade_along(),
                _ => unclear(&format!("by = {PITCH:?}, along = {ALONG_TRAVEL:?} or along = {ALONG_WORLD:?}")),
            },
            "winding-temperature" => match (text("from"), self.detail.contains_key("from_c")) {
                (Some(FROM_START), _) => Ok(Cause::Hot),
                (_, true) => shaped("from_c", Cause::Temperature),
                _ => shaped("time_constant_s", Cause::Heat),
            },
            "windage" => plain(Term::Windage),
            "stribeck" => shaped("speed_rad_s", |speed| Cause::Term(Term::Stribeck(speed))),
            "viscous-change" => plain(Term::Viscous),
            "lubricant-warm-up" => shaped("time_constant_s", |time| Cause::Term(Term::WarmUp(time))),
            "rolling-resistance-change" => plain(Term::Rolling),
            "surface-switch" => shaped("at_s", |at| Cause::Term(Term::RollingFrom(at))),
            "payload-offset" => plain(Term::Offset),
            "wheel-drag" => match number("wheel")? {
                wheel if (1.0..=255.0).contains(&wheel) && wheel.fract() == 0.0 => {
                    plain(Term::Drag(wheel as u8 - 1))
                }
                wheel => Err(("wheel", format!("wheel {wheel}; expected 1, 2, …"))),
            },
            "turning-scrub" => match self.detail.get("depends_on_mass").and_then(Value::as_bool) {
                Some(true) => plain(Term::ScrubPerKg),
                Some(false) => plain(Term::Scrub),
                None => unclear("depends_on_mass = true or false"),
            },
            "gear-load-loss" => plain(Term::GearLoad),
            "supply-sag" => plain(Term::Sag(with)),
            "regeneration" => plain(Term::Return),
            "static-step" if text("from") == Some(FROM_MOTION) => plain(Term::WithMotion(f64::INFINITY)),
            "static-step" if text("with") == Some("motion") => {
                shaped("hold_s", |hold| Cause::Term(Term::WithMotion(hold)))
            }
            "static-step" => shaped("at_s", |at| Cause::Term(Term::StepAt(at))),
            "compute-load" => plain(Term::Driver),
            "sensor-gain" => plain(Term::Gain(with)),
            "sensor-offset" => plain(Term::Constant),
            "sensor-delay" => Ok(Cause::Delay),
            "speed-scale" => match text("side") {
                Some("left") => Ok(Cause::Scale(Side::Left)),
                Some("right") => Ok(Cause::Scale(Side::Right)),
                Some("both") => Ok(Cause::Scale(Side::Both)),
                _ => unclear("side = \"left\", \"right\" or \"both\""),
            },
            "payload-mislabel" => {
                return Err((
                    "id",
                    "payload-mislabel is a finding about runs, not about a robot: coefficients hold none"
                        .to_owned(),
                ));
            }
            id => return Err(("id", format!("effect `{id}`; expected one of {}", allowed()))),
        };
        Ok(vec![Column { cause: cause?, coefficient: self.coefficient }])
    }

    /// A slope fixed in the world has two coefficients.
    fn grade_along(&self) -> Result<Vec<Column<f64>>, (&'static str, String)> {
        let both: Option<Vec<f64>> = self
            .detail
            .get("coefficients")
            .and_then(Value::as_array)
            .and_then(|both| both.iter().map(Value::as_f64).collect());
        let Some([along, across]) = both.as_deref() else {
            let expected =
                "grade along a direction of the world; expected coefficients = [along, across] in `detail`";
            return Err(("coefficients", expected.to_owned()));
        };
        let column = |along, coefficient| Column { cause: Cause::Term(Term::GradeAlong(along)), coefficient };
        Ok(vec![column([1.0, 0.0], *along), column([0.0, 1.0], *across)])
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
        let own = effect.columns().map_err(|(key, message)| Wrong { place, key, message })?;
        owners.extend(own.iter().map(|_| place));
        all.extend(own);
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

/// The dictionary's id of a column, and the column of a log that it needs.
pub fn id_of<T>(cause: &Cause<T>) -> (&'static str, &'static str) {
    let id = match cause {
        Cause::Hot | Cause::Heat(_) => "winding-temperature",
        Cause::Temperature(_) => return ("winding-temperature", "motor1_temp_c, …"),
        Cause::Delay => "sensor-delay",
        Cause::Scale(_) => "speed-scale",
        Cause::Term(term) => match term {
            Term::GradeByPitch => return ("grade", PITCH),
            Term::GradeAhead | Term::GradeAlong(_) => "grade",
            Term::Winding => "winding-temperature",
            Term::Windage => "windage",
            Term::Stribeck(_) => "stribeck",
            Term::Viscous => "viscous-change",
            Term::WarmUp(_) => "lubricant-warm-up",
            Term::Rolling => "rolling-resistance-change",
            Term::RollingFrom(_) => "surface-switch",
            Term::Offset => "payload-offset",
            Term::Drag(_) => "wheel-drag",
            Term::Scrub | Term::ScrubPerKg => "turning-scrub",
            Term::GearLoad => "gear-load-loss",
            Term::Sag(_) => "supply-sag",
            Term::Return => "regeneration",
            Term::Gain(_) => "sensor-gain",
            Term::Constant => "sensor-offset",
            Term::StepAt(_) | Term::WithMotion(_) => "static-step",
            Term::Driver => return ("compute-load", PROCESSOR),
        },
    };
    (id, "")
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
        let mut detail = candidate.detail.clone();
        if coefficients.len() > 1 {
            detail.insert("coefficients".to_owned(), json!(coefficients));
            detail.insert("std_errs".to_owned(), json!(std_errs));
        }
        // Switched off shortly before the robot stands, by what the runs say: a board that is not ahead of its time, as it stands.
        if let Some(hold) = detail.get("hold_s").and_then(Value::as_f64) {
            detail.insert("hold_s".to_owned(), json!(hold.max(0.0)));
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
            (entry("grade", json!({"along": ALONG_WORLD})), "coefficients", "[along, across]"),
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
        let candidate = Candidate {
            id: "static-step".to_owned(),
            regressors: vec![Regressor::InRun(2, Term::StepAt(20.0))],
            unit: "W".to_owned(),
            range: (0.0, 1.0),
            detail: Map::new(),
            shape: None,
            search: 0.0,
        };
        assert!(Written::of(&candidate, &[0.3], &[0.01]).unwrap_err().contains("a finding about runs"));
    }
}
