//! Files, the arrows between them, and their circles.

use std::collections::{BTreeMap, BTreeSet};

use super::resolve::resolve;
use super::tree::Tree;

/// From a file to one that it needs, with the names by which it does.
pub(super) type Arrows = BTreeMap<(usize, usize), BTreeSet<String>>;

/// Every arrow of a crate, by the files' indices.
pub(super) fn arrows(tree: &Tree) -> Arrows {
    let mut arrows = Arrows::new();
    for (index, module) in tree.modules.iter().enumerate() {
        for path in &module.mentions {
            let Some(file) = resolve(tree, index, path).file.filter(|file| *file != module.file) else {
                continue;
            };
            arrows.entry((module.file, file)).or_default().extend(path.last().cloned());
        }
    }
    arrows
}

/// Sets of files each of which needs every other, by whatever way round: Tarjan's strongly connected components of more than one.
pub(super) fn circles(files: usize, arrows: &Arrows) -> Vec<Vec<usize>> {
    let mut next = vec![Vec::new(); files];
    arrows.keys().for_each(|&(from, to)| next[from].push(to));
    let mut search = Search {
        next,
        order: vec![None; files],
        low: vec![0; files],
        count: 0,
        open: Vec::new(),
        found: Vec::new(),
    };
    for file in 0..files {
        if search.order[file].is_none() {
            search.visit(file);
        }
    }
    search.found
}

struct Search {
    next: Vec<Vec<usize>>,
    /// When a file was come to first.
    order: Vec<Option<usize>>,
    /// The earliest open file that can be reached from it.
    low: Vec<usize>,
    count: usize,
    open: Vec<usize>,
    found: Vec<Vec<usize>>,
}

impl Search {
    fn visit(&mut self, file: usize) {
        self.order[file] = Some(self.count);
        self.low[file] = self.count;
        self.count += 1;
        self.open.push(file);
        for to in self.next[file].clone() {
            match self.order[to] {
                None => {
                    self.visit(to);
                    self.low[file] = self.low[file].min(self.low[to]);
                }
                Some(order) if self.open.contains(&to) => self.low[file] = self.low[file].min(order),
                Some(_) => {}
            }
        }
        if self.order[file] == Some(self.low[file]) {
            let start = self.open.iter().position(|open| *open == file).unwrap_or(0);
            let mut circle = self.open.split_off(start);
            if circle.len() > 1 {
                circle.sort_unstable();
                self.found.push(circle);
            }
        }
    }
}
