//! `gmr simulate`: logs from the plant.

use crate::error::Result;

/// Arguments of `gmr simulate`.
#[derive(clap::Args)]
pub(crate) struct Arguments {}

pub(crate) fn run(_arguments: &Arguments) -> Result<()> {
    Ok(())
}
