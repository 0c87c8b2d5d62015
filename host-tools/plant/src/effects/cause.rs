//! A cause at work, and what it is built from.

use std::fmt::Debug;

use rand::RngExt;
use support::error::Result;

use super::super::kinematics::{Geometry, Kinematics};
use super::super::noise::{Stream, stream};
use super::super::scenario::Scenario;
use super::conditions::{Conditions, Now};
use super::entry::{Effect, Entry};

/// An effect of the dictionary with what builds its cause.
#[derive(Debug, Clone, Copy)]
pub(super) struct Listed {
    pub(super) entry: Entry,
    pub(super) build: fn(&Effect, &Setting<'_>) -> Result<Box<dyn Cause>>,
}

/// The run in which an effect is to act.
pub(in super::super) struct Setting<'a> {
    pub(in super::super) scenario: &'a Scenario,
    /// Place of the effect among those of the run: each draws its own random numbers.
    pub(in super::super) place: u64,
}

/// A physical cause in the plant: changes the conditions of every step by what is known at its
/// start.
pub(in super::super) trait Cause: Debug + Send + Sync + CloneBox {
    /// Acts on the step that begins now.
    fn act(&mut self, now: &Now, conditions: &mut Conditions);
}

/// Clones a boxed cause, so that a run in progress can be cloned.
pub(in super::super) trait CloneBox {
    fn clone_box(&self) -> Box<dyn Cause>;
}

impl<C: Cause + Clone + 'static> CloneBox for C {
    fn clone_box(&self) -> Box<dyn Cause> {
        Box::new(self.clone())
    }
}

impl Clone for Box<dyn Cause> {
    fn clone(&self) -> Self {
        (**self).clone_box()
    }
}

/// A size that is 0 until the effect begins.
#[derive(Debug, Clone, Copy)]
pub(super) struct Onset {
    pub(super) size: f64,
    pub(super) at_s: f64,
}

impl Onset {
    /// Size at a time. Half a nanosecond of slack: a step belongs to the sample at its very time
    /// despite rounding.
    pub(super) fn at(self, time_s: f64) -> f64 {
        if time_s + 0.5e-9 >= self.at_s { self.size } else { 0.0 }
    }
}

/// Size and onset of an effect that begins at a given time.
pub(super) fn onset(effect: &Effect) -> Onset {
    Onset { size: effect.size(), at_s: effect.option("at").unwrap_or(0.0) }
}

/// Size and onset of an effect: without a given time it begins between a quarter and three quarters
/// of the run.
pub(super) fn onset_drawn(effect: &Effect, setting: &Setting<'_>) -> Onset {
    let mut rng = stream(setting.scenario.seed, Stream::Onset);
    let drawn = (0..=setting.place).map(|_| rng.random_range(0.25..0.75)).last().unwrap_or(0.5);
    let at_s = effect.option("at").unwrap_or(drawn * setting.scenario.duration_s);
    Onset { size: effect.size(), at_s }
}

/// Index of the front wheel of the side that the effect names.
pub(super) fn wheel_of_side(effect: &Effect, geometry: &Geometry) -> usize {
    let right = effect.number("side") == 1.0;
    match (right, geometry.kinematics) {
        (false, _) => 0,
        (true, Kinematics::Omni) => 2,
        (true, _) => 1,
    }
}
