//! Columns of a Parquet file, each decoded by whichever thread is free.
//!
//! Within a group of rows a column is a lane: its pages are decoded one behind the other, a batch
//! at a time, beside those of the other columns. Groups need nothing of each other, so the next
//! ones are begun where they are near. What is decoded and not yet taken is bounded by batches,
//! however large groups are.

use std::collections::VecDeque;

use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};

use crate::ahead::Work;
use crate::cell::Values;
use crate::error::{Error, Result};
use crate::guarded::guarded;
use crate::parquet_column::Column;
use crate::positioned::Positioned;

/// Rows at a time.
const BATCH: usize = 4096;

/// Batches that are decoded before they are taken, at most.
const MOST_BATCHES: usize = 16;

/// Numbers and texts that are decoded before they are taken, about: of a table with very many
/// columns fewer batches.
const MOST_CELLS: usize = 1 << 22;

pub(super) struct Lanes {
    reader: SerializedFileReader<Positioned>,
    /// Of each column that is handed out, in the file.
    places: Vec<usize>,
    is_wanted: Vec<bool>,
    /// The group that is opened next, and the first of those that are open.
    next_group: usize,
    first: usize,
    groups: VecDeque<Group>,
    /// Memory of numbers that were taken.
    spare: Vec<Vec<f64>>,
}

/// A group of rows.
struct Group {
    /// Rows that have not been taken.
    remaining: usize,
    /// None of a column that nobody asked for.
    lanes: Vec<Option<Lane>>,
    /// Why it cannot be read.
    refused: Option<Error>,
}

struct Lane {
    /// None while it is decoded, and behind an error.
    column: Option<Column>,
    /// Rows that have not been decoded, or begun.
    remaining: usize,
    /// Decoded, not yet taken.
    made: VecDeque<Result<Values>>,
}

/// The next batch of a lane.
pub(super) struct Job {
    group: usize,
    lane: usize,
    column: Column,
    count: usize,
    into: Values,
}

pub(super) struct Decoded {
    group: usize,
    lane: usize,
    column: Column,
    values: Result<Values>,
}

impl Lanes {
    pub(super) fn new(reader: SerializedFileReader<Positioned>, places: Vec<usize>) -> Self {
        let is_wanted = vec![true; places.len()];
        Self {
            reader,
            places,
            is_wanted,
            next_group: 0,
            first: 0,
            groups: VecDeque::new(),
            spare: Vec::new(),
        }
    }

    /// Of groups that are not open yet.
    pub(super) fn only(&mut self, is_wanted: &[bool]) {
        self.is_wanted.copy_from_slice(is_wanted);
    }

    /// Takes back what nobody needs any more: the next batches go there.
    pub(super) fn give_back(&mut self, values: &mut [Values]) {
        for values in values {
            if let Values::Numbers(numbers) = std::mem::replace(values, Values::Unread) {
                self.spare.push(numbers);
            }
        }
    }

    /// Opens the next group; false where there is none.
    fn open(&mut self) -> bool {
        if self.next_group == self.reader.num_row_groups() {
            return false;
        }
        let opened = guarded(|| self.group(self.next_group));
        let group = match opened {
            Some(Ok(group)) => group,
            Some(Err(error)) => Group::refused(super::parquet_file::damaged(error)),
            None => Group::refused(super::parquet_file::contradicts_itself()),
        };
        self.groups.push_back(group);
        self.next_group += 1;
        true
    }

    fn group(&self, number: usize) -> Result<Group, ParquetError> {
        let schema = self.reader.metadata().file_metadata().schema_descr_ptr();
        let group = self.reader.get_row_group(number)?;
        let remaining = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
        let lanes = self.places.iter().zip(&self.is_wanted).map(|(&place, is_wanted)| {
            let open = || {
                let column = Column::new(&schema.column(place), group.get_column_reader(place)?);
                Ok(Lane { column: Some(column), remaining, made: VecDeque::new() })
            };
            is_wanted.then(open).transpose()
        });
        let lanes = lanes.collect::<Result<Vec<_>, ParquetError>>()?;
        Ok(Group { remaining, lanes, refused: None })
    }

    /// Batches that are decoded ahead at most.
    fn most_batches(&self) -> usize {
        let wanted = self.is_wanted.iter().filter(|is_wanted| **is_wanted).count();
        (MOST_CELLS / (BATCH * wanted.max(1))).clamp(1, MOST_BATCHES)
    }

