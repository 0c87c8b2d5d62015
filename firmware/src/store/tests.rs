//! What is stored is there; what a power cut leaves is the old item or the new one.

use embassy_futures::block_on;
use proptest::prelude::*;

use super::torn::{Rewriting, SECTOR, TornFlash};
use super::*;

type Image = Vec<u8>;

fn store(flash: &mut TornFlash) -> Store<&mut TornFlash> {
    Store::new(flash, 0..torn::BYTES as u32).unwrap()
}

fn get(flash: &mut TornFlash, item: Item) -> Image {
    block_on(store(flash).get(item)).unwrap().as_slice().to_vec()
}

fn all(flash: &mut TornFlash) -> [Image; 3] {
    ITEMS.map(|item| get(flash, item))
}

fn put(flash: &mut TornFlash, item: Item, bytes: &[u8]) -> Result<(), StoreError> {
    block_on(store(flash).put(item, bytes))
}

/// Sizes as items have them: 164, 28 and 68 bytes.
fn image(item: Item, version: u32) -> Image {
    let length = [164, 28, 68][item as usize - 1];
    (0..length).map(|i| (version.wrapping_mul(31) ^ i ^ ((item as u32) << 5)) as u8).collect()
}

/// Flash with three items and `writes` more behind it.
fn used(rewriting: Rewriting, writes: u32) -> TornFlash {
    let mut flash = TornFlash::new(rewriting);
    for (version, item) in (0..writes + 3).zip(ITEMS.into_iter().cycle()) {
        put(&mut flash, item, &image(item, version)).unwrap();
    }
    flash
}

#[test]
fn what_was_put_is_there() {
    let mut flash = TornFlash::new(Rewriting::Fails);
    assert_eq!(all(&mut flash), [const { Vec::new() }; 3]);
    for version in 0..100 {
        for item in ITEMS {
            put(&mut flash, item, &image(item, version)).unwrap();
            assert_eq!(get(&mut flash, item), image(item, version));
        }
    }
    assert_eq!(all(&mut flash), ITEMS.map(|item| image(item, 99)));
}

#[test]
fn fetch_copies_to_the_front() {
    let mut memory = vec![0xFF; BYTES];
    let mut store = Store::new(RamFlash::new(&mut memory), 0..BYTES as u32).unwrap();
    let mut into = [7; ITEM_BYTES];
    assert_eq!(block_on(store.fetch(Item::Robot, &mut into)), Ok(None));
    assert_eq!(block_on(store.put(Item::Robot, &[1, 2, 3])), Ok(()));
    assert_eq!(block_on(store.fetch(Item::Robot, &mut into)), Ok(Some(3)));
    assert_eq!(into[..4], [1, 2, 3, 7]);
}

#[test]
fn items_have_a_length() {
    let mut memory = vec![0xFF; BYTES];
    let mut store = Store::new(RamFlash::new(&mut memory), 0..BYTES as u32).unwrap();
    assert_eq!(block_on(store.put(Item::Robot, &[])), Err(StoreError::Length));
    assert_eq!(block_on(store.put(Item::Robot, &[0; ITEM_BYTES + 1])), Err(StoreError::Length));
    assert_eq!(block_on(store.put(Item::Robot, &[0; ITEM_BYTES])), Ok(()));
    let back = block_on(store.get(Item::Robot)).unwrap();
    assert_eq!(back.as_slice(), [0; ITEM_BYTES]);
}

/// The chip's flash has the bootloader and the application around the store.
#[test]
fn stays_within_its_range() {
    let mut memory = vec![0x5A; 4 * SECTOR_BYTES];
    let (range, sector) = (OFFSET..OFFSET + BYTES as u32, SECTOR_BYTES as u32);
    {
        let mut store = Store::new(RamFlash::new(&mut memory), range.clone()).unwrap();
        for version in 0..250 {
            block_on(store.put(Item::Coefficients, &image(Item::Coefficients, version))).unwrap();
        }
    }
    assert!(memory[..OFFSET as usize].iter().all(|byte| *byte == 0x5A));
    for wrong in [0..sector, 1..2 * sector, 0..2 * sector + 1, sector..0] {
        assert_eq!(Store::new(RamFlash::new(&mut memory), wrong).err(), Some(StoreError::Range));
    }
    assert_eq!(ADDRESS - 0x0800_0000, OFFSET);
}

/// The power is cut in every operation of a put, from every filling of the sectors, with several
/// kinds of damage each: afterwards every other item is as it was, this one is the old or the new,
/// and the next put succeeds. Gives the number of cuts.
fn cut_everywhere(rewriting: Rewriting) -> u32 {
    let mut cuts = 0;
    for writes in 0..24 {
        let before = used(rewriting, writes);
        let old = all(&mut before.clone());
        for item in ITEMS {
            let mut expected = old.clone();
            expected[item as usize - 1] = image(item, 777);
            for (cut, seed) in (0..40).flat_map(|cut| (0..4).map(move |seed| (cut, seed))) {
                let mut flash = before.clone();
                flash.power_up(Some(cut), seed);
                let result = put(&mut flash, item, &image(item, 777));
                assert_eq!(result.is_err(), flash.is_off());
                cuts += u32::from(flash.is_off());
                flash.power_up(None, seed);
                let items = all(&mut flash);
                let is_new = items == expected;
                assert!(
                    is_new || result.is_err() && items == old,
                    "{writes} {item:?} {cut} {seed}: {items:?}"
                );
                put(&mut flash, item, &image(item, 778)).unwrap();
                assert_eq!(get(&mut flash, item), image(item, 778));
            }
        }
    }
    cuts
}

