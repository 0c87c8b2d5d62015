//! A run as sums.

use std::collections::BTreeMap;

use model_core::eq18::REGRESSORS;
use serde::{Deserialize, Serialize};
use support::error::{Error, Result};

use super::local::Local;
use super::polynomial::PRODUCTS;
use super::summary::Summary;
use crate::gram::Gram;

/// Of the lines.
pub const FORMAT: u32 = 1;

/// How rows were read: sums of different settings do not add up.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Setting {
    /// Name of the robot.
    pub robot: String,
    /// Wheels.
    pub wheels: usize,
    /// Power taken off, W.
    pub static_power_w: f64,
    /// Of the filter.
    pub filter_cutoff_hz: f64,
    /// Of the power after the speeds, s.
    pub power_delay_s: f64,
    /// Slip memory: half slip, and relaxation in rad; 0 where there is none.
    pub slip: [f64; 2],
    /// Checksum of the coefficients that `local` is about; none without.
    pub reference: Option<String>,
}

/// What a run says of every model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunGram {
    /// [`FORMAT`].
    pub format: u32,
    /// Its log, and its name there where the log holds several.
    pub run: String,
    /// What it is grouped by: robot, day …
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub keys: BTreeMap<String, String>,
    /// How its rows were read.
    pub setting: Setting,
    /// What it was.
    pub summary: Summary,
    /// Eq. 18 as corrected, of all rows.
    pub eq18: Gram<REGRESSORS>,
    /// Eq. 18 as printed, of all rows.
    pub eq18_published: Gram<REGRESSORS>,
    /// The signed model, of rows in which no wheel can be clamped, nor could within the filter's
    /// memory before.
    pub signed: Gram<PRODUCTS>,
    /// The other rows: the signed model needs them one by one.
    pub may_clamp: u64,
    /// The signed model near known coefficients, of all rows; none without.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub local: Option<Local>,
}

impl RunGram {
    /// Adds the sums of the other.
    ///
    /// # Errors
    /// They were read with other settings.
    pub fn merge(&mut self, other: &Self) -> Result<()> {
        if self.setting != other.setting {
            let message = format!(
                "{}: read with other settings than {} ({:?}; {:?}); expected grams of one robot, filter and reference: make them with one \
                 gmr gram, or with the same --cutoff or --coeffs",
                other.run, self.run, other.setting, self.setting
            );
            return Err(Error::failed(message));
        }
        self.summary.merge(&other.summary);
        self.eq18.merge(&other.eq18);
        self.eq18_published.merge(&other.eq18_published);
        self.signed.merge(&other.signed);
        self.may_clamp += other.may_clamp;
        match (&mut self.local, &other.local) {
            (Some(local), Some(other)) => local.merge(other),
            (_, None) => {}
            (None, Some(_)) => self.local.clone_from(&other.local),
        }
        Ok(())
    }

    /// Of no row, with all that a run may have.
    pub fn blank() -> Self {
        Self {
            format: FORMAT,
            run: String::new(),
            keys: BTreeMap::new(),
            setting: Setting::default(),
            summary: Summary::new(0.0, 0.0, true),
            eq18: Gram::default(),
            eq18_published: Gram::default(),
            signed: Gram::default(),
            may_clamp: 0,
            local: Some(Local::default()),
        }
    }

    /// As a line of a file.
    ///
    /// # Errors
    /// It cannot be written down.
    pub fn line(&self) -> Result<String> {
        serde_json::to_string(self).map_err(|error| Error::failed(error.to_string()))
    }
}

/// All of them as one.
///
/// # Errors
/// None is given; settings differ.
pub fn total(grams: &[RunGram]) -> Result<RunGram> {
    let (first, rest) = grams.split_first().ok_or_else(|| Error::failed("no gram; expected one at least"))?;
    rest.iter().try_fold(first.clone(), |mut sum, gram| sum.merge(gram).map(|()| sum))
}
