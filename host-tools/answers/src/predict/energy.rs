//! Energy of a plan and its uncertainty.

use logs::robot::Robot;
use model::coefficients::CoefficientsFile;
use model_core::coefficients::Coefficients;
use model_core::effects::live::{Additions as _, Live, Outside};
use model_core::effects::{Cause, GRAVITY, Term};
use model_core::estimator::{Conditioned, Conditioner, Sample};
use model_core::model::Model;
use model_core::motion::Motion;
use model_core::torque::TorqueModel;
use nalgebra::{DMatrix, DVector};
use support::context::Context;
use support::error::{Error, Result};

use super::drive::{Follow, Frame, frames};
use super::legs::Limits;
use super::load::Load;
use super::plan::Plan;
use super::report::{Cost, Leg, Report};
use super::rmf::Vehicle;

/// Derivatives are taken over this share of a standard deviation to both sides: small beside what
/// is uncertain, large beside rounding.
const SHARE: f64 = 0.25;

/// The model with one number moved, and what it says of the legs.
struct Variant<const N: usize> {
    model: Model<f64>,
    live: Option<Live<f64, N>>,
    mass_kg: f64,
    /// J, a leg each.
    joules: Vec<f64>,
}

/// What the legs add up to.
#[derive(Default, Clone, Copy)]
struct Tally {
    time_s: f64,
    way_m: f64,
    /// Σ density · dt, J².
    noise_j2: f64,
    /// Time in motion, s.
    moving_s: f64,
    measured_j: f64,
    rmf_j: f64,
    is_measured: bool,
}

/// Predicts the energy of a plan.
///
/// # Errors
/// The plan cannot be read, or lasts too long; a filter that its samples cannot have.
pub(super) fn predict<const N: usize>(
    context: &Context,
    robot: &Robot,
    file: &CoefficientsFile<N>,
    plan: &Plan,
    load: &Load,
    rmf: &Vehicle,
) -> Result<Report> {
    let mut sums = Sums::new(file, load, rmf);
    let cutoff_hz = file.coefficients.robot.cutoff_hz;
    let names = frames(context, plan, robot, cutoff_hz, &mut sums)?;
    if let Some(sparse) = plan.every_second() {
        let mut of_sparse = Sums { moved: Vec::new(), ..Sums::new(file, load, rmf) };
        frames(context, &sparse, robot, cutoff_hz, &mut of_sparse)?;
        sums.sparse_j = of_sparse.legs_j();
    }
    let limits = if matches!(plan, Plan::Legs(_)) { Limits::named(robot) } else { Vec::new() };
    sums.report(robot, &names, limits)
}

struct Sums<'a, const N: usize> {
    coefficients: &'a Coefficients<f64, N>,
    covariance: DMatrix<f64>,
    load: &'a Load,
    rmf: &'a Vehicle,
    slope_is_an_effect: bool,
    /// [`model::coefficients::Origin::energy_std_share`] and its `energy_std_w`.
    energy_std_share: f64,
    energy_std_w: f64,
    legs: Vec<Tally>,
    /// What the legs cost by every second row of the plan, J; empty where that says nothing.
    sparse_j: Vec<f64>,
    /// How far each parameter was moved to either side.
    moved: Vec<f64>,
    /// The filter and the models, from the start on.
    running: Option<(Conditioner<f64, N>, Vec<Variant<N>>)>,
}

impl<'a, const N: usize> Sums<'a, N> {
    fn new(file: &'a CoefficientsFile<N>, load: &'a Load, rmf: &'a Vehicle) -> Self {
        let size = file.covariance.nrows();
        // With effects the parameters' block of what is known of both.
        let covariance = match &file.joint_covariance {
            Some(joint) => joint.view((0, 0), (size, size)).into_owned(),
            None => file.covariance.clone(),
        };
        let is_slope = |column: &model_core::effects::Column<f64>| {
            matches!(column.cause, Cause::Term(Term::GradeByPitch | Term::GradeAhead | Term::GradeAlong(_)))
        };
        Self {
            coefficients: &file.coefficients,
            moved: covariance.diagonal().iter().map(|variance| SHARE * variance.sqrt()).collect(),
            covariance,
            load,
            rmf,
            slope_is_an_effect: file.coefficients.columns.iter().any(is_slope),
            energy_std_share: file.origin.energy_std_share,
            energy_std_w: file.origin.energy_std_w,
            legs: Vec::new(),
            sparse_j: Vec::new(),
            running: None,
        }
    }

    /// What the legs cost by the model as it is, J.
    fn legs_j(self) -> Vec<f64> {
        let variants = self.running.map(|(_, variants)| variants);
        variants.and_then(|variants| variants.into_iter().next()).map_or_else(Vec::new, |now| now.joules)
    }

