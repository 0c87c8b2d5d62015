//! Feeds the board's watchdog while the tasks work.

use embassy_time::{Duration, Instant, Timer};

use super::shared::Shared;

/// A task that has not reported for so long stands still. Erasing a sector of the flash, during which none can, takes less.
const MOST_SILENCE: Duration = Duration::from_secs(2);

/// Lets `feed` feed the watchdog every `period`, as long as every task that has to has reported. Who answers the host reports nothing: it
/// waits for a host for good, and what it writes has a limit of its own.
pub async fn watch(period: Duration, mut feed: impl FnMut(), shared: &Shared) -> ! {
    loop {
        let now = Instant::now();
        if shared.reports().iter().all(|report| now.saturating_duration_since(*report) < MOST_SILENCE) {
            feed();
        }
        Timer::after(period).await;
    }
}
