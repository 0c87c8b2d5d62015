//! The inertial sensor's bus. A transaction takes no board time.

use embedded_hal_async::spi::{ErrorKind, ErrorType, Operation, SpiDevice};

use super::Robot;
use crate::exchange::Kind;

/// The inertial sensor, alone on its bus.
pub struct InertialPort(pub(super) &'static Robot);

impl ErrorType for InertialPort {
    type Error = ErrorKind;
}

impl SpiDevice for InertialPort {
    /// The one shape that a register device needs.
    async fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        let [Operation::TransferInPlace(words)] = operations else { return Err(ErrorKind::Other) };
        let mut sent = [0; LONGEST];
        let sent = sent.get_mut(..words.len()).ok_or(ErrorKind::Other)?;
        sent.copy_from_slice(words);
        self.0.exchange(Kind::Inertial, &[sent], |answer| {
            if answer.len() != words.len() {
                return Err(ErrorKind::Other);
            }
            words.copy_from_slice(answer);
            Ok(())
        })
    }
}

/// Bytes of a transaction: a reading with its address has 15.
const LONGEST: usize = 16;
