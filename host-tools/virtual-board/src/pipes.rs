//! The two FIFOs between the virtual board and its robot: whole frames in, whole frames out.

use std::fs::File;
use std::io::{ErrorKind, Read, Write};
use std::os::fd::AsFd;
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::Path;
use std::time::{Duration, Instant};

use firmware::exchange::LONGEST_FRAME;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{FileType, Mode, OFlags};
use support::error::{Error, Result};

/// Requests: the board writes.
pub const REQUESTS: &str = "board-to-robot";
/// Answers: the board reads.
pub const ANSWERS: &str = "robot-to-board";

/// Bytes of a frame's length.
const LENGTH: usize = 2;

/// What came of waiting for a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Waited {
    /// There is one.
    Request,
    /// Not yet.
    Nothing,
    /// The board has closed its end, and will not ask again.
    Closed,
}

/// The robot's ends.
///
/// Opening never waits, whichever side comes first: the requests are opened without blocking, and
/// of the answers this side keeps the reading end too, so that there always is one. When this
/// process ends, however it does, the board reads the end of the answers, and ends.
#[derive(Debug)]
pub struct VirtualPipes {
    requests: File,
    answers: File,
    buffer: Vec<u8>,
    filled: usize,
    /// Bytes at the front of the buffer that are the last request.
    handed_out: usize,
}

impl VirtualPipes {
    /// Makes both FIFOs in a folder and opens them.
    ///
    /// # Errors
    /// The folder does not take FIFOs.
    pub fn create(folder: &Path) -> Result<Self> {
        let mode = Mode::RUSR | Mode::WUSR;
        for name in [REQUESTS, ANSWERS] {
            let path = folder.join(name);
            rustix::fs::mknodat(rustix::fs::CWD, &path, FileType::Fifo, mode, 0)
                .map_err(|error| Error::io(&path, &error.into()))?;
        }
        let open = |name: &str, write: bool| {
            let path = folder.join(name);
            let flags = OFlags::NONBLOCK.bits().cast_signed();
            File::options()
                .read(true)
                .write(write)
                .custom_flags(flags)
                .open(&path)
                .map_err(|error| Error::io(&path, &error))
        };
        let (requests, answers) = (open(REQUESTS, false)?, open(ANSWERS, true)?);
        Ok(Self { requests, answers, buffer: vec![0; LENGTH + LONGEST_FRAME], filled: 0, handed_out: 0 })
    }

    /// Waits for a request, at most `limit`. [`Self::request`] shows it.
    ///
    /// # Errors
    /// The operating system refuses, or what came is no frame.
    pub fn wait(&mut self, limit: Duration) -> Result<Waited> {
        self.buffer.copy_within(self.handed_out..self.filled, 0);
        self.filled -= self.handed_out;
        self.handed_out = 0;
        let failed =
            |error: std::io::Error| Error::failed(format!("the pipe from the virtual board: {error}"));
        let begun = Instant::now();
        loop {
            if let Some(length) = self.buffer[..self.filled].first_chunk() {
                let end = LENGTH + usize::from(u16::from_le_bytes(*length));
                if end > self.buffer.len() {
                    return Err(Error::failed("the virtual board sent what is no frame"));
                }
                if self.filled >= end {
                    self.handed_out = end;
                    return Ok(Waited::Request);
                }
            }
            // Waiting first would cost one more call whenever the request is there already.
            match self.requests.read(&mut self.buffer[self.filled..]) {
                Ok(0) => {}
                Ok(count) => {
                    self.filled += count;
                    continue;
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => continue,
                Err(error) if error.kind() == ErrorKind::WouldBlock => {}
                Err(error) => return Err(failed(error)),
            }
            let Some(remaining) = limit.checked_sub(begun.elapsed()) else { return Ok(Waited::Nothing) };
            match self.poll(remaining).map_err(failed)? {
                flags if flags.contains(PollFlags::IN) => {}
                // Nobody writes any more. Before the board has opened its end this is not reported.
                flags if flags.contains(PollFlags::HUP) => return Ok(Waited::Closed),
                _ => return Ok(Waited::Nothing),
            }
        }
    }

    fn poll(&self, limit: Duration) -> std::io::Result<PollFlags> {
        let mut entry = [PollFd::from_borrowed_fd(self.requests.as_fd(), PollFlags::IN)];
        match poll(&mut entry, Timespec::try_from(limit).ok().as_ref()) {
            Ok(_) => Ok(entry[0].revents()),
            // A signal: handle it first.
            Err(rustix::io::Errno::INTR) => Ok(PollFlags::empty()),
            Err(error) => Err(error.into()),
        }
    }

    /// The request that was waited for, without its length.
    pub fn request(&self) -> &[u8] {
        self.buffer.get(LENGTH..self.handed_out).unwrap_or(&[])
    }

    /// Sends a frame, in one piece: the board reads it in one, too. It always fits, since the board
    /// has read the one before.
    ///
    /// # Errors
    /// The operating system refuses.
    pub fn answer(&mut self, frame: &[u8]) -> Result<()> {
        self.answers
            .write_all(frame)
            .map_err(|error| Error::failed(format!("the pipe to the virtual board: {error}")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_come_whole_however_they_are_cut() {
        let folder = tempfile::tempdir().unwrap();
        let mut pipes = VirtualPipes::create(folder.path()).unwrap();
        assert_eq!(pipes.wait(Duration::ZERO).unwrap(), Waited::Nothing, "nobody is there yet");
        let mut board = File::options().write(true).open(folder.path().join(REQUESTS)).unwrap();
        board.write_all(&[3, 0, 7]).unwrap();
        assert_eq!(pipes.wait(Duration::from_millis(1)).unwrap(), Waited::Nothing);
        board.write_all(&[8, 9, 1, 0]).unwrap();
        assert_eq!(pipes.wait(Duration::from_millis(1)).unwrap(), Waited::Request);
        assert_eq!(pipes.request(), [7, 8, 9]);
        assert_eq!(pipes.wait(Duration::from_millis(1)).unwrap(), Waited::Nothing);
        board.write_all(&[42]).unwrap();
        assert_eq!(pipes.wait(Duration::from_millis(1)).unwrap(), Waited::Request);
        assert_eq!(pipes.request(), [42]);
        drop(board);
        assert_eq!(pipes.wait(Duration::from_secs(5)).unwrap(), Waited::Closed);
    }
}
