//! Four INA219 on a bus, as far as the driver sees them.

use core::cell::{Cell, RefCell};

use embedded_hal::i2c::{ErrorKind, ErrorType, NoAcknowledgeSource, Operation};
use embedded_hal_async::i2c::I2c;

use super::{Convert, RAIL_COUNT};
use crate::parameters::RAILS;

/// After a power-on reset (8.6.2.1).
const RESET: u16 = 0x399F;

#[derive(Debug, Clone, Copy)]
pub(crate) struct Chip {
    pub(crate) is_present: bool,
    pub(crate) has_converted: bool,
    pub(crate) shunt_10uv: i16,
    pub(crate) bus_mv: u16,
    configuration: u16,
    calibration: u16,
}

/// Each handle is a reference to it.
pub(crate) struct Chips {
    pub(crate) chips: RefCell<[Chip; RAIL_COUNT]>,
    transactions: Cell<u32>,
}

impl Chips {
    /// All present, with 10 mV at 12 V.
    pub(crate) fn new() -> Self {
        let chip = Chip {
            is_present: true,
            has_converted: true,
            shunt_10uv: 1000,
            bus_mv: 12_000,
            configuration: RESET,
            calibration: 0,
        };
        Self { chips: RefCell::new([chip; RAIL_COUNT]), transactions: Cell::new(0) }
    }

    pub(crate) fn transactions(&self) -> u32 {
        self.transactions.get()
    }
}

impl ErrorType for &Chips {
    type Error = ErrorKind;
}

impl Convert for &Chips {}

impl I2c for &Chips {
    async fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), ErrorKind> {
        self.transactions.set(self.transactions.get() + 1);
        let mut chips = self.chips.borrow_mut();
        let place = RAILS.iter().position(|rail| rail.address.as_byte() == address).unwrap();
        let chip = &mut chips[place];
        if !chip.is_present {
            (chip.configuration, chip.calibration) = (RESET, 0);
            return Err(ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address));
        }
        for pair in operations.as_chunks_mut().0 {
            let [Operation::Write([register, written @ ..]), Operation::Read(place)] = pair else {
                panic!("{pair:?}")
            };
            if let [high, low] = written {
                let value = u16::from_be_bytes([*high, *low]);
                match register {
                    0x00 => chip.configuration = value,
                    0x05 => chip.calibration = value,
                    register => panic!("register {register:#x}"),
                }
            }
            let value = match register {
                0x00 => chip.configuration,
                0x01 => chip.shunt_10uv as u16,
                0x02 => (chip.bus_mv / 4) << 3 | u16::from(chip.has_converted) << 1,
                // 8.5.2
                0x03 => {
                    let current =
                        u32::from(chip.shunt_10uv.unsigned_abs()) * u32::from(chip.calibration) / 4096;
                    (current * u32::from(chip.bus_mv / 4) / 5000) as u16
                }
                0x05 => chip.calibration,
                register => panic!("register {register:#x}"),
            };
            place.copy_from_slice(&value.to_be_bytes());
        }
        Ok(())
    }
}
