//! `gmr`: reads the command line, runs one subcommand, ends with its exit code.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(host_tools::cli::run(std::env::args_os()))
}
