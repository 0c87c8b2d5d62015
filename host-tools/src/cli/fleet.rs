//! `gmr fleet`: a folder of logs of many robots, ranked, and what changed on which since when.

use std::path::{Path, PathBuf};

use fleet::{Answer, Exported, Request, fleet};
use logs::arguments::UnitArguments;
use logs::robot::FOUND;
use support::context::Context;
use support::error::Result;
use support::output;

/// Arguments of `gmr fleet`.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  gmr fleet logs/ --coeffs coefficients.toml --out fleet/")]
pub(crate) struct Arguments {
    /// Folder of logs (CSV, Parquet, MCAP, db3, ULog, bag, DataFlash) in folders such as
    /// robot=7/day=2026-11-02, or 7/2026-11-02; with the feature bucket also the URL of a bucket,
    /// s3://bucket/logs
    #[arg(value_name = "SOURCE")]
    source: PathBuf,
    /// Coefficients of a clean fit (signed) of such a robot: what robots and days are held against
    #[arg(long, value_name = "C.toml")]
    coeffs: PathBuf,
    /// The robot that they all are: a robot.toml, or burger, turtlebot4, warthog, husky; auto: the
    /// nearest robot.toml upward, else burger
    #[arg(long, default_value = FOUND)]
    robot: PathBuf,
    /// What folders are called, from the outermost one; robot and day among them
    #[arg(long, value_name = "KEY,…", value_delimiter = ',', default_value = "robot,day")]
    group: Vec<String>,
    /// Where everything goes: grams.jsonl, fleet.html, fleet.json, and what has been read so far. A
    /// second run reads only what is new
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
    /// Total mass of logs without a mass_kg column, kg [default: the robot's mass without payload]
    #[arg(long, value_name = "KG")]
    mass: Option<f64>,
    /// A file for each robot as well, by its own coefficients at the mean of its masses, in
    /// OUT/rmf; how far it is from the last one is said
    #[arg(long, value_enum)]
    export: Option<Export>,
    /// Figures of each robot as well, in Prometheus's text format: for node_exporter's textfile
    /// collector, NAME.prom
    #[arg(long, value_name = "FILE")]
    metrics: Option<PathBuf>,
    /// Figures as JSON on standard output
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    units: UnitArguments,
}

/// In whose words.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum Export {
    /// Open-RMF: mass, friction, inertia and ambient power, as YAML
    Rmf,
}

pub(crate) fn run(context: &Context, arguments: &Arguments) -> Result<()> {
    let (context, robot) = &arguments.units.robot(context, &arguments.robot, [])?;
    let request = Request {
        robot,
        source: &arguments.source,
        coeffs: &arguments.coeffs,
        group: &arguments.group,
        out: &arguments.out,
        mass_kg: arguments.mass.unwrap_or(robot.mass_no_load_kg()),
        rmf: matches!(arguments.export, Some(Export::Rmf)),
        metrics: arguments.metrics.as_deref(),
    };
    if let Some(file) = request.metrics {
        output::folder_of(file)?;
    }
    output::check_apart(request.metrics, [&*arguments.coeffs, &*arguments.robot])?;
    let answer = fleet(context, &request)?;
    if arguments.json {
        return output::print_json(&answer);
    }
    print_text(&answer, &arguments.out);
    Ok(())
}

/// Robots listed on a terminal.
const MOST_SHOWN: usize = 10;

/// Friction that is less off the last file's is not listed, %.
const LEAST_DRIFT_PERCENT: f64 = 1.0;

fn print_text(Answer { report, exported, .. }: &Answer, out: &Path) {
    println!("{}", report.finding);
    let left_out = report.runs.iter().filter(|run| !run.is_used).count();
    println!(
        "{} logs, {} rows; {} runs, {left_out} of them left out",
        report.logs,
        report.rows,
        report.runs.len()
    );
    for change in &report.changes {
        println!("{}", change.sentence());
    }
    if report.changes.is_empty() {
        println!("no change that stands out of how runs differ by chance");
    }
    for (robot, why) in &report.silent {
        println!("{robot}: nothing can be said: {why}");
    }
    for outlier in &report.outliers.robots {
        println!("{}", outlier.sentence());
    }
    for run in &report.disagreements.runs {
        println!("{}", run.sentence());
    }
    for standing in report.robots.iter().take(MOST_SHOWN) {
        let cost = standing.energy_per_metre_j_m.map_or("–".to_owned(), |cost| format!("{cost:.3}"));
        println!(
            "  {:<20} {cost:>9} J/m at {:.2} kg over {:.0} m",
            standing.robot, standing.mean_mass_kg, standing.distance_m
        );
    }
    if let Some(more) = report.robots.len().checked_sub(MOST_SHOWN).filter(|more| *more > 0) {
        println!("  and {more} more, on the page");
    }
    for run in report.runs.iter().filter(|run| !run.is_used) {
        println!("  left out: {}: {}", run.run, run.notes.join("; "));
    }
    let drift = |one: &Exported| one.drift_percent().map_or(0.0, f64::abs);
    let mut moved: Vec<&Exported> = exported.iter().filter(|one| drift(one) >= LEAST_DRIFT_PERCENT).collect();
    moved.sort_by(|a, b| drift(b).total_cmp(&drift(a)));
    for Exported { robot, friction_coefficient, before, .. } in moved.iter().take(MOST_SHOWN) {
        let before = before.unwrap_or(0.0);
        println!(
            "{robot}: friction for Open-RMF is {friction_coefficient:.5}, was {before:.5} when last written"
        );
    }
    if !exported.is_empty() {
        let known = exported.iter().filter(|one| one.before.is_some()).count();
        let last = if known == 0 {
            String::new()
        } else {
            format!("; of {known} that were there {} were {LEAST_DRIFT_PERCENT} % off or more", moved.len())
        };
        println!("wrote {} files for Open-RMF in {}{last}", exported.len(), out.join("rmf").display());
    }
    println!("wrote {}", out.join("fleet.html").display());
}
