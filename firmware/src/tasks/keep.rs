//! Reads the store at start and writes what the host uploads, when the robot stands.

use embassy_time::{Duration, Timer};
use embedded_storage_async::nor_flash::NorFlash;

use super::shared::{Reporter, Shared};
use crate::control_table::Reason;
use crate::items::ITEMS;
use crate::log::{info, warning};
use crate::parameters::SAMPLE_PERIOD_US;
use crate::store::{BYTES, Store};

/// How often somebody looks whether there is something to write.
const PERIOD: Duration = Duration::from_millis(100);
/// How often somebody looks whether the sample is over: a few times between two of them.
const LOOK: Duration = Duration::from_micros(SAMPLE_PERIOD_US / 10);
/// After two periods it is written anyway.
const MOST_LOOKS: usize = 20;

/// Keeps the items in a flash that is the store's, from its beginning to its end.
pub async fn keep(flash: impl NorFlash, shared: &Shared) -> ! {
    // Refused where the flash has another geometry: then nothing is stored, and no upload is taken.
    let mut store = Store::new(flash, 0..BYTES as u32);
    for item in ITEMS {
        let found = match &mut store {
            Ok(store) => store.get(item).await,
            Err(error) => Err(*error),
        };
        shared.with(|state| state.load(item, found.map_err(Reason::from)));
    }
    loop {
        shared.report(Reporter::Keep);
        Timer::after(PERIOD).await;
        let Some((item, bytes)) = shared.with(|state| state.take_pending()) else { continue };
        shared.stall();
        between_samples(shared).await;
        let stored = match &mut store {
            Ok(store) => store.put(item, bytes.as_slice()).await,
            Err(error) => Err(*error),
        };
        let stored = stored.map_err(Reason::from);
        shared.resume();
        shared.with(|state| state.stored(item, stored));
        match stored {
            Ok(()) => info!("item {=u8} stored", item as u8),
            Err(reason) => warning!("item {=u8} not stored: {=str}", item as u8, reason.text()),
        }
    }
}

/// Waits until no transaction is on a bus, while no other may begin: one that stands still with the processor would fail.
async fn between_samples(shared: &Shared) {
    for _ in 0..MOST_LOOKS {
        if !shared.is_sampling() {
            return;
        }
        Timer::after(LOOK).await;
    }
}
