//! Where a planned motion comes from, by the columns of its file.

use std::path::{Path, PathBuf};

use logs::{Header, speed_column};
use support::context::Context;
use support::error::{Error, Result};
use support::input::{Input, MOST_PROFILE, text_of};

use super::legs::Leg;

/// A planned motion.
#[derive(Debug, Clone, PartialEq)]
pub enum Plan {
    /// `time_s, v_m_s, omega_rad_s` (`slope_rad`, `leg`): linear between rows.
    Profile(Vec<Row>),
    /// `distance_m, speed_m_s` (`turn_rad`, `slope_rad`, `pause_s`, `leg`), one leg a row.
    Legs(Vec<Leg>),
    /// The wheel speeds of a log, with what it measured.
    Log(PathBuf),
}

/// A row of a profile.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    pub(super) time_s: f64,
    pub(super) speed_m_s: f64,
    pub(super) turn_rad_s: f64,
    pub(super) slope_rad: f64,
    pub(super) leg: String,
}

/// Steps of rows at even times differ by less than this share: such times may be written in
/// milliseconds.
const EVEN: f64 = 0.1;
/// Longer plans are milliseconds taken for seconds.
const LONGEST_S: f64 = 1e6;
/// No slope that wheels climb is steeper, rad.
const STEEPEST_RAD: f64 = 0.8;

impl Plan {
    /// The same with every second row of each leg: what it costs less or more is of the size of
    /// what the rows themselves leave out. None where rows are not at even times: who writes those
    /// means the corners of the motion, and nothing lies between.
    pub(super) fn every_second(&self) -> Option<Self> {
        let Self::Profile(rows) = self else { return None };
        let steps = || rows.iter().zip(&rows[1..]).map(|(from, to)| to.time_s - from.time_s);
        let (least, most) =
            steps().fold((f64::INFINITY, 0.0_f64), |(least, most), step| (least.min(step), most.max(step)));
        if rows.len() < 3 || most - least > EVEN * most {
            return None;
        }
        let mut is_odd = true;
        let mut kept = Vec::new();
        for (place, row) in rows.iter().enumerate() {
            let is_new = place == 0 || rows[place - 1].leg != row.leg;
            is_odd = is_new || !is_odd;
            if is_odd || place + 1 == rows.len() {
                kept.push(row.clone());
            }
        }
        Some(Self::Profile(kept))
    }

    /// Reads a plan.
    ///
    /// # Errors
    /// None of the three kinds; a number that no plan has, with its line and column.
    pub fn read(context: &Context, path: &Path) -> Result<Self> {
        let header = Header::open(context, path)?;
        if header.has(&speed_column(0)) {
            return Ok(Self::Log(path.to_owned()));
        }
        let columns = header.columns().to_vec();
        let text = text_of(Input::open(context, path)?, path, MOST_PROFILE)?;
        let table = Table { path, columns: &columns, text: &text };
        if header.has("distance_m") {
            return table.legs().map(Self::Legs);
        }
        if header.has("v_m_s") {
            return table.profile().map(Self::Profile);
        }
        let message = format!(
            "has the columns {}; expected a plan: time_s, v_m_s, omega_rad_s, or distance_m, speed_m_s, or a log with wheel speeds",
            columns.join(", ")
        );
        Err(Error::failed(message).in_file(path).at_line(1))
    }
}

/// A file whose columns are known.
struct Table<'a> {
    path: &'a Path,
    columns: &'a [String],
    text: &'a str,
}

/// A row of it.
struct Fields<'a> {
    table: &'a Table<'a>,
    line: u64,
    cells: Vec<&'a str>,
}

