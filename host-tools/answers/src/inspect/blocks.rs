//! Power in blocks of equal length: what segmentation and figures work on. Memory does not grow
//! with the log.

use numerics::robust::MEDIAN_TO_STD;

use super::sketch::median;

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
    /// Stretches of standing, or of moving, that begin in it: 1 or none, more where blocks were
    /// joined over others in between.
    pub stretches: u32,
    /// Time that its rows cover, s; blocks that were joined over others in between cover less than
    /// their ends say.
    pub seconds: f64,
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
        self.seconds += next.seconds;
        self.stretches += next.stretches;
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
            // Where the robot stops and goes all the time, neighbours are of two kinds.
            if 4 * self.blocks.len() > 3 * MOST_BLOCKS {
                self.halve_apart();
            }
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
        let (from_s, to_s) = (self.rows[0].0, self.rows[self.rows.len() - 1].0);
        let last = self.blocks.last();
        let begins = self.starts || last.is_none_or(|last| last.still != self.still);
        Block {
            from_s,
            to_s,
            count,
            mean,
            squares,
            min: values.iter().copied().fold(f64::INFINITY, f64::min),
            max: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            still: self.still,
            starts: self.starts,
            stretches: u32::from(begins),
            seconds: to_s - if begins { from_s } else { last.map_or(from_s, |last| last.to_s) },
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

    /// Joins every second block of a kind with the one of that kind before it, over what lies
    /// between.
    fn halve_apart(&mut self) {
        let mut joined: Vec<Block> = Vec::with_capacity(MOST_BLOCKS);
        // Of moving and of standing: the place of a block that waits for its second.
        let mut waiting = [None; 2];
        for block in self.blocks.drain(..) {
            let place = &mut waiting[usize::from(block.still)];
            match place.take() {
                Some(first) => joined[first as usize].join(&block),
                None => {
                    *place = Some(joined.len() as u32);
                    joined.push(block);
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
