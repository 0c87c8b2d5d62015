//! A named effect as the physical cause that the plant has for it.

use serde_json::{Map, Value};

use crate::effects::Regressor;
use crate::error::Result;
use crate::gap::types::Named;
use crate::plant::Effect;

/// In which runs a cause acts, by their places among all runs of a set.
#[derive(Debug, Clone, PartialEq)]
pub enum Where {
    /// In all.
    Everywhere,
    /// From a time on, s, one a run; infinite where it does not begin.
    From(Vec<f64>),
    /// In some.
    In(Vec<bool>),
}

/// A cause whose size is still to be found.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// What acts, of any size.
    pub effects: Vec<Effect>,
    /// Where.
    pub place: Where,
    /// The least and the greatest size.
    pub range: (f64, f64),
}

/// Shares of the range that a cause may fill: loads on the edge would lift a wheel.
const LEVER: f64 = 0.6;

/// A floor or a grease never loses all of its resistance, nor a robot its mass.
const LEAST_LEFT: f64 = 0.95;

/// Loss at which a winding's rise settles, W: small, so that any heating is within the plant's range of rises.
const SETTLED_LOSS_W: f64 = 0.01;

/// What a run has of a cause that is searched for run by run.
pub struct Scene<'a> {
    /// Places of the open runs among all.
    pub open: &'a [usize],
    /// Places of the locked runs among all.
    pub locked: &'a [usize],
    /// Number of all runs.
    pub runs: usize,
    /// Times of this effect's steps in the locked runs, where they have any of their own.
    pub locked_times: Option<&'a [f64]>,
    /// The plant's own coefficient of rolling resistance.
    pub rolling: f64,
    /// The least mass that a log notes, kg.
    pub lightest_kg: f64,
}

/// The cause, or why the plant has none.
///
/// # Errors
/// An option out of the plant's range.
pub fn cast(named: &Named, scene: &Scene<'_>) -> Result<std::result::Result<Part, String>> {
    let candidate = &named.candidate;
    let detail = &candidate.detail;
    let id = candidate.id.as_str();
    if crate::effects::find(id).is_none() {
        return Ok(Err("the plant knows no cause for a formula".to_owned()));
    }
    let number = |key: &str| detail.get(key).and_then(Value::as_f64);
    let mut effect = Effect::new(id, 0.0)?;
    let mut effects = Vec::new();
    let mut place = Where::Everywhere;
    let (low, high) = effect.entry().range;
    let mut range = (low, high);
    match id {
        "grade" => match named.coefficients[..] {
            [_] if detail.contains_key("by") => {
                return Ok(Err(
                    "the slope was measured along the way; the plant has constant ones".to_owned()
                ));
            }
            [x, y] => {
                effect = effect.with("heading", y.atan2(x))?;
                range = (0.0, high);
            }
            _ => effect = effect.with("along", 1.0)?,
        },
        "winding-temperature" => match candidate.regressors[..] {
            [Regressor::Heat(time)] => {
                effect = effect.with("loss", SETTLED_LOSS_W)?.with("tau", time.clamp(1.0, 3600.0))?;
                range = (0.0, high);
            }
            [Regressor::Hot] => effect = effect.with("heat", 1.0)?.with("tau", 1.0)?,
            _ => {
                return Ok(Err("temperatures were measured along the way; the plant has its own".to_owned()));
            }
        },
        "stribeck" => {
            if let Some(width) = number("speed_rad_s") {
                effect = effect.with("width", width.clamp(0.05, 20.0))?;
            }
        }
        "lubricant-warm-up" => {
            if let Some(time) = number("time_constant_s") {
                effect = effect.with("tau", time.clamp(1.0, 3600.0))?;
            }
        }
        "wheel-drag" => {
            if let Some(wheel) = number("wheel") {
                effect = effect.with("wheel", wheel)?;
            }
        }
        "payload-offset" => range = (LEVER * low, LEVER * high),
        "rolling-resistance-change" | "surface-switch" => range.0 = low.max(-LEAST_LEFT * scene.rolling),
        "payload-mislabel" => range.0 = low.max(-LEAST_LEFT * scene.lightest_kg),
        "compute-load" => return Ok(Err("the plant's computer has a load of its own".to_owned())),
        "static-step" if steps_with_motion(detail) => {
            let hold = number("hold_s").unwrap_or(f64::INFINITY).min(3600.0);
            effect = effect.with("on", 1.0)?.with("hold", hold)?;
        }
        "speed-scale" => match detail.get("side").and_then(Value::as_str) {
            Some("both") => effects.push(effect.clone().with("side", 1.0)?),
            Some("right") => effect = effect.with("side", 1.0)?,
            _ => {}
        },
        _ => {}
    }
    if let Some(found) = scene.places(&candidate.regressors) {
        place = found;
    } else if let Some(at) = number("at_s") {
        place = Where::From(vec![at; scene.runs]);
    }
    effects.push(effect);
    Ok(Ok(Part { effects, place, range }))
}

