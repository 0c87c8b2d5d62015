//! `gmr inspect`: what a log is worth before anything is fitted.

use std::path::PathBuf;

use answers::inspect::{Moving, Report, Severity, StaticState, Use};
use logs::arguments::{Log, UnitArguments, paths};
use logs::checks;
use logs::robot::FOUND;
use residuals::thresholds::calibrate::LEAST_RUNS;
use support::context::Context;
use support::error::{Error, Result};
use support::output;
use support::overwrite::Form;
use support::progress::FileProgress;

use super::look::Several;
use super::overwrite::OverwriteArgument;

/// Arguments of `gmr inspect`.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  gmr inspect --robot robot.toml run.csv\n  gmr inspect empty.mcap=1.0 full.mcap=6.0\n  gmr inspect bag.mcap --plot bag.png"
)]
pub(crate) struct Arguments {
    /// Robot: a built-in name (burger, turtlebot4, warthog, husky) or a robot.toml; auto: the
    /// nearest robot.toml upward, else burger
    #[arg(long, value_name = "R.toml", default_value = FOUND)]
    robot: PathBuf,
    /// Answer as JSON: an object of one log, a list of several
    #[arg(long)]
    json: bool,
    /// Draw static power and its states into this file; of one log
    #[arg(long, value_name = "FILE.svg|png")]
    plot: Option<PathBuf>,
    /// The logs, with the total mass behind the name where they do not hold it
    #[arg(value_name = "LOG[=KG]", required = true)]
    runs: Vec<Log>,
    #[command(flatten)]
    units: UnitArguments,
    #[command(flatten)]
    overwrite: OverwriteArgument,
}

pub(crate) fn run(context: &Context, arguments: &Arguments) -> Result<()> {
    if let Some(file) = &arguments.plot {
        report::check_extension(file)?;
        if arguments.runs.len() > 1 {
            return Err(Error::usage(format!("--plot with {} logs: expected one", arguments.runs.len())));
        }
    }
    let logs = paths(&arguments.runs);
    let inputs = logs.iter().chain([&arguments.robot]).map(PathBuf::as_path);
    output::check_apart(arguments.plot.as_deref(), inputs)?;
    arguments.overwrite.check(&arguments.plot, Form::Drawing)?;
    checks::each_once(&logs, &[])?;
    let (context, robot) = &arguments.units.robot(context, &arguments.robot, &arguments.runs)?;
    let mut progress = FileProgress::new(context, &logs);
    let reports =
        logs.iter().map(|log| Report::of(context, log, robot, &mut |read, size| progress.at((read, size))));
    let reports = reports.collect::<Result<Vec<_>>>()?;
    progress.finish();
    let [only] = &reports[..] else {
        if arguments.json {
            return output::print_json(&Several { logs: &reports });
        }
        println!("{}", answer(&reports));
        for report in &reports {
            println!("{}: {}", report.log, report.verdict);
        }
        if arguments.units.verbose {
            reports.iter().for_each(|report| println!("\n{}", summary(report, true).trim_end()));
        }
        return Ok(());
    };
    if let Some(file) = &arguments.plot {
        only.save_figure(file)?;
    }
    if arguments.json {
        return output::print_json(only);
    }
    output::print(format_args!("{}", summary(only, arguments.units.verbose)));
    Ok(())
}

/// What several logs are good for together.
fn answer(reports: &[Report]) -> String {
    let ready: Vec<&Report> = reports.iter().filter(|report| report.verdict.fit_for == Use::Fit).collect();
    if let Some(first) = reports.iter().find(|report| report.verdict.fit_for != Use::Fit) {
        let (ready, all) = (ready.len(), reports.len());
        let why = &first.verdict.verdict;
        return format!("NOT READY: {ready} of {all} logs are ready for gmr fit; {}: {why}", first.log);
    }
    let mut masses: Vec<f64> = ready
        .iter()
        .filter_map(|report| report.excitation.as_ref())
        .flat_map(|drive| drive.payloads.iter().map(|payload| payload.mass_kg))
        .collect();
    masses.sort_by(f64::total_cmp);
    masses.dedup();
    let kg: Vec<String> = masses.iter().map(f64::to_string).collect();
    let kg = kg.join(", ");
    if masses.len() < 2 {
        return format!(
            "READY for gmr fit of power, not of payload: all at {kg} kg; add a drive at another mass"
        );
    }
    let further = match LEAST_RUNS.saturating_sub(ready.len()) {
        0 => " and gmr gap".to_owned(),
        missing => format!("; for gmr gap record {missing} more clean runs"),
    };
    format!("READY for gmr fit: {} runs at {kg} kg{further}", ready.len())
}

