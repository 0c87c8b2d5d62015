//! Gram matrices: all that a linear fit needs to know of its data. `P` is the number of regressors.

use std::cmp::Ordering;

use nalgebra::{SMatrix, SVector};
use serde::{Deserialize, Serialize};

/// XᵀX of `P` products.
pub type Matrix<const P: usize> = SMatrix<f64, P, P>;
/// Xᵀp, or coefficients.
pub type Vector<const P: usize> = SVector<f64, P>;

/// Columns that are multiplied at a time.
const GROUP: usize = 4;
type Group = [f64; GROUP];

/// Rows that are summed at a time: few enough for the first cache.
const BLOCK_ROWS: usize = 128;

/// Sums over rows: XᵀX, Xᵀp, pᵀp, Σp and their number. They add up, so runs can be read one by one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(into = "Written", try_from = "Written")]
pub struct Gram<const P: usize> {
    /// XᵀX, the lower triangle; zeros above.
    xx: [[f64; P]; P],
    xp: [f64; P],
    pp: f64,
    p: f64,
    rows: u64,
}

/// The same in a file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    rows: u64,
    power: f64,
    power_squares: f64,
    with_power: Vec<f64>,
    /// The lower triangle, row by row.
    products: Vec<f64>,
}

impl<const P: usize> From<Gram<P>> for Written {
    fn from(gram: Gram<P>) -> Self {
        let triangle = gram.xx.iter().enumerate().flat_map(|(i, row)| row[..=i].iter().copied());
        Self {
            rows: gram.rows,
            power: gram.p,
            power_squares: gram.pp,
            with_power: gram.xp.to_vec(),
            products: triangle.collect(),
        }
    }
}

impl<const P: usize> TryFrom<Written> for Gram<P> {
    type Error = String;

    fn try_from(written: Written) -> Result<Self, String> {
        let Written { rows, power, power_squares, with_power, products } = written;
        let counts = (with_power.len(), products.len());
        let expected = (P, P * (P + 1) / 2);
        if counts != expected {
            return Err(format!(
                "{} and {} sums; expected {} and {}",
                counts.0, counts.1, expected.0, expected.1
            ));
        }
        let mut gram = Self { pp: power_squares, p: power, rows, ..Self::default() };
        gram.xp.copy_from_slice(&with_power);
        let mut values = products.into_iter();
        for (i, row) in gram.xx.iter_mut().enumerate() {
            row[..=i].iter_mut().zip(&mut values).for_each(|(sum, value)| *sum = value);
        }
        Ok(gram)
    }
}

impl<const P: usize> Default for Gram<P> {
    fn default() -> Self {
        Self { xx: [[0.0; P]; P], xp: [0.0; P], pp: 0.0, p: 0.0, rows: 0 }
    }
}

impl<const P: usize> Gram<P> {
    /// Adds one row: regressors and measured power (W).
    #[inline]
    pub fn add(&mut self, x: &[f64; P], power: f64) {
        for (i, (row, xi)) in self.xx.iter_mut().zip(x).enumerate() {
            for (sum, xj) in row.iter_mut().zip(x).take(i + 1) {
                *sum += xi * xj;
            }
        }
        for (sum, xi) in self.xp.iter_mut().zip(x) {
            *sum += xi * power;
        }
        self.pp += power * power;
        self.p += power;
        self.rows += 1;
    }

