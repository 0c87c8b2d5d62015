//! `gmr reproduce` from the outside: it refuses what it cannot do before it does any work, and the same seeds give the same bytes.

mod common;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use common::Bench;

#[test]
fn a_folder_of_something_else_is_left_alone() {
    let bench = Bench::new();
    bench.put("thesis.tex", "years of work");
    let ran = bench.gmr(&["reproduce", "--out", "."]);
    assert_eq!(ran.code, Some(1));
    assert_eq!(
        ran.stderr,
        "gmr: .: holds something else; expected a new or empty folder, or an earlier reproduction\n"
    );
    let ran = bench.gmr(&["reproduce", "--out", "nowhere/out"]);
    assert_eq!(ran.code, Some(1));
    assert!(ran.stderr.contains("the folder nowhere does not exist"), "{}", ran.stderr);
    assert_eq!(bench.files(), ["thesis.tex"]);
}

#[test]
fn seeds_that_there_are_not_are_wrong_usage() {
    let bench = Bench::new();
    for seeds in
        [["--seeds", "0", "--first-seed", "1"], ["--seeds", "2", "--first-seed", "18446744073709551615"]]
    {
        let ran = bench.gmr(&[&["reproduce", "--out", "out"], &seeds[..]].concat());
        assert_eq!(ran.code, Some(2), "{}", ran.stderr);
        assert!(ran.stderr.contains("expected at least one seed"), "{}", ran.stderr);
    }
    assert!(bench.files().is_empty());
}

/// A reduced reproduction against the committed one, and against itself: every byte of every file. No neural network is in it:
/// their sums are vectorised differently on other kinds of processors, and training enlarges the last digit.
///
/// `GMR_BLESS=1 cargo test -p host-tools --test reproduce` writes the committed table anew.
#[test]
fn a_reduced_reproduction_is_the_committed_one() {
    let bench = Bench::new();
    for folder in ["first", "second"] {
        let ran = bench.gmr(&["reproduce", "--reduced", "--out", folder]);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    }
    let files = contents(&bench.path("first"));
    assert!(files.len() > 20, "{} files", files.len());
    for (name, bytes) in &files {
        assert!(contents(&bench.path("second"))[name] == *bytes, "{} is another", name.display());
    }
    let table = String::from_utf8(files[Path::new("tables.txt")].clone()).unwrap();
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/paper-reduced.txt");
    if std::env::var_os("GMR_BLESS").is_some() {
        std::fs::write(&golden, &table).unwrap();
    }
    let committed = std::fs::read_to_string(&golden).unwrap();
    for (line, (found, expected)) in (1..).zip(table.lines().zip(committed.lines())) {
        assert_eq!(found, expected, "docs/paper-reduced.txt:{line}; GMR_BLESS=1 writes it anew");
    }
    assert_eq!(table.lines().count(), committed.lines().count());
}

/// Every file below a folder, by its name there.
fn contents(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = BTreeMap::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = PathBuf::from(path.file_name().unwrap());
        if path.is_dir() {
            files.extend(contents(&path).into_iter().map(|(below, bytes)| (name.join(below), bytes)));
        } else {
            files.insert(name, std::fs::read(&path).unwrap());
        }
    }
    files
}
