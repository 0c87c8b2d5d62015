//! All that the link shows: the board's tasks fill it in, [`super::render`] makes registers of it.

use super::{Fifo, Place, Settings, Upload};
use crate::control_table::{Item, Reason};
use crate::drive::{Heading, Pilot};
use crate::inertial::InertialSnapshot;
use crate::items::ItemBytes;
use crate::measurement::Snapshot;
use crate::reset::ResetReport;
use crate::totals::{Ledger, Totals};
use crate::wheels::DriveState;

/// The board as the link shows it.
#[derive(Debug, PartialEq)]
pub struct State<'a> {
    /// Now: time since start, µs.
    pub time_us: u64,
    /// Length of the estimator's window, s.
    pub window_s: u16,
    /// What was known after the last sample; wheels that are silent stay where they were.
    pub snapshot: Snapshot,
    /// What happened since start, beyond the snapshot's own counts.
    pub counters: Counters,
    /// The samples.
    pub fifo: Fifo<'a>,
    /// What the host wants driven.
    pub pilot: Pilot,
    /// From the wheels, since start.
    pub heading: Heading,
    /// What the inertial sensor says.
    pub inertial: InertialSnapshot,
    /// LEDs and buttons.
    pub panel: Panel,
    /// The board's supply by its own converter, V, where it has one.
    pub supply_voltage: Option<f32>,
    /// Why the board started.
    pub reset: ResetReport,
    /// What the robot has used and driven in its life.
    pub ledger: Ledger,
    /// Whether coefficients need a signature: for the host. Who keeps the store looks at it.
    pub needs_signature: bool,
    /// The store's spare sector is erased.
    pub is_store_prepared: bool,
    pub(super) settings: Settings,
    pub(super) upload: Upload,
}

/// What a hand or an eye can reach of the board.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Panel {
    /// User LEDs 1 to 4, as the host wants them: 0 off.
    pub leds: [u8; 4],
    /// SW1, SW2: 1 while pressed.
    pub buttons: [u8; 2],
    /// Kept for the host.
    pub(super) sound: u8,
    pub(super) calibrate_imu: u8,
    /// Nobody has begun with it.
    wants_calibration: bool,
}

impl Panel {
    const DARK: Self =
        Self { leds: [0; 4], buttons: [0; 2], sound: 0, calibrate_imu: 0, wants_calibration: false };

    /// The host wants the gyroscope calibrated, or nothing.
    pub(super) fn calibrate(&mut self, value: u8) {
        self.calibrate_imu = value;
        self.wants_calibration |= value != 0;
    }
}

/// What happened since start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counters {
    /// Samples that began late.
    pub missed_deadlines: u32,
    /// I2C transactions that failed.
    pub bus_errors: u32,
    /// Times the I2C bus was set up again.
    pub bus_recoveries: u32,
    /// Packets for this board.
    pub link_packets: u32,
    /// Broken packets on the link.
    pub link_broken: u32,
    /// Answers that no host has fetched.
    pub link_abandoned: u32,
    /// Items written to flash.
    pub store_writes: u32,
    /// Sectors of the flash erased.
    pub store_erases: u32,
}

impl Counters {
    const NONE: Self = Self {
        missed_deadlines: 0,
        bus_errors: 0,
        bus_recoveries: 0,
        link_packets: 0,
        link_broken: 0,
        link_abandoned: 0,
        store_writes: 0,
        store_erases: 0,
    };
}

impl<'a> State<'a> {
    /// Nothing measured, nothing stored. Samples go to `records`.
    #[must_use]
    pub const fn new(sample_rate_hz: u16, window_s: u16, records: &'a mut [Place]) -> Self {
        Self {
            time_us: 0,
            window_s,
            snapshot: Snapshot::UNKNOWN,
            counters: Counters::NONE,
            fifo: Fifo::new(records),
            pilot: Pilot::new(),
            heading: Heading::START,
            inertial: InertialSnapshot::UNKNOWN,
            panel: Panel::DARK,
            supply_voltage: None,
            reset: ResetReport::NONE,
            ledger: Ledger::new(),
            needs_signature: false,
            is_store_prepared: false,
            settings: Settings::new(sample_rate_hz),
            upload: Upload::new(),
        }
    }

