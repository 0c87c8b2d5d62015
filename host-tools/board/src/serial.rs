//! A serial port: the board's USB link, or a pseudo terminal.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serial2::{SerialPort, Settings};
use support::error::{Error, Result};

use super::transport::Transport;

/// The stock node's rate. USB ignores it, except 1200 Bd, which asks the stock firmware to enter
/// its bootloader.
const BAUD_RATE: u32 = 1_000_000;

/// A board takes a packet in milliseconds. One that takes nothing for so long hangs.
const SEND_TIMEOUT: Duration = Duration::from_secs(3);

/// USB identification of the OpenCR, stock firmware and ours alike.
const USB_ID: (&str, &str) = ("0483", "5740");

/// An open serial port.
pub struct Serial {
    port: SerialPort,
    path: PathBuf,
    opened: Instant,
}

impl Serial {
    /// Opens a port and keeps other users of it out.
    ///
    /// # Errors
    /// There is no such port (those that there are are named), it may not be opened, or another
    /// program has it.
    pub fn open(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let settings = |mut settings: Settings| {
            settings.set_raw();
            settings.set_baud_rate(BAUD_RATE)?;
            Ok(settings)
        };
        let mut port = SerialPort::open(path, settings).map_err(|error| explain(path, &error))?;
        lock(&port).map_err(|error| explain(path, &error))?;
        port.set_write_timeout(SEND_TIMEOUT).map_err(|error| Error::io(path, &error))?;
        Ok(Self { port, path: path.to_owned(), opened: Instant::now() })
    }

    fn lost(&self, error: &std::io::Error) -> Error {
        let what = match error.kind() {
            ErrorKind::TimedOut => {
                format!("the board takes nothing any more ({} s): does it hang?", SEND_TIMEOUT.as_secs())
            }
            _ => format!("the port is gone: was the cable pulled, or the board reset? ({error})"),
        };
        Error::failed(what).in_file(&self.path)
    }
}

impl Transport for Serial {
    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        let mut rest = bytes;
        while !rest.is_empty() {
            match self.port.write(rest) {
                Ok(0) => return Err(self.lost(&ErrorKind::WriteZero.into())),
                Ok(count) => rest = &rest[count..],
                Err(error) if matches!(error.kind(), ErrorKind::Interrupted | ErrorKind::WouldBlock) => {}
                Err(error) => return Err(self.lost(&error)),
            }
        }
        Ok(())
    }

    fn receive(&mut self, buffer: &mut [u8], limit: Duration) -> Result<usize> {
        // The operating system counts milliseconds; the rest of one is waited for, not spun
        // through.
        let limit = Duration::from_millis(limit.as_micros().div_ceil(1000).try_into().unwrap_or(u64::MAX));
        self.port.set_read_timeout(limit).map_err(|error| self.lost(&error))?;
        match self.port.read(buffer) {
            // Ready without a byte: the other end has hung up.
            Ok(0) if !buffer.is_empty() => Err(self.lost(&ErrorKind::UnexpectedEof.into())),
            Ok(count) => Ok(count),
            Err(error)
                if matches!(
                    error.kind(),
                    ErrorKind::TimedOut | ErrorKind::Interrupted | ErrorKind::WouldBlock
                ) =>
            {
                Ok(0)
            }
            Err(error) => Err(self.lost(&error)),
        }
    }

    fn now(&self) -> Duration {
        self.opened.elapsed()
    }
}

/// Two readers of one port would each get half of the answers.
#[cfg(unix)]
fn lock(port: &SerialPort) -> std::io::Result<()> {
    rustix::fs::flock(port, rustix::fs::FlockOperation::NonBlockingLockExclusive).map_err(|error| {
        if error == rustix::io::Errno::WOULDBLOCK { ErrorKind::ResourceBusy.into() } else { error.into() }
    })
}

/// Elsewhere the operating system keeps ports to one user.
#[cfg(not(unix))]
fn lock(_: &SerialPort) -> std::io::Result<()> {
    Ok(())
}

/// Why a port could not be opened, and what to do.
fn explain(path: &Path, error: &std::io::Error) -> Error {
    match error.kind() {
        ErrorKind::NotFound => {
            Error::failed(format!("there is no such port; {}", listed(&ports()))).in_file(path)
        }
        ErrorKind::PermissionDenied => Error::failed(
            "may not be opened; expected to be in its group, mostly dialout (`sudo usermod -aG dialout $USER`, then log \
             in again), or a udev rule for 0483:5740",
        )
        .in_file(path),
        ErrorKind::ResourceBusy => {
            Error::failed("is in use by another program (another gmr, a ROS node, a terminal)").in_file(path)
        }
        _ if error.to_string().contains("ioctl") || error.raw_os_error() == Some(NOT_A_TERMINAL) => {
            Error::failed("is no serial port").in_file(path)
        }
        _ => Error::io(path, error),
    }
}

/// ENOTTY of every Unix.
const NOT_A_TERMINAL: i32 = 25;

/// A serial port that the machine has.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Port {
    /// Where it is opened.
    pub path: PathBuf,
    /// Whether its USB device says that it is an OpenCR.
    pub is_opencr: bool,
}

/// The serial ports of this machine, by name.
pub fn ports() -> Vec<Port> {
    let mut paths = SerialPort::available_ports().unwrap_or_default();
    paths.sort();
    let port = |path: PathBuf| Port {
        is_opencr: usb_id(&path)
            .is_some_and(|(vendor, product)| (vendor.as_str(), product.as_str()) == USB_ID),
        path,
    };
    paths.into_iter().map(port).collect()
}

/// Vendor and product of a port's USB device, from Linux's sysfs: its folder is some levels above
/// the port's.
fn usb_id(port: &Path) -> Option<(String, String)> {
    let device = Path::new("/sys/class/tty").join(port.file_name()?).join("device").canonicalize().ok()?;
    device.ancestors().take(4).find_map(|folder| {
        let read = |name: &str| Some(std::fs::read_to_string(folder.join(name)).ok()?.trim().to_owned());
        Some((read("idVendor")?, read("idProduct")?))
    })
}

fn listed(ports: &[Port]) -> String {
    if ports.is_empty() {
        return "this machine has none: is the board connected and on?".to_owned();
    }
    let name = |port: &Port| {
        let kind = if port.is_opencr { " (OpenCR)" } else { "" };
        format!("{}{kind}", port.path.display())
    };
    format!("this machine has {}", ports.iter().map(name).collect::<Vec<_>>().join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ports_there_are_are_named() {
        let port = |path: &str, is_opencr| Port { path: path.into(), is_opencr };
        assert_eq!(
            listed(&[port("/dev/ttyACM0", true), port("/dev/ttyS0", false)]),
            "this machine has /dev/ttyACM0 (OpenCR), /dev/ttyS0"
        );
        assert!(listed(&[]).contains("is the board connected"));
    }
}
