//! Reads the store at start, writes what the host uploads, when the robot stands, and the totals.

use embassy_time::{Duration, Instant, Timer};
use embedded_storage_async::nor_flash::NorFlash;

use super::shared::{Reporter, Shared};
use crate::control_table::{Item, Reason};
use crate::items::{ITEMS, ItemBytes, Verify, check_signature};
use crate::log::{info, warning};
use crate::parameters::SAMPLE_PERIOD_US;
use crate::store::{BYTES, Store, StoreError};
use crate::totals::Totals;

/// How often somebody looks whether there is something to write.
const PERIOD: Duration = Duration::from_millis(100);
/// How often somebody looks whether the sample is over: a few times between two of them.
const LOOK: Duration = Duration::from_micros(SAMPLE_PERIOD_US / 10);
/// After two periods it is written anyway.
const MOST_LOOKS: usize = 20;

/// Keeps items and totals in a flash that is the store's, from its beginning to its end. With
/// `verify` coefficients need a signature.
pub async fn keep(flash: impl NorFlash, verify: Option<Verify>, shared: &Shared) -> ! {
    shared.with(|state| state.needs_signature = verify.is_some());
    let mut keeper = match Store::new(flash, 0..BYTES as u32) {
        Ok(store) => Keeper { store, verify, shared, has_failed: false },
        // The flash has another geometry: nothing is stored, and no upload is taken.
        Err(error) => refuse(error, shared).await,
    };
    // Before any servo has a torque: no sample begins meanwhile.
    shared.stall();
    between_samples(shared).await;
    keeper.load().await;
    shared.resume();
    loop {
        shared.report(Reporter::Keep, Instant::now().as_micros());
        Timer::after(PERIOD).await;
        keeper.look().await;
    }
}

async fn refuse(error: StoreError, shared: &Shared) -> ! {
    let reason = Reason::from(error);
    ITEMS.into_iter().for_each(|item| shared.with(|state| state.load(item, Err(reason))));
    loop {
        shared.report(Reporter::Keep, Instant::now().as_micros());
        Timer::after(PERIOD).await;
        if let Some((item, _)) = shared.with(|state| state.take_pending()) {
            shared.with(|state| state.stored(item, Err(reason)));
        }
    }
}

struct Keeper<'a, F> {
    store: Store<F>,
    verify: Option<Verify>,
    shared: &'a Shared,
    /// Erasing failed: it is not tried again unasked.
    has_failed: bool,
}

impl<F: NorFlash> Keeper<'_, F> {
    /// What the flash holds, and its spare sector erased.
    async fn load(&mut self) {
        for item in ITEMS {
            let stored = self.store.get(item).await.map_err(Reason::from);
            // Whoever had the flash in hand may have written it.
            let stored = stored.and_then(|bytes| self.check(item, &bytes).map(|()| bytes));
            self.shared.with(|state| state.load(item, stored));
        }
        let previous = self.store.previous().await.unwrap_or(ItemBytes::EMPTY);
        // This finds where the next record belongs, too, record by record: some milliseconds that a
        // sample would wait for later.
        let totals = self.store.totals().await.map(|bytes| bytes.map(|bytes| Totals::decode(&bytes)));
        self.shared.with(|state| {
            state.load_previous(previous);
            state.ledger.load(totals.map_err(Reason::from));
        });
        self.prepare().await;
        self.show().await;
    }

    /// One piece of work, if there is any.
    async fn look(&mut self) {
        let may_erase = self.shared.with(|state| state.may_erase());
        self.store.allow_erasing(may_erase);
        if let Some((item, bytes)) = self.shared.with(|state| state.take_pending()) {
            let stored = self.put(item, &bytes).await;
            self.shared.with(|state| state.stored(item, stored));
            match stored {
                Ok(()) => info!("item {=u8} stored", item as u8),
                Err(reason) => warning!("item {=u8} not stored: {=str}", item as u8, reason.text()),
            }
        } else if let Some(totals) = self.shared.with(|state| state.due_totals()) {
            self.append(&totals).await;
        } else if may_erase && !self.has_failed && self.store.is_prepared().await == Ok(false) {
            self.shared.stall();
            between_samples(self.shared).await;
            self.prepare().await;
            self.shared.resume();
        } else {
            return;
        }
        self.show().await;
    }

    /// Sampling goes on while the signature is looked at: only the erase and the words of the flash
    /// are in its way.
    async fn put(&mut self, item: Item, bytes: &ItemBytes) -> Result<(), Reason> {
        self.check(item, bytes)?;
        self.shared.stall();
        between_samples(self.shared).await;
        let stored = self.store.put(item, bytes.as_slice()).await.map_err(Reason::from);
        self.shared.resume();
        stored
    }

    /// Whether it is signed as it has to be. Takes some ten milliseconds: at a standstill, as
    /// writing.
    fn check(&self, item: Item, bytes: &ItemBytes) -> Result<(), Reason> {
        match item {
            Item::Coefficients => check_signature(bytes.as_slice(), self.verify),
            Item::Calibration | Item::Robot => Ok(()),
        }
    }

    /// A record costs a fraction of a millisecond, also while the robot drives: it begins between
    /// two samples, and one that becomes due goes on between its words. Moving to the other sector
    /// takes some milliseconds: that waits for a standstill.
    async fn append(&mut self, totals: &Totals) {
        let has_to_move = self.store.is_log_full().await != Ok(false);
        if has_to_move {
            if !self.shared.with(|state| state.snapshot.is_standing) {
                return;
            }
            self.shared.stall();
        }
        between_samples(self.shared).await;
        let written = self.store.append_totals(&totals.encode()).await.map_err(Reason::from);
        self.shared.resume();
        self.shared.with(|state| state.ledger.written(written, state.snapshot.time_us));
        if let Err(reason) = written {
            warning!("totals not written: {=str}", reason.text());
        }
    }

    async fn prepare(&mut self) {
        if let Err(error) = self.store.prepare().await {
            self.has_failed = true;
            warning!("no spare sector: {=str}", Reason::from(error).text());
        }
    }

    async fn show(&mut self) {
        let is_prepared = self.store.is_prepared().await == Ok(true);
        let erases = self.store.erases();
        self.shared.with(|state| {
            state.is_store_prepared = is_prepared;
            state.counters.store_erases = erases;
        });
    }
}

/// Waits until no transaction is on a bus: one that stands still with the processor would fail.
async fn between_samples(shared: &Shared) {
    for _ in 0..MOST_LOOKS {
        if !shared.is_sampling() {
            return;
        }
        Timer::after(LOOK).await;
    }
}
