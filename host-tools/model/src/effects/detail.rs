//! What is special about one way in which an effect shows: typed here, flat keys in JSON and files,
//! words for people.

use serde::{Serialize, Serializer};
use serde_json::{Map, Value, json};

use super::{PITCH, Sign, key};

/// What is special about a candidate.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Detail {
    /// Nothing.
    #[default]
    Plain,
    /// Which slope.
    Slope(Along),
    /// What makes the windings hotter.
    Heated(Heated),
    /// Wheel speed over which it fades, rad/s.
    Width {
        /// rad/s.
        speed_rad_s: f64,
    },
    /// Time over which it fades.
    TimeConstant {
        /// s.
        time_s: f64,
    },
    /// One wheel.
    Wheel {
        /// From 1.
        wheel: usize,
        /// Where it is.
        side: WheelSide,
    },
    /// The wheels of one side.
    Side(WheelSide),
    /// Whether it grows with the mass.
    DependsOnMass(bool),
    /// It grows with the mass, and shares the ground's grip with rolling.
    Sliding {
        /// Slip at which 1/√2 of it is there.
        half_slip: f64,
    },
    /// It grows with the mass, and changes the slip at which 1/√2 of the base's scrub is there: as
    /// a share the second coefficient.
    WithHalfSlip,
    /// A load off the centre, by how much more easily the robot turns.
    OffCentre {
        /// Mass of the empty robot, kg.
        empty_kg: f64,
    },
    /// A loss in proportion to the torque.
    InProportion,
    /// Static power that is measured along.
    WithStatic {
        /// W.
        power_w: f64,
    },
    /// While the robot moves, and some seconds longer; a little shorter where they are below 0.
    WithMotion {
        /// s.
        hold_s: f64,
    },
    /// From the first motion on.
    FromFirstMotion,
    /// From one time on, the same in all runs, s since the start.
    At {
        /// s.
        at_s: f64,
    },
    /// In all or some runs, there from times of their own on.
    InRuns {
        /// Which.
        runs: Runs,
        /// One a run, s since the start; none in runs without it. No list where it is there
        /// throughout.
        at_s: Option<Vec<Option<f64>>>,
    },
    /// A user's own.
    Formula {
        /// As written.
        formula: String,
        /// In words.
        meaning: String,
        /// The signs that its coefficient can have.
        sign: Sign,
        /// The least and greatest coefficient.
        range: (f64, f64),
    },
    /// What logs of power alone say, which know no more of it: figures by name.
    Levels(Vec<(&'static str, Value)>),
}

/// Which slope.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Along {
    /// The measured pitch.
    Pitch,
    /// Wherever the nose points.
    Ahead,
    /// A direction of the world.
    World,
}

/// What makes windings hotter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Heated {
    /// They are so from the start.
    FromStart,
    /// Their own loss, with a time constant in s.
    ByLoss(f64),
    /// The time of the run, with a time constant in s: warmth from outside.
    WithTime(f64),
    /// By measured temperatures above this one, °C.
    Measured(f64),
}

/// Wheels of a side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WheelSide {
    /// Left.
    Left,
    /// Right.
    Right,
    /// On neither side.
    Centre,
    /// All.
    Both,
}

/// Runs that something is about.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Runs {
    /// All of them.
    All,
    /// Those with these names.
    Named(Vec<String>),
}

impl WheelSide {
    /// Of a wheel: below 0 left, above 0 right, 0 neither.
    pub fn of(side: f64) -> Self {
        match side {
            side if side < 0.0 => Self::Left,
            side if side > 0.0 => Self::Right,
            _ => Self::Centre,
        }
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
            Self::Centre => "centre",
            Self::Both => "both",
        }
    }
}

impl Along {
    /// What it is along, as files say it; the pitch is no way.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pitch => PITCH,
            Self::Ahead => "the way ahead",
            Self::World => "a direction of the world",
        }
    }
}

/// What files say of windings that are hot from the start, and of a power that is there from the
/// first motion on.
pub(super) const FROM_START: &str = "the start";
pub(super) const FROM_MOTION: &str = "the first motion on";
/// What they say of a power that is there with motion.
pub(super) const MOTION: &str = "motion";
/// And of measured temperatures, and of the time of the run.
const BY_TEMPERATURES: &str = "motor temperatures";
pub(super) const BY_TIME: &str = "time";

