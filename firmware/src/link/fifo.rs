//! The latest records, until the host has said that it has them.

use crate::control_table::FIFO_WINDOW_RECORDS;
use crate::record::{RECORD_BYTES, Record};

/// Bytes of a record's number, which stands first: it follows from the record's place, and is not
/// kept.
const NUMBER: usize = size_of::<u32>();

/// What is kept of a record.
pub type Place = [u8; RECORD_BYTES - NUMBER];

/// A ring of records. It never waits for the host: the oldest are overwritten.
///
/// The memory is lent: it is most of a board's, and no stack has room for it while a state is made.
#[derive(Debug, PartialEq, Eq)]
pub struct Fifo<'a> {
    records: &'a mut [Place],
    /// Where the next one goes.
    head: usize,
    count: usize,
    next: u32,
    acknowledged: u32,
    /// Records since the host last acknowledged; stops at its maximum, where it begins.
    since_acknowledged: u32,
    lost: u32,
}

impl<'a> Fifo<'a> {
    /// Empty; the first record will be number 0.
    #[must_use]
    pub const fn new(records: &'a mut [Place]) -> Self {
        Self { records, head: 0, count: 0, next: 0, acknowledged: 0, since_acknowledged: u32::MAX, lost: 0 }
    }

    /// Numbers the record and adds it; gives its number.
    pub fn push(&mut self, record: Record) -> u32 {
        let sequence = self.next;
        let size = self.records.len();
        if self.count >= size {
            let overwritten = self.oldest();
            if self.since_acknowledged < self.patience() && self.window_start() == overwritten {
                self.lost = self.lost.saturating_add(1);
            }
        } else {
            self.count += 1;
        }
        if let Some(place) = self.records.get_mut(self.head) {
            let [_, _, _, _, rest @ ..] = record.encode();
            *place = rest;
        }
        self.head = if self.head + 1 < size { self.head + 1 } else { 0 };
        self.next = sequence.wrapping_add(1);
        self.since_acknowledged = self.since_acknowledged.saturating_add(1);
        if !self.can_acknowledge(self.acknowledged) {
            // Half of all numbers ago: it would count as yet to come.
            self.acknowledged = self.oldest();
        }
        sequence
    }

    /// Number that the next record will have.
    #[must_use]
    pub const fn next(&self) -> u32 {
        self.next
    }

    /// Number of the oldest record there is; [`Self::next`] when there is none.
    #[must_use]
    pub const fn oldest(&self) -> u32 {
        self.next.wrapping_sub(self.count as u32)
    }

    /// What the host acknowledged last.
    #[must_use]
    pub const fn acknowledged(&self) -> u32 {
        self.acknowledged
    }

    /// Records that were overwritten before a host that was there had acknowledged them.
    #[must_use]
    pub const fn lost(&self) -> u32 {
        self.lost
    }

    /// Whether `sequence` is not beyond the next record: a host that has records yet to come has
    /// them from before a restart.
    #[must_use]
    pub const fn can_acknowledge(&self, sequence: u32) -> bool {
        self.next.wrapping_sub(sequence) <= i32::MAX as u32
    }

    /// The host has all records before `sequence`, and is there. Going back is allowed: an answer
    /// may have got lost. Ignored unless
    /// [`Self::can_acknowledge`].
    pub fn acknowledge(&mut self, sequence: u32) {
        if self.can_acknowledge(sequence) {
            self.acknowledged = sequence;
            self.since_acknowledged = 0;
        }
    }

    /// Records in the window.
    #[must_use]
    pub fn window_count(&self) -> usize {
        (self.next.wrapping_sub(self.window_start()) as usize).min(FIFO_WINDOW_RECORDS)
    }

    /// The records of the window, oldest first.
    pub fn window(&self) -> impl Iterator<Item = [u8; RECORD_BYTES]> {
        let start = self.window_start();
        let behind = self.next.wrapping_sub(start) as usize;
        let (latest, earliest) = self.records.split_at_checked(self.head).unwrap_or((&[], &[]));
        let records = earliest
            .iter()
            .chain(latest)
            .skip(self.records.len().saturating_sub(behind))
            .take(self.window_count());
        records.zip(0..).map(move |(rest, index)| numbered(start.wrapping_add(index), rest))
    }

    /// A host that acknowledged nothing while so many records came is no longer there: what it
    /// misses is not lost.
    const fn patience(&self) -> u32 {
        2 * self.records.len() as u32
    }

    /// Where the window begins: behind what the host has, as far as it is still there.
    fn window_start(&self) -> u32 {
        let unacknowledged = self.next.wrapping_sub(self.acknowledged);
        self.next.wrapping_sub(unacknowledged.min(self.count as u32))
    }
}

