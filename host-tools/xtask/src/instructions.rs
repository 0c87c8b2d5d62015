//! `cargo xtask bench instructions`: what a sample costs on the board's core, counted on the
//! emulated one.

use std::process::Command;

use crate::set_up::{self, Consent, TARGET, TargetCargo};
use crate::steps::{Steps, Stop, command_line};

/// Most instructions that a sample may take in the median, and most that one may take which closes
/// a second.
const GOAL: Counts = Counts { median: 235, closing: 1_200 };
/// What hand-written C takes for the same way of a sample, without the change detector.
const C: Counts = Counts { median: 174, closing: 764 };

/// An instruction takes 1,024 ns of the emulator's time: the image counts by that
/// (tests/images/counting/counter.rs).
const EMULATOR: &str = "qemu-system-arm -cpu cortex-m7 -machine mps2-an500 -nographic -icount shift=10 \
                        -semihosting-config enable=on,target=native -kernel";

struct Counts {
    median: u32,
    closing: u32,
}

/// One line of the image's figures.
#[derive(Debug, PartialEq, Eq)]
struct Measured {
    what: String,
    median: u32,
    p95: u32,
    closing_median: u32,
    closing_worst: u32,
    worst: u32,
}

impl Measured {
    /// From `cost: NAME, B buckets: median 1 p95 1 closing 1 closing-worst 1 worst 1`; `None` for
    /// other lines.
    fn from_line(line: &str) -> Option<Self> {
        let (what, figures) = line.strip_prefix("cost: ")?.rsplit_once(": ")?;
        let words: Vec<&str> = figures.split_whitespace().collect();
        let figure = |name| {
            let at = words.iter().position(|word| *word == name)?;
            words.get(at + 1)?.parse().ok()
        };
        Some(Self {
            what: what.to_owned(),
            median: figure("median")?,
            p95: figure("p95")?,
            closing_median: figure("closing")?,
            closing_worst: figure("closing-worst")?,
            worst: figure("worst")?,
        })
    }

    /// As the committed file has it.
    fn to_line(&self) -> String {
        let Self { what, median, p95, closing_median, closing_worst, worst } = self;
        format!(
            "{what}: median {median} p95 {p95} closing {closing_median} closing-worst {closing_worst} worst {worst}"
        )
    }

    fn reaches_the_goal(&self) -> bool {
        self.median <= GOAL.median && self.closing_worst <= GOAL.closing
    }
}

/// Builds the image, runs it and prints its figures beside the goal. Fails where one is missed.
pub(crate) fn run(steps: &mut Steps) -> Result<(), Stop> {
    let mut target = None;
    steps.work("set-up", || {
        target = Some(set_up::target()?);
        set_up::qemu(Consent::Ask)
    })?;
    let target: TargetCargo = target.ok_or_else(|| Stop::new("no target"))?;
    steps.run(
        "build the counting image",
        target.command(&format!("build --release --package on-target-tests --bin cost --target {TARGET}")),
    )?;
    steps.work("instructions", count)
}

fn count() -> Result<(), Stop> {
    let image = crate::paths::target_folder().join(TARGET).join("release/cost");
    no_heap(&image)?;
    let mut words = EMULATOR.split_whitespace();
    let mut emulator = Command::new(words.next().unwrap_or_default());
    emulator.args(words).arg(&image);
    let line = command_line(&emulator);
    println!("   {line}");
    let output = emulator.output().map_err(|error| Stop::new(format!("{line}\n   {error}")))?;
    let said = String::from_utf8_lossy(&output.stdout);
    let measured: Vec<Measured> = said.lines().filter_map(Measured::from_line).collect();
    if !output.status.success() || measured.is_empty() {
        return Err(Stop::new(format!("{line}\n   {}\n{said}", output.status)));
    }
    print_table(&measured);
    said.lines().filter_map(|line| line.strip_prefix("once: ")).for_each(|line| println!("{line}"));
    compare_with_committed(&measured)?;
    let missed = measured.iter().filter(|figures| !figures.reaches_the_goal()).count();
    if missed == 0 { Ok(()) } else { Err(Stop::new(format!("the goal is missed {missed} times"))) }
}

