//! What a poll asks of a chip, and of a bus with several: all of them in one go, where the bus can
//! do that by itself.

use embedded_hal_async::i2c::{I2c, Operation};

/// Registers (8.6.1).
pub(super) const CONFIGURATION: u8 = 0;
const SHUNT: u8 = 1;
const BUS: u8 = 2;
const POWER: u8 = 3;

/// One transaction: the bus voltage with its flags, which the next conversion clears; that
/// conversion, started by writing the set-up (8.6.2.1, mode 3); the set-up read back; shunt voltage
/// and power, which stay until it ends, 2 ms later at the soonest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Conversion {
    /// Of the chip, 7 bits.
    pub address: u8,
    /// What is written to its configuration.
    pub set_up: u16,
    /// Bus voltage, configuration, shunt voltage and power; `None` while there is no answer.
    pub answer: Option<[u16; 4]>,
}

impl Conversion {
    /// Bytes of the four writes. Behind each a register of two bytes is read.
    pub const WRITES: [usize; 4] = [1, 3, 1, 1];

    /// The four writes, one behind the other.
    #[must_use]
    pub const fn written(&self) -> [u8; 6] {
        let [high, low] = self.set_up.to_be_bytes();
        [BUS, CONFIGURATION, high, low, SHUNT, POWER]
    }

    /// Asks by one transaction.
    ///
    /// # Errors
    /// The bus's.
    pub async fn ask<I: I2c + ?Sized>(&mut self, i2c: &mut I) -> Result<(), I::Error> {
        let [bus_at, configuration @ .., shunt_at, power_at] = self.written();
        let (mut bus, mut set_up, mut shunt, mut power) = ([0; 2], [0; 2], [0; 2], [0; 2]);
        let mut operations = [
            Operation::Write(&[bus_at]),
            Operation::Read(&mut bus),
            Operation::Write(&configuration),
            Operation::Read(&mut set_up),
            Operation::Write(&[shunt_at]),
            Operation::Read(&mut shunt),
            Operation::Write(&[power_at]),
            Operation::Read(&mut power),
        ];
        i2c.transaction(self.address, &mut operations).await?;
        self.answer = Some([bus, set_up, shunt, power].map(u16::from_be_bytes));
        Ok(())
    }
}

/// A bus with several chips.
pub trait Convert: I2c {
    /// Asks the chips one after the other. One that fails has no answer, and costs the others no
    /// more than time.
    fn convert_each(&mut self, conversions: &mut [Option<Conversion>]) -> impl Future<Output = ()> {
        async move {
            for conversion in conversions.iter_mut().flatten() {
                // It shows by its missing answer.
                let _ = conversion.ask(self).await;
            }
        }
    }
}
