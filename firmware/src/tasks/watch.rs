//! Feeds the board's watchdog while the tasks work.

use embassy_time::{Duration, Instant, Timer};

use super::shared::Shared;
use crate::log::warning;

/// Lets `feed` feed the watchdog every `period`, as long as no task hangs.
pub async fn watch(period: Duration, mut feed: impl FnMut(), shared: &Shared) -> ! {
    let mut before = None;
    loop {
        let hung = shared.hung(Instant::now().as_micros());
        match hung {
            None => feed(),
            // Once may be because nothing ran while the flash was written, and its turn is yet to
            // come.
            Some(reporter) if before == hung => warning!("task {=u8} hangs", reporter as u8),
            Some(_) => {}
        }
        before = hung;
        Timer::after(period).await;
    }
}
