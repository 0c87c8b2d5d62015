//! Instructions that a sample takes on the board's core, as `cargo xtask bench instructions` counts them.

use serde::Serialize;

use crate::error::{Error, Result};

/// What the bench has found, committed: it says where it finds otherwise.
const COUNTED: &str = include_str!("../../../../docs/instructions.txt");

/// Instructions of one estimator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Of a sample, the median.
    pub sample: u32,
    /// Of a sample that closes a bucket of one second, the median.
    pub closing: u32,
}

impl Counts {
    /// Of the estimator that the bench calls `name`, such as `signed window, 32 buckets`.
    ///
    /// # Errors
    /// The bench's file does not name it, or not in full.
    pub fn of(name: &str) -> Result<Self> {
        Self::read(COUNTED, name)
    }

    fn read(text: &str, name: &str) -> Result<Self> {
        let line = text.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(": "));
        let words: Vec<&str> = line.unwrap_or_default().split_whitespace().collect();
        let figure = |what: &str| {
            let at = words.iter().position(|word| *word == what)?;
            words.get(at + 1)?.parse().ok()
        };
        match (figure("median"), figure("closing")) {
            (Some(sample), Some(closing)) => Ok(Self { sample, closing }),
            _ => Err(Error::failed(format!(
                "docs/instructions.txt: no counts of `{name}`; expected a line `{name}: median … closing …`"
            ))),
        }
    }

    /// Instructions a sample on average, at `rate_hz` samples a second of which one closes a bucket.
    pub fn per_sample(&self, rate_hz: f64) -> f64 {
        let sample = f64::from(self.sample);
        sample + (f64::from(self.closing) - sample) / rate_hz
    }
}

#[cfg(test)]
mod tests {
    use super::Counts;

    const TEXT: &str = "# what\nsigned window, 32 buckets: median 100 p95 2 closing 300 closing-worst 4 worst 5\nother: median 7\n";

    #[test]
    fn reads_the_benchs_lines() {
        let counts = Counts::read(TEXT, "signed window, 32 buckets").unwrap();
        assert_eq!(counts, Counts { sample: 100, closing: 300 });
        // 100 + 200 ∕ 200 samples.
        assert_eq!(counts.per_sample(200.0), 101.0);
    }

    #[test]
    fn what_is_not_there_is_named() {
        for name in ["other", "signed window"] {
            let error = Counts::read(TEXT, name).unwrap_err().to_string();
            assert!(error.contains(&format!("`{name}`")), "{error}");
        }
    }
}