fn numbered(number: u32, rest: &Place) -> [u8; RECORD_BYTES] {
    let mut record = [0; RECORD_BYTES];
    if let Some((place, behind)) = record.split_first_chunk_mut() {
        *place = number.to_le_bytes();
        behind.copy_from_slice(rest);
    }
    record
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SIZE: usize = 20;
    type Small = Fifo<'static>;

    fn small() -> Small {
        Fifo::new(Box::leak(Box::new([[0; _]; SIZE])))
    }

    fn record(time_us: u64) -> Record {
        Record { time_us, ..Record::default() }
    }

    fn filled(count: u64) -> Small {
        let mut fifo = small();
        (0..count).for_each(|time| assert_eq!(u64::from(fifo.push(record(time))), time));
        fifo
    }

    fn window(fifo: &Small) -> Vec<(u32, u64)> {
        fifo.window().map(|bytes| Record::decode(&bytes).unwrap()).map(|r| (r.sequence, r.time_us)).collect()
    }

    #[test]
    fn begins_empty() {
        let fifo = filled(0);
        assert_eq!((fifo.oldest(), fifo.next(), fifo.window_count(), fifo.lost()), (0, 0, 0, 0));
        assert!(window(&fifo).is_empty());
    }

    #[test]
    fn shows_the_oldest_that_are_not_acknowledged() {
        let mut fifo = filled(18);
        assert_eq!(window(&fifo), (0..16).map(|i| (i, u64::from(i))).collect::<Vec<_>>());
        fifo.acknowledge(16);
        assert_eq!(window(&fifo), [(16, 16), (17, 17)]);
        fifo.acknowledge(18);
        assert_eq!(fifo.window_count(), 0);
        // The answer got lost: once more.
        fifo.acknowledge(16);
        assert_eq!(window(&fifo), [(16, 16), (17, 17)]);
    }

    #[test]
    fn the_oldest_are_overwritten() {
        let fifo = filled(25);
        assert_eq!((fifo.oldest(), fifo.next()), (5, 25));
        assert_eq!(window(&fifo), (5..21).map(|i| (i, u64::from(i))).collect::<Vec<_>>());
    }

    #[test]
    fn what_is_yet_to_come_cannot_be_acknowledged() {
        let mut fifo = filled(5);
        fifo.acknowledge(6);
        assert_eq!(fifo.acknowledged(), 0);
        fifo.acknowledge(5);
        assert_eq!(fifo.acknowledged(), 5);
    }

    /// Nobody there: nothing is lost. A host that stops reading loses what is overwritten until it
    /// counts as gone: with twenty records that is after forty, of which it misses the twenty that
    /// were overwritten meanwhile.
    #[test]
    fn only_a_host_that_is_there_loses_records() {
        assert_eq!(filled(1000).lost(), 0);
        let mut fifo = filled(100);
        fifo.acknowledge(100);
        (0..20).for_each(|time| _ = fifo.push(record(time)));
        assert_eq!(fifo.lost(), 0);
        fifo.push(record(0));
        assert_eq!(fifo.lost(), 1);
        (0..1000).for_each(|time| _ = fifo.push(record(time)));
        assert_eq!(fifo.lost(), 20);
    }

    #[test]
    fn numbers_wrap() {
        let mut fifo = Small { next: u32::MAX - 2, acknowledged: u32::MAX - 2, ..small() };
        (0..5).for_each(|time| _ = fifo.push(record(time)));
        assert_eq!(window(&fifo), [(u32::MAX - 2, 0), (u32::MAX - 1, 1), (u32::MAX, 2), (0, 3), (1, 4)]);
        fifo.acknowledge(0);
        assert_eq!(window(&fifo), [(0, 3), (1, 4)]);
    }

    /// After 2³² records of which none was acknowledged the window still begins with the oldest.
    #[test]
    fn an_old_acknowledgement_does_not_come_true_again() {
        let mut fifo = Small { next: u32::MAX - 5, ..small() };
        (0..15).for_each(|time| _ = fifo.push(record(time)));
        assert_eq!(window(&fifo)[0], (u32::MAX - 5, 0));
    }

    proptest! {
        /// A host that acknowledges what it read gets every record that is not overwritten once, in
        /// order; what it does not get is what is counted as lost.
        #[test]
        fn every_record_once_or_counted(bursts in proptest::collection::vec(0..30_u64, 1..100)) {
            let mut fifo = small();
            fifo.acknowledge(0);
            let (mut pushed, mut expected, mut missed) = (0, 0, 0);
            for burst in bursts {
                for _ in 0..burst {
                    fifo.push(record(pushed));
                    pushed += 1;
                }
                for (sequence, time) in window(&fifo) {
                    prop_assert_eq!(u64::from(sequence), time);
                    prop_assert!(time >= expected);
                    missed += time - expected;
                    expected = time + 1;
                }
                fifo.acknowledge(expected as u32);
            }
            // Read the rest.
            while fifo.window_count() > 0 {
                for (_, time) in window(&fifo) {
                    missed += time - expected;
                    expected = time + 1;
                }
                fifo.acknowledge(expected as u32);
            }
            prop_assert_eq!(expected, pushed);
            prop_assert_eq!(missed, u64::from(fifo.lost()));
        }
    }
}
