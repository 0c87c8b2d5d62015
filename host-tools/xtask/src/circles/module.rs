//! A module: what it defines, imports and mentions.

use std::collections::{BTreeMap, BTreeSet};

/// A path as it is written, `crate`, `self` and `super` included.
pub(super) type Names = Vec<String>;

/// One module, of a file of its own or inline.
#[derive(Debug, Default)]
pub(super) struct Module {
    /// Index into the tree's files.
    pub(super) file: usize,
    /// Index into the tree's modules; the root's is its own.
    pub(super) parent: usize,
    pub(super) children: BTreeMap<String, usize>,
    /// Names of functions, types, constants, traits and macros that it defines.
    pub(super) items: BTreeSet<String>,
    /// What `use` calls by a name, re-exports included.
    pub(super) bindings: BTreeMap<String, Names>,
    /// `use …::*`.
    pub(super) globs: Vec<Names>,
    /// What its code mentions: private imports, and paths of expressions, types and macros. A re-export alone is none.
    pub(super) mentions: BTreeSet<Names>,
}
