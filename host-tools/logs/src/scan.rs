//! Fields of one CSV line. Quotes are understood, but a quoted field must not contain a line end.

use std::borrow::Cow;

/// The fields of a line, spaces around them removed, quotes kept.
pub(super) struct Fields<'a> {
    rest: Option<&'a [u8]>,
}

impl<'a> Fields<'a> {
    pub(super) fn new(line: &'a [u8]) -> Self {
        Self { rest: Some(line) }
    }
}

impl<'a> Iterator for Fields<'a> {
    type Item = &'a [u8];

    #[inline]
    fn next(&mut self) -> Option<&'a [u8]> {
        let line = self.rest?;
        let length = field_length(line);
        self.rest = line.get(length + 1..);
        Some(line[..length].trim_ascii())
    }
}

/// Bytes up to the next comma outside quotes, or to the end.
#[inline]
pub(super) fn field_length(line: &[u8]) -> usize {
    let comma = memchr::memchr(b',', line).unwrap_or(line.len());
    if !line[..comma].contains(&b'"') {
        return comma;
    }
    let mut quoted = false;
    line.iter()
        .position(|&byte| {
            quoted ^= byte == b'"';
            byte == b',' && !quoted
        })
        .unwrap_or(line.len())
}

/// A field without its quotes.
pub(super) fn unquote(field: &[u8]) -> Cow<'_, [u8]> {
    match field {
        [b'"', inner @ .., b'"'] if inner.contains(&b'"') => {
            let mut bytes = Vec::with_capacity(inner.len());
            let mut escaped = false;
            for &byte in inner {
                escaped = byte == b'"' && !escaped;
                if !escaped {
                    bytes.push(byte);
                }
            }
            bytes.into()
        }
        [b'"', inner @ .., b'"'] => inner.trim_ascii().into(),
        _ => field.into(),
    }
}

/// A number at the start of a text and its length; `None` if it is anything but what logs are full
/// of: a sign or none, digits, a point or none, digits, 15 in all at most. The caller has to see
/// that the field ends there.
///
/// The result is the nearest `f64`: the quotient of two integers that are exact. A byte at a time:
/// where a field ends is then predicted, and the next field begun before this one is done; finding
/// its end by arithmetic takes longer.
#[inline(always)]
pub(super) fn plain_number(text: &[u8]) -> Option<(f64, usize)> {
    let negative = *text.first()? == b'-';
    let start = usize::from(negative);
    let mut integer = 0;
    let point = start + leading_digits(&text[start..], &mut integer);
    let (end, decimals) = if text.get(point) == Some(&b'.') {
        let decimals = leading_digits(&text[point + 1..], &mut integer);
        (point + 1 + decimals, decimals)
    } else {
        (point, 0)
    };
    if !(1..=15).contains(&(point - start + decimals)) {
        return None;
    }
    // Signed integers are the ones that processors convert in one step.
    let size = integer.cast_signed() as f64 / POWERS_OF_TEN[decimals];
    // The sign is as random as the digits: set its bit.
    Some((f64::from_bits(size.to_bits() | (u64::from(negative) << 63)), end))
}

/// A [`plain_number`] that is all of the first field of a line.
#[inline]
pub(super) fn plain_field(line: &[u8]) -> Option<(f64, usize)> {
    plain_number(line).filter(|(_, length)| matches!(line.get(*length), None | Some(b',')))
}

/// 10^0 … 10^15, all exact.
const POWERS_OF_TEN: [f64; 16] =
    [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15];

/// Appends the digits at the start of a text to a number; how many they are. Too many overflow.
#[inline(always)]
fn leading_digits(text: &[u8], number: &mut u64) -> usize {
    for (count, byte) in text.iter().enumerate() {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 {
            return count;
        }
        *number = number.wrapping_mul(10).wrapping_add(u64::from(digit));
    }
    text.len()
}

/// The number in a field, NaN if it is empty; `None` if it is text.
pub(super) fn number_in_field(field: &[u8]) -> Option<f64> {
    let field = unquote(field.trim_ascii());
    let field = field.trim_ascii();
    if field.is_empty() { Some(f64::NAN) } else { fast_float2::parse(field).ok() }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::{ProptestConfig, prop_assert, prop_assert_eq, proptest};

    use super::plain_field;

    /// The standard parser finds the nearest `f64`: so does the scanner, at the end of a line and
    /// before another field.
    fn is_exact(field: &str) -> bool {
        let exact: f64 = field.parse().unwrap();
        let scanned = |line: &str| plain_field(line.as_bytes()).map(|(value, end)| (value.to_bits(), end));
        let expected = Some((exact.to_bits(), field.len()));
        scanned(field) == expected && scanned(&format!("{field},0.5")) == expected
    }

    #[test]
    fn plain_fields_are_exact() {
        let fields = [
            "0",
            "-0",
            "7",
            "-7",
            "0.1",
            "-0.3067962",
            ".5",
            "5.",
            "000.100",
            "12345678.9012345",
            "999999999999999",
        ];
        for field in fields {
            assert!(is_exact(field), "{field}");
        }
    }

    #[test]
    fn other_fields_are_left_to_others() {
        let fields = [
            "",
            "-",
            ".",
            "-.",
            "--1",
            "+1",
            "1.2.3",
            "1e5",
            "1E5",
            "nan",
            "inf",
            "x",
            "1x",
            " 1",
            "1 ",
            "\"1\"",
            "1234567890123456",
            "0.123456789012345678901234567890",
        ];
        for field in fields {
            assert_eq!(plain_field(field.as_bytes()), None, "{field}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn fixed_point_numbers_are_exact(value in -9e6..9e6_f64, decimals in 0..9_usize) {
            let field = format!("{value:.decimals$}");
            prop_assert!(is_exact(&field), "{}", field);
        }

        /// Whatever the bytes: what is accepted is a number to the standard parser too.
        #[test]
        fn accepts_numbers_only(
            bytes in proptest::collection::vec(proptest::sample::select(&b"0123456789.-+,eE \"/:\xff"[..]), 0..24)
        ) {
            if let Some((value, end)) = plain_field(&bytes) {
                let field = std::str::from_utf8(&bytes[..end]).unwrap();
                prop_assert_eq!(value.to_bits(), field.parse::<f64>().unwrap().to_bits());
            }
        }
    }
}
