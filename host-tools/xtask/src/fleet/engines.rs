//! Spark and Ray beside `gmr fleet` on the fleet's logs: host-tools/benches/fleet/engines.py.

use std::path::Path;
use std::process::Command;

use super::made::Fleet;
use crate::paths::root;
use crate::robots::text_of;
use crate::steps::Stop;

const SCRIPT: &str = "host-tools/benches/fleet/engines.py";

/// Its table.
pub(super) fn compare(python: &Path, gmr: &Path, fleet: &Fleet) -> Result<String, Stop> {
    let mut command = Command::new(python);
    command.arg(root().join(SCRIPT)).arg(fleet.logs()).arg(fleet.coefficients());
    command.arg(gmr).arg(fleet.folder.join("out-engines"));
    text_of(command)
}
