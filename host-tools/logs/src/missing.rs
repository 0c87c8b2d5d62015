//! A column that a log does not have, and those that may be meant to be it.

use super::{MASS, POWER, TIME};

/// Parts of names that say what a column holds: of times, powers, masses and wheels.
const WORDS: [(&str, &[&str]); 4] = [
    (TIME, &["time", "stamp"]),
    (POWER, &["power", "watt"]),
    (MASS, &["mass", "weight", "payload"]),
    ("wheel", &["wheel", "velocity", "speed", "omega", "rpm"]),
];

/// What is said where a column is missing: what the log has, and which of it may be meant.
pub fn missing(name: &str, columns: &[String]) -> String {
    let words = WORDS.iter().find(|(start, _)| name.starts_with(start)).map_or(&[][..], |(_, words)| words);
    let is_own = |column: &str| {
        [TIME, POWER, MASS].contains(&column) || column.starts_with("wheel") && column.ends_with("_rad_s")
    };
    let may_be = |column: &&String| {
        let lower = column.to_lowercase();
        !is_own(column) && words.iter().any(|word| lower.contains(word))
    };
    let candidates: Vec<&str> = columns.iter().filter(may_be).map(String::as_str).collect();
    let hint = match candidates[..] {
        [] => String::new(),
        _ => format!("; perhaps {}: rename it to {name}", candidates.join(" or ")),
    };
    format!("column {name} is missing; the log has: {}{hint}", columns.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_may_be_meant_is_named() {
        let columns = ["time_s", "motor_power", "left_wheel_rpm", "wheel2_rad_s"].map(str::to_owned);
        let said = |name| missing(name, &columns);
        assert!(said(POWER).ends_with("wheel2_rad_s; perhaps motor_power: rename it to power_w"));
        assert!(said("wheel1_rad_s").ends_with("; perhaps left_wheel_rpm: rename it to wheel1_rad_s"));
        assert!(said(MASS).ends_with("wheel2_rad_s"), "{}", said(MASS));
    }
}
