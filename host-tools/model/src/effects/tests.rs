//! Every list in the tree that names effects names exactly those of [`ENTRIES`], and what one place
//! says of them the others mean.

use ::plant::effects::{Effect, entries};
use model_core::effects::{Cause, Side, Term};
use model_core::torque::TorqueModel;
use nalgebra::DMatrix;
use serde_json::json;

use super::written::{Written, columns, id_of};
use super::*;

/// A robot with two wheels, its base, and columns without a plausible content.
fn scope(columns: &[&str]) -> Scope {
    let column = |(place, name): (usize, &&str)| ScopeColumn { name: (*name).to_owned(), place, least: 20.0 };
    Scope {
        base: TorqueModel::from_array([0.03, 0.01, 0.01, 0.003, 1.3, 3.0, 0.0]),
        regenerative: false,
        one_mass: false,
        scrubs: false,
        slips: false,
        static_power: 0.0,
        sides: vec![-1.0, 1.0],
        columns: columns.iter().enumerate().map(column).collect(),
        speed: 10.0,
        torque: 0.15,
        mass: 2.0,
        empty: 1.0,
        lightest: 1.0,
        duration: 60.0,
        power: 5.0,
    }
}

/// Candidates of runs without further columns, and with all that effects ask for.
fn all_candidates() -> Vec<Candidate> {
    let plain = candidates(&scope(&[PROCESSOR])).0;
    let with_static = candidates(&Scope { static_power: 6.0, ..scope(&[]) }).0;
    let measured = candidates(&scope(&[PITCH, "motor1_temp_c", "motor2_temp_c"])).0;
    let base = TorqueModel { scrub: 0.02, ..scope(&[]).base };
    let skidding = candidates(&Scope { base, scrubs: true, slips: true, ..scope(&[]) }).0;
    [plain, with_static, measured, skidding].concat()
}

fn ids() -> Vec<&'static str> {
    ENTRIES.iter().map(|entry| entry.id).collect()
}

#[test]
fn the_plant_has_a_cause_for_each_and_no_other() {
    assert_eq!(entries().map(|cause| cause.id).collect::<Vec<_>>(), ids());
    for entry in &ENTRIES {
        assert!(!entry.typical.is_empty() && !entry.shows_in.is_empty(), "{}", entry.id);
        for typical in entry.typical {
            assert_eq!(Effect::parse(typical).unwrap().id(), entry.id);
        }
    }
}

/// Between the heading "What it can name" and the next: one row an effect, in this order, with unit
/// and sign as here.
#[test]
fn the_documentation_names_each_and_no_other() {
    let docs = include_str!("../../../../docs/gap.md");
    let section = docs.split("## What it can name").nth(1).unwrap().split("\n## ").next().unwrap();
    let rows: Vec<&str> = section.lines().filter(|line| line.starts_with("| `")).collect();
    let expected: Vec<String> = ENTRIES.iter().map(table_row).collect();
    assert_eq!(rows, expected, "expected:\n{}", expected.join("\n"));
}

fn table_row(entry: &Entry) -> String {
    let sign = match entry.sign {
        Sign::Positive => "+",
        Sign::Negative => "−",
        Sign::Either => "±",
    };
    let needs = if entry.needs.is_empty() { "" } else { "; needs " };
    let code = |text: &str| if text.contains('_') { format!("`{text}`") } else { text.to_owned() };
    let needed = code(entry.needs);
    format!("| `{}` | {sign} {} | {}{needs}{needed} |", entry.id, entry.unit, entry.meaning)
}

/// The second simulator, which judges the names, has a cause for each as well.
#[test]
fn the_judge_has_a_cause_for_each() {
    let judge = include_str!("../../../tests/reference/gap_judge/effects.py");
    for id in ids() {
        assert!(judge.contains(&format!("\"{id}\"")), "{id}");
    }
}

/// What the file's words mean is what the workflow fitted, for every candidate.
#[test]
fn every_candidate_is_written_as_what_it_was_fitted_as() {
    let mut seen = Vec::new();
    for candidate in all_candidates().into_iter().chain(at_times()) {
        let coefficients = vec![0.001; candidate.regressors.len()];
        let expected: Vec<Option<Cause<f64>>> = candidate.regressors.iter().map(in_core).collect();
        let Ok(written) = Written::of(&candidate, &coefficients, &coefficients) else {
            assert_eq!(candidate.id, "payload-mislabel");
            continue;
        };
        let text = toml::to_string(&written).unwrap();
        let read: Written = toml::from_str(&text).unwrap();
        assert_eq!(read, written, "{text}");
        let columns = columns(&[read], 2).unwrap();
        let causes: Vec<Option<Cause<f64>>> = columns.iter().map(|column| Some(column.cause)).collect();
        assert_eq!(causes, expected, "{text}");
        for column in columns.iter().filter(|column| column.cause != Cause::HalfSlip) {
            assert_eq!(id_of(&column.cause).0, written.id);
        }
        seen.push(written.id);
    }
    for id in ids() {
        assert!(id == "payload-mislabel" || seen.iter().any(|other| other == id), "{id}");
    }
}

