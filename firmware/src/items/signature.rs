//! Who may write coefficients: on a board that is built with a public key, who has the secret one.
//!
//! A signature is 64 bytes behind the image, Ed25519 (RFC 8032) of the image's bytes, checksum
//! included. A board without a key does not look at it. One with a key (the feature `signed`, and
//! the key in the variable `GMR_COEFFICIENTS_KEY` of the build) uses nothing without a right one,
//! neither from the link nor from its flash.

use crate::control_table::Reason;

pub use crate::control_table::SIGNATURE_BYTES;

/// A public key.
pub type PublicKey = [u8; 32];

/// Of an image and its signature: whether it is that of whoever may write.
pub type Verify = fn(image: &[u8], signature: &[u8; SIGNATURE_BYTES]) -> bool;

/// Where an image says how long it is: magic, version, length.
const LENGTH_AT: core::ops::Range<usize> = 6..8;

/// An image, and the signature behind it, if there is one: as far as the image itself says how long
/// it is.
#[must_use]
pub fn parts(bytes: &[u8]) -> (&[u8], Option<&[u8; SIGNATURE_BYTES]>) {
    let length = bytes.get(LENGTH_AT).and_then(|bytes| bytes.try_into().ok()).map(u16::from_le_bytes);
    match bytes.split_last_chunk() {
        Some((image, signature)) if length.map(usize::from) == Some(image.len()) => (image, Some(signature)),
        _ => (bytes, None),
    }
}

/// Whether coefficients may be used, on a board that verifies, or on one that does not.
///
/// # Errors
/// [`Reason::Signature`]
pub fn check_signature(bytes: &[u8], verify: Option<Verify>) -> Result<(), Reason> {
    match (verify, parts(bytes)) {
        (None, _) => Ok(()),
        // Nothing is signed by nobody: that there is nothing is the better reason.
        (Some(_), ([], _)) => Ok(()),
        (Some(verify), (image, Some(signature))) if verify(image, signature) => Ok(()),
        (Some(_), _) => Err(Reason::Signature),
    }
}

/// Whether the signature is that of `key` and of this image. 2.2 million instructions (`cargo xtask
/// bench instructions`).
#[cfg(feature = "signed")]
#[must_use]
pub fn is_signed_by(key: &PublicKey, image: &[u8], signature: &[u8; SIGNATURE_BYTES]) -> bool {
    let signature = ed25519_compact::Signature::new(*signature);
    ed25519_compact::PublicKey::new(*key).verify(image, &signature).is_ok()
}

/// A key of 64 hexadecimal digits; `None` for anything else.
#[must_use]
pub const fn key_of_hex(text: &str) -> Option<PublicKey> {
    let mut key = [0; size_of::<PublicKey>()];
    let mut rest = text.as_bytes();
    let mut places: &mut [u8] = &mut key;
    loop {
        match (rest, places) {
            ([high, low, after @ ..], [byte, others @ ..]) => {
                let (Some(high), Some(low)) = (digit(*high), digit(*low)) else { return None };
                *byte = 16 * high + low;
                (rest, places) = (after, others);
            }
            ([], []) => return Some(key),
            _ => return None,
        }
    }
}

const fn digit(character: u8) -> Option<u8> {
    match character {
        b'0'..=b'9' => Some(character - b'0'),
        b'a'..=b'f' => Some(character - b'a' + 10),
        b'A'..=b'F' => Some(character - b'A' + 10),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of 12 bytes, in which it says so.
    const IMAGE: [u8; 12] = [b'G', b'M', b'R', b'C', 1, 0, 12, 0, 9, 9, 9, 9];

    fn signed(signature: u8) -> Vec<u8> {
        [&IMAGE[..], &[signature; SIGNATURE_BYTES]].concat()
    }

    #[test]
    fn a_signature_stands_behind_an_image_that_says_its_length() {
        assert_eq!(parts(&signed(7)), (&IMAGE[..], Some(&[7; SIGNATURE_BYTES])));
        assert_eq!(parts(&IMAGE), (&IMAGE[..], None));
        let mut longer = signed(7);
        longer.push(7);
        assert_eq!(parts(&longer), (&longer[..], None));
        assert_eq!(parts(&[]), (&[][..], None));
    }

    #[test]
    fn only_a_board_with_a_key_asks_for_one() {
        let is_seven: Verify = |image, signature| image == IMAGE && *signature == [7; SIGNATURE_BYTES];
        assert_eq!(check_signature(&IMAGE, None), Ok(()));
        assert_eq!(check_signature(&signed(8), None), Ok(()));
        assert_eq!(check_signature(&signed(7), Some(is_seven)), Ok(()));
        assert_eq!(check_signature(&signed(8), Some(is_seven)), Err(Reason::Signature));
        assert_eq!(check_signature(&IMAGE, Some(is_seven)), Err(Reason::Signature));
        assert_eq!(check_signature(&[], Some(is_seven)), Ok(()));
    }

    #[test]
    fn keys_are_hexadecimal() {
        let text = "00ff".repeat(16);
        assert_eq!(key_of_hex(&text), Some([0, 0xFF].repeat(16).try_into().unwrap()));
        assert_eq!(key_of_hex(&text.to_uppercase()), key_of_hex(&text));
        for wrong in ["", "0", &text[1..], &text[2..], &format!("{text}00"), &text.replace('f', "g")] {
            assert_eq!(key_of_hex(wrong), None, "{wrong}");
        }
    }
}
