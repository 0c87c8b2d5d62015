//! Files that a command may write over: those that such a command wrote before, known by their
//! form.
//!
//! A measured log is not replaced by a simulated one because of a slip of the keyboard.

use std::io::Read as _;
use std::path::Path;

use crate::error::{Error, Result};

/// Stands in every drawing, behind `<!-- ` in an SVG, as a text chunk in a PNG.
pub const MARK: &str = "written by gmr";

/// What a command writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// `coefficients.toml`.
    Coefficients,
    /// A figure, SVG or PNG.
    Drawing,
    /// A page of `gmr gap`.
    Page,
    /// A log of `gmr simulate`: times to a microsecond, speeds to 1e-7 rad/s.
    SimulatedLog,
    /// A speed profile of `gmr gap`: times to 0.1 ms, speeds to 1e-6.
    Profile,
    /// What was true, of `gmr board`.
    Truth,
    /// Power and mass over time, of `gmr estimate`.
    Power,
    /// Sums of `gmr gram`.
    Grams,
    /// A board's store for a programmer, whole.
    Store,
    /// A fragment of `gmr export` or `gmr gap --export`.
    Exported,
    /// A log of `gmr convert`. It looks like a measured one, so it is only written over when
    /// forced.
    Converted,
}

/// Bytes that show the form.
const HEAD: u64 = 4096;

/// Refuses to write over a file of another form, unless forced. Devices and pipes have nothing to
/// lose.
///
/// # Errors
/// Names the file.
pub fn check(file: &Path, form: Form, force: bool) -> Result<()> {
    let is_file = std::fs::metadata(file).is_ok_and(|file| file.is_file() && file.len() > 0);
    if force || !is_file {
        return Ok(());
    }
    let mut head = Vec::new();
    let opened = std::fs::File::open(file).map_err(|error| Error::io(file, &error))?;
    let length = opened.metadata().map_or(0, |file| file.len());
    opened.take(HEAD).read_to_end(&mut head).map_err(|error| Error::io(file, &error))?;
    if form.is_of(&head, length) || form == Form::Grams && are_grams(file) {
        return Ok(());
    }
    let message = "exists already, and is not what this command writes; expected another name, or --force to write over it";
    Err(Error::failed(message).in_file(file))
}

/// Whether a Parquet file holds sums: its columns say so.
fn are_grams(file: &Path) -> bool {
    let columns = log_formats::table::Columns::open(file);
    columns.is_ok_and(|columns| columns.names().iter().any(|name| name == "eq18_published_rows"))
}

impl Form {
    /// Whether a file that begins so, and is so long, has it.
    fn is_of(self, head: &[u8], length: u64) -> bool {
        let text = String::from_utf8_lossy(head);
        let mut lines = text.lines();
        let (first, second) = (lines.next().unwrap_or(""), lines.next().unwrap_or(""));
        match self {
            Self::Coefficients => first.starts_with("format = ") && text.contains("\nmodel = \""),
            Self::Drawing => text.contains(MARK),
            Self::Page => first == "<!DOCTYPE html>" && text.contains("<title>gmr "),
            Self::SimulatedLog => first.starts_with("time_s,wheel1_rad_s,") && decimals(second, [6, 7]),
            Self::Profile => first == "time_s,v_m_s,omega_rad_s" && decimals(second, [4, 6]),
            Self::Truth => format!("{first}\n") == TRUTH,
            Self::Converted => false,
            Self::Exported => text.lines().take(2).any(|line| {
                line.contains(": from a fit, at ")
                    || line.contains(" model lacks, with 95 % intervals.")
                    || line == "  \"batteryState\": {"
            }),
            Self::Power => format!("{first}\n") == POWER,
            Self::Grams => first.starts_with("{\"format\":") && first.contains("\"run\":"),
            Self::Store => length == STORE_BYTES || first.starts_with(":02000004"),
        }
    }
}

/// The header of [`Form::Power`].
pub const POWER: &str = "time_s,measured_w,predicted_w,told_w,mass_kg,low_kg,high_kg\n";

/// The header of [`Form::Truth`].
pub const TRUTH: &str =
    "time_s,wheel1_rad_s,wheel2_rad_s,power_w,mass_kg,battery_w,motors_w,computer_w,lidar_w,bus_v\n";

/// Two sectors of 32 KiB: the whole store.
const STORE_BYTES: u64 = 65536;

/// Whether the first fields of a row have so many digits behind the point.
fn decimals(row: &str, digits: [usize; 2]) -> bool {
    let mut fields = row.split(',');
    digits.iter().all(|digits| {
        let field = fields.next().and_then(|field| field.split_once('.'));
        field.is_some_and(|(_, decimals)| decimals.len() == *digits)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_recorded_is_no_simulated_log() {
        let header = "time_s,wheel1_rad_s,wheel2_rad_s,power_w,mass_kg\n";
        let is_of = |row: &str| Form::SimulatedLog.is_of(format!("{header}{row}").as_bytes(), 100);
        assert!(is_of("0.000000,0.0000000,0.0000000,0.050400,1\n"));
        assert!(!is_of("0.005,0,0,0.0504,1\n") && !is_of("") && !is_of("0.000000,1.5,0,0,1\n"));
    }

    #[test]
    fn another_file_is_refused_and_force_forces() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("c.toml");
        let refused = |form, force| check(&file, form, force).is_err();
        assert!(!refused(Form::Coefficients, false), "not there yet");
        std::fs::write(&file, "format = 1\nmodel = \"signed\"\n").unwrap();
        assert!(!refused(Form::Coefficients, false) && refused(Form::Drawing, false));
        std::fs::write(&file, "name = \"my robot\"\n").unwrap();
        assert!(refused(Form::Coefficients, false) && !refused(Form::Coefficients, true));
        assert!(check(Path::new("/dev/null"), Form::Drawing, false).is_ok());
    }
}
