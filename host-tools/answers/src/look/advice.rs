//! What can be learned from such a log, and which cheapest sensor would change that.

use super::tally::Tally;

/// Power told less often than this, Hz, misses accelerations: only averages can be learned.
const SLOW_HZ: f64 = 5.0;

/// What is possible, what is not, and what would change it, in words.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub(super) struct Advice {
    pub(super) possible: Vec<String>,
    pub(super) impossible: Vec<String>,
    /// The cheapest thing that would change that.
    pub(super) next: String,
}

impl Advice {
    pub(super) fn of(tally: &Tally) -> Self {
        let mut possible = Vec::new();
        let mut impossible = Vec::new();
        let has_power = tally.drawn_rows > 0;
        let rate = tally.powered_rows as f64 / tally.duration_s.max(1e-9);
        let has_motion = tally.has_speed || tally.has_wheels;
        if has_power && has_motion {
            let way = if tally.has_speed { "metre" } else { "turn of a wheel" };
            possible.push(format!("energy per {way}, and power at rest and in motion (above)"));
        } else if let Some((first, last)) = tally.charge.filter(|(first, last)| first > last) {
            possible.push(format!(
                "consumption of whole trips: {:.1} points of charge in this log",
                100.0 * (first - last)
            ));
        }
        let fits = has_power && tally.has_wheels && rate >= SLOW_HZ;
        let next = match (has_power, tally.has_wheels) {
            (true, true) if !fits => {
                impossible.push(format!("payload, and power in accelerations: power comes at {rate:.1} Hz"));
                "power at 10 Hz or more: one INA219 in the motors' wire, on the I²C bus of the robot's computer"
            }
            (true, true) => {
                possible.push("a power model of this robot at this payload: gmr fit LOG=KG".to_owned());
                let masses = tally.mass_kg.filter(|(least, most)| most > least);
                if masses.is_some() {
                    possible.push("payload from power and speeds: the log tells several masses".to_owned());
                    "nothing: gmr inspect says how good the log is"
                } else {
                    impossible.push("payload: the log tells one mass at most".to_owned());
                    "no sensor: a second log with the full payload, then gmr fit EMPTY=KG FULL=KG"
                }
            }
            (true, false) => {
                impossible.push("a power model and payload: there are no wheel speeds".to_owned());
                "no sensor: record /joint_states or /odom as well (or name them in [topics] of robot.toml)"
            }
            (false, _) => {
                let why = if tally.powered_rows > 0 {
                    "the battery's current is 0 in every message, it is not measured"
                } else {
                    "nothing tells power or current"
                };
                impossible.push(format!("energy, a power model, payload: {why}"));
                "one INA219 in the motors' wire, on the I²C bus of the robot's computer: power, a model and payload"
            }
        };
        if tally.negative_share().is_some() {
            impossible.push("anything with this power's sign: read it with --flip-power".to_owned());
        }
        Self { possible, impossible, next: next.to_owned() }
    }
}