    /// The model as it is, then each parameter less and more, then the mass less and more.
    fn variants(&self, period_s: f64) -> Option<Vec<Variant<N>>> {
        let variant = |model: Model<f64>, mass_kg: f64| {
            let coefficients = Coefficients { model, ..*self.coefficients };
            let live = (!coefficients.columns.is_empty()).then(|| Live::new(&coefficients, period_s));
            Some(Variant { model, live: live.transpose().ok()?, mass_kg, joules: Vec::new() })
        };
        let (model, mass) = (self.coefficients.model, self.load.mass_kg);
        let mut variants = vec![variant(model, mass)?];
        for (parameter, step) in self.moved.iter().enumerate() {
            variants.push(variant(with(&model, parameter, -step), mass)?);
            variants.push(variant(with(&model, parameter, *step), mass)?);
        }
        let step = SHARE * self.load.mass_std_kg;
        variants.push(variant(model, mass - step)?);
        variants.push(variant(model, mass + step)?);
        Some(variants)
    }

    fn add(&mut self, conditioner: &mut Conditioner<f64, N>, variants: &mut [Variant<N>], frame: &Frame) {
        let Coefficients { robot, noise, .. } = self.coefficients;
        let sample = Sample { wheel_speed: frame.wheel_speed.array(), wheel_acceleration: None, power: 0.0 };
        let step = if frame.elapsed.is_finite() { frame.elapsed } else { 0.0 };
        let planned = frame.wheel_acceleration.map(|acceleration| {
            let motion = conditioner.planned(&sample.wheel_speed, &acceleration.array(), frame.elapsed);
            Conditioned { motion, power: 0.0, settled: true }
        });
        let Some(mut now) = planned.or_else(|| conditioner.push(&sample, frame.elapsed)) else { return };
        let twist = robot.kinematics.twist(&now.motion.wheels.map(|wheel| wheel.speed));
        if !self.slope_is_an_effect {
            climb(&mut now.motion, robot.kinematics.rows()[0], frame.slope_rad);
        }
        if self.legs.len() <= frame.leg {
            self.legs.resize(frame.leg + 1, Tally::default());
        }
        let outside = Outside { pitch: frame.slope_rad, ..Outside::UNKNOWN };
        let floor = self.coefficients.energy_floor();
        for variant in variants.iter_mut() {
            let watts = variant.power(self.coefficients, &now, &sample, &outside, frame.elapsed);
            variant.joules.resize(self.legs.len(), 0.0);
            variant.joules[frame.leg] += floor.max(watts) * step;
        }
        let rates = robot.kinematics.twist(&now.motion.wheels.map(|wheel| wheel.acceleration));
        let tally = &mut self.legs[frame.leg];
        tally.time_s += step;
        tally.way_m += twist.vx.hypot(twist.vy) * step;
        tally.noise_j2 += noise.density * step;
        if now.motion.is_moving() {
            tally.moving_s += step;
        }
        let speed = twist.vx.hypot(twist.vy);
        tally.rmf_j += self.rmf.power_w(speed, rates.vx.hypot(rates.vy), twist.omega, rates.omega) * step;
        if let Some(measured) = frame.measured_w {
            tally.is_measured = true;
            tally.measured_j += measured * step;
        }
    }

