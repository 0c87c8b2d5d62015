//! A recording as MCAP: the recorder's lines become messages in JSON, which PlotJuggler and
//! Foxglove open without ROS.

use std::io::{Seek, Write};

use log_formats::write::Mcap;
use support::error::{Error, Result};

use super::lines::{cells, names};

/// Takes the recorder's lines. The file is whole once it was [finished](Self::finish); otherwise it
/// is read up to the break with `--allow-truncated`.
pub struct McapLines<W: Write + Seek> {
    /// Until the header has come.
    to: Option<W>,
    writer: Option<Mcap<W>>,
}

fn failed(error: &log_formats::Error) -> Error {
    Error::failed(error.to_string())
}

impl<W: Write + Seek> McapLines<W> {
    /// Of a file that holds nothing yet.
    pub fn new(to: W) -> Self {
        Self { to: Some(to), writer: None }
    }

    /// Whole lines, the first one ever being the header.
    ///
    /// # Errors
    /// What cannot be written; a header without time.
    pub fn append(&mut self, lines: &str) -> Result<()> {
        let mut lines = lines.lines();
        if let Some(to) = self.to.take() {
            let names = names(lines.next().unwrap_or(""));
            let is_text = vec![false; names.len()];
            self.writer = Some(Mcap::new(to, &names, &is_text).map_err(|error| failed(&error))?);
        }
        let Some(writer) = &mut self.writer else { return Ok(()) };
        for line in lines {
            writer.row(&cells(line)).map_err(|error| failed(&error))?;
        }
        Ok(())
    }

    /// Writes what a whole file ends with.
    ///
    /// # Errors
    /// What cannot be written.
    pub fn finish(self) -> Result<()> {
        self.writer.map_or(Ok(()), |writer| writer.finish().map_err(|error| failed(&error)))
    }
}
