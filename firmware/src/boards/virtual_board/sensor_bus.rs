//! The power sensors' bus. A transaction takes no board time.

use embedded_hal_async::i2c::{ErrorKind, ErrorType, I2c, NoAcknowledgeSource, Operation};

use super::Robot;
use crate::exchange::{BusAnswer, Kind};
use crate::power_sensors::Convert;

/// The sensors' bus.
pub struct SensorBus(pub(super) &'static Robot);

impl ErrorType for SensorBus {
    type Error = ErrorKind;
}

impl Convert for SensorBus {}

impl I2c for SensorBus {
    /// Any number of writes, each followed by a read: the shape that a register device knows.
    async fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), ErrorKind> {
        for pair in operations.as_chunks_mut().0 {
            let [Operation::Write(sent), Operation::Read(received)] = pair else {
                return Err(ErrorKind::Other);
            };
            self.exchange(address, sent, received)?;
        }
        Ok(())
    }
}

impl SensorBus {
    fn exchange(&mut self, address: u8, sent: &[u8], received: &mut [u8]) -> Result<(), ErrorKind> {
        let count = u8::try_from(received.len()).map_err(|_| ErrorKind::Other)?;
        self.0.exchange(Kind::I2c, &[&[address, count], sent], |answer| {
            let (code, bytes) = answer.split_first().ok_or(ErrorKind::Other)?;
            match BusAnswer::from_code(*code) {
                Some(BusAnswer::Done) if bytes.len() == received.len() => {
                    received.copy_from_slice(bytes);
                    Ok(())
                }
                Some(BusAnswer::NoAcknowledge) => Err(ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address)),
                Some(BusAnswer::Stuck) => Err(ErrorKind::Bus),
                Some(BusAnswer::Done) | None => Err(ErrorKind::Other),
            }
        })
    }
}
