//! What a further column would explain, all others moving along (Rao's score test; the
//! Frisch–Waugh–Lovell theorem).

use nalgebra::{DMatrix, DVector};

use super::factored::Factored;

/// Products of a column x that is not in a problem.
#[derive(Debug, Clone, PartialEq)]
pub struct FurtherColumn {
    /// XᵀWx, with each column of the problem.
    pub along: DVector<f64>,
    /// xᵀWr, with the residual.
    pub residual: f64,
    /// xᵀWx.
    pub square: f64,
}

impl FurtherColumn {
    /// From the products of all columns of a panel, the last column being the residual: the column
    /// at `column` beside those in `places`.
    pub fn from_products(products: &DMatrix<f64>, places: &[usize], column: usize) -> Self {
        Self {
            along: DVector::from_fn(places.len(), |i, _| products[(places[i], column)]),
            residual: products[(column, products.ncols() - 1)],
            square: products[(column, column)],
        }
    }
}

/// The score of a further column.
#[derive(Debug, Clone, PartialEq)]
pub struct Score {
    /// (XᵀWX + P)⁻¹ XᵀWx: what of the column the problem's own columns take.
    pub by: DVector<f64>,
    /// xᵀW(r − Xδ): the slope of half the loss along the column.
    pub score: f64,
    /// Its variance where weights and prior are right: the square of what the others leave of the
    /// column.
    pub variance: f64,
    /// Share of the column's square that the others leave, 0 to 1.
    pub share: f64,
}

impl Score {
    /// The column's coefficient in the joint problem.
    pub fn value(&self) -> f64 {
        self.score / self.variance
    }

    /// Its standard error.
    pub fn std_err(&self) -> f64 {
        1.0 / self.variance.sqrt()
    }

    /// Coefficient per standard error: N(0, 1) where there is nothing but noise.
    pub fn z(&self) -> f64 {
        self.score / self.variance.sqrt()
    }
}

impl Factored {
    /// The score of a further column; `None` where the problem's columns leave no more than
    /// `least_share` of its square, or the column is none.
    pub fn score(&self, column: &FurtherColumn, least_share: f64) -> Option<Score> {
        if column.square.is_nan() || column.square <= 0.0 {
            return None;
        }
        let by = self.solve(&column.along);
        let score = column.residual - by.dot(self.right());
        let variance = column.square - by.dot(&column.along);
        let share = variance / column.square;
        (variance > 0.0 && share > least_share).then_some(Score { by, score, variance, share })
    }
}