fn steps_with_motion(detail: &Map<String, Value>) -> bool {
    detail.get("with").is_some() || detail.get("from").and_then(Value::as_str) == Some("the first motion on")
}

impl Scene<'_> {
    /// Where regressors of single runs, or of times of their own, act; `None` for those of all runs.
    fn places(&self, regressors: &[Regressor]) -> Option<Where> {
        let mut times = vec![f64::INFINITY; self.runs];
        let mut masses = vec![false; self.runs];
        let (mut any_time, mut any_mass) = (false, false);
        for regressor in regressors {
            match regressor {
                Regressor::Switch(_, own) => {
                    any_time = true;
                    for (&run, at) in self.open.iter().zip(own.iter()) {
                        times[run] = *at;
                    }
                    for (&run, at) in self.locked.iter().zip(self.locked_times.unwrap_or(&[])) {
                        times[run] = *at;
                    }
                }
                Regressor::InRun(run, term) => {
                    any_time = true;
                    if let (Some(&run), Some(at)) = (self.open.get(*run), Regressor::Term(*term).shape()) {
                        times[run] = at;
                    }
                }
                Regressor::Mass(run) => {
                    any_mass = true;
                    if let Some(&run) = self.open.get(*run) {
                        masses[run] = true;
                    }
                }
                _ => {}
            }
        }
        match (any_time, any_mass) {
            (true, _) => Some(Where::From(times)),
            (_, true) => Some(Where::In(masses)),
            _ => None,
        }
    }
}

impl Part {
    /// The cause in one run, by its place among all.
    ///
    /// # Errors
    /// A size out of the plant's range.
    pub fn in_run(&self, size: f64, run: usize) -> Result<Vec<Effect>> {
        let at = match &self.place {
            Where::Everywhere => None,
            Where::From(times) => match times.get(run) {
                Some(at) if at.is_finite() => Some(*at),
                _ => return Ok(Vec::new()),
            },
            Where::In(runs) if runs.get(run).copied().unwrap_or(false) => None,
            Where::In(_) => return Ok(Vec::new()),
        };
        let part = |effect: &Effect| {
            let effect = effect.clone().with_size(size)?;
            at.map_or_else(|| Ok(effect.clone()), |at| effect.clone().with("at", at.max(0.0)))
        };
        self.effects.iter().map(part).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::{Candidate, Switched};
    use serde_json::json;

    fn named(id: &str, regressors: Vec<Regressor>, coefficients: Vec<f64>, detail: Value) -> Named {
        let detail = detail.as_object().cloned().unwrap_or_default();
        let (unit, range, shape, search) = (String::new(), (0.0, 1.0), None, 0.0);
        let candidate = Candidate { id: id.to_owned(), regressors, unit, range, detail, shape, search };
        Named { candidate, std_errs: coefficients.clone(), coefficients }
    }

    fn part(named: &Named) -> std::result::Result<Part, String> {
        let scene = Scene {
            open: &[0, 2],
            locked: &[1],
            runs: 3,
            locked_times: Some(&[7.0]),
            rolling: 0.02,
            lightest_kg: 1.0,
        };
        cast(named, &scene).unwrap()
    }

    #[test]
    fn the_details_of_an_effect_are_the_options_of_its_cause() {
        let slope = part(&named("grade", vec![], vec![0.0, 0.02], json!({"along": "a direction"}))).unwrap();
        // Uphill at a right angle to the left of the start.
        assert_eq!(slope.effects[0].option("heading"), Some(std::f64::consts::FRAC_PI_2));
        assert_eq!(slope.range.0, 0.0);
        let drag =
            part(&named("wheel-drag", vec![], vec![0.1], json!({"wheel": 2, "side": "right"}))).unwrap();
        assert_eq!(drag.in_run(0.1, 0).unwrap()[0].option("wheel"), Some(2.0));
        let both = part(&named("speed-scale", vec![], vec![0.1], json!({"side": "both"}))).unwrap();
        let sides: Vec<_> = both.in_run(0.1, 0).unwrap().iter().map(|effect| effect.option("side")).collect();
        assert_eq!(sides, [Some(1.0), Some(0.0)]);
        // Open runs have the times of the fit, locked runs those that were looked for there.
        let times = Regressor::Switch(Switched::Static, [3.0, f64::INFINITY].into());
        let step = part(&named("static-step", vec![times], vec![0.1], json!({"runs": "all"}))).unwrap();
        assert_eq!(step.place, Where::From(vec![3.0, 7.0, f64::INFINITY]));
        assert_eq!(step.in_run(0.1, 1).unwrap()[0].option("at"), Some(7.0));
        assert!(step.in_run(0.1, 2).unwrap().is_empty());
    }

    #[test]
    fn what_the_plant_has_no_cause_for_is_not_simulated() {
        for (id, detail) in [
            ("my-formula", json!({})),
            ("compute-load", json!({})),
            ("grade", json!({"by": "pitch_rad"})),
            ("winding-temperature", json!({"by": "motor temperatures"})),
        ] {
            assert!(part(&named(id, vec![Regressor::Column(0)], vec![1.0], detail)).is_err(), "{id}");
        }
    }
}
