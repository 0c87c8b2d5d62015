//! Another floor: a torque in proportion to the mass, beyond the fitted one.

use model_core::effects::{Cause, GRAVITY, Term};
use support::error;

use super::candidate::Way;
use super::detail::Detail;
use super::entry::Entry;
use super::physical::Conversion;
use super::plant::{Finding, GREATEST_LOSS, PlantCause};
use super::regressor::Regressor;
use super::sign::Sign;

pub(super) const ROLLING_RESISTANCE_CHANGE: Entry = Entry {
    id: "rolling-resistance-change",
    meaning: "the floor is another than in the fit",
    unit: "N·m/kg",
    sign: Sign::Either,
    needs: "",
    single_runs: false,
    shows_in: "drive the same way empty and fully loaded",
    typical: &["rolling-resistance-change=0.01"],
    physical: |_| Some(FLOOR),
    candidates: |scope| {
        let constant = if scope.one_mass { scope.base.supplied_coulomb() / scope.mass } else { 0.0 };
        let range = (-scope.base.supplied_rolling() - constant, scope.much_per_kg());
        let rolling = Regressor::Term(Term::Rolling);
        let mut ways = vec![Way::new(rolling.clone(), range)];
        if scope.slips {
            ways.push(Way::of_several(vec![rolling, Regressor::HalfSlip], range).with(Detail::WithHalfSlip));
        }
        Ok(ways)
    },
    owns: |cause| matches!(cause, Cause::Term(Term::Rolling)),
    read: |fields| fields.term_with_half_slip(Term::Rolling),
    cause: change,
};

/// Friction coefficient of the floor by the torque per kilogram of every wheel: μ g m r / N of the
/// weight on it, r / N being what a wheel moves the robot forward. Told where all wheels do so
/// alike.
pub(super) const FLOOR: Conversion = Conversion {
    unit: "1",
    of: |coefficient, world| Some(coefficient / (world.torque.load_gain() * GRAVITY * world.forward?)),
};

/// A floor never loses all of its resistance.
pub(super) fn change(finding: &Finding<'_>) -> error::Result<Result<PlantCause, String>> {
    let least = -GREATEST_LOSS * finding.scene.rolling;
    finding.everywhere_within(|low, high| (low.max(least), high))
}
