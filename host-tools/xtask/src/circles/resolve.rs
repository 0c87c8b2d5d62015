//! From a path as written to the file that defines what it names. Other crates' names lead nowhere.

use super::tree::Tree;

/// Re-exports of re-exports, and globs that import each other, end here.
const DEEPEST: usize = 24;

/// A name can be a module, an item, or one of each.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Target {
    pub(super) module: Option<usize>,
    /// The file in which the item stands.
    pub(super) file: Option<usize>,
}

impl Target {
    const NONE: Self = Self { module: None, file: None };

    fn or(self, other: Self) -> Self {
        Self { module: self.module.or(other.module), file: self.file.or(other.file) }
    }
}

/// What `path` names, seen from a module.
pub(super) fn resolve(tree: &Tree, module: usize, path: &[String]) -> Target {
    Resolver { tree }.path(module, path, DEEPEST)
}

struct Resolver<'a> {
    tree: &'a Tree,
}

impl Resolver<'_> {
    fn path(&self, module: usize, path: &[String], depth: usize) -> Target {
        let Some((first, rest)) = path.split_first() else {
            return Target { module: Some(module), file: None };
        };
        let start = match first.as_str() {
            "crate" => 0,
            "self" => module,
            "super" => {
                let parent = self.tree.modules[module].parent;
                return match rest.first().map(String::as_str) {
                    Some("super") => self.path(parent, rest, depth),
                    _ => self.inside(parent, rest, depth),
                };
            }
            _ => return self.inside(module, path, depth),
        };
        self.inside(start, rest, depth)
    }

    /// The rest of a path, from a module that it has come to.
    fn inside(&self, module: usize, path: &[String], depth: usize) -> Target {
        let Some((first, rest)) = path.split_first() else {
            return Target { module: Some(module), file: None };
        };
        let found = self.name(module, first, depth);
        if rest.is_empty() {
            return found;
        }
        // A type's function or an enum's variant stands where the type does.
        let deeper = found.module.map_or(Target::NONE, |module| self.inside(module, rest, depth));
        deeper.or(Target { module: None, file: found.file })
    }

    fn name(&self, module: usize, name: &str, depth: usize) -> Target {
        let Some(depth) = depth.checked_sub(1) else { return Target::NONE };
        let here = &self.tree.modules[module];
        let own = Target {
            module: here.children.get(name).copied(),
            file: here.items.contains(name).then_some(here.file),
        };
        let bound = match here.bindings.get(name) {
            // `use rand::…` in a module that has no `rand`: another crate's.
            Some(path) if path.len() > 1 || path[0] != name => self.path(module, path, depth),
            _ => Target::NONE,
        };
        let found = own.or(bound);
        if found != Target::NONE {
            return found;
        }
        here.globs.iter().fold(Target::NONE, |found, glob| {
            if found != Target::NONE {
                return found;
            }
            match self.path(module, glob, depth).module {
                Some(other) if other != module => self.name(other, name, depth),
                _ => found,
            }
        })
    }
}
