//! Where readings of power come from, and a log in the sensor's place.

use std::path::Path;

use logs::robot::Robot;
use logs::{ColumnRequest, LogReader, POWER, Role, TIME};
use support::context::Context;
use support::error::Result;

/// Column of the voltage at the sensor, V, as `gmr record` writes it.
pub const VOLTAGE: &str = "bus_v";

/// What a sensor says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// What flows through it, W.
    pub power_w: f64,
    /// At it, V; NaN where that is not known.
    pub voltage_v: f64,
}

impl Reading {
    /// A, positive while the battery discharges; none without a voltage.
    pub fn current_a(&self) -> Option<f64> {
        (self.voltage_v > 0.0 && self.power_w.is_finite()).then(|| self.power_w / self.voltage_v)
    }
}

/// Gives readings.
pub trait PowerSource {
    /// Those since the last call, each with its time, s; `now` s have passed since the start. None
    /// while the sensor does not answer.
    ///
    /// # Errors
    /// There will be no more.
    fn take(&mut self, now: f64) -> Result<Vec<(f64, Reading)>>;

    /// Why there is no power though some of it comes, where that is known.
    fn missing(&self, _: f64) -> Option<String> {
        None
    }

    /// What went wrong so far, how often.
    fn faults(&self) -> Vec<(&'static str, u64)> {
        Vec::new()
    }

    /// All has been read.
    fn is_over(&self) -> bool {
        false
    }
}

/// Power of a log, at the times that the log has it.
pub struct LoggedPower {
    reader: LogReader,
    start_s: f64,
    ahead: Option<(f64, Reading)>,
}

impl LoggedPower {
    /// Of a log in any format.
    ///
    /// # Errors
    /// It cannot be read, or has no power.
    pub fn open(context: &Context, log: &Path, robot: &Robot) -> Result<Self> {
        let requests = [
            ColumnRequest::required(TIME, Role::Time),
            ColumnRequest::required(POWER, Role::Number),
            ColumnRequest::optional(VOLTAGE, Role::MaybeNumber),
        ];
        let scales = vec![1.0, robot.log_units().power_in_w(), 1.0];
        let reader = LogReader::open(context, log, &requests)?.scaled(scales);
        let mut log = Self { reader, start_s: 0.0, ahead: None };
        log.ahead = log.next()?;
        log.start_s = log.ahead.map_or(0.0, |(time, _)| time);
        Ok(log)
    }

    fn next(&mut self) -> Result<Option<(f64, Reading)>> {
        let mut row = [0.0; 3];
        let [time_s, power_w, voltage_v] = match self.reader.next_row(&mut row)? {
            None => return Ok(None),
            Some(_) => row,
        };
        Ok(Some((time_s, Reading { power_w, voltage_v })))
    }
}

impl PowerSource for LoggedPower {
    fn take(&mut self, now: f64) -> Result<Vec<(f64, Reading)>> {
        let mut due = Vec::new();
        while let Some((time, reading)) = self.ahead
            && time - self.start_s <= now
        {
            due.push((time - self.start_s, reading));
            self.ahead = self.next()?;
        }
        Ok(due)
    }

    fn is_over(&self) -> bool {
        self.ahead.is_none()
    }
}
