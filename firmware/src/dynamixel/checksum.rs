//! The packets' checksum: polynomial 8005h, initial 0, not reflected (CRC-16/UMTS), a word at a
//! time and without a table.
//!
//! x¹⁶ + x¹⁵ + x² + 1 is (x + 1)(x¹⁵ + x + 1). Modulo the first factor bytes are their parity;
//! modulo the second x¹⁵ is x + 1, so that two shifts reduce a word. Both remainders together say
//! what is left modulo the product.

/// x¹⁵ + x + 1
const FACTOR: u32 = 0x8003;

/// Of these bytes.
pub(super) fn checksum(bytes: &[u8]) -> u16 {
    let (words, rest) = bytes.as_chunks();
    // What came so far modulo the second factor, and words that have the same parity.
    let (mut remainder, mut sum) = (0, 0);
    for word in words {
        let word = u32::from_be_bytes(*word);
        // x³² is (x² + x)², which is x⁴ + x².
        remainder = fold(remainder << 4 ^ remainder << 2 ^ word);
        sum ^= word;
    }
    for byte in rest {
        remainder = fold(remainder << 8 ^ u32::from(*byte));
        sum ^= u32::from(*byte);
    }
    // Sixteen zeros follow the bytes, as the definition has it: of the parity they change nothing.
    let remainder = fold(fold(remainder << 8) << 8);
    let is_even = (remainder ^ sum).count_ones().is_multiple_of(2);
    (if is_even { remainder } else { remainder ^ FACTOR }) as u16
}

/// The same modulo the second factor: of degree 17 at most, and 14 where it was of 28 or less.
fn fold(polynomial: u32) -> u32 {
    let above = polynomial >> 15;
    polynomial & 0x7FFF ^ above ^ above << 1
}

#[cfg(test)]
mod tests {
    use crc::{CRC_16_UMTS, Crc};
    use proptest::prelude::*;

    /// The same by a table, a byte at a time.
    const REFERENCE: Crc<u16> = Crc::<u16>::new(&CRC_16_UMTS);

    proptest! {
        /// Any bytes, of every length modulo a word.
        #[test]
        fn is_the_standard_one(bytes in proptest::collection::vec(any::<u8>(), 0..70)) {
            prop_assert_eq!(super::checksum(&bytes), REFERENCE.checksum(&bytes));
        }
    }

    /// The catalogue's check value, and the longest runs of ones and zeros.
    #[test]
    fn is_right_at_the_ends() {
        assert_eq!(super::checksum(b"123456789"), 0xFEE8);
        for bytes in [&[0xFF; 1001][..], &[0; 1001], &[]] {
            assert_eq!(super::checksum(bytes), REFERENCE.checksum(bytes));
        }
    }
}