/// What only appears at times that were found in runs.
fn at_times() -> [Candidate; 2] {
    [(STATIC_STEP, Switched::Static), (SURFACE_SWITCH, Switched::Rolling)].map(|(entry, what)| {
        let at = Detail::At { at_s: 20.0 };
        entry.candidate(vec![Regressor::Term(what.from(20.0).unwrap())], (-1.0, 1.0), at, 0.0)
    })
}

/// By the regressors themselves, not by the words about them.
fn in_core(regressor: &Regressor) -> Option<Cause<f64>> {
    Some(match regressor {
        // A board is not ahead of its time.
        Regressor::Term(Term::WithMotion(hold)) => Cause::Term(Term::WithMotion(hold.max(0.0))),
        Regressor::Term(term) => Cause::Term(*term),
        Regressor::Heat(time) => Cause::Heat(*time),
        Regressor::Warming(time) => Cause::Warming(*time),
        Regressor::Hot => Cause::Hot,
        Regressor::Temperature(_, cold) => Cause::Temperature(*cold),
        Regressor::Delay => Cause::Delay,
        Regressor::HalfSlip => Cause::HalfSlip,
        Regressor::Scale(side) if *side < 0.0 => Cause::Scale(Side::Left),
        Regressor::Scale(side) if *side > 0.0 => Cause::Scale(Side::Right),
        Regressor::Scale(_) => Cause::Scale(Side::Both),
        Regressor::Column(_) => Cause::Term(Term::Driver),
        _ => return None,
    })
}

/// Every regressor of the board's model belongs to one effect.
#[test]
fn no_two_effects_own_the_same_column() {
    for candidate in all_candidates() {
        for cause in candidate.regressors.iter().filter_map(in_core) {
            let owners: Vec<&str> =
                ENTRIES.iter().filter(|entry| (entry.owns)(&cause)).map(|entry| entry.id).collect();
            // A half slip is the scrub's, with whatever it comes.
            let owner = if cause == Cause::HalfSlip { "turning-scrub" } else { &candidate.id };
            assert_eq!(owners, [owner], "{cause:?}");
        }
    }
}

/// Scripts read these keys.
#[test]
fn details_have_the_keys_that_scripts_know() {
    let names = Runs::Named(vec!["a.csv".to_owned()]);
    for (detail, expected) in [
        (Detail::Plain, json!({})),
        (Detail::Slope(Along::Pitch), json!({"by": "pitch_rad"})),
        (Detail::Slope(Along::Ahead), json!({"along": "the way ahead"})),
        (Detail::Slope(Along::World), json!({"along": "a direction of the world"})),
        (Detail::Heated(Heated::FromStart), json!({"from": "the start"})),
        (Detail::Heated(Heated::ByLoss(9.0)), json!({"time_constant_s": 9.0})),
        (Detail::Heated(Heated::WithTime(9.0)), json!({"by": "time", "time_constant_s": 9.0})),
        (Detail::Heated(Heated::Measured(21.0)), json!({"by": "motor temperatures", "from_c": 21.0})),
        (Detail::Width { speed_rad_s: 2.0 }, json!({"speed_rad_s": 2.0})),
        (Detail::Wheel { wheel: 2, side: WheelSide::Right }, json!({"wheel": 2, "side": "right"})),
        (Detail::Side(WheelSide::Both), json!({"side": "both"})),
        (Detail::DependsOnMass(true), json!({"depends_on_mass": true})),
        (Detail::Sliding { half_slip: 0.5 }, json!({"depends_on_mass": true, "half_slip": 0.5})),
        (Detail::WithHalfSlip, json!({"with": "half_slip"})),
        (Detail::OffCentre { empty_kg: 50.0 }, json!({"empty_kg": 50.0})),
        (Detail::WithStatic { power_w: 6.0 }, json!({"with_static_w": 6.0})),
        (Detail::WithMotion { hold_s: 1.0 }, json!({"with": "motion", "hold_s": 1.0})),
        (Detail::FromFirstMotion, json!({"from": "the first motion on"})),
        (Detail::At { at_s: 3.0 }, json!({"at_s": 3.0, "runs": "all"})),
        (Detail::InRuns { runs: Runs::All, at_s: None }, json!({"runs": "all"})),
        (
            Detail::InRuns { runs: names, at_s: Some(vec![Some(1.0), None]) },
            json!({"runs": ["a.csv"], "at_s": [1.0, null]}),
        ),
    ] {
        assert_eq!(serde_json::to_value(&detail).unwrap(), expected);
    }
}

fn any(id: &str, detail: Detail) -> Candidate {
    find(id).unwrap().candidate(Vec::new(), (-1.0, 1.0), detail, 0.0)
}

