//! What is asked of clean and field runs together.

use logs::runs::Runs;
use model::effects::{Candidate, NotTestable};
use residuals::identifiable::unidentifiable;
use residuals::predictor::Predictor;
use residuals::problem::clean_delay;
use residuals::scope::candidates;
use residuals::types::{Base, Options};

use super::products::anywhere;
use super::round::Asked;

/// Clean and field runs, and the effects that may show in these.
#[derive(Debug, Clone)]
pub struct Question {
    all: Runs,
    free: Runs,
    /// Delay of power after speed in clean runs, s.
    pub clean_delay: f64,
    /// Parameters of the base that are in question.
    pub parameters: usize,
    /// Effects that may show.
    pub list: Vec<Candidate>,
    removed: Vec<String>,
    /// Effects that these runs cannot show.
    pub not_testable: Vec<NotTestable>,
}

impl Question {
    /// Of field runs beside clean ones.
    pub fn of(runs: &Runs, clean: Option<&Runs>, base: &Base, options: &Options) -> Self {
        let all = runs.with_clean(clean);
        let (mut list, mut not_testable) = candidates(runs, base);
        list.extend_from_slice(&options.user.candidates);
        not_testable.extend_from_slice(&options.user.not_testable);
        let mut removed = options.removed.clone();
        for missing in unidentifiable(&base.masses_kg, runs) {
            removed.push(missing.id.clone());
            not_testable.push(missing);
        }
        list.retain(|candidate| !removed.contains(&candidate.id));
        Self {
            free: anywhere(&all),
            all,
            clean_delay: clean.map_or(0.0, |clean| clean_delay::estimate(clean, base)),
            parameters: base.torque.to_array().len() - usize::from(!runs.robot.scrubs()),
            list,
            removed,
            not_testable,
        }
    }

    /// The same with the model, and the level of the gate.
    pub fn asked<'a>(&'a self, base: &'a Base, options: &'a Options, level: f64) -> Asked<'a> {
        Asked {
            predictor: Predictor { clean_delay: self.clean_delay, ..Predictor::new(&self.all, base.drive) },
            free: &self.free,
            base: (base, self.parameters),
            options,
            list: &self.list,
            removed: &self.removed,
            level,
        }
    }
}
