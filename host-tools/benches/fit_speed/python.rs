//! The same work in NumPy and SciPy: reference.py in a virtual environment under target/.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::timed::{self, Timed};

/// A Python with NumPy and SciPy; made if it is not there yet.
pub(crate) fn with_scipy() -> Result<PathBuf, Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("fit_speed_venv");
    let python = folder.join("bin/python");
    if version(&python).is_err() {
        finish(Command::new("python3").args(["-m", "venv"]).arg(&folder))?;
        finish(Command::new(&python).args(["-m", "pip", "install", "--quiet", "numpy", "scipy"]))?;
    }
    print!("{}", version(&python)?);
    Ok(python)
}

fn version(python: &Path) -> Result<String, Box<dyn Error>> {
    let script = "import sys, numpy, scipy; \
                  print(f'Python {sys.version.split()[0]}, NumPy {numpy.__version__}, SciPy {scipy.__version__}')";
    let output = Command::new(python).args(["-c", script]).output()?;
    if output.status.success() {
        Ok(String::from_utf8(output.stdout)?)
    } else {
        Err("no NumPy or SciPy".into())
    }
}

fn finish(command: &mut Command) -> Result<(), Box<dyn Error>> {
    if command.status()?.success() { Ok(()) } else { Err(format!("failed: {command:?}").into()) }
}

/// reference.py, timed.
pub(crate) fn fit(python: &Path, log: &Path, cutoff_hz: &str, model: &str) -> Result<Timed, Box<dyn Error>> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/fit_speed/reference.py");
    timed::run(Command::new(python).arg(script).arg(log).args([cutoff_hz, model]))
}