    /// The same without its samples, whose memory is lent once: for tests that go on from it in
    /// several ways.
    #[must_use]
    pub fn without_samples(&self) -> State<'static> {
        State {
            time_us: self.time_us,
            window_s: self.window_s,
            snapshot: self.snapshot,
            counters: self.counters,
            fifo: Fifo::new(&mut []),
            pilot: self.pilot,
            heading: self.heading,
            inertial: self.inertial,
            panel: self.panel,
            supply_voltage: self.supply_voltage,
            reset: self.reset,
            ledger: self.ledger,
            needs_signature: self.needs_signature,
            is_store_prepared: self.is_store_prepared,
            settings: self.settings.clone(),
            upload: self.upload.clone(),
        }
    }

    /// Coefficients, calibration and robot in use.
    #[must_use]
    pub const fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Takes over what is known after a sample. A servo that is silent is where it was.
    pub fn show(&mut self, snapshot: &Snapshot) {
        let before = self.snapshot.wheels.each_ref().map(|wheel| wheel.position);
        self.snapshot = *snapshot;
        for (wheel, before) in self.snapshot.wheels.iter_mut().zip(before) {
            wheel.position = wheel.position.or(before);
        }
        let [left, right] = self.snapshot.wheels.each_ref().map(|wheel| wheel.odometer);
        let positions = left.zip(right).map(|(left, right)| [left, right]);
        if let Some(positions) = positions {
            self.heading.update(positions);
        }
        let is_driving = self.snapshot.drive.has_torque && !self.snapshot.is_standing;
        self.ledger.trip().update(positions, is_driving, self.snapshot.time_us);
    }

    /// Whether the host wants the gyroscope calibrated, for the one that does it.
    pub fn take_calibration(&mut self) -> bool {
        core::mem::take(&mut self.panel.wants_calibration)
    }

    /// What the register shows: with a sensor, whether it is being calibrated; without, what was
    /// written.
    pub(super) const fn calibration(&self) -> u8 {
        match self.inertial.model {
            Some(_) => (self.panel.wants_calibration || self.inertial.is_calibrating) as u8,
            None => self.panel.calibrate_imu,
        }
    }

    /// The battery's voltage: by the board's converter, or by the rail's sensor.
    #[must_use]
    pub fn battery_voltage(&self) -> Option<f32> {
        let [battery, ..] = self.snapshot.rails;
        self.supply_voltage.or(battery.voltage)
    }

    /// How far an upload is.
    #[must_use]
    pub const fn upload(&self) -> &Upload {
        &self.upload
    }

    /// What the flash held of an item at start, or why that is not known. Every item at once:
    /// [`crate::items::ITEMS`].
    pub fn load(&mut self, item: Item, stored: Result<ItemBytes, Reason>) {
        self.settings.load(item, stored);
    }

    /// The coefficients before those stored, as the flash held them at start.
    pub fn load_previous(&mut self, stored: ItemBytes) {
        self.settings.load_previous(stored);
    }

    /// Whether a sector of the flash may be erased: that takes long, so no servo may hold a torque
    /// or get one meanwhile.
    #[must_use]
    pub const fn may_erase(&self) -> bool {
        let drive = &self.snapshot.drive;
        let stays_off = matches!(drive.state, DriveState::Off | DriveState::CutOff | DriveState::Unfit);
        let [left, right] = drive.are_off;
        self.snapshot.is_standing && stays_off && left && right
    }

    /// An upload to be written now: there is one, it is checked, and the robot stands still.
    /// [`Self::stored`] has to follow.
    pub fn take_pending(&mut self) -> Option<(Item, ItemBytes)> {
        let is_free = !self.upload.needs_erase() || self.may_erase();
        if self.snapshot.is_standing && is_free { self.upload.take() } else { None }
    }

    /// How writing what [`Self::take_pending`] gave went: read back and equal, or not. On success
    /// it is what is in use. What needs a sector to be erased first waits for that.
    pub fn stored(&mut self, item: Item, result: Result<(), Reason>) {
        if result == Err(Reason::Erase) {
            self.upload.postpone();
            return;
        }
        if let (Ok(()), Some(bytes)) = (result, self.upload.being_written(item)) {
            self.settings.replace(item, bytes);
            self.counters.store_writes = self.counters.store_writes.saturating_add(1);
        }
        self.upload.end(result);
    }

    /// What the robot has used and driven in its life.
    #[must_use]
    pub fn totals(&self) -> Totals {
        self.ledger.totals(self.snapshot.rails.map(|rail| rail.energy), self.snapshot.time_us)
    }

    /// The totals, where they are to be written now. [`Ledger::written`] has to follow.
    #[must_use]
    pub fn due_totals(&self) -> Option<Totals> {
        let is_due = self.ledger.is_due(self.snapshot.is_standing, self.snapshot.time_us);
        is_due.then(|| self.totals())
    }
}
