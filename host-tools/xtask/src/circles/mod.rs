//! No circle between files of a crate, and arrows between rooms one way.
//!
//! A file needs another when its code names something that the other defines, by an import, a path or a macro; what `mod.rs` only
//! declares or hands on stands where it is defined. Code for tests may look anywhere: it is left out. Methods are found by the
//! compiler, not by a path, so an `impl` in another file than its type ties only one way.

mod graph;
mod mentions;
mod module;
mod resolve;
#[cfg(test)]
mod tests;
mod tree;

use std::path::{Path, PathBuf};

use crate::steps::Stop;
use graph::{Arrows, arrows, circles};
use tree::Tree;

/// Packages, by their folders.
const PACKAGES: [&str; 21] = [
    "model-core",
    "firmware",
    "host-tools",
    "host-tools/formats",
    "host-tools/numerics",
    "host-tools/plant",
    "host-tools/report",
    "host-tools/logs",
    "host-tools/model",
    "host-tools/fit",
    "host-tools/answers",
    "host-tools/gap",
    "host-tools/study",
    "host-tools/fleet",
    "host-tools/board",
    "host-tools/virtual-board",
    "host-tools/node",
    "host-tools/support",
    "host-tools/python",
    "host-tools/xtask",
    "tests",
];

/// Rooms of host-tools from the ground up, as docs/architecture.md draws them: each needs only rooms below its own floor. Others (errors,
/// output, progress …) are for everybody.
const FLOORS: [&[&str]; 9] = [
    &["numerics"],
    &["plant", "report", "robot"],
    &["effects"],
    &["coefficients", "log"],
    &["fit"],
    &["baselines", "board", "estimate", "gram", "inspect", "look", "predict"],
    &["compare", "export", "node", "virtual_board"],
    &["fleet", "gap", "reproduce"],
    &["cli"],
];

/// Says every circle and every arrow that does not go down: each is an error.
pub(crate) fn check() -> Result<(), Stop> {
    let read = |path: &Path| std::fs::read_to_string(crate::paths::root().join(path)).ok();
    let mut faults = Vec::new();
    let mut files = 0;
    for root in PACKAGES.into_iter().flat_map(roots) {
        let tree = Tree::read(&root, &read).map_err(Stop::new)?;
        files += tree.files.len();
        faults.extend(faults_of(&tree));
    }
    faults.iter().for_each(|fault| println!("   {fault}"));
    println!("   {files} files, {} circles or arrows that go up", faults.len());
    if faults.is_empty() { Ok(()) } else { Err(Stop::new("files that need one another: see above")) }
}

/// Roots of a package's library, programs, tests and benches.
fn roots(package: &str) -> Vec<PathBuf> {
    let package = Path::new(package);
    let folders = ["src", "src/bin", "tests", "benches", "images"].map(|folder| package.join(folder));
    let mut roots: Vec<PathBuf> = [package.join("src/lib.rs"), package.join("src/main.rs")].into();
    for folder in &folders[1..] {
        let Ok(entries) = crate::paths::root().join(folder).read_dir() else { continue };
        for entry in entries.flatten() {
            let path = folder.join(entry.file_name());
            roots.push(if path.extension().is_some() { path } else { path.join("main.rs") });
        }
    }
    roots.retain(|root| {
        root.extension().is_some_and(|extension| extension == "rs")
            && crate::paths::root().join(root).is_file()
    });
    roots.sort();
    roots
}

fn faults_of(tree: &Tree) -> Vec<String> {
    let arrows = arrows(tree);
    let circles = circles(tree.files.len(), &arrows);
    let mut faults: Vec<String> = circles.iter().map(|circle| circle_text(tree, &arrows, circle)).collect();
    for (&(from, to), names) in &arrows {
        let (Some(room), Some(above)) = (room(&tree.files[from]), room(&tree.files[to])) else { continue };
        if room != above && floor(&above) >= floor(&room) {
            let tie = arrow_text(tree, from, to, names.iter());
            faults.push(format!("{room} must not need {above}: {tie}"));
        }
    }
    faults
}

fn circle_text(tree: &Tree, arrows: &Arrows, circle: &[usize]) -> String {
    let within = |(from, to): &(usize, usize)| circle.contains(from) && circle.contains(to);
    let ties = arrows.iter().filter(|(arrow, _)| within(arrow));
    let ties =
        ties.map(|(&(from, to), names)| format!("\n      {}", arrow_text(tree, from, to, names.iter())));
    format!("a circle of {} files:{}", circle.len(), ties.collect::<String>())
}

fn arrow_text<'a>(tree: &Tree, from: usize, to: usize, names: impl Iterator<Item = &'a String>) -> String {
    let names: Vec<&str> = names.map(String::as_str).collect();
    format!("{} → {} ({})", tree.files[from].display(), tree.files[to].display(), names.join(", "))
}

fn floor(room: &str) -> Option<usize> {
    FLOORS.iter().position(|rooms| rooms.contains(&room))
}

/// The room that a file is in: a folder or file right below host-tools/src, if it has a floor.
fn room(file: &Path) -> Option<String> {
    let inside = file.strip_prefix("host-tools/src").ok()?;
    let first = Path::new(inside.components().next()?.as_os_str());
    let room = first.with_extension("").to_string_lossy().into_owned();
    floor(&room).map(|_| room)
}
