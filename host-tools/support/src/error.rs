//! The one error of `gmr`: where, what was found, what was expected.

use std::fmt;
use std::path::{Path, PathBuf};

/// Result with the error of `gmr`.
pub type Result<T> = std::result::Result<T, Error>;

/// Something the user can mend. Printed as `file:line:column: what was found; what was expected`,
/// on one line.
#[derive(Debug)]
pub struct Error {
    /// Wrong usage ends with exit code 2, a reader that has left with 0, everything else with 1.
    kind: Kind,
    file: Option<PathBuf>,
    line: Option<u64>,
    column: Option<String>,
    message: String,
    /// What it comes from, for callers that act on it.
    cause: Option<Box<dyn std::error::Error + Send + Sync>>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Usage,
    Failed,
    Left,
}

impl Error {
    /// The command could not do its work (exit code 1).
    pub fn failed(message: impl Into<String>) -> Self {
        Self {
            kind: Kind::Failed,
            file: None,
            line: None,
            column: None,
            message: message.into(),
            cause: None,
        }
    }

    /// The command could not do its work, for a reason that is a value of its own (exit code 1).
    pub fn of(cause: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self { message: cause.to_string(), cause: Some(Box::new(cause)), ..Self::failed("") }
    }

    /// The reason, where it is one of this kind.
    pub fn cause<C: std::error::Error + 'static>(&self) -> Option<&C> {
        self.cause.as_ref()?.downcast_ref()
    }

    /// The command line asks for something that does not exist or does not fit together (exit code
    /// 2).
    pub fn usage(message: impl Into<String>) -> Self {
        Self { kind: Kind::Usage, ..Self::failed(message) }
    }

    /// Names the file.
    #[must_use]
    pub fn in_file(mut self, file: impl AsRef<Path>) -> Self {
        self.file.get_or_insert_with(|| file.as_ref().to_owned());
        self
    }

    /// Adds what was noticed before and may be why.
    #[must_use]
    pub fn after(mut self, noticed: &str) -> Self {
        self.message.push_str(&format!("; noticed before: {noticed}"));
        self
    }

    /// Names the line, counted from 1 with the header.
    #[must_use]
    pub fn at_line(mut self, line: u64) -> Self {
        self.line.get_or_insert(line);
        self
    }

    /// Names the column as the header does.
    #[must_use]
    pub fn in_column(mut self, column: impl Into<String>) -> Self {
        self.column.get_or_insert_with(|| column.into());
        self
    }

    /// What was found and expected, without its place.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// The file that it is about.
    pub fn file(&self) -> Option<&Path> {
        self.file.as_deref()
    }

    /// Its line there, from 1.
    pub fn line(&self) -> Option<u64> {
        self.line
    }

    /// Its column or key there, by name.
    pub fn column(&self) -> Option<&str> {
        self.column.as_deref()
    }

    /// A file operation that the operating system refused.
    pub fn io(file: impl AsRef<Path>, error: &std::io::Error) -> Self {
        Self::of_system(error).in_file(file)
    }

    /// The same, of no file by name.
    pub fn of_system(error: &std::io::Error) -> Self {
        Self { cause: Some(Box::new(std::io::Error::from(error.kind()))), ..Self::failed(error.to_string()) }
    }

    /// The operating system refused something that it may grant later: no fault of a file's
    /// content.
    pub fn is_of_system(&self) -> bool {
        use std::io::ErrorKind::{InvalidData, InvalidInput, UnexpectedEof};
        let kind = self.cause::<std::io::Error>().map(std::io::Error::kind);
        kind.is_some_and(|kind| !matches!(kind, InvalidData | InvalidInput | UnexpectedEof))
    }

    /// Standard output that could not be written.
    pub fn stdout(error: &std::io::Error) -> Self {
        let kind = if error.kind() == std::io::ErrorKind::BrokenPipe { Kind::Left } else { Kind::Failed };
        Self { kind, ..Self::io("standard output", error) }
    }

    /// Whoever read standard output has seen enough (`gmr … | head`): nothing to complain about.
    pub fn is_quiet(&self) -> bool {
        self.kind == Kind::Left
    }

    /// The documented exit code: 0 done, 1 failed, 2 wrong usage.
    pub fn exit_code(&self) -> u8 {
        match self.kind {
            Kind::Left => 0,
            Kind::Failed => 1,
            Kind::Usage => 2,
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(file) = &self.file {
            write!(f, "{}", file.display())?;
            if let Some(line) = self.line {
                write!(f, ":{line}")?;
            }
            if let Some(column) = &self.column {
                write!(f, ":{column}")?;
            }
            write!(f, ": ")?;
        }
        write!(f, "{}", self.message)
    }
}

impl std::error::Error for Error {}
