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

/// A number at the start of a line and the bytes up to the end of its field; `None` if the field is anything else.
/// Spaces and quotes around a number are left to [`number_in_field`].
#[inline]
pub(super) fn plain_number(line: &[u8]) -> Option<(f64, usize)> {
    let (value, length) = fast_float2::parse_partial::<f64, _>(line).ok()?;
    matches!(line.get(length), None | Some(b',')).then_some((value, length))
}

/// The number in a field, NaN if it is empty; `None` if it is text.
pub(super) fn number_in_field(field: &[u8]) -> Option<f64> {
    let field = unquote(field.trim_ascii());
    let field = field.trim_ascii();
    if field.is_empty() { Some(f64::NAN) } else { fast_float2::parse(field).ok() }
}
