//! `cargo xtask size`: what the images need of the board's memories, against limits.

mod image;
mod panics;
mod stack;

use std::process::Command;

use crate::images::{self, OPENCR, VIRTUAL};
use crate::set_up::{self, TargetCargo};
use crate::steps::{Stop, command_line};
use image::Usage;
use panics::Sites;
use stack::Depth;

/// Of the 768 KiB that the application has: sectors 5 to 7, none of which is the store's.
const MOST_FLASH: u64 = 230 * KIB;
/// Of 256 KiB.
const MOST_RAM: u64 = 88 * KIB;
const KIB: u64 = 1024;

/// The board's image, which has limits, and the emulator's.
const IMAGES: [&str; 2] = [OPENCR, VIRTUAL];

/// What is known of an image.
struct Report {
    name: &'static str,
    usage: Usage,
    /// Where it could be measured.
    stack: Option<Depth>,
    /// Calls of the panic machinery, of the board's image.
    panics: Vec<Sites>,
}

impl Report {
    fn is_within(&self) -> bool {
        self.name != OPENCR || (self.usage.flash <= MOST_FLASH && self.usage.ram <= MOST_RAM)
    }

    /// Whether of every place that may panic it is said why it does not.
    fn is_argued(&self) -> bool {
        self.panics.iter().all(|sites| sites.why.is_some())
    }
}

/// True when the board's image is within the limits, and every place that may panic has a reason
/// why it does not.
pub(crate) fn run(as_json: bool) -> bool {
    match IMAGES.into_iter().map(report).collect::<Result<Vec<_>, _>>() {
        Ok(reports) => {
            print!("{}", if as_json { json(&reports) } else { table(&reports) });
            reports.iter().all(|report| report.is_within() && report.is_argued())
        }
        Err(stop) => {
            eprintln!("size: {stop}");
            false
        }
    }
}

fn report(name: &'static str) -> Result<Report, Stop> {
    let target = set_up::target()?;
    build(&target, name)?;
    let path = images::path(name);
    let elf = std::fs::read(&path).map_err(|error| Stop::new(format!("{}: {error}", path.display())))?;
    let usage = image::usage(&elf).map_err(|error| Stop::new(format!("{}: {error}", path.display())))?;
    let stack = if name == OPENCR { stack::measure(&path)? } else { None };
    let panics = if name == OPENCR { panics::sites(&elf)? } else { Vec::new() };
    Ok(Report { name, usage, stack, panics })
}

/// Standard output is for the figures: cargo's own goes to standard error.
fn build(target: &TargetCargo, name: &str) -> Result<(), Stop> {
    let mut command: Command = target.command(&format!("{} --quiet", images::build(name)));
    let line = command_line(&command);
    let status = command.current_dir(crate::paths::root()).status();
    match status {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(Stop::new(format!("{line}\n   {status}"))),
        Err(error) => Err(Stop::new(format!("{line}\n   {error}"))),
    }
}

fn table(reports: &[Report]) -> String {
    let mut text = format!(
        "image    flash, KiB  of {}  static RAM, KiB  of {}   worst stack, B\n",
        MOST_FLASH / KIB,
        MOST_RAM / KIB
    );
    for Report { name, usage, stack, .. } in reports {
        let stack = stack.map_or("-".to_owned(), |depth| depth.bytes.to_string());
        let share = |bytes: u64, whole: u64| 100.0 * bytes as f64 / whole as f64;
        text += &format!(
            "{name:8} {:10.1} {:6.1} % {:15.1} {:5.1} % {stack:>16}\n",
            usage.flash as f64 / KIB as f64,
            share(usage.flash, MOST_FLASH),
            usage.ram as f64 / KIB as f64,
            share(usage.ram, MOST_RAM),
        );
    }
    text += &match reports.iter().find_map(|report| report.stack) {
        Some(depth) => format!(
            "\nStack: painted at start, deepest use in {} s in the emulated STM32F746: four sensors, two servos, a host\n\
             that uploads coefficients and reads every record. It has 65536 B to itself (DTCM); an overflow leaves mapped memory and faults.\n",
            depth.seconds
        ),
        None => "\nStack: not measured, the emulated STM32F746 is not here (docs/board.md).\n".to_owned(),
    };
    for report in reports.iter().filter(|report| !report.is_within()) {
        text += &format!("\n{}: more than the limit\n", report.name);
    }
    for Report { name, panics, .. } in reports.iter().filter(|report| !report.panics.is_empty()) {
        text += &format!("\n{name}: calls of the panic machinery, and why none is reached\n");
        for Sites { place, kind, count, why } in panics {
            let why = why.unwrap_or("NOBODY HAS SAID WHY NOT");
            text += &format!("{count:5} {kind:9} {place:42} {why}\n");
        }
    }
    text
}

fn json(reports: &[Report]) -> String {
    let image = |Report { name, usage, stack, panics }: &Report| {
        let stack = stack.map_or("null".to_owned(), |depth| depth.bytes.to_string());
        format!(
            "{{\"name\":\"{name}\",\"flash_bytes\":{},\"ram_bytes\":{},\"stack_bytes\":{stack},\"panic_calls\":{},\"panic_calls_unexplained\":{}}}",
            usage.flash,
            usage.ram,
            panics.iter().map(|sites| sites.count).sum::<usize>(),
            panics.iter().filter(|sites| sites.why.is_none()).map(|sites| sites.count).sum::<usize>(),
        )
    };
    format!(
        "{{\"limits\":{{\"flash_bytes\":{MOST_FLASH},\"ram_bytes\":{MOST_RAM}}},\"images\":[{}]}}\n",
        reports.iter().map(image).collect::<Vec<_>>().join(",")
    )
}
