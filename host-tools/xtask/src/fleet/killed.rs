//! A fleet that is killed at ten random moments, and resumed: the bytes of one that nobody
//! disturbed.

use std::path::Path;
use std::process::Stdio;
use std::thread;
use std::time::{Duration, Instant};

use super::made::Fleet;
use crate::steps::Stop;

const TIMES: u32 = 10;

/// What is compared.
const OUTPUTS: [&str; 3] = ["grams.jsonl", "fleet.html", "fleet.json"];

/// Kills and resumes; what was left by [`super::measured`] is the undisturbed one.
pub(super) fn ten_times(gmr: &Path, fleet: &Fleet) -> Result<String, Stop> {
    let failed = |error: std::io::Error| Stop::new(error.to_string());
    let (undisturbed, out) = (fleet.folder.join("out"), fleet.folder.join("out-killed"));
    let _ = std::fs::remove_dir_all(&out);
    let started = Instant::now();
    // One file a log, besides those that a kill left half-written.
    let whole = std::fs::read_dir(undisturbed.join("read")).map_err(failed)?.count();
    let mut moments = Random(0x9e37_79b9_7f4a_7c15);
    let mut at = Vec::new();
    for _ in 0..TIMES {
        let mut child =
            fleet.command(gmr, &out).stdout(Stdio::null()).stderr(Stdio::null()).spawn().map_err(failed)?;
        let share = moments.next();
        let begun = read(&out);
        // At a random moment of the next sixth of the logs, the file system's half-written files
        // included.
        let goal = begun + (share * whole as f64 / 6.0) as usize;
        while read(&out) < goal && child.try_wait().map_err(failed)?.is_none() {
            thread::sleep(Duration::from_micros(200 + (800.0 * share) as u64));
        }
        child.kill().map_err(failed)?;
        if child.wait().map_err(failed)?.success() {
            return Err(Stop::new("a run was over before it was killed: the fleet is too small"));
        }
        at.push(read(&out));
    }
    let status = fleet.command(gmr, &out).stdout(Stdio::null()).status().map_err(failed)?;
    if !status.success() {
        return Err(Stop::new(format!("the last run: {status}")));
    }
    for name in OUTPUTS {
        let of = |folder: &Path| std::fs::read(folder.join(name)).map_err(failed);
        if of(&undisturbed)? != of(&out)? {
            return Err(Stop::new(format!("{name} differs from that of a run that nobody disturbed")));
        }
    }
    let _ = std::fs::remove_dir_all(&out);
    let at: Vec<String> = at.iter().map(usize::to_string).collect();
    Ok(format!(
        "{TIMES} times (SIGKILL) with {} of {whole} logs read, and resumed: the same bytes; {:.1} s in all",
        at.join(", "),
        started.elapsed().as_secs_f64()
    ))
}

/// Logs that have been read.
fn read(out: &Path) -> usize {
    std::fs::read_dir(out.join("read")).map_or(0, Iterator::count)
}

/// Marsaglia's xorshift: moments that are the same each time.
struct Random(u64);

impl Random {
    /// From 0 to 1.
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}
