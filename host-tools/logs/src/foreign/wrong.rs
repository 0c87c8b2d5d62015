//! Errors of the readers of other formats.

use support::error::Error;

/// An error of a reader as one of ours; that of our own rows comes back as it was.
pub fn wrong(error: log_formats::Error) -> Error {
    match error {
        log_formats::Error::Taker(ours) => match ours.downcast::<Error>() {
            Ok(ours) => *ours,
            Err(other) => Error::failed(other.to_string()),
        },
        log_formats::Error::Io(error) => Error::of_system(&error),
        error => Error::failed(error.to_string()),
    }
}
