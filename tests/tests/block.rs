//! Numbers that stand side by side are read and written with their bits, and nothing beside them.
#![cfg_attr(target_os = "none", no_std, no_main)]

use core::hint::black_box;

use model_core::real::Real;
use on_target_tests::{Outcome, ensure, tests};

tests!(every_size);

const NOTHING: u32 = 0xA5A5_A5A5;
/// Numbers on both sides.
const MARGIN: usize = 4;
const ROOM: usize = 20 + 2 * MARGIN;

/// One instruction moves up to 16, for some sizes: those of a robot's channels, of its torque and
/// of a bucket among them.
fn every_size() -> Outcome {
    size::<1>()?;
    size::<2>()?;
    size::<3>()?;
    size::<4>()?;
    size::<5>()?;
    size::<6>()?;
    size::<7>()?;
    size::<8>()?;
    size::<9>()?;
    size::<14>()?;
    size::<15>()?;
    size::<16>()?;
    size::<20>()
}

fn size<const K: usize>() -> Outcome {
    // Numbers of all kinds, no two alike: what is no number keeps its bits as well.
    let bits: [u32; K] = core::array::from_fn(|at| 0x0123_4567_u32.wrapping_mul(at as u32 + 1) ^ 0x7F80_0000);
    let block = [bits.map(f32::from_bits)];
    let [read] = f32::read(black_box(&block)).map(|numbers| numbers.map(f32::to_bits));
    ensure(read == bits, format_args!("{K} numbers are read as {read:x?} instead of {bits:x?}"))?;
    let mut room = [f32::from_bits(NOTHING); ROOM];
    let place = room.get_mut(MARGIN..).and_then(|room| room.first_chunk_mut::<K>());
    let Some(place) = place else { return ensure(false, format_args!("no room for {K}")) };
    f32::write(black_box(core::array::from_mut(place)), black_box(block));
    let found = black_box(&room).map(f32::to_bits);
    let is_right = found.iter().enumerate().all(|(at, found)| {
        *found == at.checked_sub(MARGIN).and_then(|at| bits.get(at)).copied().unwrap_or(NOTHING)
    });
    ensure(is_right, format_args!("{K} numbers are written as {found:x?}"))
}
