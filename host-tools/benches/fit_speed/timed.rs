//! A program's wall time and peak memory.

use std::error::Error;
use std::io::Read;
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

pub(crate) struct Timed {
    pub(crate) seconds: f64,
    /// Peak resident memory, MB: what the kernel last said, within [`POLL`]; NaN where there is no
    /// /proc.
    pub(crate) memory_mb: f64,
    pub(crate) output: String,
}

/// How often memory is asked for. The kernel keeps the peak itself, so that only the last interval
/// can be missed.
const POLL: Duration = Duration::from_millis(5);

/// Runs a program to its end.
pub(crate) fn run(command: &mut Command) -> Result<Timed, Box<dyn Error>> {
    let started = Instant::now();
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn()?;
    let status = format!("/proc/{}/status", child.id());
    let ended = AtomicBool::new(false);
    let mut output = String::new();
    let (read, success, seconds, memory_mb) = thread::scope(|scope| {
        let watch = scope.spawn(|| {
            let mut peak = f64::NAN;
            while !ended.load(Ordering::Relaxed) {
                peak = peak.max(high_water_mark(&status).unwrap_or(f64::NAN));
                thread::sleep(POLL);
            }
            peak
        });
        let read = child.stdout.take().map_or(Ok(0), |mut out| out.read_to_string(&mut output));
        let success = child.wait().map(|status| status.success());
        let seconds = started.elapsed().as_secs_f64();
        ended.store(true, Ordering::Relaxed);
        (read, success, seconds, watch.join().unwrap_or(f64::NAN))
    });
    read?;
    if success? {
        Ok(Timed { seconds, memory_mb, output })
    } else {
        Err(format!("failed: {command:?}").into())
    }
}

/// `VmHWM` of a process, MB.
fn high_water_mark(status: &str) -> Option<f64> {
    let text = std::fs::read_to_string(status).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kilobytes / 1024.0)
}

pub(crate) fn median(runs: &[Timed]) -> f64 {
    let mut seconds: Vec<f64> = runs.iter().map(|run| run.seconds).collect();
    seconds.sort_by(f64::total_cmp);
    seconds[seconds.len() / 2]
}

/// Median and extremes of the time, and the most memory.
pub(crate) fn summary(runs: &[Timed]) -> String {
    let seconds = || runs.iter().map(|run| run.seconds);
    let memory = runs.iter().map(|run| run.memory_mb).fold(f64::NAN, f64::max);
    format!(
        "{:6.2} s ({:.2} … {:.2}), {memory:.0} MB",
        median(runs),
        seconds().fold(f64::INFINITY, f64::min),
        seconds().fold(0.0, f64::max)
    )
}
