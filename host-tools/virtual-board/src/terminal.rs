//! The virtual board's link as a pseudo terminal: what a serial port is to a program that expects
//! one.

use std::fs::File;
use std::io::{ErrorKind, Read, Write};
use std::os::fd::{AsFd as _, OwnedFd};
use std::os::unix::ffi::OsStringExt as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
use support::error::{Error, Result};

/// Time between two looks at terminals of which one has no client.
const HUNG_UP_LOOK: Duration = Duration::from_micros(500);

/// This side of a pseudo terminal.
#[derive(Debug)]
pub struct VirtualTerminal {
    master: File,
    path: PathBuf,
    /// Where its link is to be.
    place: Option<PathBuf>,
    link: Option<PathBuf>,
}

/// What came from the client.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Heard {
    /// So many bytes.
    Bytes(usize),
    /// Nothing now.
    Nothing,
    /// The client has closed the port.
    HungUp,
}

impl VirtualTerminal {
    /// A new pseudo terminal that passes every byte as it is; with a symbolic link to it, if a path
    /// is given.
    ///
    /// # Errors
    /// The system has no more, or the link's place is taken.
    pub fn open(link: Option<&Path>) -> Result<Self> {
        let mut terminal = Self::hidden(link)?;
        terminal.show()?;
        Ok(terminal)
    }

    /// As [`Self::open`]; [`Self::show`] makes the link, which programs take for a board that
    /// answers.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn hidden(link: Option<&Path>) -> Result<Self> {
        let failed = |error: rustix::io::Errno| Error::failed(format!("no pseudo terminal: {error}"));
        let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).map_err(failed)?;
        grantpt(&master).map_err(failed)?;
        unlockpt(&master).map_err(failed)?;
        let path = PathBuf::from(std::ffi::OsString::from_vec(
            ptsname(&master, Vec::new()).map_err(failed)?.into_bytes(),
        ));
        set_raw(&master).map_err(failed)?;
        rustix::io::ioctl_fionbio(&master, true).map_err(failed)?;
        if let Some(link) = link {
            // One that an earlier run left behind points nowhere; anything else is somebody's.
            if std::fs::symlink_metadata(link).is_ok_and(|file| file.is_symlink()) && !link.exists() {
                std::fs::remove_file(link).map_err(|error| Error::io(link, &error))?;
            }
            if std::fs::symlink_metadata(link).is_ok() {
                return Err(Error::io(link, &ErrorKind::AlreadyExists.into()));
            }
        }
        Ok(Self { master: File::from(master), path, place: link.map(Path::to_owned), link: None })
    }

    /// Makes the link, where there is to be one.
    ///
    /// # Errors
    /// Its place is taken, or its folder is missing.
    pub fn show(&mut self) -> Result<()> {
        if let Some(place) = self.place.take() {
            std::os::unix::fs::symlink(&self.path, &place).map_err(|error| Error::io(&place, &error))?;
            self.link = Some(place);
        }
        Ok(())
    }

    /// The client's side.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What the client has sent.
    ///
    /// # Errors
    /// The operating system refuses.
    pub fn receive(&mut self, buffer: &mut [u8]) -> Result<Heard> {
        match self.master.read(buffer) {
            Ok(0) => Ok(Heard::HungUp),
            Ok(count) => Ok(Heard::Bytes(count)),
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => {
                Ok(Heard::Nothing)
            }
            Err(error) if error.raw_os_error() == Some(rustix::io::Errno::IO.raw_os_error()) => {
                Ok(Heard::HungUp)
            }
            Err(error) => Err(Error::io(&self.path, &error)),
        }
    }

    /// Sends as much as the client's side takes now, and says how much.
    ///
    /// # Errors
    /// The operating system refuses.
    pub fn send(&mut self, bytes: &[u8]) -> Result<usize> {
        match self.master.write(bytes) {
            Ok(count) => Ok(count),
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => Ok(0),
            Err(error) => Err(Error::io(&self.path, &error)),
        }
    }

    /// Waits until the client sends something, at most `limit`.
    pub fn wait(&self, limit: Duration) {
        wait_for_any([self], limit);
    }
}

/// Waits until the client of one of the terminals sends something, at most `limit`.
pub fn wait_for_any<const N: usize>(terminals: [&VirtualTerminal; N], limit: Duration) {
    let begun = Instant::now();
    // Without a client, hanging up is reported again and again: such a terminal is polled only now
    // and then.
    let mut entries =
        terminals.map(|terminal| PollFd::from_borrowed_fd(terminal.master.as_fd(), PollFlags::IN));
    loop {
        let remaining = limit.saturating_sub(begun.elapsed());
        let polled = poll(&mut entries, Timespec::try_from(remaining).ok().as_ref());
        let has_bytes = entries.iter().any(|entry| entry.revents().contains(PollFlags::IN));
        if polled.is_err() || has_bytes || remaining.is_zero() || begun.elapsed() >= limit {
            return;
        }
        std::thread::sleep(HUNG_UP_LOOK.min(remaining));
    }
}

/// No echo, no line ends, no signals: set before any client is there.
fn set_raw(master: &OwnedFd) -> rustix::io::Result<()> {
    let mut settings = tcgetattr(master)?;
    settings.make_raw();
    tcsetattr(master, OptionalActions::Now, &settings)
}

impl Drop for VirtualTerminal {
    fn drop(&mut self) {
        if let Some(link) = &self.link
            && std::fs::read_link(link).is_ok_and(|target| target == self.path)
        {
            let _ = std::fs::remove_file(link);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_passes_as_it_is_and_a_client_may_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("board");
        let mut terminal = VirtualTerminal::open(Some(&link)).unwrap();
        let all: Vec<u8> = (0..=255).collect();
        let mut buffer = [0; 512];
        for _ in 0..2 {
            let mut client = File::options().read(true).write(true).open(&link).unwrap();
            client.write_all(&all).unwrap();
            terminal.wait(Duration::from_secs(5));
            assert_eq!(terminal.receive(&mut buffer).unwrap(), Heard::Bytes(256));
            assert_eq!(buffer[..256], all);
            assert_eq!(terminal.receive(&mut buffer).unwrap(), Heard::Nothing);
            assert_eq!(terminal.send(&all).unwrap(), 256);
            client.read_exact(&mut buffer[..256]).unwrap();
            assert_eq!(buffer[..256], all);
            drop(client);
            assert_eq!(terminal.receive(&mut buffer).unwrap(), Heard::HungUp);
        }
        drop(terminal);
        assert!(!link.is_symlink());
    }

    #[test]
    fn a_file_in_the_links_place_stays() {
        let folder = tempfile::tempdir().unwrap();
        let link = folder.path().join("board");
        std::fs::write(&link, "mine").unwrap();
        assert!(VirtualTerminal::open(Some(&link)).is_err());
        assert_eq!(std::fs::read_to_string(&link).unwrap(), "mine");
    }
}
