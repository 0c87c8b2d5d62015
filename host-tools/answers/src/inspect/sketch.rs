//! Quantiles of a stream in constant memory.

use numerics::robust;

/// Counts of magnitudes in bins 1/32 of an octave wide: quantiles within 1.6 %.
pub(super) struct Sketch {
    bins: Vec<u64>,
    count: u64,
}

/// Exponent and five bits of the mantissa.
const SHIFT: u32 = 47;
const BINS: usize = 1 << (63 - SHIFT);

impl Sketch {
    pub(super) fn new() -> Self {
        Self { bins: vec![0; BINS], count: 0 }
    }

    pub(super) fn add(&mut self, value: f64) {
        self.bins[(value.abs().to_bits() >> SHIFT) as usize] += 1;
        self.count += 1;
    }

    pub(super) fn count(&self) -> u64 {
        self.count
    }

    /// The magnitude below which a share of all lies; 0 without values.
    pub(super) fn quantile(&self, share: f64) -> f64 {
        let rank = (share * self.count as f64).ceil().max(1.0) as u64;
        let mut below = 0;
        for (bin, count) in self.bins.iter().enumerate() {
            below += count;
            if below >= rank {
                let (low, high) = bounds(bin);
                return if bin == 0 { 0.0 } else { 0.5 * (low + high) };
            }
        }
        0.0
    }

    /// How many magnitudes are above `limit`, to the width of a bin.
    pub(super) fn above(&self, limit: f64) -> u64 {
        let first = (limit.abs().to_bits() >> SHIFT) as usize + 1;
        self.bins[first.min(BINS)..].iter().sum()
    }
}

fn bounds(bin: usize) -> (f64, f64) {
    (f64::from_bits((bin as u64) << SHIFT), f64::from_bits((bin as u64 + 1) << SHIFT))
}

/// Median of some values, which it reorders; 0 without values.
pub(super) fn median(values: &mut [f64]) -> f64 {
    robust::median(values).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_within_a_bin() {
        let mut sketch = Sketch::new();
        for k in 1..=1000 {
            sketch.add(f64::from(k) * if k % 2 == 0 { 0.01 } else { -0.01 });
        }
        for share in [0.1, 0.5, 0.99] {
            assert!((sketch.quantile(share) / (10.0 * share) - 1.0).abs() < 0.032);
        }
        assert!(sketch.above(9.0).abs_diff(100) <= 32);
    }

    #[test]
    fn median_of_even_and_odd() {
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&mut [4.0, 1.0, 2.0, 3.0]), 2.5);
        assert_eq!(median(&mut []), 0.0);
    }
}
