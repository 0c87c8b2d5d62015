//! The ring of buckets and the schedule against naive models that keep everything in a `Vec`.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

use model_core::payload::ring::Ring;
use model_core::payload::schedule::{Schedule, Timeline};
use proptest::prelude::*;

#[derive(Debug, Clone)]
enum Step {
    Push(u64),
    Keep(usize),
    Blank(usize),
    Halve,
}

fn step() -> impl Strategy<Value = Step> {
    prop_oneof![
        8 => (0..1000_u64).prop_map(Step::Push),
        1 => (0..12_usize).prop_map(Step::Keep),
        1 => (0..12_usize).prop_map(Step::Blank),
        1 => Just(Step::Halve),
    ]
}

fn assert_ring<const B: usize>(steps: &[Step]) -> Result<(), TestCaseError> {
    let mut ring = Ring::<u64, B>::default();
    let mut naive: Vec<u64> = vec![];
    for step in steps {
        match step {
            Step::Push(value) => {
                ring.push(*value);
                naive.push(*value);
            }
            Step::Keep(count) => {
                ring.keep_latest(*count);
                naive.drain(..naive.len().saturating_sub(*count));
            }
            Step::Blank(count) => {
                ring.blank_older(*count);
                let older = naive.len().saturating_sub(*count);
                naive[..older].fill(0);
            }
            Step::Halve => {
                ring.halve(|earlier, later| 3 * earlier + later);
                naive = naive.chunks(2).map(|c| if c.len() == 2 { 3 * c[0] + c[1] } else { c[0] }).collect();
            }
        }
        naive.drain(..naive.len().saturating_sub(B));
        prop_assert_eq!(ring.len(), naive.len());
        prop_assert_eq!(ring.is_empty(), naive.is_empty());
        for count in 0..B + 3 {
            let latest: Vec<_> = ring.latest(count).copied().collect();
            prop_assert_eq!(&latest[..], &naive[naive.len().saturating_sub(count)..]);
        }
    }
    Ok(())
}

proptest! {
    #[test]
    fn ring_is_the_end_of_a_vec(steps in proptest::collection::vec(step(), 0..60)) {
        assert_ring::<1>(&steps)?;
        assert_ring::<2>(&steps)?;
        assert_ring::<5>(&steps)?;
        assert_ring::<8>(&steps)?;
    }

    /// The naive schedule keeps the bucket numbers since the last change and cuts the window out of
    /// them.
    #[test]
    fn schedule_is_a_window_of_a_vec(
        steps in proptest::collection::vec(prop_oneof![9 => Just(None), 1 => (0..8_usize).prop_map(Some)], 1..80),
        window in 1..6_usize, more in 0..6_usize,
    ) {
        let every = window + more;
        for schedule in [
            Schedule::Moving { window },
            Schedule::Cumulative,
            Schedule::KnownChange { window },
            Schedule::Periodic { window, every },
        ] {
            let mut timeline = Timeline::new(schedule);
            prop_assert_eq!(timeline.schedule(), schedule);
            let mut since: Vec<usize> = vec![];
            for (number, step) in steps.iter().enumerate() {
                if let Some(ago) = step {
                    // A change is noticed at most one round back.
                    let ago = (*ago).min(every);
                    timeline.restart(ago);
                    since = (0..ago).collect();
                }
                since.push(number);
                let round = match schedule {
                    Schedule::Periodic { every, .. } => since.chunks(every).next_back().unwrap(),
                    _ => &since[..],
                };
                let expected = match schedule {
                    Schedule::Moving { window } => Some(round.len().min(window)),
                    Schedule::Cumulative => Some(round.len()),
                    Schedule::KnownChange { window } | Schedule::Periodic { window, .. } => {
                        (round.len() <= window).then_some(round.len())
                    }
                };
                prop_assert_eq!(timeline.advance(), expected, "{:?} at {}", schedule, number);
            }
        }
    }
}

/// No schedule has to make sense to be safe.
#[test]
fn senseless_schedules_do_not_panic() {
    for schedule in [
        Schedule::Moving { window: 0 },
        Schedule::KnownChange { window: 0 },
        Schedule::Periodic { window: 3, every: 0 },
        Schedule::Periodic { window: 5, every: 2 },
    ] {
        let mut timeline = Timeline::new(schedule);
        for _ in 0..10 {
            let count = timeline.advance().unwrap_or(0);
            assert!(count <= 5);
        }
        timeline.restart(usize::MAX);
        timeline.advance();
        timeline.advance();
    }
    let mut empty = Ring::<u8, 0>::default();
    empty.push(1);
    empty.halve(|a, _| a);
    assert_eq!(empty.latest(3).count(), 0);
}