    /// Group and lane of what is to be decoded next, among so many batches: the earliest. None
    /// where groups that are open have nothing; then also whether others could have.
    fn next_lane(&self, most: usize) -> (Option<(usize, usize)>, bool) {
        let mut before = 0;
        for (place, group) in self.groups.iter().enumerate() {
            if before >= most {
                return (None, false);
            }
            let is_free =
                |lane: &Lane| lane.column.is_some() && lane.remaining > 0 && before + lane.made.len() < most;
            let free = group.lanes.iter().enumerate().filter_map(|(number, lane)| {
                lane.as_ref().filter(|lane| is_free(lane)).map(|lane| (lane.made.len(), number))
            });
            if let Some((_, number)) = free.min() {
                return (Some((place, number)), false);
            }
            before = before.saturating_add(group.remaining.div_ceil(BATCH));
        }
        (None, before < most)
    }

    /// Nothing comes behind an error.
    fn end(&mut self) {
        self.next_group = self.reader.num_row_groups();
        self.groups.clear();
    }
}

impl Group {
    fn refused(why: Error) -> Self {
        Self { remaining: 1, lanes: Vec::new(), refused: Some(why) }
    }

    /// The next batch, where all its columns are decoded: the first one's error is told, as if they
    /// were decoded one behind the other.
    fn take(&mut self) -> Option<Result<(usize, Vec<Values>)>> {
        if let Some(why) = self.refused.take() {
            return Some(Err(why));
        }
        if self.lanes.iter().flatten().any(|lane| lane.made.is_empty()) {
            return None;
        }
        let count = BATCH.min(self.remaining);
        self.remaining -= count;
        let columns = self.lanes.iter_mut().map(|lane| match lane {
            Some(lane) => lane.made.pop_front().unwrap_or(Ok(Values::Unread)),
            None => Ok(Values::Unread),
        });
        Some(columns.collect::<Result<Vec<_>>>().map(|columns| (count, columns)))
    }
}

impl Work for Lanes {
    type Job = Job;
    type Done = Decoded;
    /// How many rows, 0 at the end, and each column's.
    type Next = Result<(usize, Vec<Values>)>;

    fn claim(&mut self) -> Option<Job> {
        let most = self.most_batches();
        loop {
            let (next, is_more) = self.next_lane(most);
            let Some((place, number)) = next else {
                if is_more && self.open() {
                    continue;
                }
                return None;
            };
            let lane = self.groups.get_mut(place)?.lanes.get_mut(number)?.as_mut()?;
            let count = BATCH.min(lane.remaining);
            lane.remaining -= count;
            let column = lane.column.take()?;
            let into = Values::Numbers(self.spare.pop().unwrap_or_default());
            return Some(Job { group: self.first + place, lane: number, column, count, into });
        }
    }

    fn make(Job { group, lane, mut column, count, mut into }: Job) -> Decoded {
        let filled = guarded(|| column.fill(count, &mut into));
        let values = match filled {
            Some(Ok(())) if into.len() == Some(count) => Ok(into),
            Some(Ok(())) => {
                Err(Error::Damaged("is a Parquet file with columns of different lengths".to_owned()))
            }
            Some(Err(error)) => Err(super::parquet_file::damaged(error)),
            None => Err(super::parquet_file::contradicts_itself()),
        };
        Decoded { group, lane, column, values }
    }

    fn keep(&mut self, Decoded { group, lane, column, values }: Decoded) {
        let group = group.checked_sub(self.first).and_then(|place| self.groups.get_mut(place));
        let Some(Some(lane)) = group.and_then(|group| group.lanes.get_mut(lane)) else { return };
        lane.column = values.is_ok().then_some(column);
        lane.made.push_back(values);
    }

    fn take(&mut self) -> Option<Self::Next> {
        loop {
            let Some(group) = self.groups.front_mut() else {
                if self.open() {
                    continue;
                }
                return Some(Ok((0, vec![Values::Unread; self.places.len()])));
            };
            if group.remaining == 0 {
                self.groups.pop_front();
                self.first += 1;
                continue;
            }
            let next = group.take()?;
            if next.is_err() {
                self.end();
            }
            return Some(next);
        }
    }

    fn is_behind(&self) -> bool {
        let (next, is_more) = self.next_lane(self.most_batches().div_ceil(2));
        next.is_some() || is_more && self.next_group < self.reader.num_row_groups()
    }
}
