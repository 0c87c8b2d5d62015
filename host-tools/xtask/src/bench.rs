//! `cargo xtask bench`: the figures of the README, measured again.

use crate::steps::{Steps, command};

/// What can be measured: its name, and the bench of host-tools that does it.
const BENCHES: [(&str, &str); 2] = [("accuracy", "accuracy"), ("fit-speed", "fit_speed")];

/// Measures one of them, or all. True when every figure was reached; `None` for a name that there is not.
pub(crate) fn run(name: Option<&str>) -> Option<bool> {
    let chosen: Vec<_> = BENCHES.iter().filter(|(known, _)| name.is_none_or(|name| name == *known)).collect();
    if chosen.is_empty() {
        return None;
    }
    let mut steps = Steps::default();
    let mut reached = true;
    for (name, bench) in chosen {
        let result = steps.run(name, command(&format!("cargo bench --package host-tools --bench {bench}")));
        if let Err(stop) = result {
            println!("{name}: {stop}");
            reached = false;
        }
    }
    steps.print_summary();
    Some(reached)
}
