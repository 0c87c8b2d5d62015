//! What is believed of mass and ground: a Kalman filter with three states, in information form per
//! bucket.
//!
//! State and covariance are in units of what was believed at first, so that the prior is the unit
//! matrix and single precision has no large numbers to fight with. Ground drifts as a Gauss–Markov
//! process about what the fit found, its standard deviation 1 whatever the time; of the mass the
//! belief fades, and never goes beyond the prior.

use crate::real::Real;

/// How many states: mass, rolling resistance, scrub.
pub const STATES: usize = 3;

/// A symmetric matrix by rows.
pub type Matrix<T> = [[T; STATES]; STATES];

/// What samples say: Σ J Jᵀ and Σ J e over the residual's variance, J being the slopes of the power
/// by the states and e what was measured beyond the prediction at the state in hand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence<T> {
    /// Σ J Jᵀ / σ².
    pub information: Matrix<T>,
    /// Σ J e / σ².
    pub score: [T; STATES],
}

impl<T: Real> Default for Evidence<T> {
    fn default() -> Self {
        Self { information: [[T::ZERO; STATES]; STATES], score: [T::ZERO; STATES] }
    }
}

impl<T: Real> Evidence<T> {
    /// Adds a sample of this weight.
    #[inline]
    pub fn add(&mut self, slopes: &[T; STATES], residual: T, weight: T) {
        for ((row, score), slope) in self.information.iter_mut().zip(&mut self.score).zip(slopes) {
            let weighted = weight * *slope;
            *score += weighted * residual;
            for (entry, other) in row.iter_mut().zip(slopes) {
                *entry += weighted * *other;
            }
        }
    }

    /// The same with everything times `factor`.
    #[must_use]
    pub fn scaled(&self, factor: T) -> Self {
        Self {
            information: self.information.map(|row| row.map(|entry| entry * factor)),
            score: self.score.map(|entry| entry * factor),
        }
    }
}

/// State and covariance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Belief<T> {
    state: [T; STATES],
    covariance: Matrix<T>,
}

impl<T: Real> Default for Belief<T> {
    fn default() -> Self {
        let (one, zero) = (T::ONE, T::ZERO);
        let covariance = [[one, zero, zero], [zero, one, zero], [zero, zero, one]];
        Self { state: [zero; STATES], covariance }
    }
}

impl<T: Real> Belief<T> {
    /// Mass, rolling resistance and scrub beyond what was believed at first, in units of how sure
    /// that was.
    pub fn state(&self) -> [T; STATES] {
        self.state
    }

    /// Their covariance in the same units.
    pub fn covariance(&self) -> Matrix<T> {
        self.covariance
    }

    /// Time passes: what is known of the ground decays by `ground` (e^(−Δt/τ)), what is known of
    /// the mass by `mass`.
    pub fn pass(&mut self, mass: T, ground: T) {
        let [m, rolling, scrub] = self.state;
        self.state = [m, ground * rolling, ground * scrub];
        let [[mm, mr, ms], [_, rr, rs], [_, _, ss]] = self.covariance;
        let (square, fade) = (ground * ground, T::ONE / mass);
        let spread = T::ONE - square;
        // Never wider than the prior: a mass of which nothing new is heard may be anywhere, not
        // everywhere.
        let mm_later = (mm * fade).at_most(T::ONE.at_least(mm));
        // A given mass has no variance, and keeps none.
        let across = if mm > T::ZERO { ground * (mm_later / mm).sqrt() } else { T::ZERO };
        let (mr, ms, rs) = (across * mr, across * ms, square * rs);
        self.covariance =
            [[mm_later, mr, ms], [mr, square * rr + spread, rs], [ms, rs, square * ss + spread]];
    }

    /// Takes what samples say. What is not finite, or leaves no covariance, is not taken.
    pub fn take(&mut self, evidence: &Evidence<T>) {
        // P⁺ = (I + P M)⁻¹ P, and x⁺ = x + P⁺ v.
        let mut system = product(&self.covariance, &evidence.information);
        let [[a, _, _], [_, b, _], [_, _, c]] = &mut system;
        for diagonal in [a, b, c] {
            *diagonal += T::ONE;
        }
        let Some(inverse) = inverse(&system) else { return };
        let later = product(&inverse, &self.covariance);
        let [[mm, mr, ms], [rm, rr, rs], [sm, sr, ss]] = later;
        let (mr, ms, rs) = (T::HALF * (mr + rm), T::HALF * (ms + sm), T::HALF * (rs + sr));
        let covariance = [[mm, mr, ms], [mr, rr, rs], [ms, rs, ss]];
        let mut state = self.state;
        for (value, row) in state.iter_mut().zip(&covariance) {
            *value += row.iter().zip(&evidence.score).map(|(entry, score)| *entry * *score).sum();
        }
        let sound = mm >= T::ZERO
            && rr > T::ZERO
            && ss > T::ZERO
            && [mm, rr, ss].iter().all(|variance| variance.is_finite())
            && state.iter().all(|value| value.is_finite());
        if sound {
            *self = Self { state, covariance };
        }
    }

    /// The mass is known for sure, in its unit beyond what was believed at first: samples tell of
    /// the ground alone.
    pub fn tell_mass(&mut self, mass: T) {
        self.forget_mass();
        let [_, rolling, scrub] = self.state;
        self.state = [mass, rolling, scrub];
        let [[mm, ..], ..] = &mut self.covariance;
        *mm = T::ZERO;
    }

    /// The payload changed: the mass is unknown, and the ground stays as known.
    pub fn forget_mass(&mut self) {
        let [_, rolling, scrub] = self.state;
        let [_, [_, rr, rs], [_, _, ss]] = self.covariance;
        let zero = T::ZERO;
        self.state = [zero, rolling, scrub];
        self.covariance = [[T::ONE, zero, zero], [zero, rr, rs], [zero, rs, ss]];
    }
}

fn product<T: Real>(left: &Matrix<T>, right: &Matrix<T>) -> Matrix<T> {
    let [first, second, third] = right;
    let mut out = [[T::ZERO; STATES]; STATES];
    for (row, [a, b, c]) in out.iter_mut().zip(left) {
        for ((entry, x), (y, z)) in row.iter_mut().zip(first).zip(second.iter().zip(third)) {
            *entry = *a * *x + *b * *y + *c * *z;
        }
    }
    out
}

/// By cofactors. `None` where the determinant is 0 or no number.
fn inverse<T: Real>([[a, b, c], [d, e, f], [g, h, i]]: &Matrix<T>) -> Option<Matrix<T>> {
    let (a, b, c, d, e, f, g, h, i) = (*a, *b, *c, *d, *e, *f, *g, *h, *i);
    let cofactors = [
        [e * i - f * h, c * h - b * i, b * f - c * e],
        [f * g - d * i, a * i - c * g, c * d - a * f],
        [d * h - e * g, b * g - a * h, a * e - b * d],
    ];
    let [[first, _, _], [second, _, _], [third, _, _]] = cofactors;
    let over = T::ONE / (a * first + b * second + c * third);
    over.is_finite().then(|| cofactors.map(|row| row.map(|entry| entry * over)))
}
