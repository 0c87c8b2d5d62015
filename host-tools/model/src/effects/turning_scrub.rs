//! Tyres that scrub in turns: a torque along the turn.

use model_core::effects::{Cause, Term};

use super::candidate::Way;
use super::detail::Detail;
use super::entry::Entry;
use super::fields::{Fields, Read};
use super::key;
use super::physical::{Conversion, World};
use super::regressor::Regressor;
use super::scope::Scope;
use super::sign::Sign;

pub(super) const TURNING_SCRUB: Entry = Entry {
    id: "turning-scrub",
    meaning: "tyres scrub in turns, or otherwise than in the fit",
    unit: "N·m",
    sign: Sign::Either,
    needs: "",
    single_runs: false,
    shows_in: "spin on the spot, then go straight at the same wheel speed",
    typical: &["turning-scrub=0.05"],
    physical: |detail| Some(moment(detail)),
    candidates,
    owns,
    read,
    cause: |finding| finding.everywhere(),
};

/// Moment of friction about the turning centre: what it takes times the turn rate is what the
/// outermost wheel's torque takes times its speed.
fn moment(detail: &Detail) -> Conversion {
    let of = |coefficient: f64, world: &World| {
        let moment = coefficient / (world.torque.load_gain() * world.turn);
        Some(moment).filter(|moment| moment.is_finite())
    };
    let unit = if *detail == Detail::DependsOnMass(false) { "N·m" } else { "N·m/kg" };
    Conversion { unit, of }
}

/// Slip at which 1/√2 of a scrub is there that shares its grip with rolling; the best is searched
/// about it. Chosen: at four times as much only spins show it, at a quarter it is the sign of the
/// turn.
const HALF_SLIP: f64 = 0.5;

fn candidates(scope: &Scope) -> Result<Vec<Way>, String> {
    let constant =
        Way::new(Regressor::Term(Term::Scrub), (0.0, scope.much())).with(Detail::DependsOnMass(false));
    // Where the base has a scrub of its own, tyres or floor may also have less grip than they had.
    let least = if scope.scrubs { -scope.base.supplied_scrub() } else { 0.0 };
    let per_kg = Way::new(Regressor::Term(Term::ScrubPerKg), (least, scope.much_per_kg()));
    let per_kg = per_kg.in_unit("N·m/kg").with(Detail::DependsOnMass(true));
    let mut ways = vec![constant.one_of_many(), per_kg.one_of_many()];
    if scope.slips {
        let scrub = vec![Regressor::Term(Term::ScrubPerKg), Regressor::HalfSlip];
        let way = Way::of_several(scrub, (least, scope.much_per_kg())).in_unit("N·m/kg");
        ways.push(way.with(Detail::WithHalfSlip));
    }
    if scope.has_sides() {
        let sliding = Way::new(Regressor::Term(Term::Sliding(HALF_SLIP)), (least, scope.much_per_kg()));
        let sliding = sliding.in_unit("N·m/kg").with(Detail::Sliding { half_slip: HALF_SLIP });
        ways.push(sliding.one_of_many());
    }
    Ok(ways)
}

/// The half slip may come with another floor's rolling resistance, too; by itself it is how tyres
/// scrub.
fn owns(cause: &Cause<f64>) -> bool {
    matches!(cause, Cause::HalfSlip | Cause::Term(Term::Scrub | Term::ScrubPerKg | Term::Sliding(_)))
}

fn read(fields: &Fields<'_>) -> Read {
    if fields.has(key::WITH) {
        return fields.term_with_half_slip(Term::ScrubPerKg);
    }
    match fields.flag(key::DEPENDS_ON_MASS) {
        Some(true) if fields.has(key::HALF_SLIP) => {
            fields.term(Term::Sliding(fields.number(key::HALF_SLIP)?))
        }
        Some(true) => fields.term(Term::ScrubPerKg),
        Some(false) => fields.term(Term::Scrub),
        None => fields.unclear("depends_on_mass = true or false"),
    }
}
