//! Energy of a plan and its uncertainty.

use logs::robot::Robot;
use logs::with_core;
use model::coefficients::{CoefficientsFile, FittedModel};
use model_core::coefficients::Coefficients;
use model_core::effects::live::{Additions as _, Live, Outside};
use model_core::effects::{Cause, GRAVITY, Term};
use model_core::estimator::{Conditioned, Conditioner, Sample};
use model_core::kinematics::Twist;
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
struct Variant {
    model: Model<f64>,
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
pub(super) fn predict(
    context: &Context,
    robot: &Robot,
    file: &CoefficientsFile,
    plan: &Plan,
    load: &Load,
    rmf: &Vehicle,
) -> Result<Report> {
    let mut sums = Sums::new(file, load, rmf);
    let cutoff_hz = file.coefficients.robot.cutoff_hz();
    let names = frames(context, plan, robot, cutoff_hz, &mut sums)?;
    if let Some(sparse) = plan.every_second() {
        let mut of_sparse = Sums { moved: Vec::new(), ..Sums::new(file, load, rmf) };
        frames(context, &sparse, robot, cutoff_hz, &mut of_sparse)?;
        sums.sparse_j = of_sparse.legs_j();
    }
    let limits = if matches!(plan, Plan::Legs(_)) { Limits::named(robot) } else { Vec::new() };
    sums.report(robot, &names, limits)
}

struct Sums<'a> {
    coefficients: &'a FittedModel,
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
    /// The model as it is, then each parameter less and more, then the mass less and more.
    variants: Vec<Variant>,
    /// The filter and the models, from the start on.
    running: Option<Box<dyn Running>>,
}

