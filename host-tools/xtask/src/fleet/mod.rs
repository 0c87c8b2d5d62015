//! `cargo xtask bench fleet`: two hundred simulated robots on five days, three of which change; who
//! is named, how fast, in how much memory, what the same work takes in Polars, NumPy and SciPy, and
//! whether a fleet that is killed ten times comes to the same.

mod baseline;
mod changed;
mod engines;
mod killed;
mod made;
mod measured;

use std::fmt::Write as _;
use std::path::PathBuf;

use self::made::Fleet;
use self::measured::Measured;
use crate::paths::{root, target_folder};
use crate::python;
use crate::set_up::Consent;
use crate::steps::{Steps, Stop, command};
use crate::test_fleet;

/// The table of the large fleet as it is committed.
const TABLE: &str = "docs/results/fleet-bench.txt";

/// The same of engines.
const ENGINES: &str = "docs/results/engines-bench.txt";

/// Of the small fleet that is measured when nobody says how large: CSV, minutes to simulate.
pub(crate) fn run(steps: &mut Steps) -> Result<(), Stop> {
    let gmr = built(steps)?;
    let fleet = Fleet::small();
    steps.work("fleet: simulate", || fleet.simulate(&gmr))?;
    steps.work("fleet: read and judge", || {
        let measured = Measured::of(&gmr, &fleet)?;
        print!("{}", measured.text());
        measured.judge()
    })
}

/// Of a fleet of so many rows, in Parquet; its table is written where it is committed.
pub(crate) fn run_large(rows: usize) -> Result<(), Stop> {
    let mut steps = Steps::default();
    let gmr = built(&mut steps)?;
    // As many runs, of some thousand rows each: memory is flat in rows where it takes no less.
    let (fleet, small) = (Fleet::of(rows), Fleet::small());
    let mut text = String::new();
    steps.work("fleet: simulate", || {
        small.simulate(&gmr)?;
        fleet.simulate(&gmr)
    })?;
    steps.work("fleet: read and judge", || {
        let small = Measured::of(&gmr, &small)?;
        let measured = Measured::of(&gmr, &fleet)?;
        let _ = write!(text, "{}", measured.text());
        let _ = writeln!(
            text,
            "peak memory      {:.0} MB; {:.0} MB with {:.1e} rows in as many runs",
            measured.peak_mb, small.peak_mb, small.rows
        );
        print!("{text}");
        measured.judge()?;
        let _ = writeln!(text, "named            the three robots and days that changed, and no other");
        Ok(())
    })?;
    steps.work("fleet: killed ten times", || {
        let said = killed::ten_times(&gmr, &fleet)?;
        println!("   {said}");
        let _ = writeln!(text, "killed           {said}");
        Ok(())
    })?;
    steps.work("fleet: in Polars, NumPy and SciPy", || {
        let said = baseline::compare(&python::engines()?, &gmr, &fleet)?;
        print!("{said}");
        text.push_str(&said);
        Ok(())
    })?;
    steps.print_summary();
    std::fs::write(root().join(TABLE), text).map_err(|error| Stop::new(format!("{TABLE}: {error}")))
}

/// Rows of the committed table of engines.
const ENGINES_ROWS: usize = 100_000_000;

/// Measures engines on a fleet of so many rows. Its table is committed unless it has fewer rows
/// than the committed one: then start-up is most of what is seen.
pub(crate) fn run_engines(rows: usize) -> Result<(), Stop> {
    let mut steps = Steps::default();
    let python = test_fleet::engines(&mut steps, Consent::Ask)?;
    let (gmr, fleet) = (target_folder().join("release/gmr"), Fleet::of(rows));
    steps.work("fleet: simulate", || fleet.simulate(&gmr))?;
    steps.work("engines", || {
        let text = engines::compare(&python, &gmr, &fleet)?;
        print!("{text}");
        if rows < ENGINES_ROWS {
            return Ok(());
        }
        std::fs::write(root().join(ENGINES), text).map_err(|error| Stop::new(format!("{ENGINES}: {error}")))
    })?;
    steps.print_summary();
    Ok(())
}

fn built(steps: &mut Steps) -> Result<PathBuf, Stop> {
    steps.run("fleet: build", command("cargo build --release --package host-tools --bin gmr"))?;
    Ok(target_folder().join("release/gmr"))
}
