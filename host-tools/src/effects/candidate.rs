//! One way in which an effect may show, for those who look for it.

use serde::Serialize;
use serde_json::{Map, Value};

use super::Regressor;

/// One way in which an effect may show.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Its entry's id, or the name that a user gave it.
    pub id: String,
    /// Its columns.
    pub regressors: Vec<Regressor>,
    /// Unit of the coefficients.
    pub unit: String,
    /// The least and greatest value of the first coefficient.
    pub range: (f64, f64),
    /// What is special about it.
    pub detail: Map<String, Value>,
    /// Name of the shape parameter in `detail`, where it may be searched.
    pub shape: Option<&'static str>,
    /// What the search for its shape, times or runs costs, in χ²: the best of many is better than the right one.
    pub search: f64,
}

/// An effect that these runs cannot show, and why.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NotTestable {
    /// Its id.
    pub id: String,
    /// What it needs.
    pub reason: String,
}
