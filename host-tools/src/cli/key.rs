//! `gmr key`: the keys with which coefficients are signed.

use std::path::PathBuf;

use board::signing::SecretKey;
use serde::Serialize;
use support::error::Result;

/// Arguments of `gmr key`.
#[derive(clap::Args)]
#[command(
    after_help = "Example:\n  gmr key new robots.key\n  gmr flash --coeffs coefficients.toml --sign robots.key --port /dev/ttyACM1"
)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    action: Action,
}

#[derive(clap::Subcommand)]
enum Action {
    /// Make a secret key, and say the public one that boards are built with
    New(File),
    /// Say the public key of a secret one
    Show(File),
}

#[derive(clap::Args)]
struct File {
    /// The secret key: whoever has it may write coefficients
    file: PathBuf,
    /// Figures as JSON on standard output
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Report<'a> {
    file: &'a std::path::Path,
    public_key: String,
}

pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let (file, key) = match &arguments.action {
        Action::New(file) => (file, SecretKey::create(&file.file)?),
        Action::Show(file) => (file, SecretKey::read(&file.file)?),
    };
    let public_key = key.public_hex();
    if file.json {
        return support::output::print_json(&Report { file: &file.file, public_key });
    }
    println!("{public_key}");
    Ok(())
}