fn print_table(measured: &[Measured]) {
    println!("\nInstructions, not cycles: the emulator has no caches and no flash wait states. No heap.\n");
    println!("{:34} | per sample: median, p95 | closing a second: median, worst | worst of all", "");
    for figures in measured {
        let Measured { what, median, p95, closing_median, closing_worst, worst } = figures;
        let verdict = if figures.reaches_the_goal() { "" } else { "  misses the goal" };
        println!(
            "{what:34} | {median:18} {p95:5} | {closing_median:23} {closing_worst:7} | {worst:12}{verdict}"
        );
    }
    for (what, counts) in [("goal, at most", GOAL), ("C, without the change detector", C)] {
        println!("{what:34} | {:18} {:5} | {:23} {:7} |", counts.median, "", "", counts.closing);
    }
}

/// Figures that other parts of the project reckon with, of the workspace's directory.
const COMMITTED: &str = "docs/results/instructions.txt";

/// Lines of that file that are no figures.
const HEAD: &str = "\
# Instructions a sample takes on the board's core, as `cargo xtask bench instructions` counts them on the emulated one.
# The bench says where it finds otherwise; GMR_BLESS=1 writes this file anew. `gmr reproduce` reckons with it.
";

/// Says which figures are not the committed ones, or commits these. Another compiler may well find
/// others: that is no failure.
fn compare_with_committed(measured: &[Measured]) -> Result<(), Stop> {
    let file = crate::paths::root().join(COMMITTED);
    let refused = |error: std::io::Error| Stop::new(format!("{COMMITTED}: {error}"));
    if std::env::var_os("GMR_BLESS").is_some() {
        let lines: String = measured.iter().map(|figures| figures.to_line() + "\n").collect();
        return std::fs::write(file, format!("{HEAD}{lines}")).map_err(refused);
    }
    for line in differing(&std::fs::read_to_string(file).map_err(refused)?, measured) {
        println!("{line}");
    }
    Ok(())
}

/// What is found otherwise than in the file `text`.
fn differing(text: &str, measured: &[Measured]) -> Vec<String> {
    let committed: Vec<&str> = text.lines().filter(|line| !line.starts_with('#')).collect();
    let lines: Vec<String> = measured.iter().map(Measured::to_line).collect();
    let new = lines.iter().filter(|line| !committed.contains(&line.as_str()));
    let old = committed.iter().filter(|line| !lines.iter().any(|now| now == *line));
    old.map(|line| format!("not found again: {line}"))
        .chain(new.map(|line| format!("found instead:   {line}")))
        .collect()
}

/// An image with an allocator has the functions that call it.
fn no_heap(image: &std::path::Path) -> Result<(), Stop> {
    let bytes = std::fs::read(image).map_err(|error| Stop::new(format!("{}: {error}", image.display())))?;
    let allocation = b"__rust_alloc";
    if bytes.windows(allocation.len()).any(|window| window == allocation) {
        return Err(Stop::new(format!("{} allocates", image.display())));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{HEAD, Measured, differing};

    #[test]
    fn reads_the_figures() {
        let line = "cost: signed window, 32 buckets: median 1 p95 2 closing 3 closing-worst 4 worst 5";
        let figures = Measured::from_line(line).expect("figures");
        assert_eq!(figures.what, "signed window, 32 buckets");
        assert_eq!([figures.median, figures.p95, figures.closing_median], [1, 2, 3]);
        assert_eq!([figures.closing_worst, figures.worst], [4, 5]);
        assert_eq!(Measured::from_line("    at the end 4.4 … 4.5 kg"), None);
    }

    #[test]
    fn what_differs_from_the_committed_figures_is_said() {
        let line = "cost: eq18 roots, 32 buckets: median 1 p95 2 closing 3 closing-worst 4 worst 5";
        let figures = [Measured::from_line(line).expect("figures")];
        let committed = format!("{HEAD}{}\n", figures[0].to_line());
        assert_eq!(differing(&committed, &figures), [""; 0]);
        let other = committed.replace("median 1", "median 9");
        assert_eq!(
            differing(&other, &figures),
            [
                "not found again: eq18 roots, 32 buckets: median 9 p95 2 closing 3 closing-worst 4 worst 5",
                "found instead:   eq18 roots, 32 buckets: median 1 p95 2 closing 3 closing-worst 4 worst 5",
            ]
        );
    }
}