impl Detail {
    /// The keys of JSON and coefficient files.
    pub fn fields(&self) -> Map<String, Value> {
        let value = match self {
            Self::Plain => json!({}),
            Self::Slope(along @ Along::Pitch) => json!({key::BY: along.name()}),
            Self::Slope(along) => json!({key::ALONG: along.name()}),
            Self::Heated(Heated::FromStart) => json!({key::FROM: FROM_START}),
            Self::Heated(Heated::ByLoss(time)) => json!({key::TIME_CONSTANT: time}),
            Self::Heated(Heated::WithTime(time)) => json!({key::BY: BY_TIME, key::TIME_CONSTANT: time}),
            Self::Heated(Heated::Measured(cold)) => json!({key::BY: BY_TEMPERATURES, key::FROM_C: cold}),
            Self::Width { speed_rad_s } => json!({key::SPEED: speed_rad_s}),
            Self::TimeConstant { time_s } => json!({key::TIME_CONSTANT: time_s}),
            Self::Wheel { wheel, side } => json!({key::WHEEL: wheel, key::SIDE: side.name()}),
            Self::Side(side) => json!({key::SIDE: side.name()}),
            Self::DependsOnMass(depends) => json!({key::DEPENDS_ON_MASS: depends}),
            Self::Sliding { half_slip } => json!({key::DEPENDS_ON_MASS: true, key::HALF_SLIP: half_slip}),
            Self::WithHalfSlip => json!({key::WITH: key::HALF_SLIP}),
            Self::OffCentre { empty_kg } => json!({key::EMPTY: empty_kg}),
            Self::InProportion => json!({key::IN_PROPORTION: true}),
            Self::WithStatic { power_w } => json!({key::WITH_STATIC: power_w}),
            Self::WithMotion { hold_s } => json!({key::WITH: MOTION, key::HOLD: hold_s}),
            Self::FromFirstMotion => json!({key::FROM: FROM_MOTION}),
            Self::At { at_s } => json!({key::AT: at_s, key::RUNS: Runs::All.json()}),
            Self::InRuns { runs, at_s: None } => json!({key::RUNS: runs.json()}),
            Self::InRuns { runs, at_s: Some(at_s) } => json!({key::RUNS: runs.json(), key::AT: at_s}),
            Self::Formula { formula, meaning, sign, range } => {
                json!({"formula": formula, "meaning": meaning, "sign": sign, "range": range})
            }
            Self::Levels(figures) => {
                return figures.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect();
            }
        };
        match value {
            Value::Object(fields) => fields,
            _ => Map::new(),
        }
    }

    /// The same with a different shape parameter, where it has any.
    #[must_use]
    pub fn with_shape(&self, shape: f64) -> Self {
        match self {
            Self::Width { .. } => Self::Width { speed_rad_s: shape },
            Self::Sliding { .. } => Self::Sliding { half_slip: shape },
            Self::TimeConstant { .. } => Self::TimeConstant { time_s: shape },
            Self::Heated(Heated::ByLoss(_)) => Self::Heated(Heated::ByLoss(shape)),
            Self::Heated(Heated::WithTime(_)) => Self::Heated(Heated::WithTime(shape)),
            Self::WithMotion { .. } => Self::WithMotion { hold_s: shape },
            Self::At { .. } => Self::At { at_s: shape },
            other => other.clone(),
        }
    }

    /// Leaves the runs that are kept, of as many that it names.
    pub fn keep(&mut self, kept: &[bool]) {
        let Self::InRuns { runs, at_s } = self else { return };
        if let Runs::Named(names) = runs
            && names.len() == kept.len()
        {
            let mut each = kept.iter();
            names.retain(|_| each.next().copied().unwrap_or(true));
        }
        if let Some(times) = at_s
            && times.len() == kept.len()
        {
            let mut each = kept.iter();
            times.retain(|_| each.next().copied().unwrap_or(true));
        }
    }
}

impl Runs {
    fn json(&self) -> Value {
        match self {
            Self::All => json!("all"),
            Self::Named(names) => json!(names),
        }
    }
}

impl Serialize for Detail {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.fields().serialize(serializer)
    }
}
