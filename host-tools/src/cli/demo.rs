//! `gmr demo`: the main job from a log to a payload and to a name for what changed, on a robot and
//! logs of its own, on one page.

use std::io::IsTerminal as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;

use maud::{Markup, PreEscaped, html};

use super::overwrite::OverwriteArgument;
use report::html::{WHOLE, document, least_width};
use support::error::{Error, Result};
use support::job::{self, Job};
use support::output;
use support::overwrite::Form;

/// Arguments of `gmr demo`.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  gmr demo --out gmr-demo")]
pub(crate) struct Arguments {
    /// The folder for robot, logs, coefficients and pages; made where it is not there
    #[arg(long, value_name = "FOLDER", default_value = "gmr-demo")]
    out: PathBuf,
    /// Name the page, and do not open it
    #[arg(long)]
    no_open: bool,
    #[command(flatten)]
    overwrite: OverwriteArgument,
}

/// What the page says of a step, and its command; `@` stands for the demo's folder.
struct Step {
    about: &'static str,
    command: &'static str,
    /// A drawing that it makes.
    drawing: Option<&'static str>,
}

/// A drive of a minute, as servo and power sensor log it at 200 Hz.
const DRIVE: &str = "simulate --sensors servo --duration 60 --force";

/// Drives of the robot as it was, and of the same robot on a slope of 0.03 rad that nobody
/// mentions: total mass, kg, seed, what is different.
const DRIVES: [(&str, &str); 10] = [
    ("clean_empty_1.csv", "--mass 1 --seed 11"),
    ("clean_empty_2.csv", "--mass 1 --seed 12"),
    ("clean_empty_3.csv", "--mass 1 --seed 13"),
    ("clean_full_1.csv", "--mass 6 --seed 21"),
    ("clean_full_2.csv", "--mass 6 --seed 22"),
    ("clean_full_3.csv", "--mass 6 --seed 23"),
    ("slope_1.csv", "--mass 3 --seed 31 --effect grade=0.03"),
    ("slope_2.csv", "--mass 3 --seed 32 --effect grade=0.03"),
    ("slope_3.csv", "--mass 3 --seed 33 --effect grade=0.03"),
    ("slope_4.csv", "--mass 3 --seed 34 --effect grade=0.03"),
];

const STEPS: [Step; 5] = [
    Step {
        about: "Drive the simulated robot for two minutes: 3 kg, then 4 kg from 60 s on. The log does not hold the mass.",
        command: "simulate --sensors servo --duration 120 --mass 3@0,4@60 --seed 5 --no-mass --force --out @/payload.csv",
        drawing: None,
    },
    Step {
        about: "What are the logs of the empty and the full robot good for?",
        command: "inspect --robot @/robot.toml @/clean_empty_1.csv @/clean_empty_2.csv @/clean_empty_3.csv @/clean_full_1.csv \
                  @/clean_full_2.csv @/clean_full_3.csv",
        drawing: None,
    },
    Step {
        about: "Fit the power model to them.",
        command: "fit --robot @/robot.toml --out @/coefficients.toml @/clean_empty_1.csv @/clean_empty_2.csv @/clean_empty_3.csv \
                  @/clean_full_1.csv @/clean_full_2.csv @/clean_full_3.csv",
        drawing: None,
    },
    Step {
        about: "Estimate the payload of the drive that does not hold it.",
        command: "estimate --robot @/robot.toml --coeffs @/coefficients.toml --plot @/payload.svg @/payload.csv",
        drawing: Some("payload.svg"),
    },
    Step {
        about: "Four drives are on a slope, which no column says. What does the model lack?",
        command: "gap --robot @/robot.toml --coeffs @/coefficients.toml --report @/gap.html --out @/extended.toml --profile \
                  @/profile.csv @/slope_1.csv @/slope_2.csv @/slope_3.csv @/slope_4.csv",
        drawing: None,
    },
];

/// The Burger, as a file that somebody can look at and change.
const ROBOT: &str = include_str!("../../robots/burger.toml");

pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let folder = &arguments.out;
    std::fs::create_dir_all(folder).map_err(|error| Error::io(folder, &error))?;
    let page = folder.join("index.html");
    arguments.overwrite.check([&page], Form::Page)?;
    output::write_content(&folder.join("robot.toml"), ROBOT)?;
    output::say(format_args!("ten drives of a simulated robot"));
    for (log, how) in DRIVES {
        answer_of(&format!("{DRIVE} {how} --out @/{log}"), folder)?;
    }
    let mut sections = Vec::new();
    for step in &STEPS {
        output::say(format_args!("{}", step.about));
        let said = answer_of(step.command, folder)?;
        if let Some(first) = said.lines().next() {
            println!("{first}");
        }
        sections.push(section(step, folder, &said)?);
    }
    let body = html! {
        h1 { "From a log to the payload, and to what changed" }
        p { "A simulated TurtleBot3. Six drives at 1 and 6 kg make the model; everything below is what the commands answer." }
        @for section in &sections { (section) }
        p { a href="gap.html" { "All that gmr gap found, with plots" } }
    };
    output::write_content(&page, document("gmr demo", body))?;
    let opened = !arguments.no_open && std::io::stdout().is_terminal() && open(&page);
    println!("{} {}", if opened { "opened" } else { "open" }, page.display());
    Ok(())
}

/// What a command answers, as another program gets it.
fn answer_of(command: &str, folder: &Path) -> Result<String> {
    // `3@0` is a mass from a time on.
    let place = |word: &str| match word.strip_prefix("@/") {
        Some(name) => folder.join(name).display().to_string(),
        None => word.to_owned(),
    };
    let words: Vec<String> = command.split_whitespace().map(place).collect();
    let job = Arc::new(Job::default());
    // Nobody stops it.
    job::run(&job, |context| super::answer(context, &words))?;
    Ok(job.take().printed)
}

/// A step on the page: what it is about, its command, its answer and its drawing.
fn section(step: &Step, folder: &Path, said: &str) -> Result<Markup> {
    let command = format!("gmr {}", step.command.replace("@/", ""));
    let drawing = match step.drawing {
        None => String::new(),
        Some(name) => {
            let file = folder.join(name);
            let text = std::fs::read_to_string(&file).map_err(|error| Error::io(&file, &error))?;
            // Inline, without what stands before the element.
            let svg = text.find("<svg").map_or("", |at| &text[at..]);
            let style = format!("<svg style=\"min-width:{:.0}px\"", least_width(WHOLE.0));
            svg.replacen("<svg", &style, 1)
        }
    };
    let said = said.replace(&format!("{}/", folder.display()), "");
    Ok(html! {
        h2 { (step.about) }
        pre { "$ " (command) "\n" (said) }
        @if !drawing.is_empty() { figure { (PreEscaped(drawing)) } }
    })
}

/// Opens a page as the desktop does; false where there is none.
fn open(page: &Path) -> bool {
    let has_desktop = cfg!(target_os = "macos")
        || ["DISPLAY", "WAYLAND_DISPLAY"].iter().any(|name| std::env::var_os(name).is_some());
    let opener = if cfg!(target_os = "macos") { "open" } else { "xdg-open" };
    has_desktop
        && Command::new(opener)
            .arg(page)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .is_ok()
}
