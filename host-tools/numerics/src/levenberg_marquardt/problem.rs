//! What is minimised: a sum of squares with its derivatives.

use nalgebra::allocator::Allocator;
use nalgebra::{DMatrix, DVector, DefaultAllocator, Dim, Dyn, OMatrix, OVector};

/// A sum of squares as a function of parameters, of a dimension that is constant
/// ([`nalgebra::Const`]) or dynamic ([`nalgebra::Dyn`]).
pub trait LeastSquares<D: Dim>
where
    DefaultAllocator: Allocator<D> + Allocator<D, D>,
{
    /// The sum. NaN where the parameters mean nothing: such a step is taken back.
    fn cost(&self, parameters: &OVector<f64, D>) -> f64;

    /// ½ of its gradient Jᵀr, and the Gauss–Newton matrix JᵀJ.
    fn derivatives(&self, parameters: &OVector<f64, D>) -> (OVector<f64, D>, OMatrix<f64, D, D>);
}

/// Residuals as a function of the parameters, differentiated numerically by central differences.
pub struct FromResiduals<F> {
    residuals: F,
}

impl<F: Fn(&DVector<f64>) -> DVector<f64>> FromResiduals<F> {
    /// Of a function that returns as many residuals for all parameters.
    pub fn new(residuals: F) -> Self {
        Self { residuals }
    }
}

/// Step of a central difference as a share of the parameter: the cube root of the rounding, where
/// truncation and rounding meet.
const DIFFERENCE: f64 = 6e-6;

impl<F: Fn(&DVector<f64>) -> DVector<f64>> LeastSquares<Dyn> for FromResiduals<F> {
    fn cost(&self, parameters: &DVector<f64>) -> f64 {
        (self.residuals)(parameters).norm_squared()
    }

    fn derivatives(&self, parameters: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let residuals = (self.residuals)(parameters);
        let mut jacobian = DMatrix::zeros(residuals.len(), parameters.len());
        for i in 0..parameters.len() {
            let by = DIFFERENCE * parameters[i].abs().max(1e-3);
            let at = |step: f64| {
                let mut moved = parameters.clone();
                moved[i] += step;
                (moved[i], (self.residuals)(&moved))
            };
            let ((low, before), (high, after)) = (at(-by), at(by));
            jacobian.set_column(i, &((after - before) / (high - low)));
        }
        (jacobian.tr_mul(&residuals), jacobian.tr_mul(&jacobian))
    }
}
