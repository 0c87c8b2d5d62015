//! The columns of a log that effects need beside speeds and power.

use std::path::Path;

use logs::Header;
use model::coefficients::FittedModel;
use model::effects::written::id_of;
use model::effects::{PITCH, PROCESSOR};
use model::pipeline::Beside;
use support::context::Context;
use support::error::{Error, Result};

/// Names of the columns, and what they are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Columns {
    names: Vec<String>,
    pitch: bool,
    /// How many wheels have a temperature.
    temperatures: usize,
    driver: bool,
}

impl Columns {
    /// Those that the effects of these coefficients need.
    ///
    /// # Errors
    /// The log lacks one.
    pub(super) fn of(context: &Context, coefficients: &FittedModel, log: &Path) -> Result<Self> {
        let needs = coefficients.columns.needs();
        let mut names = Vec::new();
        if needs.pitch {
            names.push(PITCH.to_owned());
        }
        let temperatures = if needs.temperatures { coefficients.robot.wheels() } else { 0 };
        names.extend((1..=temperatures).map(|wheel| format!("motor{wheel}_temp_c")));
        if needs.driver {
            names.push(PROCESSOR.to_owned());
        }
        let columns = Self { names, pitch: needs.pitch, temperatures, driver: needs.driver };
        if needs.nothing() {
            return Ok(columns);
        }
        let header = Header::open(context, log)?;
        match columns.names.iter().find(|name| !header.has(name)) {
            None => Ok(columns),
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
    pub(super) fn beside(&self, values: &[f64]) -> Beside {
        let mut values = values.iter().copied();
        let mut next = |is_there: bool| if is_there { values.next().unwrap_or(f64::NAN) } else { f64::NAN };
        Beside {
            pitch: next(self.pitch),
            temperature: std::array::from_fn(|wheel| next(wheel < self.temperatures)),
            driver: next(self.driver),
        }
    }
}
