//! The model against a covariance that nothing was integrated out of, on pure noise, and on runs
//! with an effect.

use std::slice::from_ref;

use logs::robot::Robot;
use logs::runs::{RawRun, Row, Rows, Run, Runs};
use model::effects::{Candidate, Regressor};
use model_core::effects::Term;
use model_core::estimator::Sample;
use model_core::torque::{Drive, TorqueModel};
use nalgebra::{DMatrix, DVector};

use super::LEVEL;
use super::evidence::{Marginal, Shape, Totals, Variances, gain_of_several, reduce};
use super::question::Question;
use super::rows::Kept;
use crate::report::{Report, Rival, example};
use residuals::noise::{Memory, Noise};
use residuals::predictor::{Predictor, State};
use residuals::types::{Base, Named, Options, Standing, Verdict};

/// Normal values: sums of twelve numbers of a multiplier.
pub(super) struct Normal(pub(super) u64);

impl Normal {
    fn next(&mut self) -> f64 {
        let mut uniform = || {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..12).map(|_| uniform()).sum::<f64>() - 6.0
    }

    /// Noise that remembers 0.7 of itself.
    fn coloured(&mut self, rows: usize, std_dev: f64) -> Vec<f64> {
        let mut last = 0.0;
        (0..rows)
            .map(|_| {
                last = 0.7 * last + self.next() * std_dev * (1.0_f64 - 0.49).sqrt();
                last
            })
            .collect()
    }
}

/// host-tools/tests/reference/gap_likelihood/dense.py has the same problem and prints the numbers.
#[test]
fn evidences_are_those_of_the_whole_covariance() {
    const ROWS: usize = 25;
    let shape = Shape { base: 2, functions: 3 };
    let value = |run: f64, row: f64, column: f64| {
        (0.37 * (column + 1.0) * row + 1.3 * run + 0.9 * column).sin()
            + 0.1 * column * (0.11 * row * (run + 1.0)).cos()
    };
    let variances = Variances {
        base: DMatrix::from_diagonal_element(2, 2, 1e-2),
        shared: vec![0.3, 0.02, 0.5],
        runs: vec![0.1, 0.2, 0.05],
    };
    let runs: Vec<Marginal> = (0..4)
        .map(|run| {
            let columns =
                DMatrix::from_fn(ROWS, 7, |row, column| value(f64::from(run), row as f64, column as f64));
            Marginal::of(&columns.tr_mul(&columns), shape, &variances.runs).unwrap()
        })
        .collect();
    let totals = Totals::of(shape, runs.iter().enumerate().map(|(run, marginal)| (run < 2, marginal)));
    let (size, other) = (0.7, 0.04);
    let none = reduce(&totals, shape, &variances, 0.0).unwrap();
    let with = reduce(&totals, shape, &variances, other).unwrap();
    let gain = |reduced: &super::evidence::Reduced| {
        let along = DVector::from_element(1, reduced.products[(1, 0)]);
        let square = DMatrix::from_element(1, 1, reduced.products[(1, 1)]);
        let any = (f64::NEG_INFINITY, f64::INFINITY);
        let one = super::evidence::gain(along[0], square[(0, 0)], size, any);
        assert!((one - gain_of_several(&along, &square, &[size])).abs() < 1e-9);
        one
    };
    let evidences = [gain(&none), 0.5 * (none.minus_two_log - with.minus_two_log), gain(&with)];
    let expected = [-1.362_358_929_720_478_8, -0.384_775_033_954_284_25, -1.361_948_299_994_644_2];
    for (evidence, expected) in evidences.iter().zip(expected) {
        assert!((evidence - expected).abs() < 1e-6, "{evidence} {expected}");
    }
}

