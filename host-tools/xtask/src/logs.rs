//! `cargo xtask bench logs`: how fast each format is read, and in how much memory, for a gigabyte of CSV and the same rows in other formats.

use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use crate::paths::target_folder;
use crate::steps::{Steps, Stop, command};

/// Bytes of the CSV.
const SIZE: u64 = 1_000_000_000;
/// No command may take more while it reads them, MB.
const MOST_MB: f64 = 300.0;

/// Writes the CSV where it is not there yet, has it converted, and reads each.
pub(crate) fn run(steps: &mut Steps) -> Result<(), Stop> {
    steps.run("logs: build", command("cargo build --quiet --release --package host-tools --bin gmr"))?;
    let folder = target_folder().join("bench-logs");
    std::fs::create_dir_all(&folder).map_err(|error| Stop::new(error.to_string()))?;
    let csv = folder.join("log.csv");
    if !csv.exists() {
        steps.work("logs: write", || write(&csv))?;
    }
    let mut peak = 0.0_f64;
    for ending in ["csv", "mcap", "parquet"] {
        let log = folder.join("log").with_extension(ending);
        if !log.exists() {
            let mut convert = gmr(&["convert", "--robot", "burger", "--out"]);
            convert.arg(&log).arg(&csv);
            peak = peak.max(timed(steps, &format!("convert to {ending}"), convert, &csv)?);
        }
        let mut inspect = gmr(&["inspect", "--robot", "burger"]);
        inspect.arg(&log);
        peak = peak.max(timed(steps, &format!("inspect {ending}"), inspect, &log)?);
    }
    if peak <= MOST_MB {
        return Ok(());
    }
    Err(Stop::new(format!("{peak:.0} MB of memory; expected {MOST_MB} MB at most")))
}

fn gmr(arguments: &[&str]) -> Command {
    let mut gmr = Command::new(target_folder().join("release/gmr"));
    gmr.args(arguments).stdout(Stdio::null());
    gmr
}

/// Two wheels, power and mass at 200 Hz, with digits as a recorder's.
fn write(csv: &Path) -> Result<(), Stop> {
    let failed = |error: std::io::Error| Stop::new(error.to_string());
    let unfinished: PathBuf = csv.with_extension("part");
    let mut to = BufWriter::new(std::fs::File::create(&unfinished).map_err(failed)?);
    to.write_all(b"time_s,wheel1_rad_s,wheel2_rad_s,power_w,mass_kg\n").map_err(failed)?;
    let (mut bytes, mut row) = (0, 0_u64);
    while bytes < SIZE {
        let time = row as f64 * 0.005;
        let (left, right) = (5.0 + (0.7 * time).sin(), 5.0 + (0.9 * time).cos());
        let line = format!("{time:.6},{left:.7},{right:.7},{:.6},3\n", 2.0 + 0.4 * left + 0.3 * right);
        to.write_all(line.as_bytes()).map_err(failed)?;
        bytes += line.len() as u64;
        row += 1;
    }
    to.flush().map_err(failed)?;
    std::fs::rename(&unfinished, csv).map_err(failed)
}

/// Runs a command that reads a log, and prints its rate. Gives its greatest memory, MB.
fn timed(steps: &mut Steps, name: &str, mut command: Command, log: &Path) -> Result<f64, Stop> {
    let mut peak_kb = 0;
    let bytes = std::fs::metadata(log).map_or(0, |found| found.len());
    steps.work(name, || {
        let started = Instant::now();
        let mut child = command.spawn().map_err(|error| Stop::new(error.to_string()))?;
        let status = loop {
            // What the kernel calls the high-water mark; the last look is at most 5 ms before the end.
            let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
            let mark = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
            let kb = mark.and_then(|mark| mark.split_whitespace().next()?.parse::<u64>().ok());
            peak_kb = peak_kb.max(kb.unwrap_or(0));
            if let Some(status) = child.try_wait().map_err(|error| Stop::new(error.to_string()))? {
                break status;
            }
            thread::sleep(Duration::from_millis(5));
        };
        let seconds = started.elapsed().as_secs_f64();
        let mb = bytes as f64 / 1e6;
        println!(
            "   {name}: {mb:.0} MB in {seconds:.1} s, {:.0} MB/s, {:.0} MB of memory",
            mb / seconds,
            peak_kb as f64 / 1e3
        );
        if status.success() { Ok(()) } else { Err(Stop::new(format!("{name}: {status}"))) }
    })?;
    Ok(peak_kb as f64 / 1e3)
}
