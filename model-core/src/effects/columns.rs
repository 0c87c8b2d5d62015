//! The effects that coefficients hold: a few columns, each a cause and its coefficient, and their
//! ids in the image.

use super::layout::Side;
use super::term::{Effect, Scene, Term};
use crate::real::Real;
use crate::slip::SlipMemory;

/// Most columns that coefficients can hold. An effect has one, a slope fixed in the world two.
pub const MOST_COLUMNS: usize = 4;

/// What a coefficient multiplies: a term, or what acts on a sensor or has a state of its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cause<T> {
    /// A term at every instant; not [`Term::Winding`], whose warmth the next four say.
    Term(Term<T>),
    /// Winding loss that is greater throughout, as a share.
    Hot,
    /// Winding loss that follows the winding's own heat with this time constant, s; per watt of
    /// that heat.
    Heat(T),
    /// Winding loss that grows with the time of the run towards a share more, with this time
    /// constant, s: warmth from outside.
    Warming(T),
    /// Winding loss by measured temperatures of the motors above this one, °C; per kelvin.
    Temperature(T),
    /// The power comes later than the speed, s.
    Delay,
    /// Speeds of a side are off, as a share.
    Scale(Side),
    /// The slip at which 1/√2 of the scrub is there
    /// ([`SlipMemory::half_slip`](crate::slip::SlipMemory::half_slip)) is greater, as a share:
    /// nothing where the model has no such slip.
    HalfSlip,
}

/// A cause and its coefficient.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Column<T> {
    /// What is multiplied.
    pub cause: Cause<T>,
    /// By how much.
    pub coefficient: T,
}

/// What has to be measured besides speeds and power.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Needs {
    /// The robot's pitch.
    pub pitch: bool,
    /// The temperature of every motor.
    pub temperatures: bool,
    /// The driver of [`Term::Driver`].
    pub driver: bool,
}

impl Needs {
    /// Speeds and power are enough.
    pub fn nothing(self) -> bool {
        self == Self::default()
    }
}

/// A column as the image holds it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Encoded {
    /// Which cause: stable for good.
    pub(crate) id: u8,
    /// Wheel, side or direction, as the id has it; 0 where it has none.
    pub(crate) which: u8,
    /// Speed, time or temperature, as the id has it; 0 where it has none.
    pub(crate) shape: f32,
}

impl<T: Real> Cause<T> {
    /// What a log or board has to measure for it.
    pub fn needs(&self) -> Needs {
        Needs {
            pitch: matches!(self, Self::Term(Term::GradeByPitch)),
            temperatures: matches!(self, Self::Temperature(_)),
            driver: matches!(self, Self::Term(Term::Driver)),
        }
    }

    /// In another precision.
    pub fn convert<U: Real>(&self) -> Cause<U> {
        let number = |value: T| U::from_f64(value.to_f64());
        match *self {
            Self::Hot => Cause::Hot,
            Self::Heat(time) => Cause::Heat(number(time)),
            Self::Warming(time) => Cause::Warming(number(time)),
            Self::Temperature(cold) => Cause::Temperature(number(cold)),
            Self::Delay => Cause::Delay,
            Self::Scale(side) => Cause::Scale(side),
            Self::HalfSlip => Cause::HalfSlip,
            Self::Term(term) => Cause::Term(match term {
                Term::GradeByPitch => Term::GradeByPitch,
                Term::GradeAhead => Term::GradeAhead,
                Term::GradeAlong(along) => Term::GradeAlong(along.map(number)),
                Term::Winding => Term::Winding,
                Term::Windage => Term::Windage,
                Term::Stribeck(speed) => Term::Stribeck(number(speed)),
                Term::Viscous => Term::Viscous,
                Term::WarmUp(time) => Term::WarmUp(number(time)),
                Term::Rolling => Term::Rolling,
                Term::RollingFrom(from) => Term::RollingFrom(number(from)),
                Term::Offset => Term::Offset,
                Term::Drag(wheel) => Term::Drag(wheel),
                Term::Scrub => Term::Scrub,
                Term::ScrubPerKg => Term::ScrubPerKg,
                Term::Sliding(half_slip) => Term::Sliding(number(half_slip)),
                Term::OffCentre(empty) => Term::OffCentre(number(empty)),
                Term::GearLoad => Term::GearLoad,
                Term::GearShare => Term::GearShare,
                Term::Sag(with) => Term::Sag(number(with)),
                Term::Return => Term::Return,
                Term::Gain(with) => Term::Gain(number(with)),
                Term::Constant => Term::Constant,
                Term::StepAt(from) => Term::StepAt(number(from)),
                Term::WithMotion(hold) => Term::WithMotion(number(hold)),
                Term::Driver => Term::Driver,
            }),
        }
    }

