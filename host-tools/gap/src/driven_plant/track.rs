//! The power that the plant draws along the recorded wheel speeds.

use logs::robot::chassis::{Chassis, PerWheel};
use logs::robot::{Geometry, Robot};
use logs::runs::RawRun;
use model_core::filter::{Channel, LowPass};
use plant::drive::Drive;
use plant::{
    Effect, Kinematics, MAX_WHEELS, PayloadSchedule, PlantSet, Profile, Robot as Machine, Scenario, Sensors,
    Simulation,
};
use support::error::{Error, Result};

use residuals::thresholds::driven_plant::{LEAD_S, MOST_CUTOFF, SMOOTHER, STEP_S};

/// A plant that can follow a robot's wheel speeds.
#[derive(Debug, Clone)]
pub struct Follower {
    /// Motors, gears, wheels and body.
    pub machine: Machine,
    /// The motors' drives.
    pub drive: Drive,
    /// Delay of the log's power after its speeds, s.
    pub delay_s: f64,
}

/// What the plant did along a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Followed {
    /// Energy drawn since the start, J, at the end of every step; power before effects on sensors
    /// included.
    energy_j: Vec<f64>,
    /// By how much plant time is ahead of the log's, s.
    lead_s: f64,
    /// Root mean square error of the plant's wheel speeds, as a share of the recorded ones.
    pub missed: f64,
}

impl Follower {
    /// The motors of `set` on a robot with these wheels.
    ///
    /// # Errors
    /// Usage: a layout that the plant does not have.
    pub fn new(set: PlantSet, robot: &Robot) -> Result<Self> {
        let (kinematics, radius, track, wheelbase) = match *robot.geometry() {
            Geometry::DifferentialDrive { wheel_radius_m, track_m }
            | Geometry::SkidSteer { wheel_radius_m, track_m, wheels: 2 } => {
                (Kinematics::Differential, wheel_radius_m, track_m, track_m)
            }
            Geometry::SkidSteer { wheel_radius_m, track_m, .. } => {
                (Kinematics::Skid, wheel_radius_m, track_m, track_m)
            }
            Geometry::ThreeWheelOmni { wheel_radius_m, arm_m } => {
                (Kinematics::Omni, wheel_radius_m, 2.0 * arm_m, 2.0 * arm_m)
            }
            Geometry::FourMecanum { wheel_radius_m, half_length_m, half_width_m } => {
                (Kinematics::Mecanum, wheel_radius_m, 2.0 * half_width_m, 2.0 * half_length_m)
            }
            Geometry::Matrix { .. } => {
                return Err(Error::usage(
                    "--plant: the robot's kinematics are a matrix; expected differential, skid-steer, omni3 or mecanum, \
                     which the plant can simulate",
                ));
            }
        };
        let mut machine = Machine::new(set, kinematics);
        machine.geometry.wheel_radius_m = radius;
        machine.geometry.track_m = track;
        machine.geometry.wheelbase_m = wheelbase;
        machine.gyration_radius_m = robot.gyration_radius_m();
        machine.loop_noise_rad_s = 0.0;
        let drive = Drive { regeneration: robot.regeneration(), ..Drive::default() };
        Ok(Self { machine, drive, delay_s: 0.0 })
    }

