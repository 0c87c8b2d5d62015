//! The argument that lets a command write over what is not its own.

use std::path::PathBuf;

use support::error::Result;
use support::overwrite::{self, Form};

/// Whether files are written over.
#[derive(clap::Args)]
pub(super) struct OverwriteArgument {
    /// Write over any file. Without, only over what such a command wrote before, known by its form:
    /// coefficients by their first keys, drawings by a mark in them, pages by their title, logs and
    /// profiles by their header and the digits of their numbers. Also: write and use a fit that
    /// cannot be used, and read logs that look like other units or negative power
    #[arg(long)]
    pub(super) force: bool,
}

impl OverwriteArgument {
    /// Refuses files that are there and of another form.
    ///
    /// # Errors
    /// Names the first.
    pub(super) fn check<'a>(&self, files: impl IntoIterator<Item = &'a PathBuf>, form: Form) -> Result<()> {
        files.into_iter().try_for_each(|file| overwrite::check(file, form, self.force))
    }
}