/// On noise alone z is a standard normal variable: its variance over 33 columns of twelve runs is 1
/// within three standard errors, 0.2, in the filter's band as well, whatever it leaves empty.
#[test]
fn the_variance_of_z_on_pure_noise_is_one() {
    let mut normal = Normal(5);
    let mut runs = runs(18, &[], &mut normal);
    runs.runs[..6].iter_mut().for_each(|run| run.clean = true);
    let kept = Kept::of(&runs);
    for filtered in [false, true] {
        let noise_of = |(place, run): (usize, &Run)| {
            let rows = normal.coloured(run.rows.len(), 0.05);
            kept.thin(place, &if filtered { runs.smoothed(run, rows) } else { rows })
        };
        let noise: Vec<Vec<f64>> = runs.runs.iter().enumerate().map(noise_of).collect();
        let columns: Vec<_> = noise.iter().map(|run| vec![run.clone()]).collect();
        let told = Noise::estimate(&kept.runs, &columns, Memory::OfClean);
        let mut squares = Vec::new();
        for (place, noise) in noise.iter().enumerate().skip(6) {
            let y = told.whiten(&kept.runs, place, noise);
            for k in 0..33 {
                let column = (0..y.len()).map(|row| (0.03 * (f64::from(k) + 0.5) * row as f64).sin());
                let x = told.whiten(&kept.runs, place, &column.collect::<Vec<_>>());
                let [along, square] =
                    [&y, &x].map(|other| x.iter().zip(other).map(|(x, other)| x * other).sum::<f64>());
                squares.push(along * along / square);
            }
        }
        let variance = squares.iter().sum::<f64>() / squares.len() as f64 / told.modelled();
        assert!((variance - 1.0).abs() < 0.2, "{filtered}: {variance}");
    }
}

const TORQUE: [f64; 7] = [0.05, 0.01, 0.004, 0.002, 1.3, 2.0, 0.0];

/// Runs of a minute with what the base predicts, an effect, and noise.
pub(super) fn runs(count: u32, effects: &[(Regressor, f64)], normal: &mut Normal) -> Runs {
    let burger = Robot::named("burger").unwrap().chassis(2.0).unwrap();
    let raw = (0..count).map(|run| {
        let pace = 0.3 + 0.11 * f64::from(run % 5);
        let rows = (0..1200).map(|k| {
            let time = 0.05 * f64::from(k);
            let speed = [5.0 * (pace * time).sin(), 4.0 * (0.7 * pace * time + f64::from(run)).sin()];
            let sample = Sample { wheel_speed: speed, wheel_acceleration: None, power: 0.0 };
            (time, sample.into(), 1.0 + f64::from(run % 4), Vec::new())
        });
        RawRun { name: format!("run{run}"), rows: rows.collect(), columns: Vec::new(), period_s: 0.05 }
    });
    let mut runs = Runs::condition_to(&burger, raw.collect(), Rows::Before).unwrap();
    let state = State { torque: TorqueModel::from_array(TORQUE), effects: effects.to_vec() };
    let powers: Vec<Vec<f64>> = {
        let predictor = Predictor::new(&runs, Drive::Dissipative);
        (0..count as usize).map(|run| predictor.predict(run, &state)).collect()
    };
    for (place, powers) in powers.into_iter().enumerate() {
        let noise = normal.coloured(powers.len(), 0.05);
        let noise = runs.smoothed(&runs.runs[place], noise);
        let run = &mut runs.runs[place];
        let rows = run.rows.iter().zip(powers).zip(noise);
        run.rows = rows.map(|((row, power), noise)| Row { power: power + noise, ..*row }).collect();
    }
    runs
}

fn base(torque: TorqueModel<f64>) -> Base {
    Base {
        torque,
        covariance: Some(DMatrix::from_diagonal_element(6, 6, 1e-8)),
        drive: Drive::Dissipative,
        masses_kg: vec![1.0, 4.0],
        of_simulator: false,
    }
}

/// A gap without a name, held to runs with these effects.
fn unexplained(clean: &Runs, field: &Runs) -> Report {
    let base = base(TorqueModel::from_array(TORQUE));
    example::report(Verdict::Unexplained).weighed(field, clean, &base, &Options::default(), LEVEL)
}

/// A drag is named in such runs, which stands out or not.
fn dragged(clean: &Runs, field: &Runs, standing: Standing) -> Report {
    named_in(clean, field, &[(Regressor::Term(Term::Drag(0)), 0.03)], standing)
}

