//! A log of ten million rows: one simulated drive, over and over.

use std::error::Error;
use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Rows of the log.
pub(crate) const ROWS: usize = 10_000_000;
const RATE_HZ: usize = 200;
/// Rows of the drive that is repeated.
const DRIVE_ROWS: usize = 500_000;

/// Simulates a drive of a servo-driven robot with its sensors, and repeats it with the clock
/// running on.
pub(crate) fn write(folder: &Path) -> Result<PathBuf, Box<dyn Error>> {
    let drive = folder.join("drive.csv");
    let simulated = Command::new(env!("CARGO_BIN_EXE_gmr"))
        .args([
            "simulate",
            "--plant",
            "servo",
            "--sensors",
            "servo",
            "--no-mass",
            "--rate",
            &RATE_HZ.to_string(),
        ])
        .args(["--duration", &(DRIVE_ROWS / RATE_HZ).to_string(), "--out"])
        .arg(&drive)
        .status()?;
    if !simulated.success() {
        return Err("gmr simulate failed".into());
    }
    let mut lines = BufReader::new(File::open(&drive)?).lines();
    let header = lines.next().ok_or("the simulated log is empty")??;
    let mut behind_time = Vec::with_capacity(DRIVE_ROWS);
    for line in lines.take(DRIVE_ROWS) {
        let line = line?;
        behind_time.push(line[line.find(',').ok_or("a row without fields")?..].to_owned());
    }
    let log = folder.join("log.csv");
    let mut out = BufWriter::with_capacity(1 << 20, File::create(&log)?);
    writeln!(out, "{header}")?;
    for row in 0..ROWS {
        let milliseconds = row * 1000 / RATE_HZ;
        let fields = &behind_time[row % behind_time.len()];
        writeln!(out, "{}.{:03}{fields}", milliseconds / 1000, milliseconds % 1000)?;
    }
    out.flush()?;
    println!("{ROWS} rows, {} MB: {header}", std::fs::metadata(&log)?.len() / 1_000_000);
    Ok(log)
}
