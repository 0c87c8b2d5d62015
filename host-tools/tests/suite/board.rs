//! `gmr board` from outside, as far as it goes without an emulator.

use crate::common::Bench;

#[test]
fn a_missing_image_is_named_with_what_builds_it() {
    let folder = Bench::new();
    let ran = folder.gmr(&["board", "--image", "nowhere", "--link", "port"]);
    assert_eq!(ran.code, Some(1));
    assert!(
        ran.stderr.contains("nowhere: ") && ran.stderr.contains("cargo build --release"),
        "{}",
        ran.stderr
    );
    assert!(!folder.path("port").is_symlink());
}

#[test]
fn wrong_usage_names_what_is_allowed() {
    let folder = Bench::new();
    for (arguments, allowed) in [
        (["--speed", "fast"], "or max"),
        (["--speed", "0"], "or max"),
        (["--power-noise", "-1"], "0 or more"),
        (["--profile", "dancing"], "training, test, constant"),
        (["--duration", "0"], "above 0"),
    ] {
        let ran = folder.gmr(&["board", "--image", "nowhere", arguments[0], arguments[1]]);
        assert_eq!(ran.code, Some(2), "{arguments:?}: {}", ran.stderr);
        assert!(ran.stderr.contains(allowed), "{arguments:?}: {}", ran.stderr);
    }
}
