//! The package's own tests (`tests/*.py`), with the module that `cargo test` has just built and the
//! command `gmr` beside it.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Said so that `cargo xtask test` counts it as skipped.
fn skipped(why: &str) {
    let _ = writeln!(std::io::stdout(), "\nSKIPPED: python::the_package_passes_its_tests: {why}");
}

/// Where cargo puts what it builds: this test is in its `debug/deps`.
fn deps() -> PathBuf {
    std::env::current_exe().unwrap().parent().unwrap().to_owned()
}

/// The package as a wheel would hold it.
fn lay_out(package: &Path, module: &Path) {
    let _ = std::fs::remove_dir_all(package);
    std::fs::create_dir_all(package).unwrap();
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("wheelwatt");
    for file in source.read_dir().unwrap().map(|file| file.unwrap().path()) {
        if file.is_file() {
            std::fs::copy(&file, package.join(file.file_name().unwrap())).unwrap();
        }
    }
    std::fs::copy(module, package.join("_gmr.abi3.so")).unwrap();
}

#[test]
fn the_package_passes_its_tests() {
    let deps = deps();
    let target = deps.ancestors().nth(2).unwrap();
    let python = target.join("python/venv/bin/python");
    if !python.exists() {
        return skipped(
            "no virtual environment in target/python: cargo xtask test makes it, with Python 3.9 and PyPI",
        );
    }
    let module = deps.join("libgmr_python.so");
    let gmr = deps.parent().unwrap().join("gmr");
    if !(module.exists() && gmr.exists()) {
        return skipped("no module or no command: cargo test --workspace builds both, on Linux");
    }
    let packages = target.join("python/packages");
    lay_out(&packages.join("wheelwatt"), &module);
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap();
    let output = Command::new(&python)
        .args(["-m", "pytest", "--rootdir"])
        .arg(env!("CARGO_MANIFEST_DIR"))
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests"))
        .env("PYTHONPATH", &packages)
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env("GMR", &gmr)
        .current_dir(root)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
    println!("{said}");
    assert!(output.status.success(), "pytest: {}\n{said}", output.status);
}
