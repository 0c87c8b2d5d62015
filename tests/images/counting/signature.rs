//! What verifying a signature costs: it keeps the thread of the firmware's main executor, and with
//! it the watchdog, waiting.

use core::hint::black_box;

use cortex_m::peripheral::SYST;
use firmware::items::{PublicKey, SIGNATURE_BYTES, is_signed_by, key_of_hex};
use on_target_tests::expansion;
use semihosting::println;

use super::counter::{SHIFT, TICK_NS, WRAP};

/// RFC 8032, section 7.1, test 3.
const KEY: Option<PublicKey> = key_of_hex("fc51cd8e6218a1a38da47ed00230f0580816ed13ba3303ac5deb911548908025");
const MESSAGE: [u8; 2] = [0xaf, 0x82];
const SIGNATURE: [&str; 2] = [
    "6291d657deec24024827e69c3abe01a30ce548a284743a445e3680d7db5ac3ac",
    "18ff9b538d16f290ae67f760984dc6594a7c15e9716ed28dc027beceea1ec40a",
];

/// Prints the figure; false where the signature is refused.
pub(super) fn count(counter: &mut SYST) -> bool {
    let mut signature = [0; SIGNATURE_BYTES];
    for (place, half) in signature.chunks_exact_mut(32).zip(SIGNATURE) {
        let Some(bytes) = key_of_hex(half) else { return false };
        place.copy_from_slice(&bytes);
    }
    let Some(key) = KEY else { return false };
    // It comes round every 655,360 instructions.
    counter.clear_current();
    counter.enable_interrupt();
    let is_right = is_signed_by(black_box(&key), black_box(&MESSAGE), black_box(&signature));
    let left = SYST::get_current();
    counter.disable_interrupt();
    let ticks = u64::from(expansion::rounds()) * u64::from(WRAP) + u64::from(WRAP - left);
    println!("once: verifying a signature: {} instructions", (ticks * u64::from(TICK_NS)) >> SHIFT);
    is_right
}
