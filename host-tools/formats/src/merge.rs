//! Rows out of several topics, on the clock of one of them.
//!
//! The rule: each message of the base topic in which the base fields are numbers is a row, at the
//! time of its header's stamp, or of its receipt where it bears none. Other fields are interpolated
//! linearly between the messages of their topic before and behind that time, if these are no
//! further apart than the greatest gap; else the row has no number there (NaN). Nothing is
//! extrapolated. A message that is not later than the one before it of its topic is left out, and
//! counted.

use std::collections::VecDeque;

use crate::bag::Bag;
use crate::ending::Ending;
use crate::error::{Error, Result, nearest};
use crate::extract::Extractor;
use crate::field::Field;

/// Clocks further apart than this, s, are different ones: no network delivers so late.
const CLOCKS_APART_S: f64 = 30.0;

/// Beyond twice the greatest gap a late message is waited for so long, ns.
const PATIENCE_NS: i64 = 1_000_000_000;

/// Rows that wait for messages of other topics at most: with more, memory would grow with a topic
/// that has gone silent.
const MOST_WAITING: usize = 1 << 16;

/// Which time a message has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Clock {
    /// The header's stamp, where it has one.
    #[default]
    Stamp,
    /// When the recorder received it.
    Receipt,
}

/// What is merged.
#[derive(Debug, Clone)]
pub struct Request {
    /// Fields of one topic, whose messages are the rows.
    pub base: Vec<Field>,
    /// Fields of any topics.
    pub others: Vec<Field>,
    /// Two messages further apart than this, s, say nothing of the time between them.
    pub greatest_gap_s: f64,
    /// Which time counts.
    pub clock: Clock,
}

/// What became of a bag.
#[derive(Debug, Clone, PartialEq)]
pub struct Merged {
    /// How it ended.
    pub ending: Ending,
    /// Rows handed out.
    pub rows: u64,
    /// Messages that were not later than the one before.
    pub out_of_order: u64,
    /// When the first row was, ns on the base topic's clock.
    pub start_ns: i64,
}

/// Hands out the rows of a bag: seconds since the first, then the base fields, then the others.
///
/// # Errors
/// A topic or field that the bag does not have; topics on different clocks; damage; and what `row`
/// reports.
pub fn merge(bag: &Bag, request: &Request, row: &mut dyn FnMut(f64, &[f64]) -> Result<()>) -> Result<Merged> {
    let mut merger = Merger::new(bag, request)?;
    let wanted: Vec<usize> = merger.tracks.iter().map(|track| track.topic).collect();
    let ending = bag.read(&wanted, &mut |topic, received, message| {
        merger.take(bag, topic, received, message)?;
        merger.hand_out(received, false, row)?;
        Ok(true)
    })?;
    merger.hand_out(i64::MAX, true, row)?;
    Ok(Merged {
        ending,
        rows: merger.rows,
        out_of_order: merger.out_of_order,
        start_ns: merger.start.unwrap_or(0),
    })
}

/// The messages of one topic that rows still need.
struct Track {
    topic: usize,
    extractor: Extractor,
    /// Where its numbers go in a row.
    slots: Vec<usize>,
    /// Its numbers are of elements by their names: messages without them are no messages of ours.
    is_named: bool,
    /// Whether its messages bear a time, once one has been seen.
    stamped: Option<bool>,
    recent: VecDeque<(i64, Vec<f64>)>,
    last: Option<i64>,
}

/// A message of the base topic that waits for the others.
struct Waiting {
    time: i64,
    received: i64,
    base: Vec<f64>,
}

struct Merger {
    /// The first is the base.
    tracks: Vec<Track>,
    base: usize,
    waiting: VecDeque<Waiting>,
    gap_ns: i64,
    clock: Clock,
    /// Stamp of the first message minus its receipt, by track, s.
    offsets: Vec<Option<f64>>,
    row: Vec<f64>,
    start: Option<i64>,
    rows: u64,
    out_of_order: u64,
}

/// The topic of this name.
///
/// # Errors
/// Names those that there are.
pub fn find_topic(bag: &Bag, name: &str) -> Result<usize> {
    bag.topics().iter().position(|topic| topic.name == name).ok_or_else(|| {
        let has = nearest(name, bag.topics().iter().map(|topic| &topic.name[..]));
        Error::Choice(format!("has no topic {name}; it has: {has}"))
    })
}

impl Merger {
    fn new(bag: &Bag, request: &Request) -> Result<Self> {
        let Some(first) = request.base.first() else {
            return Err(Error::Choice("no base field; expected one at least".to_owned()));
        };
        if let Some(other) = request.base.iter().find(|field| field.topic != first.topic) {
            let message = format!("{first} and {other} are of two topics; expected base fields of one");
            return Err(Error::Choice(message));
        }
        let base = request.base.len();
        let mut tracks =
            vec![Self::track(bag, &request.base.iter().collect::<Vec<_>>(), (0..base).collect())?];
        let mut remaining: Vec<(usize, &Field)> = (base..).zip(&request.others).collect();
        while let Some((_, next)) = remaining.first() {
            let topic = next.topic.clone();
            let (same, rest): (Vec<_>, Vec<_>) =
                remaining.into_iter().partition(|(_, field)| field.topic == topic);
            remaining = rest;
            let fields: Vec<&Field> = same.iter().map(|(_, field)| *field).collect();
            tracks.push(Self::track(bag, &fields, same.iter().map(|(slot, _)| *slot).collect())?);
        }
        let gap_ns = (request.greatest_gap_s * 1e9).clamp(0.0, 1e15) as i64;
        Ok(Self {
            offsets: vec![None; tracks.len()],
            tracks,
            base,
            waiting: VecDeque::new(),
            gap_ns,
            clock: request.clock,
            row: vec![f64::NAN; base + request.others.len()],
            start: None,
            rows: 0,
            out_of_order: 0,
        })
    }

