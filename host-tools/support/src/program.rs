//! A program from its arguments to its exit code.

use std::ffi::OsString;

use clap::Parser;
use clap::error::ErrorKind;

use crate::context::{Context, Notices};
use crate::error::{Error, Result};
use crate::{interrupt, output};

/// Runs program `name`: parses its arguments, the program's name first, and does what they ask for.
/// Notices and errors go to standard error. Gives the exit code: 0 done, 1 failed, 2 wrong usage.
pub fn run<C: Parser>(
    name: &str,
    arguments: impl IntoIterator<Item = OsString>,
    execute: impl FnOnce(&Context, C) -> Result<()>,
) -> u8 {
    let context = Context::default();
    let done = interrupt::install().and_then(|()| parse(arguments)).and_then(|cli| execute(&context, cli));
    match done.and_then(|()| output::finish()) {
        Ok(()) => {
            let Notices { lines, dropped } = context.take_notices();
            lines.iter().for_each(|line| output::say(format_args!("{name}: {line}")));
            if dropped > 0 {
                output::say(format_args!("{name}: {dropped} more"));
            }
            0
        }
        Err(error) => {
            if !error.is_quiet() {
                output::say(format_args!("{name}: {error}"));
            }
            error.exit_code()
        }
    }
}

/// The arguments of a program that another one gives, without its name.
///
/// # Errors
/// What clap refuses, on one line; help and version, which are the command line's.
pub fn parse_given<C: Parser>(arguments: &[String]) -> Result<C> {
    C::try_parse_from(std::iter::once("").chain(arguments.iter().map(String::as_str)))
        .map_err(|refusal| Error::usage(one_line(&refusal.to_string())))
}

/// The command line. Help and version are printed, and end the program, here.
fn parse<C: Parser>(arguments: impl IntoIterator<Item = OsString>) -> Result<C> {
    C::try_parse_from(arguments).map_err(|refusal| match refusal.kind() {
        ErrorKind::DisplayHelp
        | ErrorKind::DisplayVersion
        | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => refusal.exit(),
        _ => Error::usage(one_line(&refusal.to_string())),
    })
}

/// clap's refusal without its usage, on one line.
fn one_line(refusal: &str) -> String {
    let refusal = refusal.strip_prefix("error: ").unwrap_or(refusal);
    let said =
        refusal.lines().take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more"));
    said.map(str::trim).filter(|line| !line.is_empty()).collect::<Vec<_>>().join(" ")
}
