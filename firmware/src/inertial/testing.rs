//! A chip on a bus, as far as the driver sees it. Registers and their starts: the register maps
//! named in the driver.

use core::cell::{Cell, RefCell};

use embedded_hal::spi::{ErrorKind, ErrorType, Operation};
use embedded_hal_async::delay::DelayNs;
use embedded_hal_async::spi::SpiDevice;

use super::ChipModel;

/// Time passes by itself.
pub(super) struct Nothing;

impl DelayNs for Nothing {
    async fn delay_ns(&mut self, _: u32) {}
}

/// Four banks, of which the MPU-9250 has one.
pub(super) struct Bus {
    model: ChipModel,
    registers: RefCell<[[u8; 128]; 4]>,
    bank: Cell<usize>,
    /// What a broken bus gives instead: a byte, or an error.
    broken: Cell<Option<Option<u8>>>,
}

impl Bus {
    pub(super) fn new(model: ChipModel) -> Self {
        let bus = Self {
            model,
            registers: RefCell::new([[0; 128]; 4]),
            bank: Cell::new(0),
            broken: Cell::new(None),
        };
        bus.power_up();
        bus
    }

    pub(super) fn power_up(&self) {
        let mut registers = self.registers.borrow_mut();
        *registers = [[0; 128]; 4];
        match self.model {
            ChipModel::Mpu9250 => (registers[0][0x75], registers[0][0x6B]) = (0x71, 0x01),
            ChipModel::Icm20648 => {
                (registers[0][0x00], registers[0][0x06]) = (0xE0, 0x41);
                (registers[2][0x01], registers[2][0x14]) = (0x01, 0x01);
            }
        }
        self.bank.set(0);
    }

    /// Counts of rotation and acceleration.
    pub(super) fn feel(&self, rotation: [i16; 3], acceleration: [i16; 3]) {
        let (a, g) = match self.model {
            ChipModel::Mpu9250 => (0x3B, 0x43),
            ChipModel::Icm20648 => (0x2D, 0x33),
        };
        for (from, counts) in [(a, acceleration), (g, rotation)] {
            for (index, count) in counts.into_iter().enumerate() {
                let place = from + 2 * index;
                self.registers.borrow_mut()[0][place..place + 2].copy_from_slice(&count.to_be_bytes());
            }
        }
    }

    /// From now on the bus gives this byte, or an error.
    pub(super) fn break_off(&self, answers: Option<u8>) {
        self.broken.set(Some(answers));
    }
}

impl ErrorType for &Bus {
    type Error = ErrorKind;
}

impl SpiDevice for &Bus {
    async fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        let [Operation::TransferInPlace(bytes)] = operations else { panic!("{operations:?}") };
        match self.broken.get() {
            Some(None) => return Err(ErrorKind::Other),
            Some(Some(byte)) => {
                bytes.fill(byte);
                return Ok(());
            }
            None => {}
        }
        let (first, rest) = bytes.split_first_mut().unwrap();
        let bank = if self.model == ChipModel::Icm20648 { self.bank.get() } else { 0 };
        let register = usize::from(*first & 0x7F);
        if *first & 0x80 != 0 {
            for (offset, byte) in rest.iter_mut().enumerate() {
                *byte = self.registers.borrow()[bank][(register + offset) & 0x7F];
            }
            return Ok(());
        }
        let [value] = rest else { panic!("one register at a time") };
        let power = if self.model == ChipModel::Icm20648 { 0x06 } else { 0x6B };
        if (bank, register) == (0, power) && *value & 0x80 != 0 {
            self.power_up();
        } else if self.model == ChipModel::Icm20648 && register == 0x7F {
            self.bank.set(usize::from(*value >> 4 & 3));
        } else {
            self.registers.borrow_mut()[bank][register] = *value;
        }
        Ok(())
    }
}
