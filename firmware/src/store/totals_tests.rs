//! The totals are the old ones or the new ones, whenever the power goes; and nothing is erased that
//! was not prepared for it.

use embassy_futures::block_on;

use super::torn::{Rewriting, TornFlash};
use super::totals::RECORD_BYTES;
use super::*;

/// Of the test's small sectors.
const SLOTS: u32 = (torn::SECTOR / 2 / RECORD_BYTES) as u32;

type Bytes = [u8; TOTALS_BYTES];

fn totals(version: u32) -> Bytes {
    core::array::from_fn(|i| (version.wrapping_mul(37) ^ i as u32) as u8)
}

fn store(flash: &mut TornFlash) -> Store<&mut TornFlash> {
    Store::new(flash, 0..torn::BYTES as u32).unwrap()
}

fn append(flash: &mut TornFlash, version: u32) -> Result<(), StoreError> {
    block_on(store(flash).append_totals(&totals(version)))
}

fn image(version: u8) -> Vec<u8> {
    (0..164).map(|i| i ^ version).collect()
}

/// Everything that a store holds.
#[derive(Debug, Clone, PartialEq)]
struct Held {
    items: [ItemBytes; 3],
    previous: ItemBytes,
    totals: Option<Bytes>,
}

fn held(flash: &mut TornFlash) -> Held {
    let mut store = store(flash);
    let items = ITEMS.map(|item| block_on(store.get(item)).unwrap());
    let (previous, totals) = (block_on(store.previous()).unwrap(), block_on(store.totals()).unwrap());
    Held { items, previous, totals }
}

/// Two sets of coefficients, a robot, and so many records of totals.
fn used(rewriting: Rewriting, records: u32) -> TornFlash {
    let mut flash = TornFlash::new(rewriting);
    for version in [1, 2] {
        block_on(store(&mut flash).put(Item::Coefficients, &image(version))).unwrap();
    }
    block_on(store(&mut flash).put(Item::Robot, &[9; 68])).unwrap();
    (0..records).for_each(|version| append(&mut flash, version).unwrap());
    flash
}

/// `work` with the power cut in each of its operations, with several kinds of damage: gives what it
/// leaves, until it is not cut any more. Gives the number of cuts.
fn cut_everywhere(
    before: &TornFlash,
    work: impl Fn(&mut Store<&mut TornFlash>) -> Result<(), StoreError>,
    mut check: impl FnMut(&mut TornFlash, bool),
) -> u32 {
    let mut cuts = 0;
    for cut in 0.. {
        let mut was_cut = false;
        for seed in 0..6 {
            let mut flash = before.clone();
            flash.power_up(Some(cut), seed);
            let result = work(&mut store(&mut flash));
            assert_eq!(result.is_err(), flash.is_off(), "{result:?} {cut} {seed}");
            was_cut |= flash.is_off();
            flash.power_up(None, seed);
            check(&mut flash, result.is_ok());
            cuts += u32::from(result.is_err());
        }
        if !was_cut {
            break;
        }
    }
    cuts
}

#[test]
fn what_was_appended_last_is_there() {
    let mut flash = used(Rewriting::Fails, 0);
    assert_eq!(held(&mut flash).totals, None);
    for version in 0..5 * SLOTS {
        append(&mut flash, version).unwrap();
        assert_eq!(held(&mut flash).totals, Some(totals(version)));
    }
    let held = held(&mut flash);
    assert_eq!(held.items[0].as_slice(), image(2));
    assert_eq!(held.previous.as_slice(), image(1));
    assert_eq!(held.items[2].as_slice(), [9; 68]);
}

/// A new board's first record, and those with which a sector fills and moves.
#[test]
fn a_power_cut_leaves_old_or_new_totals() {
    let mut cuts = 0;
    for rewriting in [Rewriting::Clears, Rewriting::Fails] {
        let fresh = TornFlash::new(rewriting);
        let fillings = (0..2 * SLOTS + 3).map(|records| used(rewriting, records));
        for before in core::iter::once(fresh).chain(fillings) {
            let old = held(&mut before.clone());
            let new = Held { totals: Some(totals(777)), ..old.clone() };
            cuts += cut_everywhere(
                &before,
                |store| block_on(store.append_totals(&totals(777))),
                |flash, is_done| {
                    let after = held(flash);
                    assert!(after == new || !is_done && after == old, "{after:?}");
                    append(flash, 778).unwrap();
                    assert_eq!(held(flash).totals, Some(totals(778)));
                },
            );
        }
    }
    assert!(cuts > 2000, "{cuts}");
}