    fn report(&self, robot: &Robot, names: &[String], limits: Vec<super::report::Limit>) -> Result<Report> {
        let Some((_, variants)) = self.running.as_ref().filter(|_| !self.legs.is_empty()) else {
            return Err(Error::failed("holds no motion; expected a plan"));
        };
        let load = self.load;
        let all: Vec<usize> = (0..self.legs.len()).collect();
        let static_w = load.static_w.unwrap_or(0.0);
        let cost = |legs: &[usize]| -> Cost {
            let sum = |variant: &Variant<N>| -> f64 { legs.iter().map(|leg| variant.joules[*leg]).sum() };
            let tally = |of: fn(&Tally) -> f64| -> f64 { legs.iter().map(|leg| of(&self.legs[*leg])).sum() };
            let slopes = self.moved.iter().enumerate().map(|(place, step)| {
                let [less, more] = [1, 2].map(|side| sum(&variants[2 * place + side]));
                if *step > 0.0 { (more - less) / (2.0 * step) } else { 0.0 }
            });
            let slopes = DVector::from_iterator(self.moved.len(), slopes);
            let parameters = (slopes.transpose() * &self.covariance * &slopes)[0].max(0.0);
            let [lighter, heavier] = [1, 2].map(|side| sum(&variants[2 * self.moved.len() + side]));
            let mass = (heavier - lighter) / (2.0 * SHARE);
            let duration_s = tally(|tally| tally.time_s);
            let static_std = load.static_std_w * duration_s;
            // What the model's form gets wrong lasts for as long as the robot drives alike: for all
            // of the plan, at worst.
            let driving_j = sum(&variants[0]);
            let lasting_w = self.coefficients.noise.model_std.max(self.energy_std_w);
            let lasting = lasting_w * tally(|tally| tally.moving_s);
            let lasting = lasting.max(self.energy_std_share * driving_j.abs());
            let noise = tally(|tally| tally.noise_j2) + lasting * lasting;
            // What the rows lose of the motion between them is about what as many again lose.
            let sparse = legs.iter().filter_map(|leg| self.sparse_j.get(*leg));
            let rows_j = if self.sparse_j.is_empty() { 0.0 } else { sparse.sum::<f64>() - driving_j };
            let measured = legs.iter().all(|leg| self.legs[*leg].is_measured);
            let std = [parameters, mass * mass, noise, static_std * static_std].map(f64::sqrt);
            Cost {
                duration_s,
                distance_m: tally(|tally| tally.way_m),
                energy_j: driving_j + static_w * duration_s,
                driving_j,
                std_parameters_j: std[0],
                std_mass_j: std[1],
                std_residual_j: std[2],
                std_static_j: std[3],
                std_rows_j: rows_j.abs(),
                rmf_j: tally(|tally| tally.rmf_j) + static_w * duration_s,
                measured_j: measured.then(|| tally(|tally| tally.measured_j) + static_w * duration_s),
            }
        };
        let legs = all.iter().map(|&leg| {
            let name = names.get(leg).cloned().unwrap_or_else(|| (leg + 1).to_string());
            Leg::new(name, cost(&[leg]))
        });
        Ok(Report::new(robot.name(), load, *self.rmf, cost(&all), legs.collect(), limits))
    }
}

impl<const N: usize> Follow for Sums<'_, N> {
    fn start(&mut self, period_s: f64) -> Result<()> {
        let robot = &self.coefficients.robot;
        let conditioner = Conditioner::new(robot, period_s).ok();
        self.running = conditioner.zip(self.variants(period_s));
        if self.running.is_some() {
            return Ok(());
        }
        let message = format!(
            "samples {period_s} s apart do not fit the coefficients: a filter of {} Hz, a delay of {} s",
            robot.cutoff_hz, robot.conditioning.delay
        );
        Err(Error::failed(message))
    }

    fn frame(&mut self, frame: &Frame) {
        let Some((mut conditioner, mut variants)) = self.running.take() else { return };
        self.add(&mut conditioner, &mut variants, frame);
        self.running = Some((conditioner, variants));
    }
}

impl<const N: usize> Variant<N> {
    fn power(
        &mut self,
        coefficients: &Coefficients<f64, N>,
        now: &Conditioned<f64, N>,
        sample: &Sample<f64, N>,
        outside: &Outside<f64, N>,
        elapsed: f64,
    ) -> f64 {
        let range = &coefficients.robot.range;
        let beyond = self.mass_kg - range.middle();
        let watts = match &mut self.live {
            None => return self.model.power(&now.motion, self.mass_kg).unwrap_or(0.0),
            Some(live) => {
                live.correct(sample, outside, elapsed);
                live.follow(&now.motion, range, beyond);
                live.respond(&self.model, now, range, beyond).power
            }
        };
        if watts.is_finite() { watts } else { 0.0 }
    }
}

/// Weight along a slope acts on the body as an acceleration of g sin θ ahead would.
fn climb<const N: usize>(motion: &mut Motion<f64, N>, ahead: [f64; N], slope_rad: f64) {
    for (wheel, share) in motion.wheels.iter_mut().zip(ahead) {
        // Wheels at rest are held by the gears.
        if wheel.direction != 0.0 {
            wheel.inertial_torque += share * GRAVITY * slope_rad.sin();
        }
    }
}

/// The model with one parameter moved.
fn with(model: &Model<f64>, parameter: usize, step: f64) -> Model<f64> {
    match *model {
        Model::Signed { torque, drive } => {
            let mut values: [f64; model_core::torque::PARAMETERS] = torque.to_array();
            if let Some(value) = values.get_mut(parameter) {
                *value += step;
            }
            Model::Signed { torque: TorqueModel::with_array(torque, values), drive }
        }
        Model::Eq18 { gate, mut beta } => {
            if let Some(value) = beta.get_mut(parameter) {
                *value += step;
            }
            Model::Eq18 { gate, beta }
        }
    }
}
