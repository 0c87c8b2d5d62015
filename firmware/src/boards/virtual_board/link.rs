//! The link to the host. Bytes take no board time; that some wait, the answer to any other request
//! says.

use core::convert::Infallible;

use embedded_io_async::{ErrorType, Read, Write};

use super::Robot;
use super::queue::Queue;
use crate::exchange::Kind;
use crate::tasks::Connection;

/// Either way: the longest status, with stuffing, fits.
const BYTES: usize = 2048;

/// Bytes from and to the host; what is written goes out with [`Write::flush`]. There is always a
/// host.
pub struct Link {
    robot: &'static Robot,
    kind: Kind,
    queues: &'static mut Queues,
}

/// What is on its way. In statics: as values they would be copied over the stack, down to where the
/// tasks run.
pub(super) struct Queues {
    sent: Queue<BYTES>,
    received: Queue<BYTES>,
}

impl Queues {
    pub(super) const fn new() -> Self {
        Self { sent: Queue::new(), received: Queue::new() }
    }
}

impl Link {
    /// The port that requests of this kind carry.
    pub(super) fn new(robot: &'static Robot, kind: Kind, queues: &'static mut Queues) -> Self {
        Self { robot, kind, queues }
    }

    fn exchange(&mut self) {
        let Self { robot, kind, queues } = self;
        let Queues { sent, received } = &mut **queues;
        let room = (received.room() as u16).to_le_bytes();
        robot.exchange(*kind, &[&room, sent.as_slice()], |answer| received.put(answer));
        sent.clear();
    }
}

impl Connection for Link {
    async fn wait_connection(&mut self) {}
}

impl ErrorType for Link {
    type Error = Infallible;
}

impl Read for Link {
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
        while self.queues.received.is_empty() {
            match self.kind {
                Kind::NodeLink => self.robot.node_has_sent.wait().await,
                _ => self.robot.host_has_sent.wait().await,
            }
            self.exchange();
        }
        Ok(self.queues.received.take(buffer))
    }
}

impl Write for Link {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        if self.queues.sent.room() == 0 {
            self.exchange();
        }
        Ok(self.queues.sent.put(bytes))
    }

    async fn flush(&mut self) -> Result<(), Infallible> {
        if !self.queues.sent.is_empty() {
            self.exchange();
        }
        Ok(())
    }
}
