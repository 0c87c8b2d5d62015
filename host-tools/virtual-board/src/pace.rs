//! How fast the virtual board's time may run.

use std::time::{Duration, Instant};

/// How far the board may run ahead of its client's last byte: a tenth of what its FIFO of samples
/// holds at least.
const LEAD: Duration = Duration::from_millis(500);

/// A client that has said nothing for so long, of its own time, is not waited for.
const PATIENCE: Duration = Duration::from_secs(2);

/// A greater lag of board time after real time is not made up for.
const LAG: Duration = Duration::from_millis(500);

/// The pace: times real time, and no faster than an active client can follow.
#[derive(Debug)]
pub struct Pace {
    /// Board seconds per second; `None`: as fast as it goes.
    factor: Option<f64>,
    /// Real time and board time from which on the factor counts.
    origin: (Instant, Duration),
    /// Real time and board time of the client's last byte.
    heard: Option<(Instant, Duration)>,
}

impl Pace {
    /// From `now` on.
    pub fn new(factor: Option<f64>, now: Instant) -> Self {
        Self { factor, origin: (now, Duration::ZERO), heard: None }
    }

    /// The client has sent something.
    pub fn hear(&mut self, now: Instant, board: Duration) {
        self.heard = Some((now, board));
    }

    /// There is no client any more.
    pub fn hang_up(&mut self) {
        self.heard = None;
    }

    /// The clock stood still on purpose: what passed meanwhile does not count.
    pub fn restart(&mut self, now: Instant, board: Duration) {
        self.origin = (now, board);
    }

    /// How long the board has to wait before it goes on: 0 when it may.
    pub fn wait(&mut self, now: Instant, board: Duration) -> Duration {
        let for_client = match self.heard {
            Some((at, from)) if board.saturating_sub(from) > LEAD => {
                PATIENCE.saturating_sub(now.saturating_duration_since(at))
            }
            _ => Duration::ZERO,
        };
        for_client.max(self.for_clock(now, board))
    }

    fn for_clock(&mut self, now: Instant, board: Duration) -> Duration {
        let Some(factor) = self.factor else { return Duration::ZERO };
        let due = board.saturating_sub(self.origin.1).div_f64(factor);
        let passed = now.saturating_duration_since(self.origin.0);
        if passed > due + LAG {
            self.origin = (now, board);
        }
        due.saturating_sub(passed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn ms(milliseconds: u64) -> Duration {
        Duration::from_millis(milliseconds)
    }

    #[test]
    fn board_time_follows_real_time() {
        let begun = Instant::now();
        let mut pace = Pace::new(Some(2.0), begun);
        assert_eq!(pace.wait(begun, ms(0)), ms(0));
        assert_eq!(pace.wait(begun + ms(1), ms(10)), ms(4));
        assert_eq!(pace.wait(begun + ms(5), ms(10)), ms(0));
        // The machine slept for a minute: that is not made up for.
        assert_eq!(pace.wait(begun + ms(60_000), ms(10)), ms(0));
        assert_eq!(pace.wait(begun + ms(60_000), ms(20)), ms(5));
    }

    #[test]
    fn an_active_client_is_waited_for_and_a_silent_one_is_not() {
        let begun = Instant::now();
        let mut pace = Pace::new(None, begun);
        assert_eq!(pace.wait(begun, ms(99_000)), ms(0), "nobody is there");
        pace.hear(begun, ms(99_000));
        assert_eq!(pace.wait(begun, ms(99_500)), ms(0));
        assert_eq!(pace.wait(begun + ms(10), ms(99_501)), ms(1990));
        assert_eq!(pace.wait(begun + ms(2000), ms(99_501)), ms(0));
        pace.hear(begun + ms(10), ms(99_501));
        assert_eq!(pace.wait(begun + ms(11), ms(99_502)), ms(0));
        assert!(pace.wait(begun + ms(11), ms(100_600)) > ms(0));
        pace.hang_up();
        assert_eq!(pace.wait(begun + ms(11), ms(100_600)), ms(0));
    }
}