    /// Adds the sums of a block of rows, each padded to [`GROUPS`](Self::GROUPS) groups: products,
    /// power, zeros.
    ///
    /// 16 sums at a time, which fit into registers; row after row, each sum would be loaded and
    /// stored again.
    fn add_block(&mut self, block: &[Group]) {
        for i in 0..Self::GROUPS {
            for j in 0..=i {
                let mut tile = [[0.0; GROUP]; GROUP];
                for row in block.chunks_exact(Self::GROUPS) {
                    let (xs, ys) = (&row[i], &row[j]);
                    for (sums, x) in tile.iter_mut().zip(xs) {
                        for (sum, y) in sums.iter_mut().zip(ys) {
                            *sum += x * y;
                        }
                    }
                }
                self.add_tile(i * GROUP, j * GROUP, &tile);
            }
        }
        let (group, place) = (P / GROUP, P % GROUP);
        self.p += block.chunks_exact(Self::GROUPS).map(|row| row[group][place]).sum::<f64>();
        self.rows += (block.len() / Self::GROUPS) as u64;
    }

    fn add_tile(&mut self, first_row: usize, first_column: usize, tile: &[Group; GROUP]) {
        for (i, sums) in (first_row..).zip(tile) {
            for (j, sum) in (first_column..=i).zip(sums) {
                match (i.cmp(&P), j == P) {
                    (Ordering::Less, _) => self.xx[i][j] += sum,
                    (Ordering::Equal, false) => self.xp[j] += sum,
                    (Ordering::Equal, true) => self.pp += sum,
                    (Ordering::Greater, _) => {}
                }
            }
        }
    }

    /// Groups of a padded row.
    const GROUPS: usize = P / GROUP + 1;

    /// Adds the sums of the other.
    pub fn merge(&mut self, other: &Self) {
        for (sum, value) in self.xx.iter_mut().flatten().zip(other.xx.iter().flatten()) {
            *sum += value;
        }
        for (sum, value) in self.xp.iter_mut().zip(&other.xp) {
            *sum += value;
        }
        self.pp += other.pp;
        self.p += other.p;
        self.rows += other.rows;
    }

    /// Σ (p − p̄)², W²: what there is to explain.
    pub fn variation(&self) -> f64 {
        (self.pp - self.p * self.p / self.rows.max(1) as f64).max(0.0)
    }

    /// Xᵀ(p − X β): the scores of these coefficients.
    pub fn scores(&self, beta: &Vector<P>) -> Vector<P> {
        self.xp() - self.xx() * beta
    }

    /// Rows summed.
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// XᵀX.
    pub fn xx(&self) -> Matrix<P> {
        Matrix::from_fn(|i, j| self.xx[i.max(j)][i.min(j)])
    }

    /// Xᵀp.
    pub fn xp(&self) -> Vector<P> {
        Vector::from_column_slice(&self.xp)
    }

    /// Mean squared error of the coefficients, W² (the cost of Eq. 20).
    pub fn cost(&self, beta: &Vector<P>) -> f64 {
        let squares = self.pp - 2.0 * beta.dot(&self.xp()) + beta.dot(&(self.xx() * beta));
        squares.max(0.0) / self.rows.max(1) as f64
    }

    /// The same problem with every column and the power scaled to a root mean square of 1.
    pub fn scaled(&self) -> Scaled<P> {
        let rows = self.rows.max(1) as f64;
        let xx = self.xx();
        let unit = |square: f64| if square > 0.0 { (square / rows).sqrt() } else { 1.0 };
        let column = Vector::from_fn(|i, _| unit(xx[(i, i)]));
        let power = unit(self.pp);
        Scaled {
            xx: Matrix::from_fn(|i, j| xx[(i, j)] / (rows * column[i] * column[j])),
            xp: Vector::from_fn(|i, _| self.xp[i] / (rows * column[i] * power)),
            column,
            power,
        }
    }
}

/// Regressors and measured power (W) of rows: what [`Gram::add`] does to each, in less time.
impl<const P: usize> Extend<([f64; P], f64)> for Gram<P> {
    fn extend<I: IntoIterator<Item = ([f64; P], f64)>>(&mut self, rows: I) {
        let mut block = Vec::with_capacity(BLOCK_ROWS * Self::GROUPS);
        for (x, power) in rows {
            let (groups, rest) = x.as_chunks::<GROUP>();
            let mut last = [0.0; GROUP];
            last[..rest.len()].copy_from_slice(rest);
            last[rest.len()] = power;
            block.extend_from_slice(groups);
            block.push(last);
            if block.len() == BLOCK_ROWS * Self::GROUPS {
                self.add_block(&block);
                block.clear();
            }
        }
        self.add_block(&block);
    }
}

