//! The keys that runs are grouped by.

use fit::run_gram::RunGram;

/// Key of a run: whose it is.
pub(super) const ROBOT: &str = "robot";

/// Key of a run: when it was; days sort as text.
pub(super) const DAY: &str = "day";

/// What a run says of a key; runs that do not are not used.
pub(super) fn key<'a>(run: &'a RunGram, key: &str) -> &'a str {
    run.keys.get(key).map_or("", String::as_str)
}
