//! Whether a sensor can be believed: one event per poll goes in, one verdict comes out.

/// Polls without a finished conversion after which a sensor counts as [`Health::Stale`]. Its
/// conversions are faster than the polls ([`crate::parameters::SENSOR_SET_UP`]), so one is chance
/// and three are not.
const STALE_AFTER: u8 = 3;
/// Polls without an answer after which a sensor counts as [`Health::Absent`]: a single one may be a
/// disturbed bus.
const ABSENT_AFTER: u8 = 3;
/// Polls after which one counts as [`Health::Implausible`]: likewise.
const IMPLAUSIBLE_AFTER: u8 = 3;

/// The verdict on a sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum Health {
    /// Its readings count.
    Ok = 0,
    /// It answers but converts nothing new.
    Stale = 1,
    /// Its amplifier clips: the rail carries more than it can show.
    Overflow = 2,
    /// It does not answer.
    #[default]
    Absent = 3,
    /// It answers, but no longer has the set-up it was given: its supply broke down. It is set up
    /// again.
    LostCalibration = 4,
    /// It answers with readings that disagree with themselves.
    Implausible = 5,
}

impl Health {
    /// As the control table shows it.
    #[must_use]
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// `None` for a code that this version does not know.
    #[must_use]
    pub const fn from_code(code: u8) -> Option<Self> {
        Some(match code {
            0 => Self::Ok,
            1 => Self::Stale,
            2 => Self::Overflow,
            3 => Self::Absent,
            4 => Self::LostCalibration,
            5 => Self::Implausible,
            _ => return None,
        })
    }
}

/// What a poll of a sensor found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event {
    /// A new reading within range.
    Fresh,
    /// No conversion finished since the last poll.
    NotReady,
    /// A new reading, out of range.
    Clipped,
    /// The bus reported an error, such as a missing acknowledge.
    NoAnswer,
    /// The set-up read back is not the one written.
    SetUpLost,
    /// A reading that is not the chip's own product of its voltages: left out.
    Implausible,
}

/// How often each event happened since start. Stops at its maximum.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counters {
    /// [`Event::Fresh`]
    pub fresh: u32,
    /// [`Event::NotReady`]
    pub not_ready: u32,
    /// [`Event::Clipped`]
    pub clipped: u32,
    /// [`Event::NoAnswer`]
    pub no_answer: u32,
    /// [`Event::SetUpLost`]
    pub set_up_lost: u32,
    /// [`Event::Implausible`]
    pub implausible: u32,
}

impl Counters {
    /// Before the first poll.
    pub const NONE: Self =
        Self { fresh: 0, not_ready: 0, clipped: 0, no_answer: 0, set_up_lost: 0, implausible: 0 };
}

/// The state machine: a verdict and what led to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Status {
    health: Health,
    counters: Counters,
    /// Polls in a row that ended as [`Event::NotReady`].
    not_ready: u8,
    /// Polls in a row that ended as [`Event::NoAnswer`].
    no_answer: u8,
    /// Polls in a row that ended as [`Event::Implausible`].
    implausible: u8,
}

impl Status {
    /// A sensor never heard of is absent.
    #[must_use]
    pub const fn new() -> Self {
        Self { health: Health::Absent, counters: Counters::NONE, not_ready: 0, no_answer: 0, implausible: 0 }
    }

    /// The verdict after the last poll.
    #[must_use]
    pub const fn health(&self) -> Health {
        self.health
    }

    /// It has not answered so many polls in a row that it counts as absent, whatever it was before.
    /// Not so before the first poll.
    #[must_use]
    pub const fn is_silent(&self) -> bool {
        self.no_answer >= ABSENT_AFTER
    }

    /// What happened so far.
    #[must_use]
    pub const fn counters(&self) -> Counters {
        self.counters
    }

