//! What a file holds.

/// A topic of a bag, or a column of a table.
#[derive(Debug, Clone, serde::Serialize)]
pub(super) struct Topic {
    pub(super) name: String,
    pub(super) kind: String,
    pub(super) messages: Option<u64>,
}

/// What is in the file.
#[derive(Debug, Clone)]
pub(super) struct Topics {
    pub(super) topics: Vec<Topic>,
    pub(super) sources: Vec<String>,
    pub(super) cut: bool,
}