/// 0.04 of gravity's share with an inertia gain of 1.3333 ± 0.0133 is a slope of 0.03: 1 % of the
/// coefficient's error and 1 % of the gain's are √2 % of the slope, and where both err alike
/// nothing.
#[test]
fn a_slope_is_what_the_world_has_whatever_the_drive_folds_in() {
    let mut covariance = DMatrix::zeros(7, 7);
    covariance[(4, 4)] = (0.01_f64 * 0.8 / 0.75).powi(2);
    // With a loss of its own the gear takes a third either way: 0.8 / 0.75 · (1 + 0.25) = 1 / 0.75.
    let torque = TorqueModel { inertia_gain: 0.8 / 0.75, gear_loss: 0.25, ..TorqueModel::default() };
    let world = World { torque, covariance, forward: Some(0.0165), turn: 0.2 };
    let slope = any("grade", Detail::Slope(Along::Ahead));
    let size = physical(&slope, (0.04, 4e-4), &[], &world).unwrap();
    assert!((size.value - 0.03_f64.asin()).abs() < 1e-9 && size.unit == "rad", "{size:?}");
    assert!((size.std_err / (0.03 * 0.01 * 2.0_f64.sqrt()) - 1.0).abs() < 2e-3, "{size:?}");
    let alike = [0.0, 0.0, 0.0, 0.0, 4e-4 * 0.01 * 0.8 / 0.75];
    assert!(physical(&slope, (0.04, 4e-4), &alike, &world).unwrap().std_err < 1e-6);
    // A sensor's offset is what it is.
    let offset = any("sensor-offset", Detail::Plain);
    let size = physical(&offset, (0.2, 0.01), &[], &world).unwrap();
    assert_eq!((size.value, size.std_err, size.unit.as_str()), (0.2, 0.01, "W"));
}

/// Rolling resistance passes the gear: with a loss of 0.25 the motor supplies 1.25 of its 0.008
/// N·m/kg, of which 0.001 are a tenth, and half the track is 0.0165 m / 0.2.
#[test]
fn an_offset_is_told_of_what_the_motor_supplies() {
    let torque = TorqueModel { rolling: 0.008, gear_loss: 0.25, ..TorqueModel::default() };
    let world = World { torque, covariance: DMatrix::zeros(0, 0), forward: Some(0.0165), turn: 0.2 };
    let size = physical(&any("payload-offset", Detail::Plain), (0.001, 0.0), &[], &world).unwrap();
    assert!((size.value - 0.1 * 0.0165 / 0.2).abs() < 1e-12 && size.unit == "m", "{size:?}");
}

/// A half slip that steps is a share already, no floor's friction; a floor that steps is one.
#[test]
fn a_half_slip_that_steps_is_a_share() {
    let torque = TorqueModel { inertia_gain: 1.25, ..TorqueModel::default() };
    let world = World { torque, covariance: DMatrix::zeros(7, 7), forward: Some(0.0165), turn: 0.2 };
    let of = |what: Switched| {
        let regressors = vec![Regressor::Switch(what, [3.0].into())];
        let switch = Candidate { regressors, unit: "1".to_owned(), ..any("surface-switch", Detail::Plain) };
        physical(&switch, (0.6, 0.1), &[], &world).unwrap().value
    };
    assert_eq!(of(Switched::HalfSlip), 0.6);
    assert!((of(Switched::Rolling) - 0.6 / (1.25 * 9.80665 * 0.0165)).abs() < 1e-9);
}

/// A base of one mass may hold a floor as friction that does not depend on it: 0.03 N·m at 2 kg are
/// 0.015 N·m/kg.
#[test]
fn a_floor_may_take_away_what_a_base_of_one_mass_holds_as_friction_of_the_drive() {
    let least = |one_mass| {
        let all = candidates(&Scope { one_mass, ..scope(&[]) }).0;
        all.iter().find(|candidate| candidate.id == "rolling-resistance-change").unwrap().range.0
    };
    assert!((least(false) + 0.01).abs() < 1e-12);
    assert!((least(true) + 0.01 + 0.03 / 2.0).abs() < 1e-12);
}

/// Where wheels scrub in the base already, another floor may have less grip, and the ways of it in
/// proportion to the mass show.
#[test]
fn a_scrub_that_the_base_has_may_shrink() {
    let least = |scrubs| {
        let mut scope = Scope { scrubs, ..scope(&[]) };
        scope.base.scrub = 0.2;
        let all = candidates(&scope).0;
        let of_scrub = all.iter().filter(|candidate| candidate.id == "turning-scrub");
        of_scrub.map(|candidate| candidate.range.0).collect::<Vec<_>>()
    };
    assert_eq!(least(false), [0.0, 0.0, 0.0]);
    assert_eq!(least(true), [0.0, -0.2, -0.2]);
}

/// A gear that loses a quarter takes its share of what a floor loses along: at worst all of what
/// the motor supplies for it is gone.
#[test]
fn what_a_floor_may_lose_has_the_loss_of_the_gear() {
    let mut scope = Scope { scrubs: true, ..scope(&[]) };
    (scope.base.gear_loss, scope.base.scrub) = (0.25, 0.2);
    let all = candidates(&scope).0;
    let least = |id: &str| {
        let of_id = all.iter().filter(|candidate| candidate.id == id);
        of_id.map(|candidate| candidate.range.0).fold(f64::INFINITY, f64::min)
    };
    assert!((least("rolling-resistance-change") + 0.0125).abs() < 1e-12);
    assert!((least("turning-scrub") + 0.25).abs() < 1e-12);
}
