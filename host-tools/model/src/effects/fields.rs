//! An `[[effects]]` entry of a coefficients file while it is read.

use model_core::effects::{Cause, Term};
use serde_json::{Map, Value};

use super::key;

/// Which key cannot be read, what was found and what was expected.
pub(super) type Unread = (&'static str, String);

/// Causes with the coefficient of each, as estimator and board know them.
pub(super) type Read = Result<Vec<(Cause<f64>, f64)>, Unread>;

/// An entry that is being read.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fields<'a> {
    /// Its id.
    pub(super) id: &'a str,
    /// Its coefficient.
    pub(super) coefficient: f64,
    /// Its detail.
    pub(super) detail: &'a Map<String, Value>,
}

impl Fields<'_> {
    pub(super) fn text(&self, key: &str) -> Option<&str> {
        self.detail.get(key).and_then(Value::as_str)
    }

    pub(super) fn flag(&self, key: &str) -> Option<bool> {
        self.detail.get(key).and_then(Value::as_bool)
    }

    pub(super) fn has(&self, key: &str) -> bool {
        self.detail.contains_key(key)
    }

    pub(super) fn list(&self, key: &str) -> Option<Vec<f64>> {
        self.detail.get(key)?.as_array()?.iter().map(Value::as_f64).collect()
    }

    pub(super) fn number(&self, key: &'static str) -> Result<f64, Unread> {
        let number = self.detail.get(key).and_then(Value::as_f64);
        let message = || format!("{} without {key}, or not a number; expected one in `detail`", self.id);
        number.ok_or_else(|| (key, message()))
    }

    /// Static power that the sensor sees as well, W; none where only actuation is measured.
    pub(super) fn static_power(&self) -> f64 {
        self.number(key::WITH_STATIC).unwrap_or(0.0)
    }

    /// The one column that it is, by its coefficient.
    pub(super) fn one(&self, cause: Cause<f64>) -> Read {
        Ok(vec![(cause, self.coefficient)])
    }

    /// The one term that it is.
    pub(super) fn term(&self, term: Term<f64>) -> Read {
        self.one(Cause::Term(term))
    }

    /// That term alone, or with the slip at which 1/√2 of the base's scrub is there.
    pub(super) fn term_with_half_slip(&self, term: Term<f64>) -> Read {
        if self.text(key::WITH) != Some(key::HALF_SLIP) {
            return self.term(term);
        }
        let both = self.list(key::COEFFICIENTS);
        let Some([size, share]) = both.as_deref() else {
            let expected =
                format!("{} with a half slip; expected coefficients = [its own, share] in `detail`", self.id);
            return Err((key::COEFFICIENTS, expected));
        };
        Ok(vec![(Cause::Term(term), *size), (Cause::HalfSlip, *share)])
    }

    /// Refuses an entry that lacks what tells one way from another.
    pub(super) fn unclear<T>(&self, expected: &str) -> Result<T, Unread> {
        Err(("detail", format!("{} without a detail; expected {expected}", self.id)))
    }
}
