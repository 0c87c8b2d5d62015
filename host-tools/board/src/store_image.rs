//! A copy of the board's store in memory: written by the code that the board itself runs.

use embassy_futures::block_on;
use firmware::control_table::{Item, Reason};
use firmware::store::{ADDRESS, BYTES, RamFlash, Store, StoreError};
use support::error::{Error, Result};

/// The store's two sectors.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StoreImage {
    bytes: Vec<u8>,
}

impl StoreImage {
    /// Where it belongs in the chip's address space.
    pub const ADDRESS: u32 = ADDRESS;
    /// Its size.
    pub const BYTES: usize = BYTES;

    /// Of erased flash.
    pub fn erased() -> Self {
        Self { bytes: vec![0xFF; BYTES] }
    }

    /// As read from a board. What no store has written counts as empty.
    ///
    /// # Errors
    /// Fewer or more bytes than the store has.
    pub fn from_bytes(bytes: Vec<u8>) -> Result<Self> {
        if bytes.len() == BYTES {
            return Ok(Self { bytes });
        }
        Err(Error::failed(format!("{} bytes read from the board; expected {BYTES}", bytes.len())))
    }

    /// As it is to be written.
    pub fn as_bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// An item; empty when there is none.
    ///
    /// # Errors
    /// The store cannot be read.
    pub fn stored(&mut self, item: Item) -> Result<Vec<u8>> {
        let mut store = self.store()?;
        Ok(block_on(store.get(item)).map_err(failed)?.as_slice().to_vec())
    }

    /// The coefficients before those stored; empty when there are none.
    ///
    /// # Errors
    /// The store cannot be read.
    pub fn previous(&mut self) -> Result<Vec<u8>> {
        let mut store = self.store()?;
        Ok(block_on(store.previous()).map_err(failed)?.as_slice().to_vec())
    }

    /// Puts an item; the others stay.
    ///
    /// # Errors
    /// It is too long.
    pub fn put(&mut self, item: Item, bytes: &[u8]) -> Result<()> {
        let mut store = self.store()?;
        block_on(store.put(item, bytes)).map_err(failed)
    }

    fn store(&mut self) -> Result<Store<RamFlash<'_>>> {
        let end = self.bytes.len() as u32;
        Store::new(RamFlash(&mut self.bytes), 0..end).map_err(failed)
    }
}

fn failed(error: StoreError) -> Error {
    Error::failed(format!("the store's image: {}", Reason::from(error).text()))
}
