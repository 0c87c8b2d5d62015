//! Payload schedule: the total mass over time.

use support::error::{Error, Result};

/// Total mass, robot and payload, as steps in time.
#[derive(Debug, Clone, PartialEq)]
pub struct PayloadSchedule {
    /// (from s, kg), the first at 0, times ascending.
    steps: Vec<(f64, f64)>,
}

impl PayloadSchedule {
    /// The same mass throughout, kg.
    pub fn constant(mass_kg: f64) -> Self {
        Self { steps: vec![(0.0, mass_kg)] }
    }

    /// Steps of (from s, kg).
    ///
    /// # Errors
    /// Usage: no step, the first not at 0 s, times not ascending, a mass that is not positive and
    /// finite.
    pub fn steps(steps: Vec<(f64, f64)>) -> Result<Self> {
        let allowed =
            "allowed: KG or KG@SECONDS,KG@SECONDS,… with positive masses, the first at 0, times ascending";
        if steps.first().is_none_or(|&(from, _)| from != 0.0) {
            return Err(Error::usage(format!("the mass at 0 s is missing; {allowed}")));
        }
        if let Some((from, mass)) = steps.iter().find(|(_, mass)| !(mass.is_finite() && *mass > 0.0)) {
            return Err(Error::usage(format!("mass {mass} kg at {from} s; {allowed}")));
        }
        if let Some(pair) = steps.windows(2).find(|pair| !(pair[1].0.is_finite() && pair[1].0 > pair[0].0)) {
            return Err(Error::usage(format!(
                "mass step at {} s after {} s; {allowed}",
                pair[1].0, pair[0].0
            )));
        }
        Ok(Self { steps })
    }

    /// Reads `1@0,6@100` (1 kg from 0 s, 6 kg from 100 s) or a single mass.
    ///
    /// # Errors
    /// Usage, naming the part that cannot be read and what is allowed.
    pub fn parse(text: &str) -> Result<Self> {
        let number = |step: &str, digits: &str| {
            digits.trim().parse::<f64>().map_err(|_| {
                Error::usage(format!("mass `{step}` in `{text}`; allowed: KG or KG@SECONDS,KG@SECONDS,…"))
            })
        };
        let steps = text
            .split(',')
            .map(|step| {
                let (mass, from) = step.split_once('@').unwrap_or((step, "0"));
                Ok((number(step, from)?, number(step, mass)?))
            })
            .collect::<Result<Vec<_>>>()?;
        Self::steps(steps)
    }

    /// The least mass of the schedule, kg.
    pub(super) fn least_kg(&self) -> f64 {
        self.steps.iter().map(|&(_, mass)| mass).fold(f64::INFINITY, f64::min)
    }

    /// Total mass, kg, at a time, s.
    pub fn mass_at(&self, time_s: f64) -> f64 {
        // Half a nanosecond of slack: the step belongs to the sample at its very time despite
        // rounding.
        let after = self.steps.partition_point(|&(from, _)| from <= time_s + 0.5e-9);
        self.steps[after.max(1) - 1].1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_schedule_steps_at_its_times() {
        let schedule = PayloadSchedule::parse("1@0,6@100").unwrap();
        assert_eq!([0.0, 99.999, 100.0, 500.0].map(|t| schedule.mass_at(t)), [1.0, 1.0, 6.0, 6.0]);
        assert_eq!(PayloadSchedule::parse("2.5").unwrap(), PayloadSchedule::constant(2.5));
    }

    #[test]
    fn a_malformed_schedule_names_what_is_allowed() {
        for text in
            ["", "x", "1@", "1@5", "1@0,2@0", "1@0,2@-1", "-1", "0", "nan", "inf", "1@0,,2@3", "1@0,2@nan"]
        {
            let error = PayloadSchedule::parse(text).unwrap_err();
            assert_eq!(error.exit_code(), 2, "{text}");
            assert!(error.to_string().contains("allowed: KG"), "{text}: {error}");
        }
    }
}