/// A drag of another size in every run, clean or not, is nothing of the field.
#[test]
fn a_gap_that_other_labels_show_is_none() {
    let mut normal = Normal(21);
    let differing = |normal: &mut Normal| {
        let drags: Vec<_> = (0..6)
            .map(|run| (Regressor::InRun(run, Term::Drag(0)), 0.03 * normal.coloured(1, 1.0)[0]))
            .collect();
        runs(6, &drags, normal)
    };
    let (clean, field) = (differing(&mut normal), differing(&mut normal));
    let faint = dragged(&clean, &field, Standing::Faint);
    for report in [unexplained(&clean, &field), faint] {
        assert_eq!(report.verdict, Verdict::None, "{:?}", report.relabelled);
        assert!(report.effects.is_empty());
    }
}

/// The same drag in all field runs, or drags of any sign in these alone.
#[test]
fn a_gap_of_the_field_alone_stays() {
    let mut normal = Normal(22);
    let clean = runs(6, &[], &mut normal);
    let shared = runs(6, &[(Regressor::Term(Term::Drag(0)), 0.03)], &mut normal);
    let signs = [0.1, -0.1, 0.1, -0.1, 0.1, -0.1];
    let drags = signs.iter().enumerate().map(|(run, drag)| (Regressor::InRun(run, Term::Drag(0)), *drag));
    let scattered = runs(6, &drags.collect::<Vec<_>>(), &mut normal);
    let (few_clean, few_shared) = (clean.subset(&[0, 1]), shared.subset(&[0, 1]));
    for (standing, without) in
        [(Standing::Faint, Verdict::Unexplained), (Standing::WithinClean, Verdict::None)]
    {
        let report = dragged(&clean, &shared, standing);
        assert_eq!((report.verdict, report.effects.len()), (Verdict::Named, 1), "{:?}", report.relabelled);
        // Too few runs have other labels at this level.
        let report = dragged(&few_clean, &few_shared, standing);
        assert_eq!((report.verdict, report.effects.len()), (without, 0), "{:?}", report.notes);
    }
    for field in [shared, scattered] {
        let report = unexplained(&clean, &field);
        assert_eq!(report.verdict, Verdict::Unexplained, "{:?}", report.relabelled);
    }
}

/// A drag of the left wheel beside a slope in a tie: the slope is struck.
#[test]
fn an_improbable_rival_is_struck() {
    let mut normal = Normal(23);
    let clean = runs(6, &[], &mut normal);
    let drag = Regressor::Term(Term::Drag(0));
    let field = runs(6, &[(drag.clone(), 0.03)], &mut normal);
    let base = base(TorqueModel::from_array(TORQUE));
    let options = Options::default();
    let question = Question::of(&field, &clean, &base, &options);
    let rival = |regressor: &Regressor, size| {
        let with = |candidate: &&Candidate| candidate.regressors == [regressor.clone()];
        let candidate = question.testable.list.iter().find(with).unwrap().clone();
        let state = State { torque: base.torque, effects: vec![(regressor.clone(), size)] };
        Rival { candidate, state }
    };
    let slope = Regressor::Term(Term::GradeAhead);
    let tie = vec![rival(&drag, 0.03), rival(&slope, 0.01)];
    let given = example::report(Verdict::Ambiguous);
    let named = Named { candidate: tie[0].candidate.clone(), ..given.effects[1].clone() };
    let (effects, ambiguous_with) = (vec![named], vec!["grade".to_owned()]);
    let report = Report { effects, ambiguous_with, ties: vec![tie], ..given };
    let report = report.weighed(&field, &clean, &base, &options, LEVEL);
    assert_eq!((report.verdict, &report.ambiguous_with[..]), (Verdict::Named, &[][..]));
    assert_eq!(report.rivals[0].0.as_str(), "wheel-drag");
    assert!(report.rivals[0].1 > 0.99, "{:?}", report.rivals);
}

/// Names of the rules, weighed beside clean runs: field runs with these effects.
fn named(field: &[(Regressor, f64)], names: &[(Regressor, f64)]) -> Report {
    let mut normal = Normal(23);
    let clean = runs(6, &[], &mut normal);
    named_in(&clean, &runs(6, field, &mut normal), names, Standing::Clear)
}

