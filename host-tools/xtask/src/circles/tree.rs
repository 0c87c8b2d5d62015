//! The modules of one crate, as its files say.

use std::path::{Component, Path, PathBuf};

use syn::{Item, ItemMod};

use super::mentions;
use super::module::Module;

/// Reads a file, or says why not. Tests have theirs in memory.
pub(super) type Reader<'a> = &'a dyn Fn(&Path) -> Option<String>;

/// A crate: its modules, the root first, and their files.
#[derive(Debug, Default)]
pub(super) struct Tree {
    pub(super) modules: Vec<Module>,
    pub(super) files: Vec<PathBuf>,
}

impl Tree {
    /// The crate whose root is this file. Code for tests only is left out.
    ///
    /// # Errors
    /// A file is missing or not Rust.
    pub(super) fn read(root: &Path, read: Reader<'_>) -> Result<Self, String> {
        let mut tree = Self::default();
        tree.file(root, 0, root.parent().unwrap_or(Path::new("")), read)?;
        Ok(tree)
    }

    /// Adds a file as a module, its files of children lying in `folder`; gives its index.
    fn file(&mut self, file: &Path, parent: usize, folder: &Path, read: Reader<'_>) -> Result<usize, String> {
        let text = read(file).ok_or_else(|| format!("{}: cannot be read", file.display()))?;
        let parsed = syn::parse_file(&text)
            .map_err(|error| format!("{}:{}: {error}", file.display(), error.span().start().line))?;
        self.files.push(file.to_owned());
        let index = self.modules.len();
        self.modules.push(Module { file: self.files.len() - 1, parent, ..Module::default() });
        self.fill(index, &parsed.items, folder, read)?;
        Ok(index)
    }

    fn fill(&mut self, index: usize, items: &[Item], folder: &Path, read: Reader<'_>) -> Result<(), String> {
        for item in items.iter().filter(|item| !mentions::is_for_tests(mentions::attributes(item))) {
            if let Item::Mod(module) = item {
                let child = self.child(index, module, folder, read)?;
                self.modules[index].children.insert(module.ident.to_string(), child);
            } else {
                self.modules[index].items.extend(mentions::name(item));
                mentions::collect(item, &mut self.modules[index]);
            }
        }
        Ok(())
    }

    fn child(
        &mut self,
        parent: usize,
        module: &ItemMod,
        folder: &Path,
        read: Reader<'_>,
    ) -> Result<usize, String> {
        let name = module.ident.to_string();
        let folder = folder.join(&name);
        if let Some((_, items)) = &module.content {
            let index = self.modules.len();
            self.modules.push(Module { file: self.modules[parent].file, parent, ..Module::default() });
            self.fill(index, items, &folder, read)?;
            return Ok(index);
        }
        if let Some(path) = mentions::path_attribute(&module.attrs) {
            // From the folder of the file that says so; its own children lie beside it.
            let here = self.files[self.modules[parent].file].parent().unwrap_or(Path::new(""));
            let file = normal(&here.join(path));
            let folder = file.parent().unwrap_or(Path::new("")).to_owned();
            return self.file(&file, parent, &folder, read);
        }
        let beside = folder.with_extension("rs");
        let file = if read(&beside).is_some() { beside } else { folder.join("mod.rs") };
        self.file(&file, parent, &folder, read)
    }
}

/// Without `..`.
fn normal(path: &Path) -> PathBuf {
    let mut normal = PathBuf::new();
    for part in path.components() {
        if part == Component::ParentDir {
            normal.pop();
        } else {
            normal.push(part);
        }
    }
    normal
}
