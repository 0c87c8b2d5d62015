//! What hands out messages, and how that ends.

use crate::error::Result;

/// Gets a message: the place of its topic in [`Bag::topics`](crate::Bag::topics), when it was
/// received (ns), and its bytes. Says whether it wants more.
pub(crate) type Each<'a> = dyn FnMut(usize, i64, &[u8]) -> Result<bool> + 'a;

/// How reading a bag ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ending {
    /// With its last message, or because nobody wanted more.
    Whole,
    /// The file ends before its format does, or goes on as something else: what came before was
    /// read. Why, in words.
    Cut(String),
}
