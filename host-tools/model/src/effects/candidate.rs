//! One way in which an effect may show, for those who look for it.

use serde::Serialize;

use super::{Detail, Regressor, Scope, Switched};

/// One way in which an effect may show.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Its entry's id, or the name that a user gave it.
    pub id: String,
    /// Its columns.
    pub regressors: Vec<Regressor>,
    /// Unit of the coefficients.
    pub unit: String,
    /// The least and greatest value of the first coefficient.
    pub range: (f64, f64),
    /// The least coefficient of each regressor, where every run has its own; else empty.
    pub least: Vec<f64>,
    /// What is special about it.
    pub detail: Detail,
    /// What the search for its shape, times or runs costs, in χ²: the best of many is better than
    /// the right one.
    pub search: f64,
}

/// An effect that these runs cannot show, and why.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NotTestable {
    /// Its id.
    pub id: String,
    /// What it needs.
    pub reason: String,
}

impl Candidate {
    /// The same with a different shape parameter, where its one regressor has any.
    pub fn set_shape(&mut self, shape: f64) {
        if let [regressor] = &mut self.regressors[..] {
            *regressor = regressor.with_shape(shape);
            self.detail = self.detail.with_shape(shape);
        }
    }

    /// It is a half slip that is another from a time on: a share, whatever unit its effect has
    /// else.
    pub fn steps_half_slip(&self) -> bool {
        self.regressors.iter().any(|regressor| matches!(regressor, Regressor::Switch(Switched::HalfSlip, _)))
    }

    /// Leaves the regressors that are kept, of as many runs.
    pub fn keep(&mut self, kept: &[bool]) {
        let mut each = kept.iter();
        self.regressors.retain(|_| each.next().copied().unwrap_or(true));
        let mut each = kept.iter();
        self.least.retain(|_| each.next().copied().unwrap_or(true));
        self.detail.keep(kept);
    }
}

/// What the choice among a few shapes costs, in χ².
const SHAPE: f64 = 2.0;

/// A way in which an effect of the dictionary may show.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Way {
    pub(super) regressors: Vec<Regressor>,
    pub(super) range: (f64, f64),
    pub(super) detail: Detail,
    pub(super) search: f64,
    /// Unit of the coefficient, where it is not the entry's.
    pub(super) unit: Option<&'static str>,
}

impl Way {
    /// A way by one regressor, with the least and greatest coefficient.
    pub(super) fn new(regressor: Regressor, range: (f64, f64)) -> Self {
        Self { regressors: vec![regressor], range, detail: Detail::Plain, search: 0.0, unit: None }
    }

    /// By several regressors, the range being that of their size.
    pub(super) fn of_several(regressors: Vec<Regressor>, range: (f64, f64)) -> Self {
        Self { regressors, range, detail: Detail::Plain, search: 0.0, unit: None }
    }

    /// What is special about it.
    pub(super) fn with(self, detail: Detail) -> Self {
        Self { detail, ..self }
    }

    /// In another unit than the entry's.
    pub(super) fn in_unit(self, unit: &'static str) -> Self {
        Self { unit: Some(unit), ..self }
    }

    /// One of several shapes.
    pub(super) fn one_of_many(self) -> Self {
        Self { search: SHAPE, ..self }
    }

    /// Leads and sensor see the whole power, the part that was calibrated away as static included:
    /// unless it was calibrated again.
    pub(super) fn with_static_power(scope: &Scope, way: impl Fn(f64) -> Self) -> Vec<Self> {
        if scope.static_power > 0.0 {
            let with = way(scope.static_power).with(Detail::WithStatic { power_w: scope.static_power });
            vec![with.one_of_many(), way(0.0).one_of_many()]
        } else {
            vec![way(0.0)]
        }
    }
}
