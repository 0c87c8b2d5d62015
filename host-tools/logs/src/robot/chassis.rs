//! A robot with as many wheels as it has: what looks at whole logs is compiled once for all.

use std::any::Any;
use std::ops::Deref;
use std::sync::Arc;

use model_core::coefficients::{MOST_WHEELS, Robot as CoreRobot};
use model_core::conditioning::Conditioning;
use model_core::effects::Layout;
use model_core::kinematics::Twist;
use model_core::model::MassRange;
use model_core::motion::{Motion, Wheel};
use nalgebra::DMatrix;

/// The robot as model-core knows it, by its number of wheels.
#[derive(Debug, Clone, PartialEq)]
pub enum Chassis {
    /// With one wheel.
    One(Arc<CoreRobot<f64, 1>>),
    /// With two.
    Two(Arc<CoreRobot<f64, 2>>),
    /// With three.
    Three(Arc<CoreRobot<f64, 3>>),
    /// With four.
    Four(Arc<CoreRobot<f64, 4>>),
    /// With five.
    Five(Arc<CoreRobot<f64, 5>>),
    /// With six.
    Six(Arc<CoreRobot<f64, 6>>),
}

/// What to do with the robot of a [`Chassis`], whose number of wheels is known in there.
#[macro_export]
macro_rules! with_core {
    ($chassis:expr, $core:ident => $what:expr) => {
        match $chassis {
            $crate::robot::chassis::Chassis::One($core) => $what,
            $crate::robot::chassis::Chassis::Two($core) => $what,
            $crate::robot::chassis::Chassis::Three($core) => $what,
            $crate::robot::chassis::Chassis::Four($core) => $what,
            $crate::robot::chassis::Chassis::Five($core) => $what,
            $crate::robot::chassis::Chassis::Six($core) => $what,
        }
    };
}

impl Chassis {
    /// Of a robot whose number of wheels is known.
    ///
    /// # Panics
    /// If it has none, or more than six.
    pub fn new<const N: usize>(core: &CoreRobot<f64, N>) -> Self {
        fn of<T: Clone + 'static>(core: &dyn Any) -> Option<Arc<T>> {
            core.downcast_ref::<T>().cloned().map(Arc::new)
        }
        let core: &dyn Any = core;
        let chassis = of(core).map(Self::One).or_else(|| of(core).map(Self::Two));
        let chassis = chassis.or_else(|| of(core).map(Self::Three)).or_else(|| of(core).map(Self::Four));
        let chassis = chassis.or_else(|| of(core).map(Self::Five)).or_else(|| of(core).map(Self::Six));
        chassis.unwrap_or_else(|| panic!("{N} wheels; expected 1 to {MOST_WHEELS}"))
    }

    /// The robot with this number of wheels.
    ///
    /// # Panics
    /// If `N` is not how many it has.
    pub fn core<const N: usize>(&self) -> &CoreRobot<f64, N> {
        let core: Option<&CoreRobot<f64, N>> = with_core!(self, core => (&**core as &dyn Any).downcast_ref());
        core.unwrap_or_else(|| panic!("{N} wheels; expected {}", self.wheels()))
    }

    /// The same robot with other conditioning.
    #[must_use]
    pub fn with_conditioning(&self, conditioning: Conditioning<f64>) -> Self {
        let mut other = self.clone();
        with_core!(&mut other, core => Arc::make_mut(core).conditioning = conditioning);
        other
    }

    /// The same robot with a filter of this cutoff, Hz.
    #[must_use]
    pub fn with_cutoff(&self, cutoff_hz: f64) -> Self {
        let mut other = self.clone();
        with_core!(&mut other, core => Arc::make_mut(core).cutoff_hz = cutoff_hz);
        other
    }

    /// Its name.
    pub fn name(&self) -> &str {
        with_core!(self, core => core.name.as_str())
    }

    /// How many wheels it has.
    pub fn wheels(&self) -> usize {
        with_core!(self, core => core.kinematics.rows()[0].len())
    }

    /// Rows of R: forward speed, sideways speed and turn rate per speed of each wheel.
    pub fn rows(&self) -> [&[f64]; 3] {
        with_core!(self, core => core.kinematics.rows().each_ref().map(|row| &row[..]))
    }

    /// −1 of wheels on the left, 1 of those on the right, 0 of those on neither side.
    pub fn sides(&self) -> Vec<f64> {
        with_core!(self, core => Layout::new(&core.kinematics).side.to_vec())
    }

    /// Whether its wheels are on two sides.
    pub fn has_sides(&self) -> bool {
        with_core!(self, core => core.mass_matrix.sides().is_some())
    }

    /// ζ = R w for wheel speeds in rad/s, or its rates for accelerations.
    ///
    /// # Panics
    /// If there are not as many as it has wheels.
    pub fn twist(&self, mut wheels: impl Iterator<Item = f64>) -> Twist<f64> {
        with_core!(self, core => core.kinematics.twist(&std::array::from_fn(|_| wheels.next().expect("one a wheel"))))
    }

    /// Whether turns drag its wheels.
    pub fn scrubs(&self) -> bool {
        with_core!(self, core => core.scrubs())
    }

    /// Whether its steering drags the wheels, whatever a fit says of scrub.
    pub fn skids(&self) -> bool {
        with_core!(self, core => core.kinematics.scrubs())
    }

    /// k, m.
    pub fn gyration_radius(&self) -> f64 {
        with_core!(self, core => core.gyration_radius)
    }

    /// Speeds below it are none, rad/s.
    pub fn dead_band(&self) -> f64 {
        with_core!(self, core => core.dead_band)
    }

    /// M'': what a wheel feels of each wheel's acceleration, per kilogram.
    pub fn mass_matrix(&self) -> DMatrix<f64> {
        let wheels = self.wheels();
        with_core!(self, core => {
            let rows = core.mass_matrix.rows();
            DMatrix::from_fn(wheels, wheels, |i, j| rows[i][j])
        })
    }

    /// What else lies between samples and motion.
    pub fn conditioning(&self) -> &Conditioning<f64> {
        with_core!(self, core => &core.conditioning)
    }

    /// Total masses without and with full payload, kg.
    pub fn range(&self) -> MassRange<f64> {
        with_core!(self, core => core.range)
    }

    /// Low-pass cutoff for speed and power, Hz.
    pub fn cutoff_hz(&self) -> f64 {
        with_core!(self, core => core.cutoff_hz)
    }

    /// What the robot draws apart from its drives, W.
    pub fn static_power(&self) -> f64 {
        with_core!(self, core => core.static_power)
    }
}

