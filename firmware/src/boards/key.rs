//! The public key that an image is built with, if it is.

use crate::items::Verify;

/// How signatures of coefficients are verified; `None` where none is asked for.
#[cfg(not(feature = "signed"))]
pub const VERIFY: Option<Verify> = None;
/// How signatures of coefficients are verified; `None` where none is asked for.
#[cfg(feature = "signed")]
pub const VERIFY: Option<Verify> = Some(signed::verify);

#[cfg(feature = "signed")]
mod signed {
    use crate::items::{PublicKey, SIGNATURE_BYTES, is_signed_by, key_of_hex};

    const KEY: Option<PublicKey> = match option_env!("GMR_COEFFICIENTS_KEY") {
        Some(text) => key_of_hex(text),
        None => None,
    };
    const _: () = assert!(
        KEY.is_some(),
        "the feature `signed` wants a public key: 64 hexadecimal digits in GMR_COEFFICIENTS_KEY, as `gmr key new` says them"
    );

    pub(super) fn verify(image: &[u8], signature: &[u8; SIGNATURE_BYTES]) -> bool {
        // It takes a good part of the watchdog's time, in which nothing else on its thread gets a
        // turn (docs/board.md).
        #[cfg(feature = "opencr")]
        crate::boards::opencr::watchdog::feed();
        KEY.is_some_and(|key| is_signed_by(&key, image, signature))
    }
}