    /// Its id in the image. `None` for what no image can hold: a bare [`Term::Winding`], and slopes
    /// along other directions than the two of the start.
    #[inline(never)]
    pub(crate) fn encode(&self) -> Option<Encoded> {
        let plain = |id| Encoded { id, which: 0, shape: 0.0 };
        let which = |id, which| Encoded { which, ..plain(id) };
        let shaped = |id, shape: T| Encoded { shape: shape.to_f64() as f32, ..plain(id) };
        let term = match *self {
            Self::Hot => return Some(plain(4)),
            Self::Heat(time) => return Some(shaped(5, time)),
            Self::Temperature(cold) => return Some(shaped(6, cold)),
            Self::Warming(time) => return Some(shaped(31, time)),
            Self::Delay => return Some(plain(25)),
            Self::HalfSlip => return Some(plain(29)),
            Self::Scale(Side::Both) => return Some(which(26, 0)),
            Self::Scale(Side::Left) => return Some(which(26, 1)),
            Self::Scale(Side::Right) => return Some(which(26, 2)),
            Self::Term(term) => term,
        };
        Some(match term {
            Term::GradeByPitch => plain(1),
            Term::GradeAhead => plain(2),
            Term::GradeAlong([x, y]) if x == T::ONE && y == T::ZERO => which(3, 0),
            Term::GradeAlong([x, y]) if x == T::ZERO && y == T::ONE => which(3, 1),
            Term::GradeAlong(_) | Term::Winding => return None,
            Term::Windage => plain(7),
            Term::Stribeck(speed) => shaped(8, speed),
            Term::Viscous => plain(9),
            Term::WarmUp(time) => shaped(10, time),
            Term::Rolling => plain(11),
            Term::RollingFrom(from) => shaped(12, from),
            Term::Offset => plain(13),
            Term::Drag(wheel) => which(14, wheel),
            Term::Scrub => plain(15),
            Term::ScrubPerKg => plain(16),
            Term::Sliding(half_slip) => shaped(28, half_slip),
            Term::OffCentre(empty) => shaped(30, empty),
            Term::GearLoad => plain(17),
            Term::GearShare => plain(27),
            Term::Sag(with) => shaped(18, with),
            Term::Return => plain(19),
            Term::Gain(with) => shaped(20, with),
            Term::Constant => plain(21),
            Term::StepAt(from) => shaped(22, from),
            // For ever: images hold finite numbers.
            Term::WithMotion(hold) if hold == T::INFINITY => which(23, 1),
            Term::WithMotion(hold) => shaped(23, hold),
            Term::Driver => plain(24),
        })
    }

