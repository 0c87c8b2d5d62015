//! What `gmr look` says, for people and scripts.

use std::fmt::Write as _;
use std::path::Path;

use support::context::Context;
use support::error::Result;
use support::printable;

use super::advice::Advice;
use super::read;
use super::tally::Tally;
use super::topics::Topic;
use logs::robot::Robot;
use support::figure::figure;

/// A log at a glance. What the log does not tell is left out (`null` in JSON).
#[derive(Debug, Clone, serde::Serialize)]
pub struct Report {
    log: String,
    was_cut: bool,
    topics: Vec<Topic>,
    sources: Vec<String>,
    rows: u64,
    duration_s: f64,
    rate_hz: Option<f64>,
    gaps: u64,
    longest_gap_s: f64,
    distance_m: Option<f64>,
    energy_j: Option<f64>,
    moving_s: Option<f64>,
    moving_w: Option<f64>,
    resting_s: Option<f64>,
    resting_w: Option<f64>,
    /// All energy of motion per distance; what standing costs included.
    energy_per_m_j: Option<f64>,
    /// What motion costs above standing.
    motion_per_m_j: Option<f64>,
    charge: Option<Charge>,
    power_over_speed: Vec<Cell>,
    power_over_turn: Vec<Cell>,
    power_over_wheels: Vec<Cell>,
    #[serde(flatten)]
    advice: Advice,
    #[serde(skip)]
    pub(super) tally: Tally,
}

/// Charge as reported, beside what the current says.
#[derive(Debug, Clone, Copy, serde::Serialize)]
struct Charge {
    first: f64,
    last: f64,
    /// By the current, A h; `null` where that is not measured.
    drawn_ah: Option<f64>,
    /// Capacity that both together mean, A h.
    implied_capacity_ah: Option<f64>,
}

/// Power within one cell.
#[derive(Debug, Clone, Copy, serde::Serialize)]
pub(super) struct Cell {
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) mean_w: f64,
    pub(super) std_w: f64,
}

fn cells(means: &[(f64, f64, f64, f64)]) -> Vec<Cell> {
    means.iter().map(|&(from, to, mean_w, std_w)| Cell { from, to, mean_w, std_w }).collect()
}

/// Less change of charge says nothing of a capacity.
const LEAST_CHARGE: f64 = 0.02;

impl Report {
    /// Of a log of any format.
    ///
    /// # Errors
    /// A log that cannot be read.
    pub fn of(context: &Context, log: &Path, robot: &Robot, allow_cut: bool) -> Result<Self> {
        let (tally, topics) = read::read(context, log, robot, allow_cut)?;
        let has_power = tally.drawn_rows > 0;
        let powered = |value: f64| has_power.then_some(value);
        let distance = tally.has_speed.then_some(tally.distance_m);
        let driven = distance.filter(|distance| has_power && *distance > 1.0);
        let (moving_w, resting_w) =
            (tally.moving.mean_w().filter(|_| has_power), tally.resting.mean_w().filter(|_| has_power));
        let above =
            moving_w.zip(resting_w).map(|(moving, resting)| (moving - resting) * tally.moving.seconds);
        let drawn_ah = (has_power && tally.ampere_seconds != 0.0).then_some(tally.ampere_seconds / 3600.0);
        let charge = tally.charge.map(|(first, last)| Charge {
            first,
            last,
            drawn_ah,
            implied_capacity_ah: drawn_ah
                .filter(|_| first - last >= LEAST_CHARGE)
                .map(|drawn| drawn / (first - last)),
        });
        Ok(Self {
            log: printable::name(&log.display().to_string()),
            was_cut: topics.cut,
            topics: topics.topics,
            sources: topics.sources,
            rows: tally.rows,
            duration_s: tally.duration_s,
            rate_hz: (tally.duration_s > 0.0).then(|| tally.rows as f64 / tally.duration_s),
            gaps: tally.gaps,
            longest_gap_s: tally.longest_gap_s,
            distance_m: distance,
            energy_j: powered(tally.joules),
            moving_s: powered(tally.moving.seconds),
            moving_w,
            resting_s: powered(tally.resting.seconds),
            resting_w,
            energy_per_m_j: driven.map(|distance| tally.moving.joules / distance),
            motion_per_m_j: driven.zip(above).map(|(distance, above)| above / distance),
            charge,
            power_over_speed: cells(&tally.over_speed.means()),
            power_over_turn: cells(&tally.over_turn.means()),
            power_over_wheels: cells(&tally.over_wheels.means()),
            advice: Advice::of(&tally),
            tally,
        })
    }

    /// One screen for people.
    pub fn summary(&self) -> String {
        let mut text = String::new();
        let head = [format!("{}: {}", self.log, self.answer()), self.title()];
        for line in head.into_iter().chain(self.lines()) {
            let _ = writeln!(text, "{line}");
        }
        for (title, lines) in self.lists() {
            let _ = writeln!(text, "\n{title}:");
            lines.iter().for_each(|line| _ = writeln!(text, "  {line}"));
        }
        text
    }

