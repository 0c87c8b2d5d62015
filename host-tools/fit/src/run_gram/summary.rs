//! What a run was, besides its sums.

use logs::Exclusions;
use serde::{Deserialize, Serialize};

/// Counts over bins of one width; the last one holds all beyond.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Histogram {
    /// Width of a bin, in the unit of what is counted.
    pub width: f64,
    /// Seconds in each.
    pub seconds: Vec<f64>,
}

/// Bins of a histogram.
const BINS: usize = 24;

impl Histogram {
    fn new(width: f64) -> Self {
        Self { width, seconds: vec![0.0; BINS] }
    }

    fn add(&mut self, value: f64, seconds: f64) {
        let bin = (value.abs() / self.width) as usize;
        self.seconds[bin.min(BINS - 1)] += seconds;
    }

    fn merge(&mut self, other: &Self) {
        self.seconds.iter_mut().zip(&other.seconds).for_each(|(sum, value)| *sum += value);
    }
}

/// Time, way and energy, of raw rows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Summary {
    /// First and last time, s.
    pub span_s: [f64; 2],
    /// Time between rows that continue each other, s.
    pub recorded_s: f64,
    /// Of that, with a wheel above the dead band, s.
    pub moving_s: f64,
    /// Way of the robot's middle, m, on wheels of the radius that its file says.
    pub distance_m: f64,
    /// Energy of the drives, J.
    pub energy_j: f64,
    /// Rows read.
    pub rows: u64,
    /// Steps of more than five sample periods.
    pub gaps: u64,
    /// What was left out, `cut_line` among it.
    pub exclusions: Exclusions,
    /// Fastest wheel, rad/s.
    pub fastest_rad_s: f64,
    /// Total masses, kg, and the seconds at each; at most 16, the last one holds the time of all
    /// others.
    pub masses: Vec<(f64, f64)>,
    /// Forward speed, m/s.
    pub speeds: Histogram,
    /// Turn rate, rad/s.
    pub turns: Histogram,
    /// Σ v u, Σ u² of forward speed and its command (`cmd_v_m_s`), where the log has one: their
    /// ratio is how far the robot went of what it was told.
    pub commanded: Option<[f64; 2]>,
}

/// Masses distinguished.
const MOST_MASSES: usize = 16;

/// To the gram.
const SAME_MASS: f64 = 1e-3;

/// A raw row, and how long it stood for.
pub(super) struct Moment {
    pub(super) time_s: f64,
    pub(super) elapsed_s: f64,
    pub(super) speed_m_s: f64,
    pub(super) turn_rad_s: f64,
    pub(super) fastest_rad_s: f64,
    pub(super) moves: bool,
    pub(super) power_w: f64,
    pub(super) mass_kg: f64,
    pub(super) command_m_s: f64,
}

impl Summary {
    /// Of no row, of a robot that drives up to so many m/s and rad/s.
    pub(super) fn new(fastest_m_s: f64, fastest_rad_s: f64, is_commanded: bool) -> Self {
        // The last bin is for what should not be.
        let width = |most: f64| most / (BINS - 1) as f64;
        Self {
            span_s: [f64::INFINITY, f64::NEG_INFINITY],
            recorded_s: 0.0,
            moving_s: 0.0,
            distance_m: 0.0,
            energy_j: 0.0,
            rows: 0,
            gaps: 0,
            exclusions: Exclusions::default(),
            fastest_rad_s: 0.0,
            masses: Vec::new(),
            speeds: Histogram::new(width(fastest_m_s)),
            turns: Histogram::new(width(fastest_rad_s)),
            commanded: is_commanded.then_some([0.0; 2]),
        }
    }

    pub(super) fn add(&mut self, now: &Moment, most_elapsed_s: f64) {
        self.rows += 1;
        self.span_s = [self.span_s[0].min(now.time_s), self.span_s[1].max(now.time_s)];
        self.fastest_rad_s = self.fastest_rad_s.max(now.fastest_rad_s);
        if !now.elapsed_s.is_finite() {
            return;
        }
        if now.elapsed_s > most_elapsed_s {
            self.gaps += 1;
            return;
        }
        let seconds = now.elapsed_s;
        self.recorded_s += seconds;
        self.moving_s += if now.moves { seconds } else { 0.0 };
        self.distance_m += now.speed_m_s.abs() * seconds;
        self.energy_j += now.power_w * seconds;
        self.speeds.add(now.speed_m_s, seconds);
        self.turns.add(now.turn_rad_s, seconds);
        self.at_mass(now.mass_kg, seconds);
        if let Some([with, square]) = &mut self.commanded
            && now.command_m_s.is_finite()
        {
            *with += now.speed_m_s * now.command_m_s * seconds;
            *square += now.command_m_s * now.command_m_s * seconds;
        }
    }

    fn at_mass(&mut self, mass: f64, seconds: f64) {
        let is_full = self.masses.len() == MOST_MASSES;
        let known = self.masses.iter_mut().find(|(known, _)| (*known - mass).abs() < SAME_MASS);
        match known {
            Some((_, time)) => *time += seconds,
            None if is_full => self.masses[MOST_MASSES - 1].1 += seconds,
            None => self.masses.push((mass, seconds)),
        }
    }

    /// Adds the other.
    pub fn merge(&mut self, other: &Self) {
        self.span_s = [self.span_s[0].min(other.span_s[0]), self.span_s[1].max(other.span_s[1])];
        self.recorded_s += other.recorded_s;
        self.moving_s += other.moving_s;
        self.distance_m += other.distance_m;
        self.energy_j += other.energy_j;
        self.rows += other.rows;
        self.gaps += other.gaps;
        self.exclusions.cut_line += other.exclusions.cut_line;
        self.exclusions.non_finite += other.exclusions.non_finite;
        let lines =
            [&self.exclusions, &other.exclusions].into_iter().filter_map(|one| one.first_non_finite_line);
        self.exclusions.first_non_finite_line = lines.min();
        self.fastest_rad_s = self.fastest_rad_s.max(other.fastest_rad_s);
        for (mass, seconds) in &other.masses {
            self.at_mass(*mass, *seconds);
        }
        // In an order that does not tell who was added to whom.
        self.masses.sort_by(|a, b| a.0.total_cmp(&b.0));
        self.speeds.merge(&other.speeds);
        self.turns.merge(&other.turns);
        self.commanded = match (self.commanded, other.commanded) {
            (Some(a), Some(b)) => Some([a[0] + b[0], a[1] + b[1]]),
            (one, other) => one.or(other),
        };
    }

    /// How far the robot went of what it was told: 1 on wheels of the radius that its file says;
    /// none without commands.
    pub fn way_per_command(&self) -> Option<f64> {
        self.commanded.filter(|[_, square]| *square > 0.0).map(|[with, square]| with / square)
    }
}
