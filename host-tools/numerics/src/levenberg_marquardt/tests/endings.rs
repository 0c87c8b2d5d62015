//! Every ending, each by a problem that can end in no other way; and bounds.

use nalgebra::{DVector, SMatrix, SVector};

use super::super::{Bounds, Ending, FromResiduals, LeastSquares, Patience, Tolerances, descend};

type Vector = SVector<f64, 2>;
type Matrix = SMatrix<f64, 2, 2>;

/// A cost with derivatives that need not belong to it.
struct Made {
    cost: fn(&Vector) -> f64,
    gradient: fn(&Vector) -> Vector,
    matrix: Matrix,
}

impl LeastSquares<nalgebra::Const<2>> for Made {
    fn cost(&self, x: &Vector) -> f64 {
        (self.cost)(x)
    }

    fn derivatives(&self, x: &Vector) -> (Vector, Matrix) {
        ((self.gradient)(x), self.matrix)
    }
}

fn ending(problem: &Made, tolerances: &Tolerances) -> Ending {
    let start = Vector::new(1.0, 2.0);
    descend(problem, &start, &Bounds::none(&start), tolerances).ending
}

const BOWL: Made =
    Made { cost: |x| x.norm_squared(), gradient: |x| *x, matrix: Matrix::new(1.0, 0.0, 0.0, 1.0) };

#[test]
fn numbers_that_are_none_end_as_such() {
    let tolerances = Tolerances::default();
    let at_start = Made { cost: |_| f64::NAN, ..BOWL };
    assert_eq!(ending(&at_start, &tolerances), Ending::NotFinite);
    let derivative = Made { gradient: |_| Vector::new(f64::NAN, 1.0), ..BOWL };
    assert_eq!(ending(&derivative, &tolerances), Ending::NotFinite);
    // A number at the start only: no step, however small, is one.
    let elsewhere = Made { cost: |x| if *x == Vector::new(1.0, 2.0) { 5.0 } else { f64::NAN }, ..BOWL };
    assert_eq!(ending(&elsewhere, &tolerances), Ending::NotFinite);
}

/// [[1, 3], [3, 1]] has the eigenvalue −2: it can be factored once the damping is above 2, and then
/// leads to the minimum.
#[test]
fn a_failed_factorisation_raises_the_damping() {
    let indefinite = Made { matrix: Matrix::new(1.0, 3.0, 3.0, 1.0), ..BOWL };
    let start = Vector::new(1.0, 2.0);
    let tolerances = Tolerances { cost: 1e-20, ..Tolerances::default() };
    let descent = descend(&indefinite, &start, &Bounds::none(&start), &tolerances);
    assert!(descent.ending.has_converged() && descent.cost < 1e-9 && descent.steps > 5, "{descent:?}");
}

/// Where no damping helps, that is the ending: a negative diagonal is no JᵀJ.
#[test]
fn what_no_damping_makes_positive_ends_as_such() {
    let negative = Made { matrix: Matrix::new(-1.0, 0.0, 0.0, 1.0), ..BOWL };
    assert_eq!(ending(&negative, &Tolerances::default()), Ending::NotPositiveDefinite);
    let overwhelming = Made { matrix: Matrix::new(1.0, 1e30, 1e30, 1.0), ..BOWL };
    assert_eq!(ending(&overwhelming, &Tolerances::default()), Ending::NotPositiveDefinite);
}

#[test]
fn converged_endings_say_by_what() {
    let never = Tolerances {
        steps: 300,
        cost_share: 0.0,
        cost: 0.0,
        step: 0.0,
        gradient: 0.0,
        patience: Patience::ENDLESS,
    };
    // The cost ends at 1, so rounding ends every descent; the gradient is known to a hundredth
    // only.
    let shifted = Made { cost: |x| 1.0 + x.norm_squared(), ..BOWL };
    let rough = Made { gradient: |x| *x + Vector::new(0.01, 0.0), ..shifted };
    let by_gradient = Tolerances { gradient: 1e-6, ..never };
    assert_eq!(ending(&shifted, &by_gradient), Ending::ConvergedByGradient);
    let by_cost = Tolerances { cost: 1e-3, ..never };
    assert_eq!(ending(&shifted, &by_cost), Ending::ConvergedByCost);
    let by_step = Tolerances { step: 1e-6, ..never };
    assert_eq!(ending(&rough, &by_step), Ending::ConvergedByStep);
    assert_eq!(ending(&shifted, &Tolerances { steps: 2, ..never }), Ending::OutOfSteps);
    let patience = Patience { steps: 10, share: 1e-3 };
    assert_eq!(ending(&shifted, &Tolerances { patience, ..never }), Ending::Stalled);
    assert!(!Ending::OutOfSteps.has_converged() && !Ending::NotFinite.has_converged());
    assert!(!Ending::NotPositiveDefinite.has_converged() && Ending::ConvergedByCost.has_converged());
}

/// Rosenbrock's function with x ≤ 0.5: along the bound (1 − x)² + 100 (y − x²)² is least at y =
/// 0.25, where 0.25 is left. With y ≥ 2 the minimum on that bound solves 400 x (x² − 2) = 2 (1 −
/// x): x = 1.4137, by bisection below.
#[test]
fn minima_at_bounds_are_met() {
    let residuals = FromResiduals::new(|x: &DVector<f64>| {
        DVector::from_vec((super::problems::PROBLEMS[0].residuals)(x.as_slice()))
    });
    let start = DVector::from_vec(vec![-1.2, 1.0]);
    let mut bounds = Bounds::none(&start);
    bounds.upper[0] = 0.5;
    let descent = descend(&residuals, &start, &bounds, &Tolerances::default());
    assert!(descent.ending.has_converged(), "{descent:?}");
    assert!((descent.cost - 0.25).abs() < 1e-12 && descent.parameters[0] == 0.5, "{descent:?}");

    let mut bounds = Bounds::none(&start);
    bounds.lower[1] = 2.0;
    let start = DVector::from_vec(vec![1.2, 1.0]);
    let descent = descend(&residuals, &start, &bounds, &Tolerances::default());
    let slope = |x: f64| 400.0 * x * (x * x - 2.0) - 2.0 * (1.0 - x);
    let (mut low, mut high) = (1.0, 2.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if slope(middle) < 0.0 { low = middle } else { high = middle }
    }
    assert!(descent.ending.has_converged() && descent.parameters[1] == 2.0, "{descent:?}");
    assert!((descent.parameters[0] - low).abs() < 1e-6, "{descent:?} {low}");
}