impl<'a> Sums<'a> {
    fn new(file: &'a CoefficientsFile, load: &'a Load, rmf: &'a Vehicle) -> Self {
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
            variants: Vec::new(),
            running: None,
        }
    }

    /// What the legs cost by the model as it is, J.
    fn legs_j(self) -> Vec<f64> {
        self.variants.into_iter().next().map_or_else(Vec::new, |now| now.joules)
    }

    /// The model as it is, then each parameter less and more, then the mass less and more.
    fn variants(&self) -> Vec<Variant> {
        let variant = |model: Model<f64>, mass_kg: f64| Variant { model, mass_kg, joules: Vec::new() };
        let (model, mass) = (self.coefficients.model, self.load.mass_kg);
        let mut variants = vec![variant(model, mass)];
        for (parameter, step) in self.moved.iter().enumerate() {
            variants.push(variant(with(&model, parameter, -step), mass));
            variants.push(variant(with(&model, parameter, *step), mass));
        }
        let step = SHARE * self.load.mass_std_kg;
        variants.push(variant(model, mass - step));
        variants.push(variant(model, mass + step));
        variants
    }

    fn add(&mut self, frame: &Frame, driven: &Driven) {
        let Driven { twist, rates, is_moving, watts } = driven;
        let step = if frame.elapsed.is_finite() { frame.elapsed } else { 0.0 };
        if self.legs.len() <= frame.leg {
            self.legs.resize(frame.leg + 1, Tally::default());
        }
        let floor = self.coefficients.energy_floor();
        for (variant, watts) in self.variants.iter_mut().zip(watts) {
            variant.joules.resize(self.legs.len(), 0.0);
            variant.joules[frame.leg] += floor.max(*watts) * step;
        }
        let tally = &mut self.legs[frame.leg];
        tally.time_s += step;
        tally.way_m += twist.vx.hypot(twist.vy) * step;
        tally.noise_j2 += self.coefficients.noise.density * step;
        if *is_moving {
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
        if self.legs.is_empty() {
            return Err(Error::failed("holds no motion; expected a plan"));
        }
        let (load, variants) = (self.load, &self.variants);
        let all: Vec<usize> = (0..self.legs.len()).collect();
        let static_w = load.static_w.unwrap_or(0.0);
        let cost = |legs: &[usize]| -> Cost {
            let sum = |variant: &Variant| -> f64 { legs.iter().map(|leg| variant.joules[*leg]).sum() };
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

impl Follow for Sums<'_> {
    fn start(&mut self, period_s: f64) -> Result<()> {
        let FittedModel { robot, .. } = self.coefficients;
        self.variants = self.variants();
        self.running = with_core!(robot, core => {
            let coefficients = self.coefficients.of(core);
            Models::new(coefficients, &self.variants, period_s, !self.slope_is_an_effect)
                .map(|models| Box::new(models) as Box<dyn Running>)
        });
        if self.running.is_some() {
            return Ok(());
        }
        let message = format!(
            "samples {period_s} s apart do not fit the coefficients: a filter of {} Hz, a delay of {} s",
            robot.cutoff_hz(),
            robot.conditioning().delay
        );
        Err(Error::failed(message))
    }

    fn frame(&mut self, frame: &Frame) {
        if let Some(driven) = self.running.as_mut().and_then(|running| running.drive(frame)) {
            self.add(frame, &driven);
        }
    }
}

/// What the robot does in a frame.
struct Driven {
    twist: Twist<f64>,
    /// Of the twist, per second.
    rates: Twist<f64>,
    is_moving: bool,
    /// By each variant, W.
    watts: Vec<f64>,
}

/// Filter and models of a robot, whatever its number of wheels.
trait Running {
    /// `None` where the filter tells nothing yet.
    fn drive(&mut self, frame: &Frame) -> Option<Driven>;
}

struct Models<const N: usize> {
    coefficients: Coefficients<f64, N>,
    conditioner: Conditioner<f64, N>,
    /// Model, its effects, and the mass, kg.
    variants: Vec<(Model<f64>, Option<Live<f64, N>>, f64)>,
    /// Whether slopes are added to the motion.
    climbs: bool,
}

impl<const N: usize> Models<N> {
    fn new(
        coefficients: Coefficients<f64, N>,
        variants: &[Variant],
        period_s: f64,
        climbs: bool,
    ) -> Option<Self> {
        let variant = |&Variant { model, mass_kg, .. }: &Variant| {
            let coefficients = Coefficients { model, ..coefficients };
            let live = (!coefficients.columns.is_empty()).then(|| Live::new(&coefficients, period_s));
            Some((model, live.transpose().ok()?, mass_kg))
        };
        let conditioner = Conditioner::new(&coefficients.robot, period_s).ok()?;
        let variants = variants.iter().map(variant).collect::<Option<_>>()?;
        Some(Self { coefficients, conditioner, variants, climbs })
    }
}

impl<const N: usize> Running for Models<N> {
    fn drive(&mut self, frame: &Frame) -> Option<Driven> {
        let robot = &self.coefficients.robot;
        let sample = Sample { wheel_speed: frame.wheel_speed.array(), wheel_acceleration: None, power: 0.0 };
        let mut now = match frame.wheel_acceleration {
            Some(acceleration) => {
                let (speed, acceleration) = (&sample.wheel_speed, &acceleration.array());
                let motion = self.conditioner.planned(speed, acceleration, frame.elapsed);
                Conditioned { motion, power: 0.0, settled: true }
            }
            None => self.conditioner.push(&sample, frame.elapsed)?,
        };
        if self.climbs {
            climb(&mut now.motion, robot.kinematics.rows()[0], frame.slope_rad);
        }
        let outside = Outside { pitch: frame.slope_rad, ..Outside::UNKNOWN };
        let watts = self.variants.iter_mut().map(|(model, live, mass_kg)| {
            let Some(live) = live else { return model.power(&now.motion, *mass_kg).unwrap_or(0.0) };
            let above_middle = *mass_kg - robot.range.middle();
            live.correct(&sample, &outside, frame.elapsed);
            live.follow(&now.motion, &robot.range, above_middle);
            let watts = live.respond(model, &now, &robot.range, above_middle).power;
            if watts.is_finite() { watts } else { 0.0 }
        });
        Some(Driven {
            watts: watts.collect(),
            twist: robot.kinematics.twist(&now.motion.wheels.map(|wheel| wheel.speed)),
            rates: robot.kinematics.twist(&now.motion.wheels.map(|wheel| wheel.acceleration)),
            is_moving: now.motion.is_moving(),
        })
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
