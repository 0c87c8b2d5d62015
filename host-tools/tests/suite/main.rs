//! What `gmr` and its library do, from the outside: one program, because every further one would be
//! linked to all of the library again. One file a subject; `cargo test --package host-tools --test
//! suite fit::` runs those of a file.

#![allow(
    clippy::duplicate_mod,
    reason = "the tests on the emulated board have their own copy of what says that a test is skipped"
)]

mod common;
#[cfg(target_os = "linux")]
#[path = "../../../tests/system/common/mod.rs"]
mod images;

mod bad_input;
mod baselines_reference;
#[cfg(target_os = "linux")]
mod board;
mod charge;
mod compare;
#[cfg(target_os = "linux")]
mod drive;
mod edges;
#[cfg(target_os = "linux")]
mod emulated_board;
mod estimate;
mod export;
mod extended;
mod fit;
mod flash;
mod fleet;
mod foreign_logs;
mod fuzz;
mod gap;
mod gap_bad_input;
mod gap_bench;
mod gap_columns;
mod gap_power_only;
mod gap_report;
mod gap_simulation;
mod gap_simulator;
mod gap_user_effects;
mod gram;
mod gyro;
#[cfg(unix)]
mod hostile_board;
mod inspect;
mod json;
mod ladder;
mod layouts;
#[cfg(all(unix, feature = "foxglove"))]
mod live_view;
mod log;
mod look;
mod makers;
mod network_seeds;
mod newcomer;
mod node;
mod predict;
mod record;
mod reference;
mod report;
mod reproduce;
mod robot;
mod shell;
mod simulate;
mod static_power;
mod suspicion;
#[cfg(target_os = "linux")]
mod whole_system;
