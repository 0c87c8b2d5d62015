//! `gmr inspect`: what a log is worth before anything is fitted.

use std::path::PathBuf;

use answers::inspect::{Moving, Report, Severity, StaticState};
use logs::robot::FOUND;
use support::error::Result;
use support::output;
use support::own::Form;
use support::progress::FileProgress;

use super::overwrite::OverwriteArgument;
use super::units::UnitArguments;

/// Arguments of `gmr inspect`.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  gmr inspect --robot robot.toml run.csv\n  gmr inspect bag.mcap --plot bag.png"
)]
pub(crate) struct Arguments {
    /// Robot: a built-in name (burger, turtlebot4, warthog, husky) or a robot.toml; auto: the nearest robot.toml upward, else burger
    #[arg(long, value_name = "R.toml", default_value = FOUND)]
    robot: PathBuf,
    /// Answer as JSON
    #[arg(long)]
    json: bool,
    /// Draw static power and its states into this file
    #[arg(long, value_name = "FILE.svg|png")]
    plot: Option<PathBuf>,
    /// The log
    #[arg(value_name = "RUN.csv")]
    run: PathBuf,
    #[command(flatten)]
    units: UnitArguments,
    #[command(flatten)]
    overwrite: OverwriteArgument,
}

pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    if let Some(file) = &arguments.plot {
        report::check_extension(file)?;
    }
    output::check_apart(arguments.plot.as_deref(), [&arguments.run, &arguments.robot].map(PathBuf::as_path))?;
    arguments.overwrite.check(&arguments.plot, Form::Drawing)?;
    let robot = arguments.units.robot(&arguments.robot)?;
    let mut progress = FileProgress::new(std::slice::from_ref(&arguments.run));
    let report = Report::of(&arguments.run, &robot, |read, size| progress.at((read, size)))?;
    progress.finish();
    if let Some(file) = &arguments.plot {
        report.save_figure(file)?;
    }
    if arguments.json {
        return output::print_json(&report);
    }
    output::print(format_args!("{}", summary(&report)));
    Ok(())
}

/// One screen for people.
fn summary(report: &Report) -> String {
    let mut lines = vec![
        format!("{} ({}): {}", report.log, report.robot, report.verdict),
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
    ];
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
    lines.push("Findings:".to_owned());
    for finding in &report.findings {
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
    if report.findings.is_empty() {
        lines.push("  nothing to complain about".to_owned());
    }
    lines.join("\n") + "\n"
}
