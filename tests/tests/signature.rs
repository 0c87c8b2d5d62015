//! Signatures of coefficients, verified on the board's core.
#![cfg_attr(target_os = "none", no_std, no_main)]

use firmware::items::{PublicKey, SIGNATURE_BYTES, is_signed_by, key_of_hex};
use on_target_tests::{Failed, Outcome, ensure, tests};

tests!(takes_what_the_standard_signs, refuses_another_key, refuses_every_changed_byte);

/// RFC 8032, section 7.1, test 3.
const KEY: Option<PublicKey> = key_of_hex("fc51cd8e6218a1a38da47ed00230f0580816ed13ba3303ac5deb911548908025");
const MESSAGE: [u8; 2] = [0xaf, 0x82];
const SIGNATURE: [&str; 2] = [
    "6291d657deec24024827e69c3abe01a30ce548a284743a445e3680d7db5ac3ac",
    "18ff9b538d16f290ae67f760984dc6594a7c15e9716ed28dc027beceea1ec40a",
];

fn signature() -> Result<[u8; SIGNATURE_BYTES], Failed> {
    let mut signature = [0; SIGNATURE_BYTES];
    for (place, half) in signature.chunks_exact_mut(32).zip(SIGNATURE) {
        place.copy_from_slice(&key_of_hex(half).ok_or(Failed)?);
    }
    Ok(signature)
}

fn takes_what_the_standard_signs() -> Outcome {
    let key = KEY.ok_or(Failed)?;
    ensure(is_signed_by(&key, &MESSAGE, &signature()?), format_args!("refused"))
}

fn refuses_another_key() -> Outcome {
    // Of test 2.
    let other =
        key_of_hex("3d4017c3e843895a92b70aa74d1b7ebc9c982ccf2ec4968cc0cd55f12af4660c").ok_or(Failed)?;
    ensure(!is_signed_by(&other, &MESSAGE, &signature()?), format_args!("taken"))?;
    // No point of the curve, and one of small order.
    for key in [[0xFF; 32], [0; 32]] {
        ensure(!is_signed_by(&key, &MESSAGE, &signature()?), format_args!("{key:?} taken"))?;
    }
    Ok(())
}

fn refuses_every_changed_byte() -> Outcome {
    let key = KEY.ok_or(Failed)?;
    let good = signature()?;
    for place in 0..SIGNATURE_BYTES {
        let mut changed = good;
        if let Some(byte) = changed.get_mut(place) {
            *byte ^= 1 << (place % 8);
        }
        ensure(!is_signed_by(&key, &MESSAGE, &changed), format_args!("byte {place} taken"))?;
    }
    for message in [&MESSAGE[..1], &[0xaf, 0x83], &[0xaf, 0x82, 0]] {
        ensure(!is_signed_by(&key, message, &good), format_args!("{message:?} taken"))?;
    }
    Ok(())
}
