//! An item on its way into the flash: checked at once, written when the robot stands still.

use crate::control_table::{Item, Reason, UPLOAD_BYTES, UploadState};
use crate::items::{ItemBytes, SIGNATURE_BYTES, checksum, parts};

use super::Settings;

/// The upload window and how far it is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Upload {
    pub(super) item: u8,
    pub(super) length: u16,
    pub(super) window: [u8; UPLOAD_BYTES],
    /// Of coefficients; zeros where there is none.
    pub(super) signature: [u8; SIGNATURE_BYTES],
    state: UploadState,
    reason: Reason,
    is_being_written: bool,
}

impl Upload {
    pub(super) const fn new() -> Self {
        Self {
            item: 0,
            length: 0,
            window: [0; UPLOAD_BYTES],
            signature: [0; SIGNATURE_BYTES],
            state: UploadState::Idle,
            reason: Reason::None,
            is_being_written: false,
        }
    }

    /// How far it is.
    #[must_use]
    pub const fn state(&self) -> UploadState {
        self.state
    }

    /// Why it was refused, or [`Reason::Erase`] while it waits for that; [`Reason::None`]
    /// otherwise.
    #[must_use]
    pub const fn reason(&self) -> Reason {
        self.reason
    }

    /// Whether the flash is being written, or about to be: item, length and window then stay as
    /// they were checked.
    pub(super) const fn is_waiting(&self) -> bool {
        matches!(self.state, UploadState::Waiting)
    }

    /// Whether something is to be written, or being written.
    #[must_use]
    pub const fn is_open(&self) -> bool {
        self.is_waiting()
    }

    /// Whether it is too late to forget it.
    pub(super) const fn is_being_written(&self) -> bool {
        self.is_being_written
    }

    /// The host has uploaded all of it.
    pub(super) fn submit(&mut self, settings: &Settings) {
        if self.is_waiting() {
            // Said twice: an answer got lost.
            return;
        }
        match self.check(settings) {
            // Flash wears: what it holds already is not written again.
            Ok((item, bytes)) if settings.stored(item) == bytes.as_slice() => self.end(Ok(())),
            Ok(_) => (self.state, self.reason) = (UploadState::Waiting, Reason::None),
            Err(reason) => self.end(Err(reason)),
        }
    }

    /// The host wants the coefficients with this checksum in use again, which were before those
    /// that are. As if it had uploaded them: so they are checked, stored and read back likewise,
    /// and the two change places.
    ///
    /// False while another upload waits.
    pub(super) fn roll_back(&mut self, crc: u32, settings: &Settings) -> bool {
        let is_same = |bytes: &[u8]| !bytes.is_empty() && checksum(parts(bytes).0) == crc;
        if self.is_waiting() {
            // Said twice: an answer got lost.
            return self
                .pending()
                .is_ok_and(|(item, bytes)| item == Item::Coefficients && is_same(bytes.as_slice()));
        }
        let previous = settings.previous();
        if is_same(settings.stored(Item::Coefficients)) {
            self.end(Ok(()));
        } else if is_same(previous.as_slice()) {
            self.fill(Item::Coefficients, previous);
            self.submit(settings);
        } else {
            self.end(Err(Reason::Empty));
        }
        true
    }

    fn fill(&mut self, item: Item, bytes: &ItemBytes) {
        let (image, signature) = parts(bytes.as_slice());
        (self.item, self.length) = (item as u8, image.len() as u16);
        self.signature = signature.copied().unwrap_or([0; SIGNATURE_BYTES]);
        self.window.iter_mut().zip(image).for_each(|(place, byte)| *place = *byte);
    }

    /// The host wants nothing written.
    pub(super) fn forget(&mut self) {
        if !self.is_being_written {
            (self.state, self.reason) = (UploadState::Idle, Reason::None);
        }
    }

    /// What waits, for the one that writes it; [`Self::end`] has to follow.
    pub(super) fn take(&mut self) -> Option<(Item, ItemBytes)> {
        if !self.is_waiting() || self.is_being_written {
            return None;
        }
        let pending = self.pending().ok()?;
        self.is_being_written = true;
        Some(pending)
    }

    /// It cannot be written before a sector is erased: it waits for that.
    pub(super) fn postpone(&mut self) {
        self.is_being_written = false;
        self.reason = Reason::Erase;
    }

    /// Whether it waits for a sector to be erased.
    pub(super) const fn needs_erase(&self) -> bool {
        self.is_waiting() && matches!(self.reason, Reason::Erase)
    }

    /// What [`Self::take`] gave.
    pub(super) fn being_written(&self, item: Item) -> Option<ItemBytes> {
        let (taken, bytes) = self.pending().ok()?;
        (self.is_being_written && taken == item).then_some(bytes)
    }

    pub(super) fn end(&mut self, result: Result<(), Reason>) {
        self.is_being_written = false;
        (self.state, self.reason) = match result {
            Ok(()) => (UploadState::Stored, Reason::None),
            Err(reason) => (UploadState::Refused, reason),
        };
    }

    fn check(&self, settings: &Settings) -> Result<(Item, ItemBytes), Reason> {
        let (item, bytes) = self.pending()?;
        settings.check(item, bytes.as_slice())?;
        Ok((item, bytes))
    }

    fn pending(&self) -> Result<(Item, ItemBytes), Reason> {
        let item = Item::from_code(self.item).ok_or(Reason::Item)?;
        let bytes = self.window.get(..usize::from(self.length)).ok_or(Reason::Length)?;
        let image = ItemBytes::new(bytes).ok_or(Reason::Length)?;
        let is_signed = item == Item::Coefficients && self.signature != [0; SIGNATURE_BYTES];
        let bytes = if is_signed { image.with(&self.signature).ok_or(Reason::Length)? } else { image };
        Ok((item, bytes))
    }
}