#[test]
fn a_power_cut_leaves_old_or_new() {
    assert!(cut_everywhere(Rewriting::Clears) > 2500);
}

#[test]
fn a_power_cut_leaves_old_or_new_where_words_are_written_once() {
    assert!(cut_everywhere(Rewriting::Fails) > 2500);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// One cut after another.
    #[test]
    fn cuts_in_a_row(
        is_written_once: bool,
        seed: u64,
        puts in proptest::collection::vec((0..3_usize, proptest::option::weighted(0.7, 0..40_u32)), 1..60),
    ) {
        let rewriting = if is_written_once { Rewriting::Fails } else { Rewriting::Clears };
        let mut flash = TornFlash::new(rewriting);
        let mut known = [const { Image::new() }; 3];
        for (version, (index, cut)) in (0..).zip(puts) {
            let new = image(ITEMS[index], version);
            flash.power_up(cut, seed.wrapping_add(u64::from(version)));
            let result = put(&mut flash, ITEMS[index], &new);
            let was_cut = flash.is_off();
            prop_assert_eq!(result.is_err(), was_cut);
            flash.power_up(None, 0);
            let items = all(&mut flash);
            let mut expected = known.clone();
            expected[index] = new;
            prop_assert!(items == expected || was_cut && items == known, "{items:?}");
            known = items;
        }
    }

    /// Whatever stands there, such as the stock firmware's settings, is no item, no panic, and
    /// gives way to ours.
    #[test]
    fn foreign_contents(
        mut contents in proptest::collection::vec(any::<u8>(), torn::BYTES),
        ones in proptest::collection::vec((0..torn::BYTES, 0..SECTOR), 0..4),
        ends in any::<[bool; 4]>(),
    ) {
        for (start, length) in ones {
            contents[start..(start + length).min(torn::BYTES)].fill(0xFF);
        }
        // Pages that look erased, open or closed.
        let words = [0, SECTOR - torn::WORD, SECTOR, torn::BYTES - torn::WORD];
        for (word, is_erased) in words.into_iter().zip(ends) {
            contents[word..word + torn::WORD].fill(if is_erased { 0xFF } else { 0 });
        }
        let mut flash = TornFlash::new(Rewriting::Clears);
        flash.cells = contents;
        prop_assert_eq!(all(&mut flash), [const { Vec::new() }; 3]);
        for item in ITEMS {
            put(&mut flash, item, &image(item, 5)).unwrap();
        }
        prop_assert_eq!(all(&mut flash), ITEMS.map(|item| image(item, 5)));
    }
}

/// The stock firmware's settings: ST's EEPROM emulation, whose pages begin with the half-word 0000h
/// (valid) or FFFFh (erased) and go on with pairs of a value and a virtual address (AN3969).
#[test]
fn settings_of_the_stock_firmware_are_no_items() {
    let mut memory = vec![0xFF; BYTES];
    memory[..4].copy_from_slice(&[0x00, 0x00, 0xFF, 0xFF]);
    for (address, entry) in (0_u16..2000).zip(memory[4..].chunks_exact_mut(4)) {
        entry[..2].copy_from_slice(&address.wrapping_mul(257).to_le_bytes());
        entry[2..].copy_from_slice(&(address % 1024).to_le_bytes());
    }
    let mut store = Store::new(RamFlash::new(&mut memory), 0..BYTES as u32).unwrap();
    for item in ITEMS {
        assert_eq!(block_on(store.get(item)), Ok(ItemBytes::EMPTY));
        assert_eq!(block_on(store.put(item, &image(item, 1))), Ok(()));
    }
    for item in ITEMS {
        assert_eq!(block_on(store.get(item)).unwrap().as_slice(), image(item, 1));
    }
}

/// A cell that stays as it is: nothing helps, and the store says so instead of believing what it
/// wrote.
#[test]
fn a_broken_flash_is_reported() {
    struct Stuck(TornFlash);
    use embedded_storage_async::nor_flash::{ErrorType, ReadNorFlash};
    impl ErrorType for Stuck {
        type Error = torn::Failure;
    }
    impl ReadNorFlash for Stuck {
        const READ_SIZE: usize = 1;
        async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), torn::Failure> {
            (&mut self.0).read(offset, bytes).await
        }
        fn capacity(&self) -> usize {
            torn::BYTES
        }
    }
    impl NorFlash for Stuck {
        const WRITE_SIZE: usize = torn::WORD;
        const ERASE_SIZE: usize = SECTOR;
        async fn erase(&mut self, from: u32, to: u32) -> Result<(), torn::Failure> {
            (&mut self.0).erase(from, to).await
        }
        async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), torn::Failure> {
            // One bit never clears, wherever it is written.
            let stuck: Vec<u8> = bytes.iter().map(|byte| byte | 0x10).collect();
            (&mut self.0).write(offset, &stuck).await
        }
    }
    let mut store = Store::new(Stuck(TornFlash::new(Rewriting::Clears)), 0..torn::BYTES as u32).unwrap();
    assert_eq!(block_on(store.put(Item::Robot, &image(Item::Robot, 0))), Err(StoreError::ReadBack));
}
