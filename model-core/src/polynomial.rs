//! Power as a polynomial of the mass: P = a d² + b d + c with d = m − m₀.

use core::ops::{Add, AddAssign};

use crate::real::Real;

/// P(d) = a d² + b d + c, d the mass in kg beyond a reference mass.
///
/// A reference in the middle of the mass range keeps single precision from cancelling when
/// residuals are summed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Polynomial<T> {
    /// W/kg²
    pub a: T,
    /// W/kg
    pub b: T,
    /// W
    pub c: T,
}

impl<T: Real> Polynomial<T> {
    /// What sums begin with. Zeros below zero: those plus x is x even where x is −0, so that the
    /// first sum costs nothing.
    pub(crate) const NOTHING: Self = Self { a: T::NOTHING, b: T::NOTHING, c: T::NOTHING };

    /// The power in W at `d` kg beyond the reference.
    #[inline]
    pub fn at(&self, d: T) -> T {
        (self.a * d + self.b) * d + self.c
    }

    /// dP/dm in W/kg at `d` kg beyond the reference.
    #[inline]
    pub fn slope(&self, d: T) -> T {
        T::TWO * self.a * d + self.b
    }

    /// The same curve about a reference that is `shift` kg higher.
    #[inline]
    pub fn about(&self, shift: T) -> Self {
        Self { a: self.a, b: self.slope(shift), c: self.at(shift) }
    }
}

impl<T: Real> Add for Polynomial<T> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self { a: self.a + other.a, b: self.b + other.b, c: self.c + other.c }
    }
}

impl<T: Real> AddAssign for Polynomial<T> {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}
