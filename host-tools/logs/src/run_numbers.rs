//! Runs of a log by number, in the order in which they appear.

use std::collections::HashMap;

/// Most runs of a log: where every row has another name, the column is something else.
pub(super) const MOST_RUNS: usize = 10_000;

/// Names of the runs seen; the one of the row before is found by comparing bytes only.
#[derive(Default)]
pub(super) struct Runs {
    ids: HashMap<Vec<u8>, usize>,
    pub names: Vec<String>,
    current: Vec<u8>,
    current_id: usize,
}

impl Runs {
    /// The number of the run of this name.
    pub(super) fn id(&mut self, name: &[u8]) -> usize {
        if self.names.is_empty() || self.current != name {
            let next = self.names.len();
            self.current_id = *self.ids.entry(name.to_owned()).or_insert(next);
            if self.current_id == next && next < MOST_RUNS {
                self.names.push(String::from_utf8_lossy(name).into_owned());
            }
            name.clone_into(&mut self.current);
        }
        self.current_id
    }

    /// The names as they were written, by number.
    pub(super) fn into_written(self) -> Vec<Vec<u8>> {
        let mut names: Vec<(usize, Vec<u8>)> = self.ids.into_iter().map(|(name, id)| (id, name)).collect();
        names.sort_unstable();
        names.into_iter().map(|(_, name)| name).collect()
    }
}