    /// `None` for an unknown id.
    pub(crate) fn decode(encoded: Encoded) -> Option<Self> {
        let Encoded { id, which, shape } = encoded;
        let shape = T::from_f64(f64::from(shape));
        let (one, zero) = (T::ONE, T::ZERO);
        let cause = match (id, which) {
            (4, 0) => Self::Hot,
            (5, 0) => Self::Heat(shape),
            (6, 0) => Self::Temperature(shape),
            (31, 0) => Self::Warming(shape),
            (25, 0) => Self::Delay,
            (26, 0) => Self::Scale(Side::Both),
            (26, 1) => Self::Scale(Side::Left),
            (26, 2) => Self::Scale(Side::Right),
            (1, 0) => Self::Term(Term::GradeByPitch),
            (2, 0) => Self::Term(Term::GradeAhead),
            (3, 0) => Self::Term(Term::GradeAlong([one, zero])),
            (3, 1) => Self::Term(Term::GradeAlong([zero, one])),
            (7, 0) => Self::Term(Term::Windage),
            (8, 0) => Self::Term(Term::Stribeck(shape)),
            (9, 0) => Self::Term(Term::Viscous),
            (10, 0) => Self::Term(Term::WarmUp(shape)),
            (11, 0) => Self::Term(Term::Rolling),
            (12, 0) => Self::Term(Term::RollingFrom(shape)),
            (13, 0) => Self::Term(Term::Offset),
            (14, wheel) => Self::Term(Term::Drag(wheel)),
            (15, 0) => Self::Term(Term::Scrub),
            (16, 0) => Self::Term(Term::ScrubPerKg),
            (28, 0) => Self::Term(Term::Sliding(shape)),
            (29, 0) => Self::HalfSlip,
            (30, 0) => Self::Term(Term::OffCentre(shape)),
            (17, 0) => Self::Term(Term::GearLoad),
            (27, 0) => Self::Term(Term::GearShare),
            (18, 0) => Self::Term(Term::Sag(shape)),
            (19, 0) => Self::Term(Term::Return),
            (20, 0) => Self::Term(Term::Gain(shape)),
            (21, 0) => Self::Term(Term::Constant),
            (22, 0) => Self::Term(Term::StepAt(shape)),
            (23, 1) => Self::Term(Term::WithMotion(T::INFINITY)),
            (23, 0) => Self::Term(Term::WithMotion(shape)),
            (24, 0) => Self::Term(Term::Driver),
            _ => return None,
        };
        Some(cause)
    }
}

impl<T: Real> Column<T> {
    /// Whether coefficient and shape are finite and have a meaning: losses are not negative,
    /// factors do not vanish, times are positive, the wheel is one of `wheels`.
    fn is_sound(&self, wheels: usize) -> bool {
        let c = self.coefficient;
        let (loss, factor) = (c >= T::ZERO, c > -T::ONE);
        let positive = |shape: T| shape > T::ZERO && shape.is_finite();
        let not_negative = |shape: T| shape >= T::ZERO && shape.is_finite();
        let means = match self.cause {
            Cause::Hot | Cause::Term(Term::GearLoad | Term::GearShare) => loss,
            Cause::Term(Term::Sag(with)) => loss && not_negative(with),
            Cause::Heat(time) | Cause::Warming(time) => loss && positive(time),
            Cause::Temperature(cold) => loss && cold.is_finite(),
            Cause::Delay => true,
            Cause::Scale(_) | Cause::HalfSlip => factor,
            Cause::Term(Term::Gain(with)) => factor && not_negative(with),
            Cause::Term(
                Term::Stribeck(shape) | Term::WarmUp(shape) | Term::Sliding(shape) | Term::OffCentre(shape),
            ) => positive(shape),
            Cause::Term(Term::RollingFrom(from) | Term::StepAt(from)) => not_negative(from),
            Cause::Term(Term::WithMotion(hold)) => hold >= T::ZERO,
            Cause::Term(Term::Drag(wheel)) => usize::from(wheel) < wheels,
            Cause::Term(Term::Return) => loss && c <= T::ONE,
            Cause::Term(_) => true,
        };
        c.is_finite() && means
    }
}

/// Why columns cannot stand together, or at all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InvalidColumns {
    /// More than [`MOST_COLUMNS`].
    TooMany,
    /// No coefficients can hold the one at this place, or its numbers have no meaning.
    Value(usize),
    /// The one at this place stands before it already.
    Twice(usize),
}

/// At most [`MOST_COLUMNS`] columns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Columns<T> {
    columns: [Option<Column<T>>; MOST_COLUMNS],
}

impl<T: Real> Default for Columns<T> {
    fn default() -> Self {
        Self::NONE
    }
}

impl<T: Real> Columns<T> {
    /// No effects: the fitted model as it is.
    pub const NONE: Self = Self { columns: [None; MOST_COLUMNS] };

    /// Of a robot with so many wheels.
    ///
    /// # Errors
    /// The first column that cannot be held.
    pub fn new(list: &[Column<T>], wheels: usize) -> Result<Self, InvalidColumns> {
        let mut columns = Self::NONE;
        if list.len() > MOST_COLUMNS {
            return Err(InvalidColumns::TooMany);
        }
        for (place, (slot, column)) in columns.columns.iter_mut().zip(list).enumerate() {
            let encoded = column.cause.encode().filter(|_| column.is_sound(wheels));
            let Some(Encoded { id, which, .. }) = encoded else { return Err(InvalidColumns::Value(place)) };
            let same = |other: &Column<T>| {
                other.cause.encode().is_some_and(|other| (other.id, other.which) == (id, which))
            };
            if list.iter().take(place).any(same) {
                return Err(InvalidColumns::Twice(place));
            }
            *slot = Some(*column);
        }
        Ok(columns)
    }

