//! The store of a board in its chip's own bootloader, through the program dfu-util.

use std::io::ErrorKind;
use std::path::Path;
use std::process::Command;

use support::error::{Error, Result};

use super::store_image::StoreImage;

const PROGRAM: &str = "dfu-util";
/// The bootloader of every STM32.
const USB_ID: &str = "0483:df11";
/// Its first alternate setting is the flash.
const FLASH: &str = "0";

/// The store as the board has it.
///
/// # Errors
/// dfu-util is not installed, there is no board in its bootloader, or reading fails.
pub fn read() -> Result<StoreImage> {
    let folder = folder()?;
    let file = folder.path().join("store.bin");
    let range = format!("{:#010x}:{}", StoreImage::ADDRESS, StoreImage::BYTES);
    run(&["-s", &range, "-U"], &file)?;
    StoreImage::from_bytes(std::fs::read(&file).map_err(|error| Error::io(PROGRAM, &error))?)
}

/// Writes the store, reads it back and compares.
///
/// # Errors
/// As [`read`]; what was read back is something else.
pub fn write(image: &StoreImage) -> Result<()> {
    let folder = folder()?;
    let file = folder.path().join("store.bin");
    std::fs::write(&file, image.as_bytes()).map_err(|error| Error::io(&file, &error))?;
    // Not `:leave`: the board stays in its bootloader, for the comparison, until a reset.
    run(&["-s", &format!("{:#010x}", StoreImage::ADDRESS), "-D"], &file)?;
    if read()? == *image {
        return Ok(());
    }
    Err(Error::failed("what was read back is not what was written: the store is damaged; write it again"))
}

fn folder() -> Result<tempfile::TempDir> {
    tempfile::tempdir().map_err(|error| Error::failed(format!("no folder for temporary files: {error}")))
}

fn run(arguments: &[&str], file: &Path) -> Result<()> {
    let output = Command::new(PROGRAM).args(["-d", USB_ID, "-a", FLASH]).args(arguments).arg(file).output();
    let output = output.map_err(|error| match error.kind() {
        ErrorKind::NotFound => Error::failed(
            "dfu-util is not installed; expected it on the PATH (Debian and Ubuntu: sudo apt install dfu-util)",
        ),
        _ => Error::io(PROGRAM, &error),
    })?;
    if output.status.success() {
        return Ok(());
    }
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8_lossy(&said);
    if said.contains("No DFU capable USB device") {
        return Err(Error::failed(
            "there is no board in its bootloader; on the OpenCR hold BOOT, press and release RESET, then release BOOT",
        ));
    }
    if said.contains("Cannot open DFU device") || said.contains("LIBUSB_ERROR_ACCESS") {
        return Err(Error::failed(
            "the board's bootloader may not be opened; expected a udev rule for 0483:df11, or sudo",
        ));
    }
    let last = said.lines().map(str::trim).rfind(|line| !line.is_empty()).unwrap_or("it says nothing");
    Err(Error::failed(format!("dfu-util failed ({}): {last}", output.status)))
}
