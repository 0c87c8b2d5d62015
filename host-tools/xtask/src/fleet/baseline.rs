//! The same work in Polars, NumPy and SciPy: host-tools/benches/fleet/baseline.py on the same
//! files, in turn with `gmr fleet`.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

use super::made::Fleet;
use super::measured::Measured;
use crate::paths::root;
use crate::robots::text_of;
use crate::steps::Stop;

const SCRIPT: &str = "host-tools/benches/fleet/baseline.py";

/// All sums that `gmr fleet` makes, then those of Eq. 18 and of its drift alone. `gmr fleet` runs
/// before and after them, since the machine changes from minute to minute.
pub(super) fn compare(python: &Path, gmr: &Path, fleet: &Fleet) -> Result<String, Stop> {
    let script = |rest: &[&str]| -> Result<Value, Stop> {
        let mut command = Command::new(python);
        command.arg(root().join(SCRIPT)).arg(fleet.logs()).arg(fleet.coefficients()).args(rest);
        serde_json::from_str(&text_of(command)?).map_err(|error| Stop::new(error.to_string()))
    };
    let before = Measured::of(gmr, fleet)?;
    let all = script(&[])?;
    let between = Measured::of(gmr, fleet)?;
    let lean = script(&["--lean"])?;
    let behind = Measured::of(gmr, fleet)?;
    let check = difference(&all, gmr, fleet)?;
    let mut text = String::new();
    let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
    let rows = [("all its sums", &all, [&before, &between]), ("lean", &lean, [&between, &behind])];
    for (name, polars, ours) in rows {
        let mean = |of: &dyn Fn(&Measured) -> f64| 0.5 * (of(ours[0]) + of(ours[1]));
        let (seconds, cpu_s) = (number(&polars["seconds"]), number(&polars["cpu_s"]));
        let of = |key: &str| number(&polars["spent"][key]);
        let _ = writeln!(
            text,
            "Polars, {name:<12} {seconds:.1} s, {cpu_s:.1} s of processor, {:.2e} rows/s, {:.0} MB (reading {:.1} s, filter {:.1} s, sums {:.1} \
             s, solving {:.2} s): gmr fleet took {:.1} and {:.1} s before and after, {:.1} times as fast; of processor {:.1} times",
            number(&polars["rows"]) / seconds,
            number(&polars["peak_mb"]),
            of("reading_s"),
            of("filter_s"),
            of("sums_s"),
            of("solving_s"),
            ours[0].seconds,
            ours[1].seconds,
            seconds / mean(&|one| one.seconds),
            cpu_s / mean(&|one| one.cpu_s)
        );
    }
    let _ = writeln!(
        text,
        "same sums         Eq. 18 from both differs by {check:.1e} of its greatest coefficient"
    );
    Ok(text)
}

/// How far both are apart in Eq. 18, of its greatest coefficient.
fn difference(polars: &Value, gmr: &Path, fleet: &Fleet) -> Result<f64, Stop> {
    let mut fit = Command::new(gmr);
    fit.args(["fit", "--json", "--model", "eq18", "--grams"]).arg(fleet.folder.join("out/grams.jsonl"));
    let report: Value = serde_json::from_str(&text_of(fit)?).map_err(|error| Stop::new(error.to_string()))?;
    let numbers = |list: &Value, of: &dyn Fn(&Value) -> Option<f64>| -> Vec<f64> {
        list.as_array().into_iter().flatten().filter_map(of).collect()
    };
    let ours = numbers(&report["parameters"], &|one| one["value"].as_f64());
    let theirs = numbers(&polars["eq18"], &Value::as_f64);
    if ours.len() != theirs.len() || ours.is_empty() {
        return Err(Stop::new(format!("{} and {} coefficients", ours.len(), theirs.len())));
    }
    let most = ours.iter().fold(0.0_f64, |most, one| most.max(one.abs()));
    Ok(ours.iter().zip(&theirs).map(|(a, b)| (a - b).abs() / most).fold(0.0, f64::max))
}
