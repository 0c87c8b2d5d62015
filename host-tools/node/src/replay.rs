//! A log in the place of sensor and wheels, at the pace of a clock.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use logs::robot::Robot;
use logs::{Header, SampleReader};
use support::context::Context;
use support::error::Result;

use super::power::VOLTAGE;
use super::{Node, Outlet};

/// Looks at whether it is to end at least so often.
const NAP: Duration = Duration::from_millis(50);

/// Replays rows into `node`, and tells `outlet` every `every_s` of the log. `speed` is relative to
/// the recording; without it the log runs as fast as it goes. Gives whether it came to the end.
///
/// # Errors
/// The log cannot be read, does not fit the coefficients, or nobody takes the states.
pub fn rows(
    context: &Context,
    node: &mut Node<'_>,
    robot: &Robot,
    log: &Path,
    (speed, every_s): (Option<f64>, f64),
    outlet: &mut dyn Outlet,
    stopped: &AtomicBool,
) -> Result<bool> {
    let columns: &[&str] = if Header::open(context, log)?.has(VOLTAGE) { &[VOLTAGE] } else { &[] };
    let mut reader = SampleReader::open_with(context, log, robot, columns)?;
    let period = reader.period_s();
    let began = Instant::now();
    // Time of the log, without what lies between its runs.
    let (mut run, mut passed, mut last, mut told) = (0, 0.0, None::<f64>, 0.0);
    while let Some(row) = reader.next_row()? {
        if row.run == run {
            passed += last.map_or(0.0, |last| row.time - last);
        }
        (run, last) = (row.run, Some(row.time));
        if let Some(speed) = speed {
            let due = Duration::try_from_secs_f64(passed / speed).unwrap_or(Duration::MAX);
            while let Some(wait) = due.checked_sub(began.elapsed()).filter(|wait| !wait.is_zero()) {
                if stopped.load(Ordering::Relaxed) {
                    return Ok(false);
                }
                std::thread::sleep(wait.min(NAP));
            }
        }
        if stopped.load(Ordering::Relaxed) {
            return Ok(false);
        }
        let voltage = reader.extras().first().copied().unwrap_or(f64::NAN);
        node.row(&row, voltage, period)?;
        // Half a period before its time: rows are not exactly at it.
        if passed + 0.5 * period >= told + every_s {
            told += every_s * ((passed + 0.5 * period - told) / every_s).floor();
            outlet.publish(&node.state(row.time))?;
        }
    }
    Ok(true)
}