    /// Takes the result of one poll.
    ///
    /// A reading decides at once, in either direction; a missing one only after several in a row,
    /// so that the verdict does not flicker.
    pub fn observe(&mut self, event: Event) {
        let counter = match event {
            Event::Fresh => &mut self.counters.fresh,
            Event::NotReady => &mut self.counters.not_ready,
            Event::Clipped => &mut self.counters.clipped,
            Event::NoAnswer => &mut self.counters.no_answer,
            Event::SetUpLost => &mut self.counters.set_up_lost,
            Event::Implausible => &mut self.counters.implausible,
        };
        *counter = counter.saturating_add(1);

        self.not_ready = if event == Event::NotReady { self.not_ready.saturating_add(1) } else { 0 };
        self.no_answer = if event == Event::NoAnswer { self.no_answer.saturating_add(1) } else { 0 };
        self.implausible = if event == Event::Implausible { self.implausible.saturating_add(1) } else { 0 };
        self.health = match event {
            Event::Fresh => Health::Ok,
            Event::Clipped => Health::Overflow,
            Event::SetUpLost => Health::LostCalibration,
            Event::NotReady if self.not_ready >= STALE_AFTER => Health::Stale,
            Event::NoAnswer if self.no_answer >= ABSENT_AFTER => Health::Absent,
            Event::Implausible if self.implausible >= IMPLAUSIBLE_AFTER => Health::Implausible,
            Event::NotReady | Event::NoAnswer | Event::Implausible => self.health,
        };
    }
}

impl Default for Status {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(events: &[Event]) -> Health {
        let mut status = Status::new();
        events.iter().for_each(|&event| status.observe(event));
        status.health()
    }

    #[test]
    fn absent_until_heard() {
        assert_eq!(after(&[]), Health::Absent);
        assert_eq!(after(&[Event::Fresh]), Health::Ok);
    }

    #[test]
    fn silent_after_three_polls_without_an_answer() {
        let mut status = Status::new();
        let silence = [false, false, true].map(|expected| {
            status.observe(Event::NoAnswer);
            status.is_silent() == expected
        });
        assert!(!Status::new().is_silent());
        assert_eq!(silence, [true; 3]);
        status.observe(Event::NotReady);
        assert!(!status.is_silent());
    }

    #[test]
    fn one_missing_reading_is_chance_three_are_not() {
        use Event::{Fresh, NoAnswer, NotReady};
        assert_eq!(after(&[Fresh, NotReady, NotReady]), Health::Ok);
        assert_eq!(after(&[Fresh, NotReady, NotReady, NotReady]), Health::Stale);
        assert_eq!(after(&[Fresh, NoAnswer, NoAnswer]), Health::Ok);
        assert_eq!(after(&[Fresh, NoAnswer, NoAnswer, NoAnswer]), Health::Absent);
    }

    /// The two kinds of missing reading do not add up to one verdict.
    #[test]
    fn only_events_in_a_row_count() {
        use Event::{Fresh, NoAnswer, NotReady};
        assert_eq!(after(&[Fresh, NotReady, NotReady, Fresh, NotReady]), Health::Ok);
        assert_eq!(after(&[Fresh, NotReady, NotReady, NoAnswer, NotReady]), Health::Ok);
    }

    #[test]
    fn a_reading_decides_at_once() {
        use Event::{Clipped, Fresh, NotReady, SetUpLost};
        assert_eq!(after(&[Fresh, Clipped]), Health::Overflow);
        assert_eq!(after(&[Clipped, Fresh]), Health::Ok);
        assert_eq!(after(&[Fresh, SetUpLost]), Health::LostCalibration);
        // A sensor just set up again has to convert first.
        assert_eq!(after(&[Fresh, SetUpLost, NotReady]), Health::LostCalibration);
        assert_eq!(after(&[Fresh, SetUpLost, NotReady, Fresh]), Health::Ok);
    }

    #[test]
    fn counters_stop_at_their_maximum() {
        let mut status = Status::new();
        status.counters.fresh = u32::MAX;
        (0..300).for_each(|_| status.observe(Event::NoAnswer));
        status.observe(Event::Fresh);
        assert_eq!(status.counters(), Counters { fresh: u32::MAX, no_answer: 300, ..Counters::default() });
    }
}
