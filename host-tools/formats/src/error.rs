//! What is wrong with a log, in one line.

/// Result with the error of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Why a log is not read. The text says what was found and what was expected, without the file's
/// name.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The operating system refused.
    #[error("{0}")]
    Io(#[from] std::io::Error),
    /// The file ends before its format does: what is there can be read on request.
    #[error("{0}")]
    Truncated(String),
    /// The bytes are not what their format says.
    #[error("{0}")]
    Damaged(String),
    /// Of a kind that is not read here.
    #[error("{0}")]
    Unsupported(String),
    /// There is no such topic, field or column; the text names those that there are.
    #[error("{0}")]
    Choice(String),
    /// Of whoever takes the rows.
    #[error("{0}")]
    Taker(Box<dyn std::error::Error + Send + Sync>),
}

impl Error {
    /// The bytes are not what `format` says.
    pub(crate) fn damaged(format: &str, why: impl std::fmt::Display) -> Self {
        let why = why.to_string();
        Self::Damaged(format!("is no {format} file that can be read: {}", why.replace('\n', " ")))
    }

    /// The same of one of a bag's files.
    pub(crate) fn of_part(self, file: &std::path::Path) -> Self {
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let named = |why: String| format!("its file {name} {why}");
        match self {
            Self::Truncated(why) => Self::Truncated(named(why)),
            Self::Damaged(why) => Self::Damaged(named(why)),
            Self::Unsupported(why) => Self::Unsupported(named(why)),
            Self::Choice(why) => Self::Choice(named(why)),
            Self::Io(_) | Self::Taker(_) => self,
        }
    }
}

/// At most so many names in a message: more are not read by anybody.
const MOST_NAMED: usize = 20;

/// Names in one line, the nearest to `wanted` first.
pub(crate) fn nearest<'a>(wanted: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    let mut names: Vec<&str> = names.into_iter().collect();
    names.sort_by_key(|name| distance(wanted, name));
    let more = names.len().saturating_sub(MOST_NAMED);
    names.truncate(MOST_NAMED);
    let listed = names.join(", ");
    if more > 0 { format!("{listed} and {more} more") } else { listed }
}

/// Letters to change, insert or leave out between two names (Levenshtein 1966).
fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().take(80).collect(), b.chars().take(80).collect());
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let changed = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = changed.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_comes_first() {
        assert_eq!(distance("kitten", "sitting"), 3);
        let named = nearest("/joint_state", ["/odom", "/joint_states", "/tf"]);
        assert!(named.starts_with("/joint_states, "), "{named}");
    }
}
