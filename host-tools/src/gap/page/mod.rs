//! The answer as one self-contained HTML page: no network, no scripts, plots inline.
//!
//! It is well-formed XML, too, so that a test can read it strictly. Every text goes through maud, which escapes it.

mod course;
mod figure;
mod figures;
mod sections;

use std::path::{Path, PathBuf};

use maud::{Markup, PreEscaped, html};

pub use self::course::{Course, Picture};
use super::investigate::Report;
use super::localise::Cell;
use super::summary;
use crate::error::{Error, Result};
use crate::output;

/// What was asked for: shown, so that it can be asked again.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Inputs {
    /// Name of the robot.
    pub robot: String,
    /// Coefficients of the base.
    pub coefficients: Option<PathBuf>,
    /// Logs of the runs under inquiry.
    pub logs: Vec<PathBuf>,
    /// Logs of the clean runs that were at hand.
    pub clean: Vec<PathBuf>,
    /// Further options and their values.
    pub options: Vec<(String, String)>,
}

/// The same disagreement as another model of the robot sees it: the simulated plant.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulated {
    /// What was simulated and what came of it, sentences.
    pub text: Vec<String>,
    /// Run by run: measured, and simulated before and after.
    pub courses: Vec<Course>,
    /// Where the residual lies.
    pub cells: Vec<Cell>,
}

/// Refuses a file that is no page, or has no folder: asked before the long work.
///
/// # Errors
/// Another extension than `.html` (wrong usage), or no such folder.
pub fn check(file: &Path) -> Result<()> {
    let extension = file.extension().and_then(|extension| extension.to_str()).map(str::to_ascii_lowercase);
    if !matches!(extension.as_deref(), Some("html" | "htm")) {
        return Err(Error::usage("reports are written as .html").in_file(file));
    }
    output::folder_of(file).map(|_| ())
}

/// Writes the page, whole or not at all.
///
/// # Errors
/// It cannot be drawn or written.
pub fn save(
    file: &Path,
    report: &Report,
    picture: &Picture,
    inputs: &Inputs,
    simulated: Option<&Simulated>,
) -> Result<()> {
    let page = text(report, picture, inputs, simulated)?;
    output::write_whole(file, |write| {
        write.write_all(page.as_bytes()).map_err(|error| Error::io(file, &error))
    })
}

/// The page.
///
/// # Errors
/// A figure cannot be drawn.
pub fn text(
    report: &Report,
    picture: &Picture,
    inputs: &Inputs,
    simulated: Option<&Simulated>,
) -> Result<String> {
    let body = html! {
        (sections::verdict(report, inputs))
        (sections::effects(report))
        (sections::next(report))
        (sections::gap(report)?)
        (sections::maps(&report.localisation, &picture.map)?)
        (sections::courses(&picture.courses)?)
        @if let Some(simulated) = simulated { (sections::simulated(simulated)?) }
        (sections::scores(report)?)
        (sections::base(report, inputs))
        (sections::not_testable(report))
        (sections::inputs(inputs, &report.confirmed.runs))
    };
    Ok(document(&summary::headline(report), body))
}

/// Void elements are closed as in XML, which HTML allows.
const HEAD: &str = "<meta charset=\"utf-8\"/>\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
                    <meta name=\"color-scheme\" content=\"light dark\"/>";

fn document(title: &str, body: Markup) -> String {
    let page = html! {
        (PreEscaped("<!DOCTYPE html>\n"))
        html lang="en" {
            head {
                (PreEscaped(HEAD))
                title { "gmr gap: " (title) }
                style { (PreEscaped(include_str!("style.css"))) }
            }
            body { main { (body) } }
        }
    };
    page.into_string()
}
