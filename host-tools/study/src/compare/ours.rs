//! The models of this project and the paper, as `compare` runs them.

use fit::dataset::Dataset;
use fit::{Fit, pgd};
use logs::robot::Robot;
use model::coefficients::{Method, ModelKind};
use support::error::Result;

use crate::baselines;

/// A model of this project or the paper: it can estimate the mass.
#[derive(Debug, Clone, Copy)]
pub struct OurModel {
    /// Its name in tables and in `gmr compare --models`.
    pub name: &'static str,
    /// What it is, in one line.
    pub source: &'static str,
    /// What it assumes beyond that, in one line.
    pub assumes: &'static str,
    pub(super) kind: ModelKind,
    pub(super) method: Method,
}

impl OurModel {
    pub(super) fn fit(&self, robot: &Robot, train: &Dataset) -> Result<Fit> {
        let rows = train.with_gate(self.kind.gate());
        fit::fit(robot, &rows, self.kind, self.method, &pgd::Settings::default())
    }
}

/// The models of this project and the paper, in the order of the table.
pub const OURS: [OurModel; 3] = [
    OurModel {
        name: "signed",
        source: "signed torque model (default)",
        assumes: "motors of one kind, wheels that roll without slipping",
        kind: ModelKind::Signed,
        method: Method::Physical,
    },
    OurModel {
        name: "eq18",
        source: "Eq. 18, corrected",
        assumes: "as the signed model, and inertial torque only where it speeds a wheel up",
        kind: ModelKind::Eq18,
        method: Method::Nnls,
    },
    OurModel {
        name: "eq18-published",
        source: "Eq. 18 as printed, Algorithm 1",
        assumes: "as eq18, with the derivation's slips: the squared inertial torque counts in braking, too, and goes with m, not m²",
        kind: ModelKind::Eq18Published,
        method: Method::Pgd,
    },
];

/// Every model's name: those of this project and the paper, then the baselines.
pub fn names() -> impl Iterator<Item = &'static str> {
    OURS.iter().map(|model| model.name).chain(baselines::every().map(|card| card.name))
}
