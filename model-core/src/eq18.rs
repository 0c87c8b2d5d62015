//! The 15 products of Eq. 18, gated as published, as derived, or not at all.
//!
//! P_act = Σ_j β_j m^pow(j) φ_j, each φ_j summed over the wheels. With K = (M'' a)_i, u = K w,
//! h = sgn w, s = sgn(a w) and r = sgn u:
//!
//! | j | pow | φ of one wheel | published where it differs |
//! |---|---|---|---|
//! | 0, 1, 2 | 0, 1, 2 | 1 | |
//! | 3 | 0 | w² | |
//! | 4 | 0 | (1+s) a² | (2+s) a² |
//! | 5 | 2 | (1+r) K² | pow 1, (2+r) K² |
//! | 6, 7 | 0, 1 | \|w\| | |
//! | 8, 9 | 0, 1 | (1+s) h a | |
//! | 10, 11 | 1, 2 | (1+r) h K | |
//! | 12 | 0 | (1+s) a w | |
//! | 13 | 1 | (1+r) u | |
//! | 14 | 1 | (1+s)(1+r) K a | |
//!
//! The print has (2+s) and (2+r), and m where (M' Ψ)² carries m²: squaring Eq. 16 with s² = r² = 1
//! gives the others. Without gates the same products are the expansion of the signed torque model
//! ([`crate::torque`]), with φ₀…φ₂ = h²: there a wheel at rest draws nothing.

use crate::motion::{Motion, Wheel};
use crate::polynomial::Polynomial;
use crate::real::Real;

/// How many products there are.
pub const REGRESSORS: usize = 15;

/// What multiplies the inertial products.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Gate {
    /// Eq. 18 as printed.
    Published,
    /// Eq. 18 as it follows from Eq. 15 and 16.
    Corrected,
    /// 1: torques keep their signs.
    Signed,
}

const POWER: [u8; REGRESSORS] = [0, 1, 2, 0, 0, 2, 0, 1, 0, 1, 1, 2, 0, 1, 1];
const POWER_PUBLISHED: [u8; REGRESSORS] = [0, 1, 2, 0, 0, 1, 0, 1, 0, 1, 1, 2, 0, 1, 1];

impl Gate {
    /// The power of the mass that multiplies each product.
    pub const fn mass_powers(self) -> &'static [u8; REGRESSORS] {
        match self {
            Gate::Published => &POWER_PUBLISHED,
            Gate::Corrected | Gate::Signed => &POWER,
        }
    }

    /// The wheel's quantities along its motion.
    ///
    /// Times h, the features lose their signs: s = sgn(a w) is the sign of h a, so that (1 + s) h
    /// a = h a + |h a|, and the other gated products follow from that and from h K likewise. No
    /// comparison is needed.
    #[inline(always)]
    fn along<T: Real>(self, wheel: &Wheel<T>) -> Along<T> {
        let h = wheel.direction;
        let (speed, a, k) = (h * wheel.speed, h * wheel.acceleration, h * wheel.inertial_torque);
        match self {
            Gate::Published | Gate::Corrected => {
                Along { one: T::ONE, speed, a, k, gated_a: a + a.abs(), gated_k: k + k.abs() }
            }
            Gate::Signed => Along { one: h * h, speed, a, k, gated_a: a, gated_k: k },
        }
    }
}

struct Along<T> {
    /// 1, or h²
    one: T,
    /// |w|
    speed: T,
    /// h a
    a: T,
    /// h K
    k: T,
    /// (1 + s) h a
    gated_a: T,
    /// (1 + r) h K
    gated_k: T,
}

/// φ_0 … φ_14 of one instant, summed over the wheels, without the powers of the mass.
#[inline(always)]
pub fn products<T: Real, const N: usize>(gate: Gate, motion: &Motion<T, N>) -> [T; REGRESSORS] {
    let mut sums = [T::NOTHING; REGRESSORS];
    for wheel in &motion.wheels {
        let Along { one, speed, a, k, gated_a, gated_k } = gate.along(wheel);
        let (mut square_a, mut square_k) = (gated_a * a, gated_k * k);
        if gate == Gate::Published {
            // 2 + s = 1 + (1 + s)
            square_a += a * a;
            square_k += k * k;
        }
        let wheel_products = [
            one,
            one,
            one,
            speed * speed,
            square_a,
            square_k,
            speed,
            speed,
            gated_a,
            gated_a,
            gated_k,
            gated_k,
            gated_a * speed,
            gated_k * speed,
            gated_a * gated_k,
        ];
        for (sum, product) in sums.iter_mut().zip(wheel_products) {
            *sum += product;
        }
    }
    sums
}

/// X^0 … X^14 of Eq. 19: the products times their powers of the mass (kg).
#[inline]
pub fn regressors<T: Real>(gate: Gate, products: &[T; REGRESSORS], mass: T) -> [T; REGRESSORS] {
    let factors = [T::ONE, mass, mass * mass];
    let mut regressors = *products;
    for (regressor, power) in regressors.iter_mut().zip(gate.mass_powers()) {
        *regressor = *regressor * factors.get(usize::from(*power)).copied().unwrap_or(T::ONE);
    }
    regressors
}

/// Eq. 24: the power as a polynomial of the total mass (reference 0 kg), without the static power.
#[inline(always)]
pub fn polynomial<T: Real>(gate: Gate, products: &[T; REGRESSORS], beta: &[T; REGRESSORS]) -> Polynomial<T> {
    let mut sums = [T::NOTHING; 3];
    for ((product, coefficient), power) in products.iter().zip(beta).zip(gate.mass_powers()) {
        if let Some(sum) = sums.get_mut(usize::from(*power)) {
            *sum += *product * *coefficient;
        }
    }
    let [c, b, a] = sums;
    Polynomial { a, b, c }
}

/// Eq. 24 of one instant: [`polynomial`] of its [`products`].
#[inline(always)]
pub fn power<T: Real, const N: usize>(
    gate: Gate,
    motion: &Motion<T, N>,
    beta: &[T; REGRESSORS],
) -> Polynomial<T> {
    // Which gate is asked once a sample, not once a wheel and product; what is equal of the
    // products is computed once.
    match gate {
        Gate::Published => polynomial(Gate::Published, &products(Gate::Published, motion), beta),
        Gate::Corrected => polynomial(Gate::Corrected, &products(Gate::Corrected, motion), beta),
        Gate::Signed => polynomial(Gate::Signed, &products(Gate::Signed, motion), beta),
    }
}
