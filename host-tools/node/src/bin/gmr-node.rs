//! `gmr-node`: what `gmr node` does, as a program of its own for a robot's computer.

use std::process::ExitCode;

/// Payload, battery and what is left on ROS 2's topics, from one power sensor on the robot's own
/// computer.
#[derive(clap::Parser)]
#[command(name = "gmr-node", version, about, max_term_width = 110)]
struct Program {
    #[command(flatten)]
    arguments: node::command::Arguments,
}

fn main() -> ExitCode {
    ExitCode::from(support::program::run("gmr-node", std::env::args_os(), |context, program: Program| {
        node::command::run(context, &program.arguments)
    }))
}
