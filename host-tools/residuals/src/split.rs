//! Runs that are explored, and runs that stay locked until the end.

use logs::runs::Runs;
use support::error::{Error, Result};

use super::thresholds::split::{LEAST_OPEN, PARTS};
use crate::noise::whiten::Signal;

/// Places of runs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Split {
    /// Explored, and left out one by one to select.
    pub open: Vec<usize>,
    /// Locked.
    pub locked: Vec<usize>,
}

impl Split {
    /// Signals of open and of locked runs, put in the order of all runs. What follows the open runs
    /// is left out.
    pub fn in_order(&self, open: &Signal, locked: &Signal) -> Signal {
        let mut all: Vec<(usize, &Vec<f64>)> = self.open.iter().copied().zip(open).collect();
        all.extend(self.locked.iter().copied().zip(locked));
        all.sort_by_key(|(place, _)| *place);
        all.into_iter().map(|(_, values)| values.clone()).collect()
    }
}

/// Every third run in the order of payloads is locked, so that both parts meet light and heavy
/// ones.
///
/// # Errors
/// Fewer runs than naming and confirming need.
pub fn by_run(runs: &Runs) -> Result<Split> {
    in_order(&by_mass(runs))
}

/// Places of runs in the order of their payloads.
pub fn by_mass(runs: &Runs) -> Vec<usize> {
    let mut order: Vec<(f64, usize)> = runs
        .runs
        .iter()
        .enumerate()
        .map(|(place, run)| (run.rows.iter().map(|row| row.mass).sum::<f64>() / run.rows.len() as f64, place))
        .collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    order.into_iter().map(|(_, place)| place).collect()
}

/// Every third run of these places is locked.
///
/// # Errors
/// As [`by_run`].
pub fn in_order(order: &[usize]) -> Result<Split> {
    let count = order.len();
    if count < LEAST_OPEN + 1 {
        let s = if count == 1 { "" } else { "s" };
        return Err(Error::failed(format!(
            "{count} run{s}; expected at least {}: {LEAST_OPEN} to name an effect and 1 to confirm it. Record {} more",
            LEAST_OPEN + 1,
            LEAST_OPEN + 1 - count
        )));
    }
    let (mut open, mut locked) = (Vec::new(), Vec::new());
    for (rank, &place) in order.iter().enumerate() {
        if rank % PARTS == 1 { locked.push(place) } else { open.push(place) }
    }
    open.sort_unstable();
    locked.sort_unstable();
    Ok(Split { open, locked })
}
