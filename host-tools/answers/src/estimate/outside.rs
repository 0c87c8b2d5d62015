//! The columns of a log that effects need beside speeds and power.

use std::path::Path;

use logs::Header;
use model::effects::written::id_of;
use model::effects::{PITCH, PROCESSOR};
use model_core::coefficients::Coefficients;
use model_core::effects::live::Outside;
use support::context::Context;
use support::error::{Error, Result};

/// Names of the columns, and what they are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Columns<const N: usize> {
    names: Vec<String>,
    pitch: bool,
    temperatures: bool,
    driver: bool,
}

impl<const N: usize> Columns<N> {
    /// Those that the effects of these coefficients need.
    ///
    /// # Errors
    /// The log lacks one.
    pub(super) fn of(context: &Context, coefficients: &Coefficients<f64, N>, log: &Path) -> Result<Self> {
        let needs = coefficients.columns.needs();
        let mut names = Vec::new();
        if needs.pitch {
            names.push(PITCH.to_owned());
        }
        if needs.temperatures {
            names.extend((1..=N).map(|wheel| format!("motor{wheel}_temp_c")));
        }
        if needs.driver {
            names.push(PROCESSOR.to_owned());
        }
        let found =
            Self { names, pitch: needs.pitch, temperatures: needs.temperatures, driver: needs.driver };
        if needs.nothing() {
            return Ok(found);
        }
        let header = Header::open(context, log)?;
        match found.names.iter().find(|name| !header.has(name)) {
            None => Ok(found),
            Some(missing) => {
                let ids: Vec<&str> = coefficients
                    .columns
                    .iter()
                    .filter(|column| !column.cause.needs().nothing())
                    .map(|column| id_of(&column.cause).0)
                    .collect();
                Err(Error::failed(format!(
                    "no such column; expected one, for the coefficients' effect {} needs it",
                    ids.join(" or ")
                ))
                .in_file(log)
                .in_column(missing))
            }
        }
    }

    /// To be asked for.
    pub(super) fn names(&self) -> Vec<&str> {
        self.names.iter().map(String::as_str).collect()
    }

    /// What they hold in one row, in the order of the names.
    pub(super) fn outside(&self, values: &[f64]) -> Outside<f64, N> {
        let mut values = values.iter().copied();
        let mut next = |is_there: bool| if is_there { values.next().unwrap_or(f64::NAN) } else { f64::NAN };
        Outside {
            pitch: next(self.pitch),
            temperature: std::array::from_fn(|_| next(self.temperatures)),
            driver: next(self.driver),
        }
    }
}
