//! Streams of DMA, as the drivers of our own use them: bytes between a peripheral and memory that
//! is never given back.

use core::sync::atomic::{AtomicU8, Ordering, fence};

use embassy_stm32::pac::dma::regs::{Cr, Ixr};
use embassy_stm32::pac::dma::vals::{Dir, Pl};
use embassy_stm32::pac::dma::{Dma, St};
use embassy_stm32::pac::{DMA1, DMA2};

/// A stream ends within some cycles of the bus behind the item that it moves.
const MOST_LOOKS: u32 = 64;
/// Where a stream's flags stand in the register of its half, and which they are.
const SHIFTS: [u32; 4] = [0, 6, 16, 22];
const FLAGS: u32 = 0x3D;

/// The two controllers.
#[derive(Clone, Copy)]
pub(super) enum Controller {
    One,
    Two,
}

/// How a stream moves.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Manner {
    Once,
    /// Once, and an interrupt behind the last byte.
    Telling,
    /// Round and round.
    Circular,
}

/// A stream and the channel of what it serves (RM0385, tables 27 and 28).
#[derive(Clone, Copy)]
pub(super) struct Stream {
    pub(super) controller: Controller,
    pub(super) number: usize,
    pub(super) channel: u8,
}

impl Stream {
    /// Says which register of the peripheral is the other end.
    pub(super) fn connect(self, register: *mut ()) {
        self.halt();
        self.registers().par().write_value(register.addr() as u32);
    }

    /// Moves so many bytes, beginning with the first, from here on.
    pub(super) fn begin(self, bytes: &'static [AtomicU8], count: usize, direction: Dir, manner: Manner) {
        self.halt();
        self.clear();
        let stream = self.registers();
        stream.m0ar().write_value(bytes.as_ptr().addr() as u32);
        stream.ndtr().write(|register| register.set_ndt(count.min(bytes.len()) as u16));
        let mut set_up = Cr(0);
        set_up.set_chsel(self.channel);
        set_up.set_dir(direction);
        set_up.set_circ(manner == Manner::Circular);
        set_up.set_tcie(manner == Manner::Telling);
        set_up.set_minc(true);
        set_up.set_pl(Pl::HIGH);
        set_up.set_en(true);
        // The bytes are in memory before it begins.
        fence(Ordering::SeqCst);
        stream.cr().write_value(set_up);
    }

    /// How many bytes it has still to move; of a circular one, to the end of the round.
    pub(super) fn remaining(self) -> usize {
        usize::from(self.registers().ndtr().read().ndt())
    }

    /// Whether it moves what comes.
    pub(super) fn is_running(self) -> bool {
        self.registers().cr().read().en()
    }

    /// Forgets what it has told.
    pub(super) fn clear(self) {
        let shift = SHIFTS.get(self.number % SHIFTS.len()).copied().unwrap_or(0);
        self.dma().ifcr(self.number / SHIFTS.len()).write_value(Ixr(FLAGS << shift));
    }

    const fn dma(self) -> Dma {
        match self.controller {
            Controller::One => DMA1,
            Controller::Two => DMA2,
        }
    }

    const fn registers(self) -> St {
        self.dma().st(self.number)
    }

    /// Stops it; one that has moved all has stopped itself.
    fn halt(self) {
        let control = self.registers().cr();
        if !control.read().en() {
            return;
        }
        control.write_value(Cr(0));
        for _ in 0..MOST_LOOKS {
            if !control.read().en() {
                break;
            }
        }
    }
}