    fn track(bag: &Bag, fields: &[&Field], slots: Vec<usize>) -> Result<Track> {
        let topic = find_topic(bag, &fields[0].topic)?;
        let extractor = Extractor::new(&bag.topics()[topic], fields)?;
        let is_named = fields.iter().all(|field| field.is_named());
        Ok(Track { topic, extractor, slots, is_named, stamped: None, recent: VecDeque::new(), last: None })
    }

    fn take(&mut self, bag: &Bag, topic: usize, received: i64, message: &[u8]) -> Result<()> {
        for place in 0..self.tracks.len() {
            let track = &mut self.tracks[place];
            if track.topic != topic {
                continue;
            }
            let name = &bag.topics()[topic].name;
            let numbers = track.extractor.numbers(message).map_err(|error| match error {
                Error::Damaged(why) => {
                    Error::Damaged(format!("topic {name}, received at {received} ns: {why}"))
                }
                Error::Unsupported(why) => Error::Unsupported(format!("topic {name}: {why}")),
                error => error,
            })?;
            // Another publisher's joints: no message of ours.
            let is_none = |number: &f64| number.is_nan();
            if place == 0 && numbers.iter().any(is_none) || track.is_named && numbers.iter().all(is_none) {
                continue;
            }
            let numbers = numbers.to_vec();
            let stamp = track.extractor.stamp_ns().filter(|_| self.clock == Clock::Stamp);
            let stamped = *track.stamped.get_or_insert(stamp.is_some());
            let time = if stamped { stamp } else { Some(received) };
            let Some(time) = time.filter(|time| track.last.is_none_or(|last| *time > last)) else {
                self.out_of_order += 1;
                continue;
            };
            track.last = Some(time);
            if self.offsets[place].is_none() {
                self.offsets[place] = Some((time.saturating_sub(received)) as f64 / 1e9);
                self.check_clocks(bag)?;
            }
            if place == 0 {
                self.waiting.push_back(Waiting { time, received, base: numbers });
            } else {
                self.tracks[place].recent.push_back((time, numbers));
            }
        }
        Ok(())
    }

    fn check_clocks(&self, bag: &Bag) -> Result<()> {
        let Some(base) = self.offsets[0] else { return Ok(()) };
        let apart =
            |offset: &Option<f64>| offset.is_some_and(|offset| (offset - base).abs() > CLOCKS_APART_S);
        let Some(other) = self.offsets.iter().position(apart) else { return Ok(()) };
        let name = |place: usize| &bag.topics()[self.tracks[place].topic].name;
        let how = |place: usize| {
            if self.tracks[place].stamped == Some(true) { "stamped" } else { "timed by their receipt" }
        };
        let offset = self.offsets[other].unwrap_or(0.0) - base;
        Err(Error::Choice(format!(
            "mixes clocks: messages of {} are {}, those of {} are {}, {offset:.0} s apart; expected one clock (clock = \"receipt\" in [topics] takes \
             the recorder's for all)",
            name(0),
            how(0),
            name(other),
            how(other)
        )))
    }

    /// Hands out the rows that nothing is missing for, and those that have waited long enough.
    fn hand_out(
        &mut self,
        now: i64,
        is_end: bool,
        row: &mut dyn FnMut(f64, &[f64]) -> Result<()>,
    ) -> Result<()> {
        let patience = self.gap_ns.saturating_mul(2).saturating_add(PATIENCE_NS);
        while let Some(first) = self.waiting.front() {
            let time = first.time;
            let is_late =
                is_end || now.saturating_sub(first.received) > patience || self.waiting.len() > MOST_WAITING;
            let is_ready = self.tracks[1..].iter().all(|track| track.last.is_some_and(|last| last >= time));
            if !is_ready && !is_late {
                break;
            }
            let Some(first) = self.waiting.pop_front() else { break };
            self.row.fill(f64::NAN);
            self.row[..self.base].copy_from_slice(&first.base);
            for track in &mut self.tracks[1..] {
                track.interpolate(time, self.gap_ns, &mut self.row);
            }
            let start = *self.start.get_or_insert(time);
            row((time - start) as f64 / 1e9, &self.row)?;
            self.rows += 1;
        }
        // What no row can ask for any more, so that memory does not grow where the base topic is
        // silent.
        let first = self.waiting.front().map_or(i64::MAX, |first| first.time);
        for track in &mut self.tracks[1..] {
            let oldest = track.last.unwrap_or(0).saturating_sub(patience).min(first);
            while track.recent.get(1).is_some_and(|(next, _)| *next <= oldest) {
                track.recent.pop_front();
            }
        }
        Ok(())
    }
}

impl Track {
    /// Fills its places of a row; times asked for only ever grow.
    fn interpolate(&mut self, time: i64, gap_ns: i64, row: &mut [f64]) {
        while self.recent.get(1).is_some_and(|(next, _)| *next <= time) {
            self.recent.pop_front();
        }
        let Some((before, from)) = self.recent.front().filter(|(before, _)| *before <= time) else { return };
        if *before == time {
            for (slot, value) in self.slots.iter().zip(from) {
                row[*slot] = *value;
            }
            return;
        }
        let Some((behind, to)) = self.recent.get(1).filter(|(behind, _)| behind - before <= gap_ns) else {
            return;
        };
        let share = (time - before) as f64 / (behind - before) as f64;
        for ((slot, from), to) in self.slots.iter().zip(from).zip(to) {
            row[*slot] = from + (to - from) * share;
        }
    }
}