impl Table<'_> {
    fn rows(&self) -> impl Iterator<Item = Fields<'_>> {
        let lines = self.text.lines().enumerate().skip(1).filter(|(_, line)| !line.trim().is_empty());
        lines.map(|(index, line)| Fields {
            table: self,
            line: index as u64 + 1,
            cells: line.split(',').map(str::trim).collect(),
        })
    }

    fn profile(&self) -> Result<Vec<Row>> {
        let mut rows: Vec<Row> = Vec::new();
        for fields in self.rows() {
            let last = rows.last().map_or(f64::NEG_INFINITY, |row| row.time_s);
            let is_next = |time: f64| time > last && (0.0..=LONGEST_S).contains(&time);
            rows.push(Row {
                time_s: fields.number("time_s", "seconds from 0, ascending, 1e6 at most", is_next)?,
                speed_m_s: fields.number("v_m_s", "-100 to 100", |v| v.abs() <= 100.0)?,
                turn_rad_s: fields.number("omega_rad_s", "-100 to 100", |w| w.abs() <= 100.0)?,
                slope_rad: fields.slope()?,
                leg: fields.name(1),
            });
        }
        self.enough(rows, 2)
    }

    fn legs(&self) -> Result<Vec<Leg>> {
        let mut legs = Vec::new();
        for fields in self.rows() {
            let not_negative = |value: f64| (0.0..=LONGEST_S).contains(&value);
            let distance_m =
                fields.number("distance_m", "metres, backwards below 0", |d| d.abs() <= LONGEST_S)?;
            let moves = distance_m != 0.0;
            legs.push(Leg {
                name: fields.name(legs.len() + 1),
                distance_m,
                speed_m_s: fields.number("speed_m_s", "m/s above 0 where the leg has a distance", |v| {
                    (0.0..=100.0).contains(&v) && (v > 0.0 || !moves)
                })?,
                turn_rad: fields.or_nought("turn_rad", "-1000 to 1000", |turn| turn.abs() <= 1000.0)?,
                slope_rad: fields.slope()?,
                pause_s: fields.or_nought("pause_s", "seconds not below 0", not_negative)?,
            });
        }
        self.enough(legs, 1)
    }

    fn enough<T>(&self, rows: Vec<T>, least: usize) -> Result<Vec<T>> {
        if rows.len() >= least {
            return Ok(rows);
        }
        let message = format!("has {} rows; expected {least} at least", rows.len());
        Err(Error::failed(message).in_file(self.path))
    }
}

impl<'a> Fields<'a> {
    fn cell(&self, column: &str) -> Option<&'a str> {
        let place = self.table.columns.iter().position(|name| name == column)?;
        self.cells.get(place).copied()
    }

    fn number(&self, column: &str, expected: &str, is_one: impl Fn(f64) -> bool) -> Result<f64> {
        let cell = self.cell(column);
        let value = cell.and_then(|cell| cell.parse::<f64>().ok()).filter(|value| is_one(*value));
        value.ok_or_else(|| {
            let cell = cell.map_or("nothing".to_owned(), |cell| format!("{cell:?}"));
            Error::failed(format!("found {cell}; expected {expected}"))
                .in_file(self.table.path)
                .at_line(self.line)
                .in_column(column)
        })
    }

    fn or_nought(&self, column: &str, expected: &str, is_one: impl Fn(f64) -> bool) -> Result<f64> {
        if self.cell(column).is_none_or(str::is_empty) {
            Ok(0.0)
        } else {
            self.number(column, expected, is_one)
        }
    }

    fn slope(&self) -> Result<f64> {
        self.or_nought("slope_rad", "-0.8 to 0.8, uphill positive", |slope| slope.abs() <= STEEPEST_RAD)
    }

    /// As the file says, or this number.
    fn name(&self, number: usize) -> String {
        self.cell("leg").filter(|cell| !cell.is_empty()).map_or_else(|| number.to_string(), str::to_owned)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn profile(rows: &[(f64, &str)]) -> Plan {
        let row = |&(time_s, leg): &(f64, &str)| Row {
            time_s,
            speed_m_s: 0.1,
            turn_rad_s: 0.0,
            slope_rad: 0.0,
            leg: leg.to_owned(),
        };
        Plan::Profile(rows.iter().map(row).collect())
    }

    #[test]
    fn legs_begin_and_end_when_they_did() {
        let rows =
            [(0.0, "a"), (1.0, "a"), (2.0, "a"), (3.0, "a"), (4.0, "b"), (5.0, "b"), (6.0, "b"), (7.0, "b")];
        let kept = [(0.0, "a"), (2.0, "a"), (4.0, "b"), (6.0, "b"), (7.0, "b")];
        assert_eq!(profile(&rows).every_second(), Some(profile(&kept)));
    }

    #[test]
    fn corners_are_no_samples() {
        assert_eq!(profile(&[(0.0, "a"), (2.0, "a"), (5.0, "a")]).every_second(), None);
        assert_eq!(profile(&[(0.0, "a"), (2.0, "a")]).every_second(), None);
    }
}