/// The same of these runs, however names stand.
fn named_in(clean: &Runs, field: &Runs, names: &[(Regressor, f64)], standing: Standing) -> Report {
    let base = base(TorqueModel::from_array(TORQUE));
    let options = Options::default();
    let question = Question::of(field, clean, &base, &options);
    let given = example::report(Verdict::Named);
    let named = |(regressor, size): &(Regressor, f64)| {
        let with = |candidate: &&Candidate| candidate.regressors == [regressor.clone()];
        let candidate = question.testable.list.iter().find(with).unwrap().clone();
        Named { candidate, coefficients: vec![*size], ..given.effects[0].clone() }
    };
    let report = Report { effects: names.iter().map(named).collect(), standing, ..given.clone() };
    report.weighed(field, clean, &base, &options, LEVEL)
}

/// A run of a quarter of a minute has fewer columns of its own than the others.
#[test]
fn runs_may_be_of_any_length() {
    let mut normal = Normal(12);
    let clean = runs(6, &[], &mut normal);
    let drags = (Regressor::Term(Term::Drag(0)), 0.03);
    let mut field = runs(6, from_ref(&drags), &mut normal);
    let short: Vec<Row> = field.runs[0].rows.iter().take(300).copied().collect();
    field.runs[0].rows = short.into();
    let report = named_in(&clean, &field, &[drags], Standing::Clear);
    assert_eq!(report.rivals[0].0, "wheel-drag");
    assert!(report.rivals[0].1 > 0.95, "{:?}", report.rivals);
}

/// A slope is named where the left wheel drags: it is taken back.
#[test]
fn an_improbable_name_is_taken_back() {
    let drags = (Regressor::Term(Term::Drag(0)), 0.03);
    let slope = named(from_ref(&drags), &[(Regressor::Term(Term::GradeAhead), 0.01)]);
    assert_eq!((slope.verdict, slope.effects.len()), (Verdict::Unexplained, 0), "{:?}", slope.rivals);
    let headline = crate::report::summary::headline(&slope);
    assert!(headline.contains("would be named, but wheel-drag is likelier"), "{headline}");
    let drag = named(from_ref(&drags), from_ref(&drags));
    assert_eq!((drag.verdict, drag.effects.len()), (Verdict::Named, 1), "{:?}", drag.rivals);
}

/// The left wheel drags and the road slopes. Both names stay; thicker grease beside the drag is none.
#[test]
fn each_of_two_names_is_weighed_beside_the_other() {
    let drag = (Regressor::Term(Term::Drag(0)), 0.06);
    let slope = (Regressor::Term(Term::GradeAhead), 0.02);
    let both = [drag.clone(), slope];
    let right = named(&both, &both);
    assert_eq!(right.verdict, Verdict::Named, "{:?}", right.rivals);
    let ids: Vec<&str> = right.rivals.iter().map(|(id, _)| id.as_str()).collect();
    assert_eq!(ids, ["wheel-drag", "grade"]);
    assert!(right.rivals.iter().all(|(_, share)| *share > 0.95), "{:?}", right.rivals);
    let wrong = named(&both, &[drag, (Regressor::Term(Term::Viscous), 0.002)]);
    assert_eq!((wrong.verdict, wrong.effects.len()), (Verdict::Unexplained, 0), "{:?}", wrong.rivals);
    assert_eq!(wrong.rivals[0].0, "grade");
}

/// From coefficients that are a fifth off, the base goes back to the one that made the clean runs.
#[test]
fn the_base_is_fitted_anew_by_clean_runs() {
    let clean = runs(6, &[], &mut Normal(3));
    let start = TorqueModel::from_array(TORQUE.map(|value| 1.2 * value));
    let fitted = crate::clean_base::fitted(&clean, &base(start));
    let predictor = Predictor::new(&clean, Drive::Dissipative);
    let power = |values: [f64; 7]| {
        predictor.predict(0, &State { torque: TorqueModel::from_array(values), effects: Vec::new() })
    };
    let truth = power(TORQUE);
    let off = |values: [f64; 7]| {
        let squares = power(values).iter().zip(&truth).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
        (squares / truth.len() as f64).sqrt()
    };
    let (before, after) = (off(start.to_array()), off(fitted.to_array()));
    assert!(after < 0.05 * before, "{after} {before}");
}
