//! Sensors that stand still while others change.

use serde::Serialize;

use super::{POWER, speed_column};
use crate::robot::Robot;

/// A column that kept its value while others changed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Stuck {
    /// Name of the column.
    pub column: String,
    /// The value it kept.
    pub value: f64,
    /// First line of the longest such stretch.
    pub line: u64,
    /// Time of it, s.
    pub from_s: f64,
    /// End of it, s.
    pub to_s: f64,
    /// Time of all such stretches, s.
    pub total_s: f64,
}

/// A value must stand still for this long, s, and this many rows: wheels held at a speed do for a
/// while.
const STUCK_S: f64 = 5.0;
const STUCK_ROWS: u64 = 8;

/// The others must change this often meanwhile, and in this share of the rows: sensors that are
/// read seldom keep their values for some rows.
const OTHERS_CHANGE: u64 = 8;
const OTHERS_CHANGE_SHARE: u64 = 20;

/// Others have moved where they are further from where they were than so many of their smallest
/// steps: a register of coarse steps that goes to and fro between two of them says that nothing
/// moves.
const STEPS: f64 = 1.5;

/// Watches one column for standing still.
struct Standing {
    column: String,
    value: f64,
    line: u64,
    from_s: f64,
    to_s: f64,
    rows: u64,
    others_changed: u64,
    /// All wheels' speeds as the stretch began.
    speeds: Vec<f64>,
    longest: Option<Stuck>,
}

impl Standing {
    fn new(column: String) -> Self {
        Self {
            column,
            value: f64::NAN,
            line: 0,
            from_s: 0.0,
            to_s: 0.0,
            rows: 0,
            others_changed: 0,
            speeds: Vec::new(),
            longest: None,
        }
    }

    /// Another value in this row; `others` are the wheels beside it that changed, each with the
    /// smallest step that it ever made.
    fn add(
        &mut self,
        (line, time_s): (u64, f64),
        value: f64,
        speeds: &[f64],
        mut others: impl Iterator<Item = (usize, f64)>,
    ) {
        if value == self.value {
            self.rows += 1;
            let moved = others.any(|(wheel, step)| (speeds[wheel] - self.speeds[wheel]).abs() > STEPS * step);
            self.others_changed += u64::from(moved);
            self.to_s = time_s;
            return;
        }
        self.close();
        (self.value, self.line, self.from_s, self.to_s) = (value, line, time_s, time_s);
        (self.rows, self.others_changed) = (1, 0);
        self.speeds.clear();
        self.speeds.extend_from_slice(speeds);
    }

    fn restart(&mut self) {
        self.close();
        self.value = f64::NAN;
    }

    fn close(&mut self) {
        let seconds = self.to_s - self.from_s;
        let others =
            self.others_changed >= OTHERS_CHANGE && OTHERS_CHANGE_SHARE * self.others_changed >= self.rows;
        let stuck = seconds >= STUCK_S && self.rows >= STUCK_ROWS && others;
        self.rows = 0;
        if !stuck {
            return;
        }
        let total_s = seconds + self.longest.as_ref().map_or(0.0, |longest| longest.total_s);
        match &mut self.longest {
            Some(longest) if longest.to_s - longest.from_s >= seconds => longest.total_s = total_s,
            longest => {
                *longest = Some(Stuck {
                    column: self.column.clone(),
                    value: self.value,
                    line: self.line,
                    from_s: self.from_s,
                    to_s: self.to_s,
                    total_s,
                });
            }
        }
    }

    fn finish(mut self) -> Option<Stuck> {
        self.close();
        self.longest
    }
}

/// A robot may turn about one of its wheels for so long, s.
const PIVOT_S: f64 = 30.0;

/// Watches power and the wheels of one log.
pub struct Standings<'a> {
    robot: &'a Robot,
    power: Standing,
    wheels: Vec<Standing>,
    before: Vec<f64>,
    /// The smallest change of each wheel.
    steps: Vec<f64>,
}

impl<'a> Standings<'a> {
    /// Of a log with the speeds of so many wheels of this robot.
    pub fn new(robot: &'a Robot, wheels: usize) -> Self {
        Self {
            robot,
            power: Standing::new(POWER.to_owned()),
            wheels: (0..wheels).map(|wheel| Standing::new(speed_column(wheel))).collect(),
            before: vec![0.0; wheels],
            steps: vec![f64::INFINITY; wheels],
        }
    }

    /// The next row, in whatever unit; `fresh` where it does not continue the row before.
    pub fn add(&mut self, line: u64, time_s: f64, fresh: bool, speeds: &[f64], power: f64) {
        if fresh {
            self.power.restart();
            self.wheels.iter_mut().for_each(Standing::restart);
        }
        let mut changed = Vec::new();
        if !fresh {
            for (wheel, (now, before)) in speeds.iter().zip(&self.before).enumerate() {
                let change = (now - before).abs();
                if change > 0.0 {
                    self.steps[wheel] = self.steps[wheel].min(change);
                    changed.push((wheel, self.steps[wheel]));
                }
            }
        }
        // Without wheels nothing tells whether power had a reason to change.
        self.power.add((line, time_s), power, speeds, changed.iter().copied());
        for (wheel, standing) in self.wheels.iter_mut().enumerate() {
            let others = changed.iter().copied().filter(|(other, _)| *other != wheel);
            standing.add((line, time_s), speeds[wheel], speeds, others);
        }
        self.before.copy_from_slice(speeds);
    }

    /// What stood still though it should not.
    pub fn finish(self) -> Vec<Stuck> {
        let robot = self.robot;
        std::iter::once(self.power)
            .chain(self.wheels)
            .filter_map(Standing::finish)
            .filter(|stuck| stuck.column == POWER || !may_stand(robot, stuck))
            .collect()
    }
}

/// Whether a wheel that stands while others turn does what it should: omnidirectional robots drive
/// along its axle, others turn about it.
fn may_stand(robot: &Robot, stuck: &Stuck) -> bool {
    let omnidirectional = robot.geometry().twist_components() == 3;
    stuck.value.abs() <= robot.speed_dead_band_rad_s()
        && (omnidirectional || stuck.to_s - stuck.from_s < PIVOT_S)
}

impl std::fmt::Display for Stuck {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { column, value, from_s, to_s, total_s, .. } = self;
        write!(
            f,
            "{column} stays at {value} from {from_s:.1} to {to_s:.1} s while others change ({total_s:.1} s in all)"
        )
    }
}