/// An upload, its way back, and a sector prepared: the totals, and both sets of coefficients, are
/// never parted.
#[test]
fn a_power_cut_in_anything_else_leaves_them_alone() {
    let mut cuts = 0;
    for rewriting in [Rewriting::Clears, Rewriting::Fails] {
        for records in [0, 1, SLOTS - 1, SLOTS, SLOTS + 1] {
            let before = used(rewriting, records);
            let old = held(&mut before.clone());
            let as_before = |held: &Held| held.totals == old.totals && held.items[2] == old.items[2];
            for coefficients in [image(3), image(1)] {
                cuts += cut_everywhere(
                    &before,
                    |store| block_on(store.put(Item::Coefficients, &coefficients)),
                    |flash, is_done| {
                        let after = held(flash);
                        let is_new = after.items[0].as_slice() == coefficients
                            && after.previous == old.items[0]
                            && as_before(&after);
                        assert!(is_new || !is_done && after == old, "{after:?}");
                    },
                );
            }
            cuts += cut_everywhere(
                &before,
                |store| block_on(store.prepare()),
                |flash, is_done| {
                    assert_eq!(held(flash), old);
                    let mut store = store(flash);
                    assert!(!is_done || block_on(store.is_prepared()).unwrap());
                    // Half an erase is none: what is put next does not end up on it.
                    store.allow_erasing(false);
                    if !block_on(store.is_prepared()).unwrap() {
                        assert_eq!(block_on(store.prepare()), Err(StoreError::Unprepared));
                    }
                    store.allow_erasing(true);
                    assert_eq!(block_on(store.prepare()), Ok(()));
                },
            );
        }
    }
    assert!(cuts > 1000, "{cuts}");
}

/// From a prepared sector on nothing is erased until both are full; then what does not fit is
/// refused, and nothing of it done.
#[test]
fn without_leave_nothing_is_erased() {
    let mut flash = used(Rewriting::Fails, 3);
    let mut store = store(&mut flash);
    block_on(store.prepare()).unwrap();
    let erases = store.erases();
    store.allow_erasing(false);
    let mut version = 0;
    let refused = loop {
        match block_on(store.append_totals(&totals(version))) {
            Ok(()) => version += 1,
            Err(error) => break error,
        }
        assert!(version < 100 * SLOTS, "it never ends");
    };
    assert_eq!((refused, store.erases()), (StoreError::Unprepared, erases));
    // The rest of one sector, and the other.
    assert_eq!(version, 2 * SLOTS - 3);
    assert_eq!(block_on(store.totals()), Ok(Some(totals(version - 1))));
    assert!(block_on(store.is_log_full()).unwrap());
    // As many as no sector holds.
    let refused = (0..100).find_map(|round| {
        let error = block_on(store.put(Item::Coefficients, &image(round))).err()?;
        Some((round, error))
    });
    let (round, error) = refused.unwrap();
    assert_eq!((error, store.erases()), (StoreError::Unprepared, erases));
    assert_eq!(block_on(store.get(Item::Coefficients)).unwrap().as_slice(), image(round - 1));
    store.allow_erasing(true);
    block_on(store.append_totals(&totals(version))).unwrap();
    assert_eq!(block_on(store.totals()), Ok(Some(totals(version))));
}

/// A record more than it holds, of a flash with bits that stay: it is skipped, and the one before
/// it stays in force until another is whole.
#[test]
fn a_worn_cell_costs_a_record_not_the_totals() {
    let mut flash = used(Rewriting::Clears, 2);
    let next = torn::SECTOR / 2 + 2 * RECORD_BYTES;
    let sector = (0..2).find(|sector| flash.cells[sector * torn::SECTOR + next - 1] != 0xFF).unwrap();
    // Programmed by nobody: it cannot become a 1 again.
    flash.cells[sector * torn::SECTOR + next + RECORD_BYTES + 7] = 0;
    assert_eq!(held(&mut flash).totals, Some(totals(1)));
    append(&mut flash, 2).unwrap();
    assert_eq!(held(&mut flash).totals, Some(totals(2)));
}
