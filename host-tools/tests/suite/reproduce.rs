//! `gmr reproduce` from the outside: it refuses what it cannot do before it does any work, and the
//! same seeds give the same bytes.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::common::Bench;

#[test]
fn a_folder_of_something_else_is_left_alone() {
    let bench = Bench::new();
    bench.put("thesis.tex", "years of work");
    let ran = bench.gmr(&["reproduce", "--out", "."]);
    assert_eq!(ran.code, Some(1));
    assert_eq!(
        ran.stderr,
        "gmr: .: holds thesis.tex, which is not of a reproduction; expected a new or empty folder, or an earlier reproduction\n"
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

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_nothing_behind() {
    let bench = Bench::new();
    let temporary = bench.path("temporary");
    std::fs::create_dir(&temporary).unwrap();
    let entries = || std::fs::read_dir(&temporary).unwrap().count();
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_gmr"));
    command.args(["reproduce", "--reduced", "--seeds", "100", "--out"]).arg(bench.path("out"));
    let piped = std::process::Stdio::piped;
    let child = command.env("TMPDIR", &temporary).stdout(piped()).stderr(piped()).spawn().unwrap();
    let begun = std::time::Instant::now();
    while entries() == 0 && begun.elapsed() < std::time::Duration::from_secs(20) {
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    assert_eq!(entries(), 1, "logs go to a temporary folder");
    rustix::process::kill_process(rustix::process::Pid::from_child(&child), rustix::process::Signal::INT)
        .unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(bench.files(), ["temporary"]);
    assert_eq!(entries(), 0);
}

/// A reduced reproduction against the committed one, and against itself: every byte of every file.
/// No neural network is in it: their sums are vectorised differently on other kinds of processors,
/// and training enlarges the last digit.
///
/// `GMR_BLESS=1 cargo test -p host-tools --test suite reproduce` writes the committed table anew.
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
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/results/paper-reduced.txt");
    if std::env::var_os("GMR_BLESS").is_some() {
        std::fs::write(&golden, &table).unwrap();
    }
    let committed = std::fs::read_to_string(&golden).unwrap();
    for (line, (made, expected)) in (1..).zip(table.lines().zip(committed.lines())) {
        assert_eq!(made, expected, "docs/results/paper-reduced.txt:{line}; GMR_BLESS=1 writes it anew");
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
