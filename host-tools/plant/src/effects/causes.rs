//! The effects of a run at work.

use support::error::Result;

use super::super::body::WheelStep;
use super::super::kinematics::{MAX_WHEELS, Twist};
use super::super::scenario::Scenario;
use super::cause::{Cause, Setting};
use super::conditions::{Conditions, Now};
use super::list::listed;
use super::processor::Processor;

/// All causes of a run, with what they need to know of it.
#[derive(Debug, Clone)]
pub(in super::super) struct Causes {
    causes: Vec<Box<dyn Cause>>,
    processor: Processor,
    untouched: Conditions,
    now: Now,
    conditions: Conditions,
}

impl Causes {
    /// The causes of a run about to start.
    ///
    /// # Errors
    /// Usage: an effect that makes no sense for this robot.
    pub(in super::super) fn new(scenario: &Scenario) -> Result<Self> {
        let untouched = Conditions::new(&scenario.robot);
        let mut effects: Vec<_> = (0..).zip(&scenario.effects).collect();
        // What others weigh with comes first, in whatever order they were asked for: the mass, then
        // the slope.
        effects.sort_by_key(|(_, effect)| match effect.id() {
            "payload-mislabel" => 0,
            "grade" => 1,
            _ => 2,
        });
        let causes = effects
            .into_iter()
            .map(|(place, effect)| (listed(effect).build)(effect, &Setting { scenario, place }));
        Ok(Self {
            causes: causes.collect::<Result<_>>()?,
            processor: Processor::new(scenario.seed),
            now: Now {
                time_s: 0.0,
                step_s: scenario.step_s,
                mass_kg: scenario.payload.mass_at(0.0),
                twist: [0.0; 3],
                heading_rad: 0.0,
                wheel_rad_s: [0.0; MAX_WHEELS],
                last: [WheelStep::default(); MAX_WHEELS],
                winding_ohm: untouched.wheels.map(|wheel| wheel.motor.resistance_ohm),
                cpu_percent: 0.0,
            },
            conditions: untouched.clone(),
            untouched,
        })
    }

    /// Whether nothing changes ever.
    pub(in super::super) fn is_empty(&self) -> bool {
        self.causes.is_empty()
    }

    /// What holds in the present step.
    pub(in super::super) fn conditions(&self) -> &Conditions {
        &self.conditions
    }

    /// Load of the computer at a time that never goes back, percent.
    pub(in super::super) fn cpu_percent_at(&mut self, time_s: f64) -> f64 {
        self.processor.percent_at(time_s)
    }

    /// The conditions of the step that begins at `time_s` with `mass_kg` noted.
    pub(in super::super) fn begin(&mut self, time_s: f64, mass_kg: f64) {
        if self.is_empty() {
            return;
        }
        (self.now.time_s, self.now.mass_kg) = (time_s, mass_kg);
        self.now.cpu_percent = self.processor.percent_at(time_s);
        self.conditions.clone_from(&self.untouched);
        for cause in &mut self.causes {
            cause.act(&self.now, &mut self.conditions);
        }
    }

    /// What came of the step.
    pub(in super::super) fn end(
        &mut self,
        steps: &[WheelStep; MAX_WHEELS],
        twist: Twist,
        wheel_rad_s: [f64; MAX_WHEELS],
    ) {
        let now = &mut self.now;
        now.heading_rad += 0.5 * (now.twist[2] + twist[2]) * now.step_s;
        (now.twist, now.wheel_rad_s, now.last) = (twist, wheel_rad_s, *steps);
        now.winding_ohm = self.conditions.wheels.map(|wheel| wheel.motor.resistance_ohm);
    }
}