    /// In the order given.
    pub fn iter(&self) -> impl Iterator<Item = &Column<T>> {
        self.columns.iter().flatten()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.iter().count()
    }

    /// The fitted model is as it is.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// What has to be measured besides speeds and power.
    pub fn needs(&self) -> Needs {
        let mut needs = Needs::default();
        for column in self.iter() {
            let of_column = column.cause.needs();
            needs.pitch |= of_column.pitch;
            needs.temperatures |= of_column.temperatures;
            needs.driver |= of_column.driver;
        }
        needs
    }

    /// The delay of the power, s.
    pub fn delay(&self) -> T {
        let of = |column: &Column<T>| match column.cause {
            Cause::Delay => column.coefficient,
            _ => T::ZERO,
        };
        self.iter().map(of).sum()
    }

    /// The fitted slip memory, with a greater half slip where the columns have one.
    pub(crate) fn softened(&self, memory: &SlipMemory<T>) -> SlipMemory<T> {
        let of = |column: &Column<T>| match column.cause {
            Cause::HalfSlip => column.coefficient,
            _ => T::ZERO,
        };
        let share: T = self.iter().map(of).sum();
        SlipMemory { half_slip: memory.half_slip * (T::ONE + share), ..*memory }
    }

    /// The terms, with one [`Term::Winding`] for all that warms windings: its coefficient is 1, and
    /// its warmth is
    /// [`Self::warmth`].
    pub(crate) fn terms(&self) -> Terms<T> {
        let mut terms =
            Terms { list: [Effect { term: Term::Winding, coefficient: T::ONE }; MOST_COLUMNS], length: 0 };
        let warms = |column: &Column<T>| {
            matches!(column.cause, Cause::Hot | Cause::Heat(_) | Cause::Warming(_) | Cause::Temperature(_))
        };
        let winding = self.iter().any(warms).then_some(Effect { term: Term::Winding, coefficient: T::ONE });
        let others = self.iter().filter_map(|column| match column.cause {
            Cause::Term(term) => Some(Effect { term, coefficient: column.coefficient }),
            _ => None,
        });
        for (slot, effect) in terms.list.iter_mut().zip(winding.into_iter().chain(others)) {
            *slot = effect;
            terms.length += 1;
        }
        terms
    }

    /// By how much the loss of a winding is greater, as a share: so long into the run in s, its own
    /// heat in W, its temperature in °C.
    pub(crate) fn warmth(&self, time: T, heat: T, temperature: T) -> T {
        let of = |column: &Column<T>| match column.cause {
            Cause::Hot => column.coefficient,
            Cause::Heat(_) => column.coefficient * heat,
            Cause::Warming(constant) => column.coefficient * (T::ONE - (-(time / constant)).exp()),
            Cause::Temperature(cold) => column.coefficient * (temperature - cold),
            _ => T::ZERO,
        };
        self.iter().map(of).sum()
    }

    /// In another precision.
    pub fn convert<U: Real>(&self) -> Columns<U> {
        Columns {
            columns: self.columns.map(|column| {
                column.map(|column| Column {
                    cause: column.cause.convert(),
                    coefficient: U::from_f64(column.coefficient.to_f64()),
                })
            }),
        }
    }
}

/// Effects to run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Terms<T> {
    list: [Effect<T>; MOST_COLUMNS],
    length: usize,
}

impl<T: Real> Terms<T> {
    pub(crate) fn as_slice(&self) -> &[Effect<T>] {
        self.list.get(..self.length).unwrap_or(&[])
    }
}

/// A scene at rest at the start of a run.
impl<T: Real, const N: usize> Scene<T, N> {
    /// Of a robot of this mass (kg), with nothing measured besides speeds and power.
    pub(crate) fn at_start(mass: T) -> Self {
        Self {
            mass,
            time: T::ZERO,
            pitch: T::ZERO,
            heading: [T::ONE, T::ZERO],
            warmth: [T::ZERO; N],
            still: T::ZERO,
            driver: T::ZERO,
        }
    }
}
