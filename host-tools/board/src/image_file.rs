//! The store as a file that any programmer takes: raw bytes, or Intel HEX, which carries the
//! address.

use std::path::Path;

use ihex::{Reader, Record};
use support::error::{Error, Result};
use support::output::write_content;

use super::store_image::StoreImage;

/// Data bytes of a line, as programmers write them.
const LINE: usize = 32;

/// Kinds of files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Bytes alone: the programmer has to know the address.
    Raw,
    /// Text with addresses and checksums.
    IntelHex,
}

impl Kind {
    /// By the file's extension.
    ///
    /// # Errors
    /// It has none, or a different one.
    pub fn of(file: &Path) -> Result<Self> {
        match file.extension().and_then(|extension| extension.to_str()) {
            Some("bin") => Ok(Self::Raw),
            Some("hex") => Ok(Self::IntelHex),
            _ => Err(Error::usage("expected a name that ends with .bin or .hex").in_file(file)),
        }
    }
}

/// Writes the image, whole or not at all, reads it back and compares.
///
/// # Errors
/// What the operating system refuses; what was read back is something else.
pub fn write(file: &Path, image: &StoreImage) -> Result<()> {
    let content = match Kind::of(file)? {
        Kind::Raw => image.as_bytes().to_vec(),
        Kind::IntelHex => hex(image)?.into_bytes(),
    };
    write_content(file, &content)?;
    if read(file)? == *image {
        return Ok(());
    }
    Err(Error::failed("what was read back is not what was written").in_file(file))
}

/// Reads an image.
///
/// # Errors
/// The file cannot be read, or is not an image of the whole store.
pub fn read(file: &Path) -> Result<StoreImage> {
    let refused = |error: std::io::Error| Error::io(file, &error);
    let bytes = match Kind::of(file)? {
        Kind::Raw => std::fs::read(file).map_err(refused)?,
        Kind::IntelHex => {
            let text = std::fs::read_to_string(file).map_err(refused)?;
            bytes_of(&text).map_err(|error| error.in_file(file))?
        }
    };
    StoreImage::from_bytes(bytes).map_err(|error| error.in_file(file))
}

fn hex(image: &StoreImage) -> Result<String> {
    let mut records = Vec::new();
    for (index, value) in image.as_bytes().chunks(LINE).enumerate() {
        let address = StoreImage::ADDRESS + (index * LINE) as u32;
        let [high, offset] = [address >> 16, address & 0xFFFF].map(|half| half as u16);
        if index == 0 || offset == 0 {
            records.push(Record::ExtendedLinearAddress(high));
        }
        records.push(Record::Data { offset, value: value.to_vec() });
    }
    records.push(Record::EndOfFile);
    ihex::create_object_file_representation(&records).map_err(|error| Error::failed(error.to_string()))
}

fn bytes_of(text: &str) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut base = 0;
    for record in Reader::new(text) {
        match record.map_err(|error| Error::failed(error.to_string()))? {
            Record::ExtendedLinearAddress(high) => base = u32::from(high) << 16,
            Record::Data { offset, value } => {
                let expected = StoreImage::ADDRESS as usize + bytes.len();
                let address = base + u32::from(offset);
                if address as usize != expected {
                    return Err(Error::failed(format!("data at {address:#010x}; expected {expected:#010x}")));
                }
                bytes.extend(value);
            }
            _ => {}
        }
    }
    Ok(bytes)
}
