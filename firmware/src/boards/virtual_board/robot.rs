//! The board's end of the exchange with the virtual robot ([`crate::exchange`]): two files of the
//! emulator's host.

use core::cell::RefCell;

use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::Instant;
use semihosting::fs::File;
use semihosting::io::{Read, Write};
use semihosting::process::ExitCode;

use crate::exchange::{ANSWERS, Kind, LONGEST_FRAME, NOTICE_LINK, NOTICE_NODE, REQUESTS};

/// Bytes of a frame's length.
const LENGTH: usize = 2;

/// The robot. Every driver of this board has a reference to it.
pub struct Robot {
    pipes: RefCell<Pipes>,
    /// Bytes from the host wait.
    pub(super) host_has_sent: Signal<NoopRawMutex, ()>,
    /// Bytes from the node wait.
    pub(super) node_has_sent: Signal<NoopRawMutex, ()>,
}

struct Pipes {
    requests: File,
    answers: File,
    frame: [u8; LENGTH + LONGEST_FRAME],
}

impl Robot {
    /// Waits until the other end has opened its files too. `None` where there are none.
    pub(super) fn open() -> Option<Self> {
        let requests = File::create(REQUESTS).ok()?;
        let answers = File::open(ANSWERS).ok()?;
        let pipes = RefCell::new(Pipes { requests, answers, frame: [0; LENGTH + LONGEST_FRAME] });
        Some(Self { pipes, host_has_sent: Signal::new(), node_has_sent: Signal::new() })
    }

    /// Sends a request, waits for the answer and hands its body to `use_answer`. Board time stands
    /// still meanwhile.
    ///
    /// Ends the emulator when the robot has gone, or says that this is the end.
    pub(super) fn exchange<T>(&self, kind: Kind, body: &[&[u8]], use_answer: impl FnOnce(&[u8]) -> T) -> T {
        let mut pipes = self.pipes.borrow_mut();
        let time = Instant::now().as_micros().to_le_bytes();
        if pipes.send(kind, time, body).is_none() {
            ExitCode::FAILURE.exit_process()
        }
        match pipes.receive() {
            Some([notices, answer @ ..]) => {
                if notices & NOTICE_LINK != 0 {
                    self.host_has_sent.signal(());
                }
                if notices & NOTICE_NODE != 0 {
                    self.node_has_sent.signal(());
                }
                use_answer(answer)
            }
            Some([]) => ExitCode::SUCCESS.exit_process(),
            None => ExitCode::FAILURE.exit_process(),
        }
    }
}

impl Pipes {
    /// In one piece: each call costs the emulator as much as the robot's answer takes.
    fn send(&mut self, kind: Kind, time: [u8; 8], body: &[&[u8]]) -> Option<()> {
        let head: [&[u8]; 2] = [&[kind as u8], &time];
        let mut end = LENGTH;
        for bytes in head.iter().chain(body) {
            let place = self.frame.get_mut(end..end + bytes.len())?;
            place.copy_from_slice(bytes);
            end += bytes.len();
        }
        let length = u16::try_from(end - LENGTH).ok()?;
        *self.frame.first_chunk_mut()? = length.to_le_bytes();
        self.requests.write_all(self.frame.get(..end)?).ok()
    }

    /// The answer without its length; `None` when the robot has gone.
    fn receive(&mut self) -> Option<&[u8]> {
        let mut filled = 0;
        // Nearly always one call: the robot writes a frame in one piece.
        loop {
            if let Some(length) = self.frame.get(..filled)?.first_chunk() {
                let end = LENGTH + usize::from(u16::from_le_bytes(*length));
                if filled >= end {
                    return self.frame.get(LENGTH..end);
                }
            }
            match self.answers.read(self.frame.get_mut(filled..)?) {
                Ok(0) | Err(_) => return None,
                Ok(count) => filled += count,
            }
        }
    }
}
