//! Sensors that are wrong.

use std::collections::VecDeque;

use super::super::kinematics::{Geometry, Kinematics};
use super::cause::{Cause, Listed, Onset, onset, wheel_of_side};
use super::conditions::{Conditions, Now};
use super::entry::{Effect, Entry};
use super::options::{AT, SIDE};

pub(super) const GAIN: Listed = Listed {
    entry: Entry {
        id: "sensor-gain",
        meaning: "The power sensor reads a factor off: another shunt than its calibration says.",
        unit: "reading over truth, minus 1",
        range: (-0.5, 0.5),
        options: &[AT],
    },
    build: |effect, _| Ok(Box::new(Gain { error: onset(effect) })),
};

#[derive(Debug, Clone)]
struct Gain {
    error: Onset,
}

impl Cause for Gain {
    fn act(&mut self, now: &Now, conditions: &mut Conditions) {
        conditions.power_gain *= 1.0 + self.error.at(now.time_s);
    }
}

pub(super) const OFFSET: Listed = Listed {
    entry: Entry {
        id: "sensor-offset",
        meaning: "The power sensor reads a constant off.",
        unit: "reading without power, W",
        range: (-5.0, 5.0),
        options: &[AT],
    },
    build: |effect, _| Ok(Box::new(Offset { error: onset(effect) })),
};

#[derive(Debug, Clone)]
struct Offset {
    error: Onset,
}

impl Cause for Offset {
    fn act(&mut self, now: &Now, conditions: &mut Conditions) {
        conditions.power_offset_w += self.error.at(now.time_s);
    }
}

pub(super) const DELAY: Listed = Listed {
    entry: Entry {
        id: "sensor-delay",
        meaning: "The readings of power and of speed are shifted in time against each other.",
        unit: "by how much power is late, s; negative: speed is late",
        range: (-0.5, 0.5),
        options: &[],
        // The readings are delayed by the measuring chain itself.
    },
    build: |_, _| Ok(Box::new(Nothing)),
};

#[derive(Debug, Clone)]
struct Nothing;

impl Cause for Nothing {
    fn act(&mut self, _: &Now, _: &mut Conditions) {}
}

/// By how much power is late in a run with these effects, s.
pub(in super::super) fn power_delay_s(effects: &[Effect]) -> f64 {
    effects.iter().filter(|effect| effect.id() == DELAY.entry.id).map(Effect::size).sum()
}

/// A line that gives back what went in some steps ago, and its start before that.
#[derive(Debug, Clone)]
pub(in super::super) struct DelayLine<T> {
    steps: usize,
    queue: VecDeque<T>,
}

impl<T: Copy> DelayLine<T> {
    /// A line of `delay_s` (to the nearest step; 0 if negative) that was filled with `start`.
    pub(in super::super) fn new(delay_s: f64, step_s: f64, start: T) -> Self {
        let steps = (delay_s / step_s).round().max(0.0) as usize;
        Self { steps, queue: VecDeque::from(vec![start; steps]) }
    }

    /// Takes the present value and gives the delayed one.
    pub(in super::super) fn pass(&mut self, value: T) -> T {
        if self.steps == 0 {
            return value;
        }
        self.queue.push_back(value);
        self.queue.pop_front().unwrap_or(value)
    }
}

pub(super) const SPEED_SCALE: Listed = Listed {
    entry: Entry {
        id: "speed-scale",
        meaning: "The wheels of one side are smaller or larger than noted, or their encoder counts wrongly: loop and log \
              read their speed a factor off.",
        unit: "reading over truth, minus 1",
        range: (-0.3, 0.3),
        options: &[SIDE, AT],
    },
    build: |effect, setting| {
        let geometry = setting.scenario.robot.geometry;
        let front = wheel_of_side(effect, &geometry);
        let wheels = wheels_of_side(front, &geometry);
        Ok(Box::new(SpeedScale { error: onset(effect), wheels }))
    },
};

fn wheels_of_side(front: usize, geometry: &Geometry) -> Vec<usize> {
    match geometry.kinematics {
        Kinematics::Differential | Kinematics::Omni => vec![front],
        Kinematics::Skid | Kinematics::Mecanum => vec![front, front + 2],
    }
}

#[derive(Debug, Clone)]
struct SpeedScale {
    error: Onset,
    wheels: Vec<usize>,
}

impl Cause for SpeedScale {
    fn act(&mut self, now: &Now, conditions: &mut Conditions) {
        for &wheel in &self.wheels {
            conditions.speed_scale[wheel] *= 1.0 + self.error.at(now.time_s);
        }
    }
}