    /// The log's name.
    pub(super) fn log(&self) -> &str {
        &self.log
    }

    /// What driving and standing cost.
    pub(super) fn answer(&self) -> String {
        if let Some(share) = self.tally.negative_share() {
            return format!(
                "NOT READY: power is negative in {:.0} % of the rows, so a discharging current counts as positive. Read it with --flip-power",
                100.0 * share
            );
        }
        let watts = |what: &str, power: Option<f64>| power.map(|power| format!("{} W {what}", figure(power)));
        let powers = [watts("driving", self.moving_w), watts("standing", self.resting_w)];
        let powers: Vec<String> = powers.into_iter().flatten().collect();
        if powers.is_empty() {
            return match (self.tally.drawn_rows > 0, self.distance_m) {
                (true, _) => "power, but nothing that says how the robot moved".to_owned(),
                (false, Some(distance)) => format!("{} m driven; power is not measured", figure(distance)),
                (false, None) => "power is not measured".to_owned(),
            };
        }
        let per = self.energy_per_m_j.map_or(String::new(), |per| format!("{} J/m; ", figure(per)));
        per + &powers.join(", ")
    }

    pub(super) fn title(&self) -> String {
        let cut = if self.was_cut { ", cut off: what comes before is used" } else { "" };
        let rate = self.rate_hz.map_or(String::new(), |rate| format!(" at {rate:.1} Hz"));
        format!("  {} rows in {:.1} s{rate}, {} gap(s){cut}", self.rows, self.duration_s, self.gaps)
    }

    pub(super) fn lines(&self) -> Vec<String> {
        let mut lines = Vec::new();
        if let (Some(energy), Some(seconds)) = (self.energy_j, self.moving_s) {
            let rest = self.resting_w.map_or("never at rest".to_owned(), |rest| {
                format!("{rest:.2} W at rest ({:.0} s)", self.resting_s.unwrap_or(0.0))
            });
            let motion = self.moving_w.map_or("never in motion".to_owned(), |power| {
                format!("{power:.2} W in motion ({seconds:.0} s)")
            });
            lines.push(format!("  {energy:.0} J ({:.2} Wh): {motion}, {rest}", energy / 3600.0));
        }
        if let Some(distance) = self.distance_m {
            let per = self.energy_per_m_j.map_or(String::new(), |per| format!(", {per:.1} J/m"));
            let motion = self
                .motion_per_m_j
                .map_or(String::new(), |per| format!(", {per:.1} J/m of it above standing"));
            lines.push(format!("  {distance:.1} m driven{per}{motion}"));
        } else if let Some(energy) =
            self.energy_j.filter(|_| self.tally.rolled_rad > 1.0 && self.moving_s.is_some())
        {
            let _ = energy;
            let turns = self.tally.rolled_rad / std::f64::consts::TAU;
            lines.push(format!(
                "  {turns:.0} turns of a wheel, {:.2} J each (no odometry: the way is not known)",
                self.tally.moving.joules / turns
            ));
        }
        if let Some(charge) = &self.charge {
            let drawn = charge.drawn_ah.map_or("the current is not measured".to_owned(), |drawn| {
                format!("{drawn:.3} Ah by its current")
            });
            let implied = charge
                .implied_capacity_ah
                .map_or(String::new(), |implied| format!(": a full battery would hold {implied:.2} Ah"));
            lines.push(format!(
                "  charge {:.1} % → {:.1} % as reported, {drawn}{implied}",
                100.0 * charge.first,
                100.0 * charge.last
            ));
        }
        lines
    }

    /// Titles and lines of what the log holds and what follows.
    pub(super) fn lists(&self) -> Vec<(&'static str, Vec<String>)> {
        let topics = self.topics.iter().map(|topic| {
            let rate = topic.messages.map_or(String::new(), |messages| {
                format!(", {messages} ({:.1} Hz)", messages as f64 / self.duration_s.max(1e-9))
            });
            format!("{} ({}){rate}", printable::name(&topic.name), printable::name(&topic.kind))
        });
        let mut lists = vec![("In the log", topics.collect())];
        if !self.sources.is_empty() {
            lists.push(("Read here", self.sources.iter().map(|source| printable::name(source)).collect()));
        }
        lists.push(("It can tell", self.advice.possible.clone()));
        lists.push(("It cannot tell", self.advice.impossible.clone()));
        lists.push(("What would change that", vec![self.advice.next.clone()]));
        lists.retain(|(_, lines): &(_, Vec<String>)| !lines.is_empty());
        lists
    }

    pub(super) fn charts(&self) -> [(&'static str, &'static str, &[Cell]); 3] {
        [
            ("Power over speed, straight on", "speed (m/s)", &self.power_over_speed),
            ("Power over turn, on the spot", "turn (rad/s)", &self.power_over_turn),
            ("Power over the wheels' speed", "wheels (rad/s)", &self.power_over_wheels),
        ]
    }
}
