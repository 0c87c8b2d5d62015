//! A named effect as the physical cause that the plant has for it.

use plant::Effect;
use support::error::Result;

use super::{Candidate, Regressor};

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
pub struct PlantCause {
    /// What acts, of any size.
    pub effects: Vec<Effect>,
    /// Where.
    pub place: Where,
    /// The least and the greatest size.
    pub range: (f64, f64),
}

/// A floor or a grease never loses more of its resistance than this share, nor a robot of its mass.
pub(super) const GREATEST_LOSS: f64 = 0.95;

/// What a run has of a cause that is searched for run by run.
#[derive(Debug, Clone, Copy)]
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

/// What was named, and for which runs.
#[derive(Debug, Clone, Copy)]
pub struct Finding<'a> {
    /// The effect.
    pub candidate: &'a Candidate,
    /// Coefficients of its regressors.
    pub coefficients: &'a [f64],
    /// The runs.
    pub scene: &'a Scene<'a>,
}

impl Finding<'_> {
    /// The plant's effect of this name, as it is without options.
    pub(super) fn everywhere(&self) -> Result<std::result::Result<PlantCause, String>> {
        self.acting(Ok)
    }

    /// The same, its size within a part of the plant's range.
    pub(super) fn everywhere_within(
        &self,
        range: impl FnOnce(f64, f64) -> (f64, f64),
    ) -> Result<std::result::Result<PlantCause, String>> {
        let cause = self.everywhere()?;
        Ok(cause.map(|cause| PlantCause { range: range(cause.range.0, cause.range.1), ..cause }))
    }

    /// With options.
    pub(super) fn acting(
        &self,
        with: impl FnOnce(Effect) -> Result<Effect>,
    ) -> Result<std::result::Result<PlantCause, String>> {
        self.acting_each(|effect| Ok(vec![with(effect)?]))
    }

    /// As several effects of one size.
    pub(super) fn acting_each(
        &self,
        with: impl FnOnce(Effect) -> Result<Vec<Effect>>,
    ) -> Result<std::result::Result<PlantCause, String>> {
        let effect = Effect::new(&self.candidate.id, 0.0)?;
        let range = effect.entry().range;
        Ok(Ok(PlantCause { effects: with(effect)?, place: Where::Everywhere, range }))
    }

    /// Where it acts: in single runs, at times of its own, or everywhere.
    pub(super) fn place(&self) -> Where {
        let scene = self.scene;
        let mut times = vec![f64::INFINITY; scene.runs];
        let mut masses = vec![false; scene.runs];
        let (mut any_time, mut any_mass) = (false, false);
        let mut common = None;
        for regressor in &self.candidate.regressors {
            match regressor {
                Regressor::Switch(_, of_open) => {
                    any_time = true;
                    for (&run, at) in scene.open.iter().zip(of_open.iter()) {
                        times[run] = *at;
                    }
                    for (&run, at) in scene.locked.iter().zip(scene.locked_times.unwrap_or(&[])) {
                        times[run] = *at;
                    }
                }
                Regressor::InRun(run, term) => {
                    any_time = true;
                    if let (Some(&run), Some(at)) = (scene.open.get(*run), Regressor::Term(*term).shape()) {
                        times[run] = at;
                    }
                }
                Regressor::Mass(run) => {
                    any_mass = true;
                    if let Some(&run) = scene.open.get(*run) {
                        masses[run] = true;
                    }
                }
                other => common = common.or(other.begins()),
            }
        }
        match (any_time, any_mass, common) {
            (true, ..) => Where::From(times),
            (_, true, _) => Where::In(masses),
            (.., Some(at)) => Where::From(vec![at; scene.runs]),
            _ => Where::Everywhere,
        }
    }
}

impl PlantCause {
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
        let sized = |effect: &Effect| {
            let effect = effect.clone().with_size(size)?;
            at.map_or_else(|| Ok(effect.clone()), |at| effect.clone().with("at", at.max(0.0)))
        };
        self.effects.iter().map(sized).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::{Along, Detail, Heated, Runs, Switched, WheelSide, cause};

    fn cause_of(
        id: &str,
        regressors: Vec<Regressor>,
        coefficients: &[f64],
        detail: Detail,
    ) -> std::result::Result<PlantCause, String> {
        let (id, unit, range, search) = (id.to_owned(), String::new(), (0.0, 1.0), 0.0);
        let candidate = Candidate { id, regressors, unit, range, least: Vec::new(), detail, search };
        let scene = Scene {
            open: &[0, 2],
            locked: &[1],
            runs: 3,
            locked_times: Some(&[7.0]),
            rolling: 0.02,
            lightest_kg: 1.0,
        };
        cause(&Finding { candidate: &candidate, coefficients, scene: &scene }).unwrap()
    }

    #[test]
    fn the_details_of_an_effect_are_the_options_of_its_cause() {
        let slope = cause_of("grade", vec![], &[0.0, 0.02], Detail::Slope(Along::World)).unwrap();
        // Uphill at a right angle to the left of the start.
        assert_eq!(slope.effects[0].option("heading"), Some(std::f64::consts::FRAC_PI_2));
        assert_eq!(slope.range.0, 0.0);
        let second = Detail::Wheel { wheel: 2, side: WheelSide::Right };
        let drag = cause_of("wheel-drag", vec![], &[0.1], second).unwrap();
        assert_eq!(drag.in_run(0.1, 0).unwrap()[0].option("wheel"), Some(2.0));
        let both = cause_of("speed-scale", vec![], &[0.1], Detail::Side(WheelSide::Both)).unwrap();
        let sides: Vec<_> = both.in_run(0.1, 0).unwrap().iter().map(|effect| effect.option("side")).collect();
        assert_eq!(sides, [Some(1.0), Some(0.0)]);
        // No floor loses all of the plant's resistance, of 0.02.
        let floor = cause_of("rolling-resistance-change", vec![], &[-0.1], Detail::Plain).unwrap();
        assert!((floor.range.0 + 0.019).abs() < 1e-12, "{floor:?}");
    }

    #[test]
    fn causes_act_where_and_when_they_were_found() {
        // Open runs have the times of the fit, locked runs those that were looked for there.
        let times = Regressor::Switch(Switched::Static, [3.0, f64::INFINITY].into());
        let all = Detail::InRuns { runs: Runs::All, at_s: None };
        let step = cause_of("static-step", vec![times], &[0.1], all.clone()).unwrap();
        assert_eq!(step.place, Where::From(vec![3.0, 7.0, f64::INFINITY]));
        assert_eq!(step.in_run(0.1, 1).unwrap()[0].option("at"), Some(7.0));
        assert!(step.in_run(0.1, 2).unwrap().is_empty());
        let at = Regressor::Term(Switched::Rolling.from(5.0).unwrap());
        let floor = cause_of("surface-switch", vec![at], &[0.01], Detail::At { at_s: 5.0 }).unwrap();
        assert_eq!(floor.place, Where::From(vec![5.0; 3]));
        let wrong = cause_of("payload-mislabel", vec![Regressor::Mass(1)], &[0.3], all).unwrap();
        assert_eq!(wrong.place, Where::In(vec![false, false, true]));
    }

    #[test]
    fn what_the_plant_has_no_cause_for_is_not_simulated() {
        for (id, detail) in [
            ("my-formula", Detail::Plain),
            ("compute-load", Detail::Plain),
            ("grade", Detail::Slope(Along::Pitch)),
            ("winding-temperature", Detail::Heated(Heated::Measured(20.0))),
        ] {
            assert!(cause_of(id, vec![Regressor::Column(0)], &[1.0], detail).is_err(), "{id}");
        }
    }
}
