//! What a coefficient of an effect multiplies in the regression.

use std::sync::Arc;

use model_core::effects::Term;

/// What steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Switched {
    /// The static power, W.
    Static,
    /// Rolling resistance, N·m/kg.
    Rolling,
    /// The slip at which half of the base's scrub is there, as a share.
    HalfSlip,
}

impl Switched {
    /// The term from a time on, where the board's model has one.
    pub fn from(self, time: f64) -> Option<Term<f64>> {
        match self {
            Self::Static => Some(Term::StepAt(time)),
            Self::Rolling => Some(Term::RollingFrom(time)),
            Self::HalfSlip => None,
        }
    }

    /// What it comes to if it is there throughout.
    pub fn throughout(self) -> Regressor {
        match self {
            Self::Static => Regressor::Term(Term::Constant),
            Self::Rolling => Regressor::Term(Term::Rolling),
            Self::HalfSlip => Regressor::HalfSlip,
        }
    }
}

/// See [`Regressor::range`]. Chosen: an order of magnitude either way.
pub const HALF_SLIP: (f64, f64) = (-0.9, 9.0);

/// One thing that a coefficient multiplies.
#[derive(Debug, Clone, PartialEq)]
pub enum Regressor {
    /// A term of the board's model, in all runs.
    Term(Term<f64>),
    /// A term of the board's model in one run.
    InRun(usize, Term<f64>),
    /// Winding loss that follows a thermal state with this time constant, s; per watt of mean heat.
    Heat(f64),
    /// Winding loss that grows with time towards a share more, with this time constant, s.
    Warming(f64),
    /// Winding loss that is greater throughout, as a share.
    Hot,
    /// Winding loss by the columns of motor temperatures, from this place on; per kelvin above `1`
    /// (°C).
    Temperature(usize, f64),
    /// A step of power, W, of rolling torque, N·m/kg, or of the half slip, as a share, of one size
    /// at a time of its own in each run; infinite where there is none.
    Switch(Switched, Arc<[f64]>),
    /// The mass of one run is off, kg.
    Mass(usize),
    /// The masses of all runs are off, kg.
    Masses,
    /// The power comes later than the speed, s.
    Delay,
    /// Speeds of one side (−1 left, 1 right, 0 both) are off, as a share.
    Scale(f64),
    /// The slip at which half of the base's scrub is there is greater, as a share.
    HalfSlip,
    /// A further column, W per its unit.
    Column(usize),
}

impl Regressor {
    /// Its shape parameter, if it has one that may be searched.
    pub fn shape(&self) -> Option<f64> {
        self.clone().shape_mut().map(|shape| *shape).filter(|shape| shape.is_finite())
    }

    /// The same with a different shape parameter.
    #[must_use]
    pub fn with_shape(&self, shape: f64) -> Self {
        let mut other = self.clone();
        if let Some(place) = other.shape_mut() {
            *place = shape;
        }
        other
    }

    fn shape_mut(&mut self) -> Option<&mut f64> {
        match self {
            Self::Term(
                Term::Stribeck(shape)
                | Term::WarmUp(shape)
                | Term::Sliding(shape)
                | Term::RollingFrom(shape)
                | Term::StepAt(shape)
                | Term::WithMotion(shape),
            )
            | Self::Heat(shape)
            | Self::Warming(shape) => Some(shape),
            _ => None,
        }
    }

    /// What it comes to at the end of its shape's range, where nothing of its shape shows: a
    /// warm-up that takes longer than the runs is grease that is thicker, a switch at the start is
    /// none.
    pub fn limit(&self) -> Option<Self> {
        match self {
            Self::Term(Term::WarmUp(_)) => Some(Self::Term(Term::Viscous)),
            Self::Term(Term::RollingFrom(_)) => Some(Switched::Rolling.throughout()),
            Self::Term(Term::StepAt(_) | Term::WithMotion(_)) => Some(Switched::Static.throughout()),
            Self::Switch(what, _) => Some(what.throughout()),
            _ => None,
        }
    }

    /// When it begins in all runs, s since the start, if it begins at a time.
    pub fn begins(&self) -> Option<f64> {
        match self {
            Self::Term(Term::RollingFrom(at) | Term::StepAt(at)) => Some(*at),
            _ => None,
        }
    }

    /// Where its shape parameter is looked for: times are known to their grid, the others to a
    /// factor of two.
    pub fn interval(&self) -> Option<(f64, f64)> {
        let shape = self.shape()?;
        Some(match self {
            _ if self.begins().is_some() => (shape - 1.5, shape + 1.5),
            Self::Term(Term::WithMotion(_)) => (0.5 * shape - 0.5, 2.0 * shape + 0.5),
            _ => (0.5 * shape, 2.0 * shape),
        })
    }

    /// The coefficients that it can have beside another's: from a tenth of the half slip to ten
    /// times as much. `None` where what it stands with says so.
    pub fn range(&self) -> Option<(f64, f64)> {
        matches!(self, Self::HalfSlip).then_some(HALF_SLIP)
    }

    /// The one run that it concerns.
    pub fn run(&self) -> Option<usize> {
        match self {
            Self::InRun(run, _) | Self::Mass(run) => Some(*run),
            _ => None,
        }
    }
}
