//! The store on the board's core, in memory that behaves as flash.
#![cfg_attr(target_os = "none", no_std, no_main)]

use embassy_futures::block_on;
use embedded_storage_async::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use firmware::control_table::Item;
use firmware::items::{Calibration, ITEMS, RobotIdentity};
use firmware::store::{RamFlash, Store};
use on_target_tests::{Failed, Outcome, ensure, tests};

#[allow(dead_code, clippy::excessive_precision, clippy::approx_constant)]
mod reference {
    include!("../reference/image.rs");
}
use reference::IMAGE;

tests!(what_was_put_is_there, foreign_contents_give_way, a_power_cut_leaves_old_or_new);

/// Small, so that two of them fit the stack and fill often.
const SECTOR: usize = 2048;
const BYTES: usize = 2 * SECTOR;

type Small<'a> = RamFlash<'a, SECTOR>;

fn store<F: NorFlash>(flash: F) -> Result<Store<F>, Failed> {
    Store::new(flash, 0..BYTES as u32).map_err(|_| Failed)
}

fn put_all(memory: &mut [u8], factor: f32) -> Outcome {
    let calibration = Calibration { power_factors: [factor; 4] }.encode();
    let robot = RobotIdentity::BURGER.encode();
    let mut store = store(Small::from(memory))?;
    for (item, bytes) in ITEMS.into_iter().zip([IMAGE.as_slice(), &calibration, &robot]) {
        let result = block_on(store.put(item, bytes));
        ensure(result == Ok(()), format_args!("{item:?}: {result:?}"))?;
    }
    Ok(())
}

fn calibration(memory: &mut [u8]) -> Result<Calibration, Failed> {
    let found = block_on(store(Small::from(memory))?.get(Item::Calibration)).map_err(|_| Failed)?;
    Calibration::decode(found.as_slice()).map_err(|_| Failed)
}

fn ensure_all(memory: &mut [u8], factor: f32) -> Outcome {
    let found = calibration(memory)?;
    ensure(found.power_factors == [factor; 4], format_args!("{found:?}, not {factor}"))?;
    let mut store = store(Small::from(memory))?;
    let image = block_on(store.get(Item::Coefficients)).map_err(|_| Failed)?;
    ensure(image.as_slice() == IMAGE, format_args!("{image:?}"))?;
    let robot = block_on(store.get(Item::Robot)).map_err(|_| Failed)?;
    ensure(robot.as_slice() == RobotIdentity::BURGER.encode(), format_args!("{robot:?}"))
}

/// More than both sectors hold, so that they change places several times.
fn what_was_put_is_there() -> Outcome {
    let mut memory = [0xFF; BYTES];
    for round in 0..30_u8 {
        let factor = 1.0 + f32::from(round) / 64.0;
        put_all(&mut memory, factor)?;
        ensure_all(&mut memory, factor)?;
    }
    Ok(())
}

fn foreign_contents_give_way() -> Outcome {
    let mut memory = [0; BYTES];
    for (byte, i) in memory.iter_mut().zip(0_u32..) {
        *byte = (i.wrapping_mul(2_654_435_761) >> 24) as u8;
    }
    ensure(calibration(&mut memory).is_err(), format_args!("found in noise"))?;
    put_all(&mut memory, 1.5)?;
    ensure_all(&mut memory, 1.5)
}

/// Flash that is off after so many writes and erases.
struct CutOff<'a> {
    flash: Small<'a>,
    left: u32,
}

#[derive(Debug)]
struct Off;

impl NorFlashError for Off {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

impl CutOff<'_> {
    fn count(&mut self) -> Result<(), Off> {
        self.left = self.left.checked_sub(1).ok_or(Off)?;
        Ok(())
    }
}

impl ErrorType for CutOff<'_> {
    type Error = Off;
}

impl ReadNorFlash for CutOff<'_> {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Off> {
        self.flash.read(offset, bytes).await.map_err(|_| Off)
    }

    fn capacity(&self) -> usize {
        self.flash.capacity()
    }
}

impl NorFlash for CutOff<'_> {
    const WRITE_SIZE: usize = Small::WRITE_SIZE;
    const ERASE_SIZE: usize = SECTOR;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Off> {
        self.count()?;
        self.flash.erase(from, to).await.map_err(|_| Off)
    }

    /// Word by word: each may be the last.
    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Off> {
        for (word, at) in bytes.chunks(Self::WRITE_SIZE).zip((offset..).step_by(Self::WRITE_SIZE)) {
            self.count()?;
            self.flash.write(at, word).await.map_err(|_| Off)?;
        }
        Ok(())
    }
}

fn a_power_cut_leaves_old_or_new() -> Outcome {
    let mut before = [0xFF; BYTES];
    put_all(&mut before, 1.25)?;
    // From here on the sectors fill at the third or fourth.
    for _ in 0..16 {
        let bytes = Calibration { power_factors: [1.25; 4] }.encode();
        block_on(store(Small::from(before.as_mut_slice()))?.put(Item::Calibration, &bytes))
            .map_err(|_| Failed)?;
        for left in 0.. {
            let mut memory = before;
            let bytes = Calibration { power_factors: [0.75; 4] }.encode();
            let flash = CutOff { flash: Small::from(memory.as_mut_slice()), left };
            let is_done = block_on(store(flash)?.put(Item::Calibration, &bytes)).is_ok();
            let is_new = calibration(&mut memory)?.power_factors == [0.75; 4];
            ensure(is_new || !is_done, format_args!("done after {left} writes, but not there"))?;
            ensure_all(&mut memory, if is_new { 0.75 } else { 1.25 })?;
            if is_done {
                break;
            }
        }
    }
    Ok(())
}
