//! `cargo xtask test-node`: `gmr node` beside a DDS peer that is not ours, in real time and over
//! this machine's network. No part of `cargo xtask test`, where it is skipped and counted: who else
//! multicasts there, nobody knows.

use crate::python;
use crate::steps::{Steps, Stop, carried_out, command};

/// True when it passed.
pub(crate) fn run() -> bool {
    carried_out(all)
}

fn all(steps: &mut Steps) -> Result<(), Stop> {
    steps.work("set-up", || python::peer().map(drop))?;
    // Built alone it reads fewer formats than when the workspace is built whole.
    steps.run("gmr-node alone", command("cargo clippy --package node --bin gmr-node -- -D warnings"))?;
    steps.run("peer", command("cargo test --package host-tools --test suite -- node::a_peer"))
}