/// A Gram matrix with unit diagonal: what a solver sees.
#[derive(Debug, Clone, PartialEq)]
pub struct Scaled<const P: usize> {
    /// Scaled XᵀX / rows; 1 on the diagonal, 0 for a column that is zero throughout.
    pub xx: Matrix<P>,
    /// Scaled Xᵀp / rows.
    pub xp: Vector<P>,
    column: Vector<P>,
    power: f64,
}

impl<const P: usize> Scaled<P> {
    /// ½ of the scaled mean squared error, without the constant ½ pᵀp.
    pub fn cost(&self, scaled_beta: &Vector<P>) -> f64 {
        scaled_beta.dot(&(self.xx * scaled_beta)) / 2.0 - scaled_beta.dot(&self.xp)
    }

    /// Its gradient.
    pub fn gradient(&self, scaled_beta: &Vector<P>) -> Vector<P> {
        self.xx * scaled_beta - self.xp
    }

    /// Coefficients in physical units.
    pub fn unscale(&self, scaled_beta: &Vector<P>) -> Vector<P> {
        Vector::from_fn(|i, _| scaled_beta[i] * self.power / self.column[i])
    }

    /// Coefficients as the solver sees them.
    pub fn scale(&self, beta: &Vector<P>) -> Vector<P> {
        Vector::from_fn(|i, _| beta[i] * self.column[i] / self.power)
    }

    /// Ratio of the largest to the smallest eigenvalue among columns that are not zero; infinite
    /// where columns depend on each other to rounding.
    pub fn condition(&self) -> f64 {
        let used: Vec<usize> = (0..P).filter(|&i| self.xx[(i, i)] > 0.0).collect();
        if used.is_empty() {
            return f64::INFINITY;
        }
        let matrix = nalgebra::DMatrix::from_fn(used.len(), used.len(), |i, j| self.xx[(used[i], used[j])]);
        let eigenvalues = matrix.symmetric_eigenvalues();
        let (least, most) = (eigenvalues.min(), eigenvalues.max());
        if least > most * 1e-15 { most / least } else { f64::INFINITY }
    }
}

#[cfg(test)]
mod tests {
    use super::{BLOCK_ROWS, Gram};

    /// Blocks sum the same products in a different order: over n rows of one sign the rounding
    /// stays below n ε of a sum.
    #[test]
    fn blocks_are_rows() {
        fn check<const P: usize>() {
            let count = 3 * BLOCK_ROWS + 5;
            let row = |k: usize| {
                let x: [f64; P] = std::array::from_fn(|i| 1.0 + ((7 * k + 3 * i) % 11) as f64 / 7.0);
                (x, 1.0 + (k % 13) as f64 / 3.0)
            };
            let (mut one_by_one, mut in_blocks) = (Gram::<P>::default(), Gram::<P>::default());
            in_blocks.extend((0..count).map(row));
            for (x, power) in (0..count).map(row) {
                one_by_one.add(&x, power);
            }
            assert_eq!(in_blocks.rows(), one_by_one.rows());
            let all = |gram: &Gram<P>| {
                let sums = [gram.pp, gram.p];
                sums.into_iter().chain(gram.xp).chain(gram.xx.into_iter().flatten()).collect::<Vec<f64>>()
            };
            for (a, b) in all(&in_blocks).iter().zip(all(&one_by_one)) {
                assert!((a - b).abs() <= count as f64 * f64::EPSILON * b, "{P}: {a} {b}");
            }
        }
        check::<3>();
        check::<4>();
        check::<15>();
        check::<21>();
    }
}
