//! Where robots come from: built in, or files.

use std::path::{Path, PathBuf};

use support::context::Context;
use support::error::{Error, Result};
use support::input::{MOST_DESCRIPTION, read_text};

use super::{Robot, lenient, parse};

/// Robots that need no file: their names, and the content of the file they were read from.
const BUILT_IN: [(&[&str], &str); 4] = [
    (&["burger", "turtlebot3burger", "turtlebot3"], include_str!("../../../robots/burger.toml")),
    (&["turtlebot4", "create3"], include_str!("../../../robots/turtlebot4.toml")),
    (&["warthog"], include_str!("../../../robots/warthog.toml")),
    (&["husky", "huskya200"], include_str!("../../../robots/husky.toml")),
];

/// Instead of a name or path: the `robot.toml` in the working directory or the nearest folder above
/// that has one, else the burger.
pub const FOUND: &str = "auto";

/// The nearest robot.toml from the working directory upward.
pub fn nearest() -> Option<PathBuf> {
    let folder = std::env::current_dir().ok()?;
    folder.ancestors().map(|folder| folder.join("robot.toml")).find(|file| file.is_file())
}

/// The file of a built-in robot.
fn built_in(name: &str) -> Option<&'static str> {
    let name = lenient(name);
    BUILT_IN.iter().find(|(names, _)| names.contains(&name.as_str())).map(|(_, text)| *text)
}

fn unknown(name: &str) -> Error {
    Error::usage(format!(
        "no robot is called {name}; expected {} or the path of a robot.toml (gmr new-robot writes one)",
        BUILT_IN.map(|(names, _)| names[0]).join(", ")
    ))
}

impl Robot {
    /// A built-in robot by its name (`burger`, …) or the robot of a file. Upper case, `-`, `_` and
    /// spaces do not matter in names. Keys of the file that are not known are noticed.
    ///
    /// # Errors
    /// The name is not known (wrong usage), the file cannot be read, or its content is not a robot:
    /// with line and column.
    pub fn load(context: &Context, name_or_path: impl AsRef<Path>) -> Result<Self> {
        let mut path = name_or_path.as_ref();
        let file_above;
        if path == Path::new(FOUND) {
            path = match nearest() {
                None => Path::new("burger"),
                Some(file) => {
                    file_above = file;
                    context.notice(format_args!("the robot is that of {}", file_above.display()));
                    &file_above
                }
            };
        }
        if let Some(text) = path.to_str().and_then(built_in) {
            return Self::parse(text).map_err(|error| error.in_file(path));
        }
        let is_name = path.extension().is_none() && path.components().count() == 1;
        if is_name && !path.exists() {
            return Err(unknown(&path.display().to_string()));
        }
        if !path.exists() {
            let message = format!(
                "is not there; expected a robot.toml (gmr new-robot writes one), or {}",
                BUILT_IN.map(|(names, _)| names[0]).join(", ")
            );
            return Err(Error::failed(message).in_file(path));
        }
        let text = read_text(path, MOST_DESCRIPTION)?;
        let robot = Self::parse(&text).map_err(|error| error.in_file(path))?;
        for unknown in &robot.unknown_keys {
            context.notice(format_args!("{}:{unknown}", path.display()));
        }
        Ok(robot)
    }

    /// A built-in robot by its name.
    ///
    /// # Errors
    /// The name is not known (wrong usage).
    pub fn named(name: &str) -> Result<Self> {
        Self::parse(built_in(name).ok_or_else(|| unknown(name))?)
    }

    /// The robot that a text in the form of robot.toml describes.
    ///
    /// # Errors
    /// A key is missing, or a value is of another type or outside what is allowed: with line and
    /// column.
    pub fn parse(text: &str) -> Result<Self> {
        parse::robot(text)
    }
}
