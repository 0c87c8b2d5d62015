//! Power in blocks of equal length: what segmentation and figures work on. Memory does not grow with the log.

use super::sketch::median;
use crate::numerics::robust::MEDIAN_TO_STD;

/// Shortest block, s, and fewest rows in one: mean and spread of a block mean something.
const BLOCK_S: f64 = 0.5;
const BLOCK_ROWS: f64 = 8.0;

/// Most blocks; when there are more, neighbours are joined and blocks grow.
const MOST_BLOCKS: usize = 8192;

/// Rows of a block further away than this many robust standard deviations do not count: glitches.
const GLITCH_Z: f64 = 8.0;

/// Rows of one stretch of time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Block {
    /// Time of the first row, s.
    pub from_s: f64,
    /// Time of the last row, s.
    pub to_s: f64,
    /// Rows that count.
    pub count: f64,
    /// Their mean.
    pub mean: f64,
    /// Sum of their squared deviations from the mean.
    pub squares: f64,
    /// Least value, glitches included.
    pub min: f64,
    /// Greatest value, glitches included.
    pub max: f64,
    /// Whether the robot stood; always, where the log does not tell.
    pub still: bool,
    /// Whether the block does not continue the one before.
    pub starts: bool,
}

impl Block {
    /// Standard deviation of the rows.
    pub fn std(&self) -> f64 {
        (self.squares / self.count).sqrt()
    }

    fn join(&mut self, next: &Self) {
        let count = self.count + next.count;
        let step = next.mean - self.mean;
        self.squares += next.squares + step * step * self.count * next.count / count;
        self.mean += step * next.count / count;
        self.count = count;
        self.to_s = next.to_s;
        self.min = self.min.min(next.min);
        self.max = self.max.max(next.max);
    }
}

/// Collects rows into blocks.
pub struct Blocks {
    blocks: Vec<Block>,
    /// Blocks joined into one since the start: 1, 2, 4, …
    joined: usize,
    rows: Vec<(f64, f64)>,
    still: bool,
    starts: bool,
    length_s: Option<f64>,
}

impl Blocks {
    /// No rows yet.
    pub fn new() -> Self {
        Self { blocks: Vec::new(), joined: 1, rows: Vec::new(), still: true, starts: true, length_s: None }
    }

    /// Adds a row. A block ends when it is long enough, and where `still` changes.
    pub fn add(&mut self, time_s: f64, value: f64, still: bool) {
        if still != self.still {
            self.close();
            self.still = still;
        }
        self.rows.push((time_s, value));
        let first = self.rows[0].0;
        let length = match self.length_s {
            Some(length) => length,
            // The first block is as long as its rows ask for, and so are all others.
            None if self.rows.len() as f64 >= BLOCK_ROWS && time_s - first >= BLOCK_S => {
                let length = time_s - first;
                self.length_s = Some(length);
                length
            }
            None => return,
        };
        if time_s - first >= length * (1.0 - 1e-9) {
            self.close();
        }
    }

    /// A gap or a new run: what follows does not continue what was.
    pub fn restart(&mut self) {
        self.close();
        self.starts = true;
    }

    fn close(&mut self) {
        if self.rows.is_empty() {
            return;
        }
        let block = self.block();
        self.rows.clear();
        self.starts = false;
        // Joined blocks fill up one by one.
        let full = match (self.blocks.last(), self.length_s) {
            (Some(last), Some(length)) => {
                let fits = block.to_s - last.from_s <= length * self.joined as f64 * 1.001;
                self.joined == 1 || !fits || block.starts || block.still != last.still
            }
            _ => true,
        };
        match self.blocks.last_mut() {
            Some(last) if !full => last.join(&block),
            _ => self.blocks.push(block),
        }
        if self.blocks.len() > MOST_BLOCKS {
            self.joined *= 2;
            self.halve();
        }
    }

    fn block(&self) -> Block {
        let mut values: Vec<f64> = self.rows.iter().map(|row| row.1).collect();
        let middle = median(&mut values);
        let mut deviations: Vec<f64> = values.iter().map(|value| (value - middle).abs()).collect();
        let limit = GLITCH_Z * MEDIAN_TO_STD * median(&mut deviations);
        let counts = |value: &f64| limit == 0.0 || (value - middle).abs() <= limit;
        let count = values.iter().filter(|value| counts(value)).count() as f64;
        let mean = values.iter().filter(|value| counts(value)).sum::<f64>() / count;
        let squares = values.iter().filter(|value| counts(value)).map(|value| (value - mean).powi(2)).sum();
        Block {
            from_s: self.rows[0].0,
            to_s: self.rows[self.rows.len() - 1].0,
            count,
            mean,
            squares,
            min: values.iter().copied().fold(f64::INFINITY, f64::min),
            max: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            still: self.still,
            starts: self.starts,
        }
    }

    fn halve(&mut self) {
        let mut joined: Vec<Block> = Vec::with_capacity(MOST_BLOCKS);
        let mut odd = false;
        for block in self.blocks.drain(..) {
            match joined.last_mut() {
                Some(last) if odd && !block.starts && block.still == last.still => {
                    last.join(&block);
                    odd = false;
                }
                _ => {
                    joined.push(block);
                    odd = true;
                }
            }
        }
        self.blocks = joined;
    }

    /// All blocks.
    pub fn finish(mut self) -> Vec<Block> {
        self.close();
        self.blocks
    }
}

impl Default for Blocks {
    fn default() -> Self {
        Self::new()
    }
}
