//! Bytes on their way.

/// At most `N` of them, first in, first out.
pub(super) struct Queue<const N: usize> {
    bytes: [u8; N],
    length: usize,
}

impl<const N: usize> Queue<N> {
    pub(super) const fn new() -> Self {
        Self { bytes: [0; N], length: 0 }
    }

    pub(super) fn as_slice(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or(&[])
    }

    pub(super) fn is_empty(&self) -> bool {
        self.length == 0
    }

    /// How many more fit.
    pub(super) fn room(&self) -> usize {
        N - self.length
    }

    pub(super) fn clear(&mut self) {
        self.length = 0;
    }

    /// Adds as many as fit and says how many.
    pub(super) fn put(&mut self, bytes: &[u8]) -> usize {
        let count = bytes.len().min(self.room());
        let end = self.length + count;
        if let (Some(place), Some(bytes)) = (self.bytes.get_mut(self.length..end), bytes.get(..count)) {
            place.copy_from_slice(bytes);
            self.length = end;
        }
        count
    }

    /// Takes as many as `buffer` holds and says how many.
    pub(super) fn take(&mut self, buffer: &mut [u8]) -> usize {
        let count = buffer.len().min(self.length);
        if let (Some(place), Some(bytes)) = (buffer.get_mut(..count), self.bytes.get(..count)) {
            place.copy_from_slice(bytes);
        }
        self.bytes.copy_within(count..self.length, 0);
        self.length -= count;
        count
    }
}
