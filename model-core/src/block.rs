//! Numbers that stand side by side, read and written at once.
//!
//! The FPU of the board's core moves up to 16 of them with one instruction, but only between memory
//! and registers in a row, which the compiler's choice of registers hardly ever is: it takes one
//! instruction for each. Elsewhere a block is copied like anything else, with the same bits.

#![cfg_attr(
    all(target_arch = "arm", target_abi = "eabihf"),
    expect(unsafe_code, reason = "no safe code chooses registers")
)]

use crate::filter::{Channels, Steps};
use crate::payload::window::Sums;
use crate::real::Real;
use crate::torque::TorqueModel;

/// Numbers of this type side by side, and nothing else between them.
pub trait Block<T>: Copy + sealed::Sealed {}

/// Only types of this module: nobody else's are known to be made of numbers alone.
mod sealed {
    pub trait Sealed {}
}

macro_rules! blocks {
    ($([$($generics:tt)*] $block:ty),* $(,)?) => {$(
        impl<T: Real, $($generics)*> sealed::Sealed for $block {}
        impl<T: Real, $($generics)*> Block<T> for $block {}
    )*};
}

blocks!(
    [] Steps<T>,
    [const N: usize] Channels<T, N>,
    [] TorqueModel<T>,
    [] Sums<T>,
    [const N: usize, const M: usize] [[T; N]; M],
);

#[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
pub(crate) use by_registers::{read, write};

#[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
mod by_registers {
    use core::arch::asm;
    use core::mem::{size_of, transmute_copy};

    use super::Block;

    /// The function that reads, for the sizes that one instruction moves, each with its registers;
    /// other sizes are left to the compiler.
    macro_rules! reads {
        ($($size:literal: $range:tt, $($name:ident $register:tt),*;)*) => {
            #[inline(always)]
            pub(crate) fn read<B: Block<f32>>(block: &B) -> B {
                $(if size_of::<B>() == $size * size_of::<f32>() {
                    $(let $name: f32;)*
                    // SAFETY: reads the numbers of `block`, which are as many as the registers.
                    unsafe {
                        asm!(
                            concat!("vldmia {block}, {{", $range, "}}"),
                            block = in(reg) core::ptr::from_ref(block),
                            $(out($register) $name,)*
                            options(pure, readonly, nostack, preserves_flags),
                        );
                    }
                    let numbers = [$($name),*];
                    // SAFETY: these are the bits of `block`, and of the same size.
                    return unsafe { transmute_copy::<[f32; $size], B>(&numbers) };
                })*
                *block
            }
        };
    }

    /// The function that writes, likewise.
    macro_rules! writes {
        ($($size:literal: $range:tt, $($name:ident $register:tt),*;)*) => {
            #[inline(always)]
            pub(crate) fn write<B: Block<f32>>(block: &mut B, value: B) {
                $(if size_of::<B>() == $size * size_of::<f32>() {
                    // SAFETY: a block is numbers and nothing else, here as many as these.
                    let [$($name),*] = unsafe { transmute_copy::<B, [f32; $size]>(&value) };
                    // SAFETY: writes the numbers of `block`, which are as many as the registers.
                    unsafe {
                        asm!(
                            concat!("vstmia {block}, {{", $range, "}}"),
                            block = in(reg) core::ptr::from_mut(block),
                            $(in($register) $name,)*
                            options(nostack, preserves_flags),
                        );
                    }
                    return;
                })*
                *block = value;
            }
        };
    }

    // Different registers for what is in hand at the same time.
    reads!(
        4: "s8-s11", a "s8", b "s9", c "s10", d "s11";
        7: "s7-s13", a "s7", b "s8", c "s9", d "s10", e "s11", f "s12", g "s13";
        8: "s16-s23", a "s16", b "s17", c "s18", d "s19", e "s20", f "s21", g "s22", h "s23";
        15: "s14-s28", a "s14", b "s15", c "s16", d "s17", e "s18", f "s19", g "s20", h "s21",
            i "s22", j "s23", k "s24", l "s25", m "s26", n "s27", o "s28";
    );

    // The channels three registers on: where `Channels` has what they become.
    writes!(
        8: "s16-s23", a "s16", b "s17", c "s18", d "s19", e "s20", f "s21", g "s22", h "s23";
        15: "s17-s31", a "s17", b "s18", c "s19", d "s20", e "s21", f "s22", g "s23", h "s24",
            i "s25", j "s26", k "s27", l "s28", m "s29", n "s30", o "s31";
    );
}
