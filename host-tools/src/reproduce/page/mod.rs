//! The reproduction as one page.

mod sections;
mod summary;

use maud::html;

use super::figures::{self, Figure};
use super::study::Study;
use super::table::Table;
use crate::error::Result;
use crate::report::html::document;

/// What the page shows, drawn once.
pub(super) struct Content {
    figures: Vec<Figure>,
    tables: Vec<Table>,
}

/// The page.
///
/// # Errors
/// A figure cannot be drawn.
pub fn text(study: &Study, figures: Vec<Figure>) -> Result<String> {
    let content = Content { figures, tables: Table::all(study) };
    let body = html! {
        (summary::header(study))
        (sections::settings(study))
        (sections::simulation(&content)?)
        (sections::experiment(&content)?)
        (sections::recalibration(&content))
        (sections::price(study, &content)?)
        (sections::print(study, &content))
    };
    Ok(document("gmr reproduce", body))
}

/// The page with its own drawings.
///
/// # Errors
/// As [`text`].
pub fn of(study: &Study) -> Result<String> {
    text(study, figures::all(study))
}
