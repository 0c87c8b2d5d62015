//! The servos' bus. Sending takes no board time; the answer comes when the robot says.

use core::convert::Infallible;
use core::future::pending;

use embassy_time::{Duration, Instant, Timer};
use embedded_io_async::{ErrorType, Read, Write};

use super::Robot;
use super::queue::Queue;
use crate::exchange::Kind;
use crate::wheels::SwitchedPort;

/// Both servos' answers to the longest request, and more.
const BYTES: usize = 512;

/// Sends and receives on the servos' bus, as the board's own does: what is written goes out with
/// [`Write::flush`].
pub struct ServoPort {
    robot: &'static Robot,
    sent: Queue<BYTES>,
    received: Queue<BYTES>,
    /// When the first byte of `received` arrives.
    arrival: Instant,
}

impl ServoPort {
    pub(super) fn new(robot: &'static Robot) -> Self {
        Self { robot, sent: Queue::new(), received: Queue::new(), arrival: Instant::MIN }
    }
}

impl SwitchedPort for ServoPort {
    fn set_supply(&mut self, on: bool) {
        self.robot.exchange(Kind::ServoSupply, &[&[u8::from(on)]], |_| ());
    }
}

impl ErrorType for ServoPort {
    type Error = Infallible;
}

impl Read for ServoPort {
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
        if self.received.is_empty() {
            // As on a silent wire: whoever reads has a time limit.
            pending::<()>().await;
        }
        Timer::at(self.arrival).await;
        Ok(self.received.take(buffer))
    }
}

impl Write for ServoPort {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        let count = self.sent.put(bytes);
        if count == 0 {
            self.flush().await?;
            return Ok(self.sent.put(bytes));
        }
        Ok(count)
    }

    async fn flush(&mut self) -> Result<(), Infallible> {
        if self.sent.is_empty() {
            return Ok(());
        }
        let Self { robot, sent, received, arrival } = self;
        robot.exchange(Kind::Servo, &[sent.as_slice()], |answer| {
            if let Some((delay, bytes)) = answer.split_first_chunk() {
                if received.is_empty() {
                    *arrival = Instant::now() + Duration::from_micros(u32::from_le_bytes(*delay).into());
                }
                received.put(bytes);
            }
        });
        sent.clear();
        Ok(())
    }
}