/// The answer and what is wrong; all there is to know where that is asked for.
fn summary(report: &Report, verbose: bool) -> String {
    let mut lines = vec![format!("{} ({}): {}", report.log, report.robot, report.verdict)];
    if verbose {
        details(report, &mut lines);
    }
    for finding in report.findings.iter().filter(|finding| verbose || finding.severity != Severity::Note) {
        let severity = match finding.severity {
            Severity::Problem => "problem",
            Severity::Warning => "warning",
            Severity::Note => "note   ",
        };
        lines.push(format!("  {severity}  {}", finding.text));
        if !finding.advice.is_empty() {
            lines.push(format!("           → {}", finding.advice));
        }
    }
    lines.join("\n") + "\n"
}

/// Sampling, drive and static power.
fn details(report: &Report, lines: &mut Vec<String>) {
    lines.extend([
        format!(
            "  {} rows in {:.1} s at {}, steps {:.4} to {:.4} s (std {:.4} s), {} gap(s)",
            report.rows,
            report.duration_s,
            report.rate_hz.map_or("no rate".to_owned(), |rate| format!("{rate:.1} Hz")),
            report.timing.jitter.min_s,
            report.timing.jitter.max_s,
            report.timing.jitter.std_s,
            report.timing.gap_count
        ),
        format!("  {}", report.exclusions),
    ]);
    if let Some(drive) = &report.excitation {
        let percent = |share: f64| format!("{:.0} %", 100.0 * share);
        let [slow, usual, fast] = drive.speed_quantiles_rad_s;
        lines.push(format!(
            "  moving {} of the time; of that straight {}, turning {}, accelerating {}",
            percent(drive.share_moving),
            percent(drive.share_straight),
            percent(drive.share_turning),
            percent(drive.share_accelerating)
        ));
        lines.push(format!(
            "  wheel speed {slow:.2} … {usual:.2} … {fast:.2} rad/s (5, 50, 95 %), acceleration {:.2} … {:.2} rad/s² \
             (50, 95 %)",
            drive.acceleration_quantiles_rad_s2[0], drive.acceleration_quantiles_rad_s2[1]
        ));
        if !drive.payloads.is_empty() {
            const SHOWN: usize = 6;
            let masses = drive.payloads.iter().take(SHOWN);
            let masses: Vec<_> = masses
                .map(|payload| format!("{} kg ({})", payload.mass_kg, percent(payload.share)))
                .collect();
            let more = if drive.payloads.len() > SHOWN { ", …" } else { "" };
            lines.push(format!("  total mass {}{more}", masses.join(", ")));
        }
    }
    lines.push(String::new());
    lines.push(format!("Static power, standstill told from {}:", report.standstill_from));
    let state = |state: &StaticState, what: &str| {
        format!(
            "  {:8.3} W ± {:.3} W (mean ± {:.3} W), {:5.1} % of samples, {:.0} s in {} stretch(es){what}",
            state.mean_w,
            state.std_w,
            state.std_err_w,
            100.0 * state.share,
            state.dwell_s,
            state.stretches
        )
    };
    for standing in &report.static_states {
        let what = match standing.moving {
            Moving::Unknown => ", perhaps moving",
            _ if standing.is_offset() => ", an offset of the sensor",
            _ => "",
        };
        lines.push(state(standing, what));
    }
    for moving in &report.moving_levels {
        lines.push(state(moving, ", probably motion"));
    }
    if report.static_states.is_empty() && report.moving_levels.is_empty() {
        lines.push("  none found".to_owned());
    }
    lines.push(String::new());
}
