//! Negative self-test of panic_probe: an index that may be out of bounds keeps an image from
//! linking.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod panic_probe;

use core::hint::black_box;

fn may_panic() {
    black_box(black_box([1, 2, 3])[black_box(1_usize)]);
}

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    loop {
        may_panic();
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    may_panic();
}