    /// Drives along a run with effects in the plant.
    ///
    /// # Errors
    /// An effect that makes no sense for the robot; a run that the filter cannot follow.
    pub fn follow(&self, robot: &Chassis, run: &RawRun, effects: &[Effect]) -> Result<Followed> {
        let speeds = smoothed(robot, run)?;
        let start = run.rows.first().map_or(0.0, |row| row.0);
        let end = run.rows.last().map_or(0.0, |row| row.0) - start;
        let at_rest = speeds.first().is_none_or(|w| w.iter().all(|w| w.abs() <= robot.dead_band()));
        let lead_s = if at_rest { 0.0 } else { LEAD_S };
        let mut knots = vec![(0.0, [0.0; MAX_WHEELS])];
        let mut masses: Vec<(f64, f64)> = Vec::new();
        for ((time, _, mass, _), speed) in run.rows.iter().zip(&speeds) {
            let at = time - start + lead_s;
            if at > knots[knots.len() - 1].0 {
                knots.push((at, std::array::from_fn(|i| speed.get(i).copied().unwrap_or(0.0))));
            }
            if masses.last().is_none_or(|(_, last)| last != mass) {
                let from = if masses.is_empty() { 0.0 } else { at };
                masses.push((from, *mass));
            }
        }
        let scenario = Scenario {
            robot: self.machine.clone(),
            drive: self.drive,
            profile: Profile::from_wheel_speeds(knots),
            payload: PayloadSchedule::steps(masses)?,
            duration_s: end + lead_s + 1.0,
            rate_hz: 1.0 / STEP_S,
            sensors: Sensors::exact(),
            static_power_w: 0.0,
            seed: 0,
            effects: effects.iter().map(|effect| later(effect, lead_s)).collect::<Result<_>>()?,
            step_s: STEP_S,
        };
        let mut energy_j = vec![0.0];
        let (mut missed, mut asked) = (0.0, 0.0);
        let mut next = run.rows.iter().zip(&speeds).peekable();
        for sample in Simulation::new(&scenario)?.skip(1) {
            let last = energy_j[energy_j.len() - 1];
            energy_j.push(last + sample.power_w * STEP_S);
            while let Some(((time, ..), speed)) = next.peek()
                && time - start + lead_s <= sample.time_s
            {
                for (wanted, driven) in speed.iter().zip(sample.wheel_rad_s) {
                    missed += (wanted - driven).powi(2);
                    asked += wanted * wanted;
                }
                next.next();
            }
        }
        let missed = if asked > 0.0 { (missed / asked).sqrt() } else { 0.0 };
        Ok(Followed { energy_j, lead_s, missed })
    }
}

impl Followed {
    /// Power at every row of the run, W: the mean over a sample period about it, as a sensor
    /// averages; `delay_s` later.
    pub fn power(&self, run: &RawRun, delay_s: f64) -> Vec<f64> {
        let start = run.rows.first().map_or(0.0, |row| row.0);
        let energy = |time: f64| {
            let place = (time / STEP_S).clamp(0.0, (self.energy_j.len() - 1) as f64);
            let from = (place as usize).min(self.energy_j.len().saturating_sub(2));
            let share = place - from as f64;
            let next = self.energy_j.get(from + 1).copied().unwrap_or(self.energy_j[from]);
            self.energy_j[from] + share * (next - self.energy_j[from])
        };
        let half = 0.5 * run.period_s;
        run.rows
            .iter()
            .map(|(time, ..)| {
                let at = time - start + self.lead_s - delay_s;
                // Before the start nothing has been drawn yet: the first mean stands for it.
                let at = at.max(half);
                (energy(at + half) - energy(at - half)) / run.period_s
            })
            .collect()
    }
}

/// An effect that begins at a time of the log. In the plant it begins later: the plant has to get
/// going first.
fn later(effect: &Effect, lead_s: f64) -> Result<Effect> {
    match effect.option("at") {
        Some(at) if lead_s > 0.0 && at > 0.0 => effect.clone().with("at", at + lead_s),
        _ => Ok(effect.clone()),
    }
}

/// Wheel speeds, rad/s, smoothed without delay.
fn smoothed(robot: &Chassis, run: &RawRun) -> Result<Vec<PerWheel<f64>>> {
    let raw: Vec<PerWheel<f64>> = run.rows.iter().map(|(_, sample, ..)| sample.wheel_speed).collect();
    let cutoff = SMOOTHER * robot.cutoff_hz();
    if cutoff * run.period_s > MOST_CUTOFF {
        return Ok(raw);
    }
    let filter = LowPass::new(cutoff, run.period_s)
        .map_err(|_| Error::failed("too slow for the filter").in_file(&run.name))?;
    let pass = |values: &mut dyn Iterator<Item = f64>| {
        let mut channel = Channel::default();
        let mut first = true;
        let mut out = Vec::with_capacity(raw.len());
        for value in values {
            if std::mem::take(&mut first) {
                filter.settle(&mut channel, value);
            }
            out.push(filter.step(&mut channel, value).value);
        }
        out
    };
    let backwards: Vec<Vec<f64>> = (0..robot.wheels())
        .map(|wheel| {
            let there = pass(&mut raw.iter().map(|speeds| speeds[wheel]));
            pass(&mut there.into_iter().rev())
        })
        .collect();
    let rows = (0..raw.len()).rev();
    Ok(rows.map(|row| PerWheel::new(robot.wheels(), |wheel| backwards[wheel][row])).collect())
}
