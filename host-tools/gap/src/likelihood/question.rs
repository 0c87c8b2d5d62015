//! What is asked of clean and field runs together.

use logs::runs::Runs;
use residuals::predictor::Predictor;
use residuals::problem::clean_delay;
use residuals::scope::Testable;
use residuals::types::{Base, Options};

use super::asked::Asked;
use super::products::anywhere;

/// Clean and field runs, and what is asked of them.
#[derive(Debug, Clone)]
pub struct Question {
    all: Runs,
    free: Runs,
    /// Delay of power after speed in clean runs, s.
    pub clean_delay: f64,
    /// Parameters of the base that are in question.
    pub parameters: usize,
    /// Effects that may show in the field, and that cannot.
    pub testable: Testable,
}

impl Question {
    /// Of field runs beside clean ones.
    pub fn of(runs: &Runs, clean: &Runs, base: &Base, options: &Options) -> Self {
        let all = runs.with_clean(Some(clean));
        Self {
            free: anywhere(&all),
            all,
            clean_delay: clean_delay::estimate(clean, base),
            parameters: base.torque.to_array().len() - usize::from(!runs.robot.scrubs()),
            testable: Testable::of(runs, runs, base, options),
        }
    }

    /// The same with the model, and the level of the gate.
    pub fn asked<'a>(&'a self, base: &'a Base, level: f64) -> Asked<'a> {
        Asked {
            predictor: Predictor { clean_delay: self.clean_delay, ..Predictor::new(&self.all, base.drive) },
            free: &self.free,
            base: (base, self.parameters),
            list: &self.testable.list,
            removed: &self.testable.removed,
            level,
        }
    }
}
