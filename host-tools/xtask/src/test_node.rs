//! `cargo xtask test-node`: `gmr node` beside a DDS peer that is not ours, in real time and over this machine's network. No part of
//! `cargo xtask test`, where it is skipped and counted: who else multicasts there, nobody knows.

use crate::python;
use crate::steps::{Steps, Stop, command};

/// True when it passed.
pub(crate) fn run() -> bool {
    let mut steps = Steps::default();
    let result = all(&mut steps);
    steps.print_summary();
    if let Err(stop) = &result {
        println!("\nstopped: {stop}");
    }
    result.is_ok()
}

fn all(steps: &mut Steps) -> Result<(), Stop> {
    steps.work("set-up", || python::peer().map(drop))?;
    steps.run("peer", command("cargo test --package host-tools --test suite -- node::a_peer"))
}
