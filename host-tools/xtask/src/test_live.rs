//! `cargo xtask test-live`: `gmr record --foxglove` beside WebSocket clients that are not ours. No
//! part of `cargo xtask test`: the feature is another build of host-tools.

use crate::python;
use crate::steps::{Steps, Stop, carried_out, command};

/// True when it passed.
pub(crate) fn run() -> bool {
    carried_out(all)
}

fn all(steps: &mut Steps) -> Result<(), Stop> {
    steps.work("set-up", || python::live().map(drop))?;
    let with = "--package host-tools --features foxglove";
    steps.run("lints", command(&format!("cargo clippy {with} --all-targets -- -D warnings")))?;
    steps.run("clients", command(&format!("cargo test {with} --test suite -- live_view::")))
}
