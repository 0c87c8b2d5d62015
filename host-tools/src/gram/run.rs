//! A run as sums, and files of them: JSON, a run a line.

use std::collections::BTreeMap;
use std::io::{BufRead as _, BufReader};
use std::path::Path;

use model_core::eq18::REGRESSORS;
use serde::{Deserialize, Serialize};

use super::local::Local;
use super::polynomial::PRODUCTS;
use super::summary::Summary;
use crate::error::{Error, Result};
use crate::fit::gram::Gram;
use crate::input::Input;
use crate::output::write_whole;

/// Of the lines.
pub const FORMAT: u32 = 1;

/// How rows were read: sums of different settings do not add up.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
    /// Of the power behind the speeds, s.
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
    /// The signed model, of rows in which no wheel can be clamped, nor could within the filter's memory before.
    pub signed: Gram<PRODUCTS>,
    /// The other rows: the signed model needs them one by one.
    pub may_clamp: u64,
    /// The signed model near known coefficients, of all rows; none without.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub local: Option<Local>,
}

impl RunGram {
    /// Adds another's sums.
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

    fn line(&self) -> Result<String> {
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

/// Writes them, whole or not at all.
///
/// # Errors
/// What the operating system refuses.
pub fn write_all(file: &Path, grams: &[RunGram]) -> Result<()> {
    write_whole(file, |out| {
        for gram in grams {
            let line = gram.line()?;
            out.write_all(line.as_bytes())
                .and_then(|()| out.write_all(b"\n"))
                .map_err(|error| Error::io(file, &error))?;
        }
        Ok(())
    })
}

/// Bytes of a line, at most: a gram has some 15 thousand.
const MOST_LINE: u64 = 1 << 20;

/// Reads them.
///
/// # Errors
/// A line that is no gram of this format: names it.
pub fn read_all(file: &Path) -> Result<Vec<RunGram>> {
    let mut text = BufReader::new(Input::open(file)?);
    let mut grams = Vec::new();
    for number in 1.. {
        let mut line = String::new();
        let wrong = |message: String| Error::failed(message).in_file(file).at_line(number);
        let length = std::io::Read::take(&mut text, MOST_LINE)
            .read_line(&mut line)
            .map_err(|error| wrong(format!("{error}; expected grams: a JSON object a line")))?;
        if length == 0 {
            break;
        }
        let format = serde_json::from_str::<serde_json::Value>(&line)
            .ok()
            .and_then(|gram| gram.get("format")?.as_u64());
        if let Some(other) = format.filter(|format| *format != u64::from(FORMAT)) {
            return Err(wrong(format!(
                "format {other}; expected {FORMAT}: make the grams again with this gmr gram"
            )));
        }
        let gram: RunGram = serde_json::from_str(&line)
            .map_err(|error| wrong(format!("is no gram ({error}); expected what gmr gram writes")))?;
        if gram.local.as_ref().is_some_and(|local| !local.is_whole()) {
            return Err(wrong("local has another number of sums; expected what gmr gram writes".to_owned()));
        }
        grams.push(gram);
    }
    if grams.is_empty() {
        return Err(Error::failed("is empty; expected grams: a JSON object a line").in_file(file));
    }
    Ok(grams)
}
