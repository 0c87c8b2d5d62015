//! `gmr completions` and `gmr man`: what shells and man know of the commands, made from the
//! commands themselves.

use std::path::{Path, PathBuf};

use clap::Command;
use support::error::{Error, Result};
use support::output;

/// Arguments of `gmr completions`.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  gmr completions bash > ~/.local/share/bash-completion/completions/gmr\n  \
    gmr completions zsh > \"${fpath[1]}/_gmr\"\n  gmr completions fish > ~/.config/fish/completions/gmr.fish"
)]
pub(crate) struct Completions {
    /// For which shell
    #[arg(value_enum)]
    shell: clap_complete::Shell,
}

/// Arguments of `gmr man`.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  gmr man | man -l -\n  gmr man --out ~/.local/share/man/man1")]
pub(crate) struct Man {
    /// Write the page of gmr and one of each command into this folder, instead of gmr's to standard
    /// output
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
}

pub(crate) fn completions(arguments: &Completions, mut gmr: Command) -> Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut gmr, "gmr", &mut script);
    output::print(format_args!("{}", String::from_utf8_lossy(&script)));
    Ok(())
}

pub(crate) fn man(arguments: &Man, mut gmr: Command) -> Result<()> {
    gmr.build();
    let Some(folder) = &arguments.out else {
        output::print(format_args!("{}", String::from_utf8_lossy(&page(gmr, Path::new("-"))?)));
        return Ok(());
    };
    std::fs::create_dir_all(folder).map_err(|error| Error::io(folder, &error))?;
    for command in gmr.get_subcommands().filter(|command| command.get_name() != "help") {
        let name = format!("gmr-{}", command.get_name());
        let file = folder.join(format!("{name}.1"));
        output::write_content(&file, page(command.clone(), &file)?)?;
    }
    let file = folder.join("gmr.1");
    output::write_content(&file, page(gmr, &file)?)
}

fn page(command: Command, file: &Path) -> Result<Vec<u8>> {
    let mut text = Vec::new();
    clap_mangen::Man::new(command).render(&mut text).map_err(|error| Error::io(file, &error))?;
    Ok(text)
}
