//! robot.toml: what is known of a robot beforehand.
