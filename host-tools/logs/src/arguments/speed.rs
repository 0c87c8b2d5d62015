//! How fast something runs that could run in real time.

use support::error::{Error, Result};

/// How many times as fast as real time; none: as fast as it goes.
///
/// # Errors
/// Neither a number from 0.001 to 1e6 nor `max`.
pub fn times_real_time(written: &str) -> Result<Option<f64>> {
    if written == "max" {
        return Ok(None);
    }
    match written.parse() {
        Ok(speed) if (1e-3..=1e6).contains(&speed) => Ok(Some(speed)),
        _ => {
            let message = format!("--speed {written}: allowed: times real time, 0.001 to 1e6, or max");
            Err(Error::usage(message))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_max() {
        assert_eq!(times_real_time("max").unwrap(), None);
        assert_eq!(times_real_time("2.5").unwrap(), Some(2.5));
        for wrong in ["0", "-1", "1e7", "nan", "fast", ""] {
            let error = times_real_time(wrong).unwrap_err().to_string();
            assert!(error.contains("0.001 to 1e6, or max"), "{error}");
        }
    }
}
