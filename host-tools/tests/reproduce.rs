//! `gmr reproduce` refuses what it cannot do before it does any work.

mod common;

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
