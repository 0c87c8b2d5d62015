//! The scalar: `f32` on the board, `f64` on the host.

use core::fmt::Debug;
use core::iter::Sum;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use crate::block::Block;

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// A floating-point scalar. Sealed: the models are checked for these two only.
pub trait Real:
    sealed::Sealed
    + Copy
    + Default
    + Debug
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + Sum
    + Send
    + Sync
    + 'static
{
    /// 0
    const ZERO: Self;
    /// −0: plus x it is x, whatever x is, so that a sum which begins with it costs no addition
    /// more.
    const NOTHING: Self;
    /// 1
    const ONE: Self;
    /// ½
    const HALF: Self;
    /// 2
    const TWO: Self;
    /// ∞
    const INFINITY: Self;
    /// Not a number.
    const NAN: Self;
    /// Machine epsilon.
    const EPSILON: Self;

    /// Rounds to this precision.
    fn from_f64(value: f64) -> Self;
    /// Exact.
    fn to_f64(self) -> f64;
    /// √x; NaN below zero.
    fn sqrt(self) -> Self;
    /// eˣ
    fn exp(self) -> Self;
    /// |x|
    fn abs(self) -> Self;
    /// Neither infinite nor NaN.
    fn is_finite(self) -> bool;

    /// |x| with the sign of `sign`.
    fn copysign(self, sign: Self) -> Self;

    /// The larger; `self` where `other` is NaN.
    #[inline]
    fn at_least(self, other: Self) -> Self {
        if other > self { other } else { self }
    }

    /// The smaller; `self` where `other` is NaN.
    #[inline]
    fn at_most(self, other: Self) -> Self {
        if other < self { other } else { self }
    }

    /// [`Self::at_most`] for whoever knows that `self` is a number: one instruction.
    fn least(self, other: Self) -> Self;

    /// [`Self::at_least`], likewise.
    fn most(self, other: Self) -> Self;

    /// A copy of numbers that stand side by side, read at once where the processor can
    /// ([`crate::block`]).
    #[inline(always)]
    fn read<B: Block<Self>>(block: &B) -> B {
        *block
    }

    /// Writes them likewise.
    #[inline(always)]
    fn write<B: Block<Self>>(block: &mut B, value: B) {
        *block = value;
    }

    /// −1, 0 or 1: the sign, with sgn 0 = 0 as in the paper, and 0 for NaN.
    #[inline]
    fn sign(self) -> Self {
        if self > Self::ZERO {
            Self::ONE
        } else if self < Self::ZERO {
            -Self::ONE
        } else {
            Self::ZERO
        }
    }
}

/// √x in single precision, correctly rounded both ways: by the FPU where the target is sure to have
/// one, since core has no square root and libm's takes some fifty instructions of integer
/// arithmetic; by libm elsewhere.
#[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
#[inline]
#[expect(unsafe_code, reason = "core offers no square root, and the FPU has it in one instruction")]
fn sqrt_single(x: f32) -> f32 {
    let root;
    // SAFETY: the instruction reads one register and writes one; it touches neither memory nor
    // stack. Of the FPU's state it changes only the exception flags, which is why `preserves_flags`
    // is not among the options.
    unsafe {
        core::arch::asm!(
            "vsqrt.f32 {root}, {x}",
            x = in(sreg) x,
            root = lateout(sreg) root,
            options(pure, nomem, nostack),
        );
    }
    root
}

#[cfg(not(all(target_arch = "arm", target_abi = "eabihf")))]
use libm::sqrtf as sqrt_single;

macro_rules! real {
    ($scalar:ty, $sqrt:path, $least:path, $most:path, $exp:path $(, $blocks:item)*) => {
        impl Real for $scalar {
            const ZERO: Self = 0.0;
            const NOTHING: Self = -0.0;
            const ONE: Self = 1.0;
            const HALF: Self = 0.5;
            const TWO: Self = 2.0;
            const INFINITY: Self = <$scalar>::INFINITY;
            const NAN: Self = <$scalar>::NAN;
            const EPSILON: Self = <$scalar>::EPSILON;

            #[inline]
            fn from_f64(value: f64) -> Self {
                value as Self
            }
            #[inline]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            #[inline]
            fn sqrt(self) -> Self {
                $sqrt(self)
            }
            #[inline]
            fn exp(self) -> Self {
                $exp(self)
            }
            #[inline]
            fn abs(self) -> Self {
                <$scalar>::abs(self)
            }
            #[inline]
            fn is_finite(self) -> bool {
                <$scalar>::is_finite(self)
            }
            #[inline]
            fn copysign(self, sign: Self) -> Self {
                <$scalar>::copysign(self, sign)
            }
            #[inline]
            fn least(self, other: Self) -> Self {
                $least(self, other)
            }
            #[inline]
            fn most(self, other: Self) -> Self {
                $most(self, other)
            }
            $($blocks)*
        }
    };
}

// The FPU of the board has minNum and maxNum, which leave NaN out; a host's processor has the
// comparison.
real!(
    f32,
    sqrt_single,
    f32::min,
    f32::max,
    libm::expf,
    #[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
    #[inline(always)]
    fn read<B: Block<Self>>(block: &B) -> B {
        crate::block::read(block)
    },
    #[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
    #[inline(always)]
    fn write<B: Block<Self>>(block: &mut B, value: B) {
        crate::block::write(block, value);
    }
);
real!(f64, libm::sqrt, Real::at_most, Real::at_least, libm::exp);
