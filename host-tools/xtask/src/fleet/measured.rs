//! `gmr fleet` on the fleet: how fast, in how much memory, where the time went, and who is named.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Stdio;
use std::thread;
use std::time::{Duration, Instant};

use serde_json::Value;

use super::changed::CHANGED;
use super::made::Fleet;
use crate::steps::Stop;

pub(super) struct Measured {
    report: Value,
    pub(super) rows: f64,
    bytes: f64,
    pub(super) seconds: f64,
    /// Of all its threads, by the kernel: what it takes on a machine that others use as well.
    pub(super) cpu_s: f64,
    pub(super) peak_mb: f64,
}

fn failed(error: impl std::fmt::Display) -> Stop {
    Stop::new(error.to_string())
}

/// User and system time of a process, s; the kernel counts in hundredths.
fn processor_s(process: u32) -> Option<f64> {
    let status = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // The name in brackets may hold anything; behind it the state is field 3, the times are 14 and
    // 15.
    let mut times = status.rsplit_once(')')?.1.split_whitespace().skip(11);
    let mut next = || times.next()?.parse::<f64>().ok();
    Some((next()? + next()?) / 100.0)
}

impl Measured {
    /// From nothing.
    pub(super) fn of(gmr: &Path, fleet: &Fleet) -> Result<Self, Stop> {
        let out = fleet.folder.join("out");
        let _ = std::fs::remove_dir_all(&out);
        let said = fleet.folder.join("said.json");
        let started = Instant::now();
        let mut command = fleet.command(gmr, &out);
        command.arg("--json").stdout(Stdio::from(std::fs::File::create(&said).map_err(failed)?));
        let mut child = command.spawn().map_err(failed)?;
        let (mut peak_kb, mut cpu_s) = (0, 0.0);
        let status = loop {
            // What the kernel calls the high-water mark; the last look is at most 5 ms before the
            // end.
            let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
            let mark = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
            let kb = mark.and_then(|mark| mark.split_whitespace().next()?.parse::<u64>().ok());
            peak_kb = peak_kb.max(kb.unwrap_or(0));
            cpu_s = processor_s(child.id()).unwrap_or(cpu_s);
            if let Some(status) = child.try_wait().map_err(failed)? {
                break status;
            }
            thread::sleep(Duration::from_millis(5));
        };
        let seconds = started.elapsed().as_secs_f64();
        if !status.success() {
            return Err(Stop::new(format!("gmr fleet: {status}")));
        }
        let text = std::fs::read_to_string(&said).map_err(failed)?;
        let report: Value = serde_json::from_str(&text).map_err(failed)?;
        let rows = report["rows"].as_f64().unwrap_or(0.0);
        Ok(Self { report, rows, bytes: fleet.bytes() as f64, seconds, cpu_s, peak_mb: peak_kb as f64 / 1e3 })
    }

    pub(super) fn text(&self) -> String {
        let mut text = String::new();
        let of = |key: &str| self.report["seconds"][key].as_f64().unwrap_or(f64::NAN);
        let _ = writeln!(
            text,
            "gmr fleet        {:.3e} rows, {:.0} MB in {:.1} s: {:.2e} rows/s, {:.0} MB/s; {:.1} s of processor, {:.2} µs a row; at most {:.0} MB of \
             memory",
            self.rows,
            self.bytes / 1e6,
            self.seconds,
            self.rows / self.seconds,
            self.bytes / 1e6 / self.seconds,
            self.cpu_s,
            1e6 * self.cpu_s / self.rows,
            self.peak_mb
        );
        let _ = writeln!(
            text,
            "where it went    on both cores together: reading {:.1} s, filter {:.1} s, sums {:.1} s; all logs {:.1} s; then sums collected \
             {:.2} s, judged {:.2} s, page and figures {:.2} s",
            of("reading_s"),
            of("filter_s"),
            of("sums_s"),
            of("all_logs_s"),
            of("sums_kept_s"),
            of("judging_s"),
            of("page_s")
        );
        text
    }

    /// Holds what is named against what is true.
    pub(super) fn judge(&self) -> Result<(), Stop> {
        let text = |one: &Value, key: &str| one[key].as_str().unwrap_or("").to_owned();
        let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
        let changes: Vec<(String, String, String)> = list(&self.report["changes"])
            .iter()
            .map(|change| (text(change, "robot"), text(change, "since"), text(change, "coefficient")))
            .collect();
        let mut missed = Vec::new();
        for (robot, day, effect, names) in CHANGED {
            let (robot, since) = (format!("{robot:03}"), format!("2026-11-{day:02}"));
            let is_named =
                changes.iter().any(|one| one.0 == robot && one.1 == since && names.contains(&one.2.as_str()));
            if !is_named {
                missed.push(format!("{effect} of robot {robot} since {since}"));
            }
        }
        let truly = |robot: &str| CHANGED.iter().any(|change| format!("{:03}", change.0) == robot);
        let wrong: Vec<_> = changes.iter().filter(|one| !truly(&one.0)).collect();
        let outliers: Vec<String> =
            list(&self.report["outliers"]["found"]).iter().map(|one| text(one, "robot")).collect();
        let disagreeing: Vec<String> =
            list(&self.report["disagreements"]["found"]).iter().map(|one| text(one, "run")).collect();
        let is_of_changed =
            |run: &String| CHANGED.iter().any(|one| run.contains(&format!("robot={:03}/", one.0)));
        let strangers: Vec<&String> = disagreeing.iter().filter(|run| !is_of_changed(run)).collect();
        println!(
            "   robots unlike the others: {outliers:?}; runs that disagree: {} of the three robots, {} of others",
            disagreeing.len() - strangers.len(),
            strangers.len()
        );
        if missed.is_empty() && wrong.is_empty() && outliers.is_empty() && strangers.is_empty() {
            println!("   the three robots and days are named, no other is");
            return Ok(());
        }
        Err(Stop::new(format!(
            "not named: {missed:?}; named without a change: {wrong:?}; unlike the others: {outliers:?}; runs of others that disagree: \
             {strangers:?}; all: {changes:?}"
        )))
    }
}