/// A value a wheel, of a robot with as many wheels as it has.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PerWheel<T> {
    count: usize,
    values: [T; MOST_WHEELS],
}

/// The wheels of a robot at one instant.
pub type Wheels = PerWheel<Wheel<f64>>;

impl<T> Deref for PerWheel<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        &self.values[..self.count]
    }
}

impl<T: Copy + Default> PerWheel<T> {
    /// What `of` says of each of so many.
    ///
    /// # Panics
    /// If there are more than six.
    pub fn new(count: usize, mut of: impl FnMut(usize) -> T) -> Self {
        let mut values = [T::default(); MOST_WHEELS];
        values[..count].iter_mut().zip(0..).for_each(|(value, wheel)| *value = of(wheel));
        Self { count, values }
    }

    /// Those of another instant of the same robot.
    pub(crate) fn set(&mut self, values: &[T]) {
        self.count = values.len();
        self.values[..values.len()].copy_from_slice(values);
    }

    /// As model-core takes them.
    ///
    /// # Panics
    /// If `N` is not how many there are.
    pub fn array<const N: usize>(&self) -> [T; N] {
        assert_eq!(self.count, N, "as many wheels as the robot has");
        std::array::from_fn(|wheel| self.values[wheel])
    }
}

impl<T: Copy + Default, const N: usize> From<[T; N]> for PerWheel<T> {
    fn from(values: [T; N]) -> Self {
        Self::new(N, |wheel| values[wheel])
    }
}

/// What to do with wheels as the models take them, whose number is known in there.
#[macro_export]
macro_rules! with_motion {
    ($wheels:expr, $motion:ident => $what:expr) => {
        match $wheels.len() {
            1 => $crate::with_motion!(@ 1, $wheels, $motion => $what),
            2 => $crate::with_motion!(@ 2, $wheels, $motion => $what),
            3 => $crate::with_motion!(@ 3, $wheels, $motion => $what),
            4 => $crate::with_motion!(@ 4, $wheels, $motion => $what),
            5 => $crate::with_motion!(@ 5, $wheels, $motion => $what),
            _ => $crate::with_motion!(@ 6, $wheels, $motion => $what),
        }
    };
    (@ $count:literal, $wheels:expr, $motion:ident => $what:expr) => {{
        let $motion = &$wheels.motion::<$count>();
        $what
    }};
}

/// What is asked of the wheels of a robot at one instant, wherever they are kept.
pub trait Together: Deref<Target = [Wheel<f64>]> {
    /// As the models take them.
    ///
    /// # Panics
    /// If `N` is not how many there are.
    fn motion<const N: usize>(&self) -> Motion<f64, N> {
        Motion { wheels: (**self).try_into().expect("as many wheels as the robot has") }
    }

    /// Whether any of them turns.
    fn is_moving(&self) -> bool {
        self.iter().any(|wheel| wheel.direction != 0.0)
    }

    /// Mean of their absolute speeds, rad/s.
    fn mean_speed(&self) -> f64 {
        self.mean(|wheel| wheel.speed.abs())
    }

    /// Mean of what each of them has.
    fn mean(&self, of: impl Fn(&Wheel<f64>) -> f64) -> f64 {
        self.iter().map(of).sum::<f64>() / self.len() as f64
    }
}

impl Together for Wheels {}
impl Together for &[Wheel<f64>] {}
