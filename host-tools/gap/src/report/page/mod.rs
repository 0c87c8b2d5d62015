//! The answer as one self-contained HTML page.

mod course;
mod figures;
mod given;
mod sections;

use std::path::Path;

use maud::html;
use report::html::document;
use support::error::{Error, Result};
use support::output;

pub use self::course::{Course, Picture};
pub use self::given::{Inputs, Simulated};
use super::summary;
use crate::report::Report;

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
    output::write_content(file, page)
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
        (sections::probabilities(report)?)
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
    Ok(document(&format!("gmr gap: {}", summary::headline(report)), body))
}
