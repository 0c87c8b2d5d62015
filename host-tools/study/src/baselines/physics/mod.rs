//! Physics-based power from outside: the power for the motion of the body and the resistance of the
//! ground, with or without the losses of the motors.
//!
//! ```text
//! P = m max(v·v̇, 0) + I max(ω ω̇, 0)      growth of the kinetic energy
//!   + Fc Σ |w|                             traction resistance of each wheel
//!   + b Σ w² + R Σ (i_f sgn w + i_K K)²    losses of the motors
//! ```
//!
//! The split into kinetic, traction and motor energy is that of Wahab, Rios-Gutierrez and El Shahat
//! (2015), with the resistance μ m g r at every wheel. The sources measure the constants one by
//! one. A log has none of these measurements: all are fitted together by least squares, each at
//! least 0. The mass is one of them: no source has a payload.
//!
//! Chosen here: the kinetic energy lost in braking is not recovered, as in the paper's Eq. 8. The
//! motors' winding loss is that of a current of friction i_f and one of inertia i_K K, where K =
//! (M'' a) is the inertial torque of a wheel per kilogram, multiplied out, so that the power is
//! linear in all constants. The constant power of electronics is left out: it is not part of a
//! log's actuation power.

mod lugre;
mod term;
#[cfg(test)]
mod tests;

use fit::gram::Gram;
use fit::nnls;
use logs::robot::Robot;
use numerics::search::golden_section;
use support::error::{Error, Result};

use self::term::{Bristles, rigid};
use super::baseline::{Baseline, Parameter, named};
use super::point::Point;
use super::training;

pub use self::term::Term;

/// Most terms of a source.
const MOST: usize = 12;

/// The model with the terms of one source.
pub struct Physics {
    name: &'static str,
    terms: &'static [Term],
    friction: Friction,
    fitted: Option<Fitted>,
}

/// What opposes a wheel that turns.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Friction {
    /// The same torque at any speed.
    Constant,
    /// The bristles of LuGre under a wheel of this radius, m; `None` where the robot's file has
    /// none.
    LuGre(Option<f64>),
}

/// Constants, and the Stribeck speed vs in rad/s; infinite without bristles.
type Fitted = ([f64; MOST], f64);

impl Physics {
    /// Not fitted; with LuGre's bristles if a term needs them, else with constant friction.
    ///
    /// # Panics
    /// With more terms than there are places for.
    pub fn new(name: &'static str, terms: &'static [Term], robot: &Robot) -> Self {
        assert!(terms.len() <= MOST, "{name} has too many terms");
        let bristles = terms.contains(&Term::Stribeck);
        let friction = if bristles { Friction::LuGre(robot.wheel_radius_m()) } else { Friction::Constant };
        Self { name, terms, friction, fitted: None }
    }

    /// The share of its steady friction that acts at each wheel of each point.
    fn bristles(&self, points: &[Point]) -> Result<Vec<Bristles>> {
        match self.friction {
            Friction::Constant => Ok(points.iter().map(|point| rigid(&point.wheels)).collect()),
            Friction::LuGre(Some(radius)) => Ok(lugre::shares(points, radius)),
            Friction::LuGre(None) => {
                Err(Error::failed(format!("{}: the robot's file has no wheel_radius_m", self.name)))
            }
        }
    }

    /// Power of each term per unit of its constant; 0 after the last.
    fn powers(&self, point: &Point, bristles: &Bristles, stribeck: f64) -> [f64; MOST] {
        let mut powers = [0.0; MOST];
        for (power, term) in powers.iter_mut().zip(self.terms) {
            *power = term.power(point, bristles, stribeck);
        }
        powers
    }

    /// The best constants at a Stribeck speed, and their mean squared error, W².
    fn solve(&self, points: &[Point], bristles: &[Bristles], stribeck: f64) -> Fitted {
        let mut gram = Gram::<MOST>::default();
        let rows = points.iter().zip(bristles);
        gram.extend(rows.map(|(point, bristles)| (self.powers(point, bristles, stribeck), point.power)));
        let problem = gram.scaled();
        let constants = problem.unscale(&nnls::solve(&problem).beta);
        (constants.into(), gram.cost(&constants))
    }

    /// The Stribeck speed with the least error: the best of a grid over the speeds of the points,
    /// then between its neighbours.
    fn stribeck(&self, points: &[Point], bristles: &[Bristles]) -> f64 {
        let speeds = points.iter().flat_map(|point| point.wheels.iter()).map(|wheel| wheel.speed.abs());
        let fastest = speeds.fold(0.0, f64::max);
        let ratio = SLOWEST_SHARE.powf(1.0 / f64::from(GRID));
        let at = |place: f64| fastest * ratio.powf(place);
        let cost = |place: f64| self.solve(points, bristles, at(place)).1;
        let grid = (0..=GRID).map(|place| (f64::from(place), cost(f64::from(place))));
        let best = grid.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0.0, |(place, _)| place);
        at(golden_section(best - 1.0, best + 1.0, 1e-6, cost).map_or(best, |least| least.at))
    }
}

/// Steps of the grid of Stribeck speeds, from the fastest wheel's speed to this share of it.
const GRID: u32 = 16;
const SLOWEST_SHARE: f64 = 1e-3;
/// The Stribeck speed is searched on so many points, evenly over the whole.
const SEARCH_POINTS: usize = 4_000;

impl Baseline for Physics {
    fn fit(&mut self, training: &[Point]) -> Result<()> {
        self.fitted = None;
        training::check(self.name, training)?;
        let bristles = self.bristles(training)?;
        let stribeck = match self.friction {
            Friction::Constant => f64::INFINITY,
            Friction::LuGre(_) => {
                let (points, bristles) =
                    (training::thin(training, SEARCH_POINTS), training::thin(&bristles, SEARCH_POINTS));
                self.stribeck(&points, &bristles)
            }
        };
        let (constants, cost) = self.solve(training, &bristles, stribeck);
        if !cost.is_finite() {
            return Err(Error::failed(format!("{}: the constants have no finite solution", self.name)));
        }
        self.fitted = Some((constants, stribeck));
        Ok(())
    }

    fn predict(&self, points: &[Point]) -> Result<Vec<f64>> {
        let unfitted = || Error::failed(format!("{}: not fitted", self.name));
        let (constants, stribeck) = self.fitted.ok_or_else(unfitted)?;
        let bristles = self.bristles(points)?;
        let predict = |(point, bristles)| {
            let powers = self.powers(point, bristles, stribeck);
            powers.iter().zip(&constants).map(|(power, constant)| power * constant).sum()
        };
        Ok(points.iter().zip(&bristles).map(predict).collect())
    }

    /// The constants, and vs where there are bristles: NaN where friction does not fall with the
    /// speed.
    fn parameters(&self) -> Vec<Parameter> {
        let Some((constants, stribeck)) = &self.fitted else { return Vec::new() };
        let mut parameters = named(self.terms.iter().map(|term| term.symbol()), constants);
        if self.friction != Friction::Constant {
            let falls = self.terms.iter().zip(constants).any(|(term, c)| *term == Term::Stribeck && *c > 0.0);
            let value = if falls { *stribeck } else { f64::NAN };
            parameters.push(Parameter { name: "vs", value, unit: "rad/s" });
        }
        parameters
    }
}
