//! The latest buckets, a fixed number of them.

/// A ring of the latest `B` buckets, oldest first when iterated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ring<S, const B: usize> {
    slots: [S; B],
    /// Where the next bucket goes.
    next: usize,
    filled: usize,
}

impl<S: Copy + Default, const B: usize> Default for Ring<S, B> {
    fn default() -> Self {
        Self { slots: [S::default(); B], next: 0, filled: 0 }
    }
}

impl<S: Copy + Default, const B: usize> Ring<S, B> {
    /// Adds a bucket; the oldest makes room.
    pub fn push(&mut self, bucket: S) {
        if let Some(slot) = self.slots.get_mut(self.next) {
            *slot = bucket;
        }
        self.next = if self.next + 1 < B { self.next + 1 } else { 0 };
        self.filled = (self.filled + 1).min(B);
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.filled
    }

    /// None yet.
    pub fn is_empty(&self) -> bool {
        self.filled == 0
    }

    /// The latest `count` buckets, or all if there are fewer, oldest first.
    pub fn latest(&self, count: usize) -> impl Iterator<Item = &S> + Clone {
        let [older, recent] = self.latest_parts(count);
        older.iter().chain(recent)
    }

    /// The same in the two parts that they are stored in.
    pub fn latest_parts(&self, count: usize) -> [&[S]; 2] {
        let count = count.min(self.filled);
        // The slots up to `next` are the latest; what is missing stands at the end.
        let (recent, older) = self.slots.split_at_checked(self.next).unwrap_or((&[], &[]));
        let from_older = older.len().saturating_sub(count.saturating_sub(recent.len()));
        let from_recent = recent.len().saturating_sub(count);
        let older = older.get(from_older..).unwrap_or(&[]);
        let recent = recent.get(from_recent..).unwrap_or(&[]);
        [older, recent]
    }

    /// Forgets all but the latest `count`.
    pub fn keep_latest(&mut self, count: usize) {
        let mut kept = Self::default();
        for bucket in self.latest(count) {
            kept.push(*bucket);
        }
        *self = kept;
    }

    /// Empties all but the latest `count`; their places stay.
    pub fn blank_older(&mut self, count: usize) {
        // Backwards from the last that stays: as many steps as there are buckets to empty.
        let count = count.min(self.filled);
        let mut slot = if count <= self.next { self.next - count } else { self.next + B - count };
        for _ in count..self.filled {
            slot = if slot > 0 { slot - 1 } else { B.saturating_sub(1) };
            if let Some(slot) = self.slots.get_mut(slot) {
                *slot = S::default();
            }
        }
    }

    /// Replaces every two neighbours by one, so that there is room for as many again.
    pub fn halve(&mut self, mut merge: impl FnMut(S, S) -> S) {
        let mut halved = Self::default();
        let mut first = None;
        for bucket in self.latest(B) {
            first = match first {
                None => Some(*bucket),
                Some(earlier) => {
                    halved.push(merge(earlier, *bucket));
                    None
                }
            };
        }
        if let Some(odd) = first {
            halved.push(odd);
        }
        *self = halved;
    }
}

#[cfg(test)]
mod tests {
    use super::Ring;
    use std::vec::Vec;

    #[test]
    fn keeps_the_latest_in_order() {
        let mut ring = Ring::<u32, 4>::default();
        assert!(ring.is_empty());
        for i in 1..=10 {
            ring.push(i);
            let all: Vec<_> = ring.latest(9).copied().collect();
            let expected: Vec<_> = (i.saturating_sub(3).max(1)..=i).collect();
            assert_eq!(all, expected);
            let two: Vec<_> = ring.latest(2).copied().collect();
            assert_eq!(two, (i.saturating_sub(1).max(1)..=i).collect::<Vec<_>>());
        }
        assert_eq!(ring.latest(0).count(), 0);
    }

    #[test]
    fn blanking_keeps_places() {
        let mut ring = Ring::<u32, 4>::default();
        for i in 1..=6 {
            ring.push(i);
        }
        ring.blank_older(3);
        assert_eq!(ring.latest(4).copied().collect::<Vec<_>>(), [0, 4, 5, 6]);
        ring.blank_older(9);
        assert_eq!(ring.latest(4).copied().collect::<Vec<_>>(), [0, 4, 5, 6]);
    }

    #[test]
    fn halving_merges_neighbours() {
        let mut ring = Ring::<u32, 4>::default();
        for i in [1, 2, 4, 8, 16] {
            ring.push(i);
        }
        ring.halve(|a, b| a + b);
        assert_eq!(ring.latest(4).copied().collect::<Vec<_>>(), [6, 24]);
        ring.push(1);
        ring.halve(|a, b| a + b);
        assert_eq!(ring.latest(4).copied().collect::<Vec<_>>(), [30, 1]);
    }
}
