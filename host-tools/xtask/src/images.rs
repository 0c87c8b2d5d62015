//! The firmware's images: how each is built, and where it is then.

use std::path::PathBuf;

use crate::set_up::TARGET;

/// The board's image.
pub(crate) const OPENCR: &str = "opencr";
/// The emulator's.
pub(crate) const VIRTUAL: &str = "virtual";

/// The profile that an image is built with: what is flashed has one of its own.
fn profile(name: &str) -> &'static str {
    if name == OPENCR { "image" } else { "release" }
}

/// Arguments of the cargo that builds one.
pub(crate) fn build(name: &str) -> String {
    let profile = profile(name);
    format!("build --profile {profile} --package firmware --features {name} --bin {name} --target {TARGET}")
}

/// Where it is.
pub(crate) fn path(name: &str) -> PathBuf {
    crate::paths::target_folder().join(TARGET).join(profile(name)).join(name)
}
