//! The process that is the virtual board: QEMU with the board's image.

use std::fs::File;
use std::io::ErrorKind;
use std::os::fd::AsFd as _;
use std::os::unix::process::{CommandExt as _, ExitStatusExt as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use support::error::{Error, Result};

/// The emulator.
const QEMU: &str = "qemu-system-arm";
/// Decodes the board's log. Its library would be a dependency under the MPL.
const DECODER: &str = "defmt-print";
/// Where the emulator's own messages go.
const MESSAGES: &str = "qemu.err";
/// How the image comes about.
pub const BUILD: &str =
    "cargo build --release -p firmware --bin virtual --features virtual --target thumbv7em-none-eabihf";

/// What happens to the board's log.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum BoardLog {
    /// Nobody looks at it.
    #[default]
    Discard,
    /// Decoded on standard error, by the program `defmt-print`.
    Print,
    /// As defmt frames in a file.
    Frames(PathBuf),
}

/// A running emulator. Dropped, it is killed.
#[derive(Debug)]
pub struct Qemu {
    emulator: Child,
    decoder: Option<Child>,
    folder: PathBuf,
}

impl Qemu {
    /// Starts the image in `folder`, where its files are. `shift`: an instruction takes 2^`shift`
    /// ns of the board's time.
    ///
    /// # Errors
    /// There is no image, no emulator, or no decoder for the log.
    pub fn start(image: &Path, folder: &Path, shift: u8, log: &BoardLog) -> Result<Self> {
        // The emulator runs in a different folder.
        let image = std::fs::canonicalize(image).map_err(|error| match error.kind() {
            ErrorKind::NotFound => {
                Error::failed(format!("there is no such image; built with: {BUILD}")).in_file(image)
            }
            _ => Error::io(image, &error),
        })?;
        let (output, decoder) = match log {
            BoardLog::Discard => (Stdio::null(), None),
            BoardLog::Frames(path) => {
                (File::create(path).map_err(|error| Error::io(path, &error))?.into(), None)
            }
            BoardLog::Print => {
                let mut decoder = start_decoder(&image)?;
                let input = decoder.stdin.take().map_or_else(Stdio::null, Stdio::from);
                (input, Some(decoder))
            }
        };
        let messages = folder.join(MESSAGES);
        let messages = File::create(&messages).map_err(|error| Error::io(&messages, &error))?;
        let emulator = Command::new(QEMU)
            .args(["-cpu", "cortex-m7", "-machine", "mps2-an500", "-nographic", "-monitor", "none"])
            .args(["-semihosting-config", "enable=on,target=native"])
            .args(["-icount", &format!("shift={shift},sleep=off"), "-kernel"])
            .arg(image)
            .current_dir(folder)
            .stdin(Stdio::null())
            .stdout(output)
            .stderr(messages)
            // Ctrl-C is for this process, which then ends the emulator.
            .process_group(0)
            .spawn()
            .map_err(|error| not_started(QEMU, "Debian: apt install qemu-system-arm", &error))?;
        Ok(Self { emulator, decoder, folder: folder.to_owned() })
    }

    /// How it ended; `None` while it runs.
    ///
    /// # Errors
    /// The operating system does not know it.
    pub fn ended(&mut self) -> Result<Option<String>> {
        let status = self.emulator.try_wait().map_err(|error| Error::io(QEMU, &error))?;
        Ok(status.map(|status| self.describe(status)))
    }

    fn describe(&self, status: ExitStatus) -> String {
        let how = match (status.code(), status.signal()) {
            (Some(0), _) => "the virtual board ended by itself".to_owned(),
            (Some(code), _) => format!("the virtual board failed with exit code {code}"),
            (None, Some(signal)) => format!("the virtual board was killed by signal {signal}"),
            (None, None) => "the virtual board ended".to_owned(),
        };
        let said = std::fs::read_to_string(self.folder.join(MESSAGES)).unwrap_or_default();
        let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
        let hint = if self.decoder.is_none() { "; --log shows what it says" } else { "" };
        if said.is_empty() { format!("{how}{hint}") } else { format!("{how}; {QEMU} says: {said}") }
    }

    /// Waits for it to end by itself, at most `limit`; then it is killed.
    pub fn wait(&mut self, limit: Duration) {
        let begun = Instant::now();
        while begun.elapsed() < limit && matches!(self.emulator.try_wait(), Ok(None)) {
            std::thread::sleep(Duration::from_millis(2));
        }
        self.kill();
    }

    fn kill(&mut self) {
        // Both do nothing when it has ended.
        let _ = self.emulator.kill();
        let _ = self.emulator.wait();
        if let Some(mut decoder) = self.decoder.take() {
            // It ends with its input.
            let _ = decoder.wait();
        }
    }
}

impl Drop for Qemu {
    fn drop(&mut self) {
        self.kill();
    }
}

fn start_decoder(image: &Path) -> Result<Child> {
    let to_stderr =
        std::io::stderr().as_fd().try_clone_to_owned().map_err(|error| Error::io(DECODER, &error))?;
    Command::new(DECODER)
        .arg("-e")
        .arg(image)
        .stdin(Stdio::piped())
        .stdout(to_stderr)
        .process_group(0)
        .spawn()
        .map_err(|error| not_started(DECODER, "cargo install defmt-print --locked", &error))
}

fn not_started(program: &str, remedy: &str, error: &std::io::Error) -> Error {
    match error.kind() {
        ErrorKind::NotFound => Error::failed(format!("{program} is not installed ({remedy})")),
        _ => Error::io(program, error),
    }
}
