//! What USB's interrupt and its tasks share.

use core::cell::Cell;
use core::sync::atomic::{AtomicBool, Ordering};

use embassy_sync::blocking_mutex::CriticalSectionMutex;
use embassy_sync::waitqueue::AtomicWaker;

use super::{ENDPOINTS, PACKET_BYTES};

/// One packet from the host.
#[derive(Debug, Clone, Copy)]
pub(super) struct Packet {
    bytes: [u8; PACKET_BYTES],
    length: usize,
}

impl Packet {
    /// The first `length` of `bytes`; `None` where the packet would be longer than any that the
    /// host may send.
    pub(super) fn new(bytes: [u8; PACKET_BYTES], length: usize) -> Option<Self> {
        (length <= PACKET_BYTES).then_some(Self { bytes, length })
    }

    pub(super) fn as_slice(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or(&[])
    }

    /// What a SETUP packet has to be (USB 2.0, 9.3).
    pub(super) fn setup(&self) -> Option<[u8; 8]> {
        self.as_slice().try_into().ok()
    }
}

/// One endpoint number, both directions.
pub(super) struct Endpoint {
    /// Received, while its transaction is not over.
    staged: CriticalSectionMutex<Cell<Option<Packet>>>,
    /// Received. The endpoint takes the next one when this has been fetched.
    received: CriticalSectionMutex<Cell<Option<Packet>>>,
    /// Who sends to the host.
    pub(super) to_host: AtomicWaker,
    /// Who receives from it.
    pub(super) from_host: AtomicWaker,
}

impl Endpoint {
    const fn new() -> Self {
        Self {
            staged: CriticalSectionMutex::new(Cell::new(None)),
            received: CriticalSectionMutex::new(Cell::new(None)),
            to_host: AtomicWaker::new(),
            from_host: AtomicWaker::new(),
        }
    }

    /// A packet of a transaction that is under way.
    pub(super) fn stage(&self, packet: Option<Packet>) {
        self.staged.lock(|place| place.set(packet));
    }

    /// The transaction is over: its packet can be fetched.
    pub(super) fn publish(&self) {
        if let Some(packet) = self.staged.lock(Cell::take) {
            self.received.lock(|place| place.set(Some(packet)));
            self.from_host.wake();
        }
    }

    /// Fetches the packet, if there is one.
    pub(super) fn take(&self) -> Option<Packet> {
        self.received.lock(Cell::take)
    }

    /// Nothing of what was is to be fetched any more.
    pub(super) fn clear(&self) {
        self.stage(None);
        let _ = self.take();
    }

    fn wake(&self) {
        self.to_host.wake();
        self.from_host.wake();
    }
}

/// All that is shared.
pub(super) struct State {
    endpoints: [Endpoint; ENDPOINTS],
    /// A SETUP packet while its stage is not over, and one that nobody has answered yet.
    staged_setup: CriticalSectionMutex<Cell<Option<[u8; 8]>>>,
    setup: CriticalSectionMutex<Cell<Option<[u8; 8]>>>,
    /// The host has reset the bus, and nobody has taken note yet.
    has_reset: AtomicBool,
    pub(super) bus: AtomicWaker,
}

pub(super) static STATE: State = State {
    endpoints: [const { Endpoint::new() }; ENDPOINTS],
    staged_setup: CriticalSectionMutex::new(Cell::new(None)),
    setup: CriticalSectionMutex::new(Cell::new(None)),
    has_reset: AtomicBool::new(false),
    bus: AtomicWaker::new(),
};

impl State {
    /// `None` for a number that the chip has not.
    pub(super) fn endpoint(&self, index: usize) -> Option<&Endpoint> {
        self.endpoints.get(index)
    }

    /// The control pipe's.
    pub(super) fn control(&self) -> &Endpoint {
        let [control, ..] = &self.endpoints;
        control
    }

    /// All, with their numbers.
    pub(super) fn endpoints(&self) -> impl Iterator<Item = (usize, &Endpoint)> {
        self.endpoints.iter().enumerate()
    }

    /// A SETUP packet; `None` for what came as one and is none.
    pub(super) fn stage_setup(&self, setup: Option<[u8; 8]>) {
        self.staged_setup.lock(|place| place.set(setup));
    }

    /// The setup stage is over.
    pub(super) fn publish_setup(&self) {
        if let Some(setup) = self.staged_setup.lock(Cell::take) {
            self.setup.lock(|place| place.set(Some(setup)));
            self.control().wake();
        }
    }

    /// Fetches the SETUP packet that is to be answered.
    pub(super) fn take_setup(&self) -> Option<[u8; 8]> {
        self.setup.lock(Cell::take)
    }

    /// Whether the control transfer under way has ended without the device: the host has begun
    /// another one, or reset the bus.
    pub(super) fn is_overtaken(&self) -> bool {
        self.has_reset() || self.setup.lock(|place| place.get().is_some())
    }

    /// The host has reset the bus: nothing of before counts any more.
    pub(super) fn reset(&self) {
        self.stage_setup(None);
        let _ = self.take_setup();
        for (_, endpoint) in self.endpoints() {
            endpoint.clear();
            endpoint.wake();
        }
        self.has_reset.store(true, Ordering::Release);
        self.bus.wake();
    }

    /// Whether a reset waits to be taken note of.
    pub(super) fn has_reset(&self) -> bool {
        self.has_reset.load(Ordering::Acquire)
    }

    /// Whether the bus was reset since somebody last asked.
    pub(super) fn take_reset(&self) -> bool {
        self.has_reset.swap(false, Ordering::AcqRel)
    }
}
