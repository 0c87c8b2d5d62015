//! Invented reports, one of each verdict, for tests of what is shown.

use model::effects::{Candidate, Detail, NotTestable, Regressor, Runs, World, physical};
use model_core::effects::Term;
use model_core::torque::{Drive, TorqueModel};
use nalgebra::DMatrix;
use numerics::intervals::mean_interval;

use super::localise::Cell;
use crate::confirm::Confirmed;
use crate::report::{Basis, Report};
use crate::words;
use residuals::noise::whiten::Whitener;
use residuals::predictor::State;
use residuals::split::Split;
use residuals::types::{Named, Round, Scored, Standing, Status, Verdict};

/// As full as a report may be: twelve runs with long names, three effects, many ties and cells.
pub(crate) fn report(verdict: Verdict) -> Report {
    let stands = verdict.stands();
    let effects = [
        named(
            "grade",
            vec![
                Regressor::Term(Term::GradeAlong([1.0, 0.0])),
                Regressor::Term(Term::GradeAlong([0.0, 1.0])),
            ],
            "1",
        ),
        named("viscous-change", vec![Regressor::Term(Term::Viscous)], "N·m·s/rad"),
        named("payload-mislabel", (0..4).map(Regressor::Mass).collect(), "kg"),
    ];
    let scored = |id: &str, status| Scored {
        id: id.to_owned(),
        detail: Detail::TimeConstant { time_s: 9.0 },
        gain: 100.0,
        coefficients: vec![f64::NAN],
        status,
    };
    let torque = TorqueModel { inertia_gain: 1.0, ..TorqueModel::from_array([0.01; 7]) };
    let residual = vec![vec![0.5; 4]; 12];
    Report {
        verdict,
        standing: Standing::Clear,
        effects: if stands { effects.into() } else { Vec::new() },
        ambiguous_with: match verdict {
            Verdict::Ambiguous => {
                ["windage", "stribeck", "lubricant-warm-up", "supply-sag", "sensor-gain", "wheel-drag"]
                    .map(str::to_owned)
                    .into()
            }
            _ => Vec::new(),
        },
        not_testable: (0..6)
            .map(|k| NotTestable { id: format!("effect-{k}"), reason: "needs cpu_percent".to_owned() })
            .collect(),
        rounds: vec![Round {
            structure: 30.0,
            allowed: 5.0,
            candidates: vec![
                scored("grade", Status::Winner),
                scored("windage", Status::Tie),
                scored("stribeck", Status::Implausible),
            ],
            outcome: "added grade".to_owned(),
        }],
        localisation: (0..8).map(|k| cell(k, stands)).collect(),
        residuals: (residual.clone(), stands.then_some(residual)),
        over_dispersion: None,
        clean_structure: None,
        refit: Vec::new(),
        ties: Vec::new(),
        rivals: Vec::new(),
        relabelled: None,
        notes: Vec::new(),
        basis: Some(Basis {
            drive: Drive::Dissipative,
            clean_delay: 0.0,
            whitener: Whitener { coefficients: Vec::new() },
            std_w: 1.0,
            precision: DMatrix::zeros(0, 0),
        }),
        confirmed: Confirmed {
            share: None,
            clean_w: None,
            runs: (0..4).map(|k| format!("a/rather/long/folder/for/runs/with_a_long_name_{k}.csv")).collect(),
            before_w: 0.31,
            after_w: if stands { 0.11 } else { 0.31 },
            floor_w: 0.1,
            floor_unclipped_w: 0.12,
            floor_how: "so and so",
            closed: stands.then_some(0.96),
            gain_w2: mean_interval(&[0.05, 0.09, 0.07, 0.07]),
            by_run: vec![(0.09, 0.012); 4],
            residuals: [vec![vec![0.3; 4]; 4], vec![vec![0.1; 4]; 4]],
        },
        state: State { torque, effects: Vec::new() },
        covariance: None,
        split: Split { open: (0..8).collect(), locked: (8..12).collect() },
        base: [torque, torque],
    }
}

fn named(id: &str, regressors: Vec<Regressor>, unit: &str) -> Named {
    let count = regressors.len();
    let mut named = Named {
        candidate: Candidate {
            id: id.to_owned(),
            regressors,
            unit: unit.to_owned(),
            range: (-1.0, 1.0),
            least: Vec::new(),
            detail: Detail::InRuns {
                runs: Runs::Named(vec!["x/one.csv".to_owned(), "x/two.csv".to_owned()]),
                at_s: None,
            },
            search: 0.0,
        },
        coefficients: (0..count).map(|k| 0.03 * (k as f64 + 1.0)).collect(),
        std_errs: vec![0.001; count],
        physical: None,
    };
    // Wheels of 33 mm, 160 mm apart; gears that pass three quarters of the torque.
    let torque = TorqueModel { inertia_gain: 4.0 / 3.0, ..TorqueModel::default() };
    let world = World { torque, covariance: DMatrix::zeros(0, 0), forward: Some(0.0165), turn: 0.2 };
    named.physical = physical(&named.candidate, words::headline(&named), &[], &world);
    named
}

fn cell(k: usize, stands: bool) -> Cell {
    Cell {
        axis: format!("axis {}", k % 4),
        from: k as f64,
        to: k as f64 + 1.0,
        mean_residual_w: 0.1 * k as f64,
        band_w: 0.05,
        mean_after_w: stands.then_some(0.0),
        band_after_w: stands.then_some(0.05),
        runs: 12,
        words: format!("a rather long description of the cell with the number {k}"),
    }
}
