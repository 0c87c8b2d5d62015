//! A run that advances to any given microsecond, for a board that asks at any time.

use plant::effects;
use plant::kinematics::Kinematics;
use plant::motion::{Command, Motion, Moved};
use plant::noise::{Stream, stream};
use plant::rails::{LB_012, PowerTree, RAILS, SERVOS, Supply};
use plant::scenario::{DEFAULT_STEP_S, Scenario};
use plant::{MAX_WHEELS, Robot};
use support::error::{Error, Result};

use rand::RngExt;

/// Integration step, µs.
const STEP_US: u64 = 250;
const _: () = assert!(STEP_US as f64 * 1e-6 == DEFAULT_STEP_S);

/// What is true at a time.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Truth {
    /// Since the start, µs.
    pub time_us: u64,
    /// Total mass, kg.
    pub mass_kg: f64,
    /// Speeds of left and right wheel, rad/s, positive forward.
    pub wheel_rad_s: [f64; SERVOS],
    /// Power that the drives draw, the servos' electronics apart, W.
    pub actuation_w: f64,
    /// The same since the start, J.
    pub actuation_j: f64,
    /// Battery, motors, computer, lidar.
    pub rails: [Supply; RAILS],
    /// Energy of each since the start, J.
    pub rails_j: [f64; RAILS],
    /// What is in the battery, 0 to 1; `None` of one that is never empty.
    pub charge: Option<f64>,
}

/// One wheel as its servo sees it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct WheelState {
    /// Angle, rad, positive forward, since the start and from a seeded phase on.
    pub angle_rad: f64,
    /// rad/s, positive forward.
    pub speed_rad_s: f64,
    /// Winding voltage over the supply's, −1 to 1.
    pub duty: f64,
    /// Winding current, A.
    pub current_a: f64,
}

/// A stretch of time over which the rails stayed as they were.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// µs
    pub length_us: u64,
    /// Means over it.
    pub rails: [Supply; RAILS],
}

/// The plant of a differential drive, in lockstep with its caller; constant in memory.
#[derive(Debug, Clone)]
pub struct Lockstep {
    scenario: Scenario,
    motion: Motion,
    /// What hangs on the rails.
    pub power: PowerTree,
    /// Wheel speeds, rad/s, that take the profile's place.
    pub command: Option<[f64; SERVOS]>,
    now_us: u64,
    /// Up to here the motion has been computed: at or after now, by less than a step.
    step_end_us: u64,
    /// The step that `now_us` lies in.
    moved: Moved,
    rails: [Supply; RAILS],
    speed_before: [f64; MAX_WHEELS],
    /// At `step_end_us` less the step.
    angle_before: [f64; MAX_WHEELS],
    actuation_j: f64,
    rails_j: [f64; RAILS],
}

impl Lockstep {
    /// A robot about to start.
    ///
    /// # Errors
    /// What [`Scenario::check`] finds; a robot without two wheels; a step other than the default.
    pub fn new(scenario: Scenario) -> Result<Self> {
        scenario.check()?;
        if scenario.robot.geometry.kinematics != Kinematics::Differential {
            return Err(Error::usage("the board drives two servos; allowed: differential kinematics"));
        }
        if let Some(effect) = effects::of_logs(&scenario.effects) {
            let message = format!("effect {}: the board has rails and sensors of its own", effect.id());
            return Err(Error::usage(format!("{message}; allowed: effects of motors, gears, load and road")));
        }
        if scenario.step_s != DEFAULT_STEP_S {
            return Err(Error::usage(format!("step {} s; allowed: {DEFAULT_STEP_S}", scenario.step_s)));
        }
        let Robot { supply_v, .. } = scenario.robot;
        let mut power = PowerTree::new(supply_v, scenario.seed);
        let mut phase = stream(scenario.seed, Stream::EncoderPhase);
        Ok(Self {
            motion: Motion::new(&scenario)?,
            rails: power.supply(0.0, 0.0),
            power,
            command: None,
            now_us: 0,
            step_end_us: 0,
            moved: Moved {
                turned_rad: [0.0; MAX_WHEELS],
                power_w: 0.0,
                drive_v: supply_v,
                voltage: [0.0; MAX_WHEELS],
                current: [0.0; MAX_WHEELS],
            },
            speed_before: [0.0; MAX_WHEELS],
            angle_before: std::array::from_fn(|_| phase.random_range(0.0..std::f64::consts::TAU)),
            actuation_j: 0.0,
            rails_j: [0.0; RAILS],
            scenario,
        })
    }

    /// A battery with this charge, 0 to 1, instead of one that is never empty. Before the start
    /// only.
    pub fn set_charge(&mut self, charge: f64) {
        let lidar = self.power.lidar;
        self.power = PowerTree::with_cells(LB_012, charge, self.scenario.seed);
        self.power.lidar = lidar;
        self.rails = self.power.supply(0.0, 0.0);
    }

    /// Since the start, µs.
    pub fn now_us(&self) -> u64 {
        self.now_us
    }

    /// What is simulated.
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// Goes towards `time_us`, up to the end of the present step, and gives the stretch that has
    /// passed; `None` when there. What lies in the past stays as it was.
    pub fn advance_towards(&mut self, time_us: u64) -> Option<Span> {
        if time_us <= self.now_us {
            return None;
        }
        if self.now_us == self.step_end_us {
            self.step();
        }
        let until = time_us.min(self.step_end_us);
        let length_us = until - self.now_us;
        self.now_us = until;
        let seconds = length_us as f64 * 1e-6;
        self.actuation_j += self.moved.power_w * seconds;
        for (energy, rail) in self.rails_j.iter_mut().zip(self.rails) {
            *energy += rail.power_w * seconds;
        }
        Some(Span { length_us, rails: self.rails })
    }

    fn step(&mut self) {
        for (angle, turned) in self.angle_before.iter_mut().zip(self.moved.turned_rad) {
            *angle += turned;
        }
        self.speed_before = self.motion.wheel_speeds();
        let [battery, ..] = self.rails;
        let command = match self.command {
            None => Command::Profile,
            Some([left, right]) => Command::Wheels([left, right, 0.0, 0.0]),
        };
        self.moved = self.motion.advance(&self.scenario, command, battery.voltage_v);
        self.rails = self.power.supply(self.step_end_us as f64 * 1e-6, self.moved.power_w);
        self.step_end_us += STEP_US;
    }

    /// How much of the present step has passed, 0 to 1.
    fn share(&self) -> f64 {
        1.0 - (self.step_end_us - self.now_us) as f64 / STEP_US as f64
    }

    /// Left and right wheel now, straight between the ends of a step.
    pub fn wheels(&self) -> [WheelState; SERVOS] {
        let after = self.motion.wheel_speeds();
        let [battery, ..] = self.rails;
        std::array::from_fn(|i| WheelState {
            angle_rad: self.angle_before[i] + self.share() * self.moved.turned_rad[i],
            speed_rad_s: self.speed_before[i] + self.share() * (after[i] - self.speed_before[i]),
            duty: self.moved.voltage[i] / battery.voltage_v,
            current_a: self.moved.current[i],
        })
    }

    /// Battery, motors, computer, lidar in the present step.
    pub fn rails(&self) -> [Supply; RAILS] {
        self.rails
    }

    /// What is true now.
    pub fn truth(&self) -> Truth {
        Truth {
            time_us: self.now_us,
            mass_kg: self.scenario.payload.mass_at(self.now_us as f64 * 1e-6),
            wheel_rad_s: self.wheels().map(|wheel| wheel.speed_rad_s),
            actuation_w: self.moved.power_w,
            actuation_j: self.actuation_j,
            rails: self.rails,
            rails_j: self.rails_j,
            charge: self.power.charge(),
        }
    }
}

#[cfg(test)]
mod tests {
    use plant::{Effect, PlantSet, Profile, ProfileKind, simulate};

    use super::*;

    fn scenario() -> Scenario {
        Scenario::new(PlantSet::Servo, Kinematics::Differential, ProfileKind::Training, 20.0, 5)
    }

    fn advance_to(run: &mut Lockstep, time_us: u64) {
        while run.advance_towards(time_us).is_some() {}
    }

    /// The run does not depend on how often it is asked: whole steps are the same to the last
    /// digit.
    #[test]
    fn asking_does_not_disturb() {
        let (mut often, mut seldom) =
            (Lockstep::new(scenario()).unwrap(), Lockstep::new(scenario()).unwrap());
        for ask in 1..5000_u64 {
            advance_to(&mut often, ask * 997);
            often.wheels();
        }
        advance_to(&mut often, 5_000_000);
        advance_to(&mut seldom, 5_000_000);
        assert_eq!(often.wheels(), seldom.wheels());
        // Energies are sums of other pieces.
        let (often, seldom) = (often.truth(), seldom.truth());
        assert!((often.actuation_j - seldom.actuation_j).abs() < 1e-12 * seldom.actuation_j);
        assert_eq!(often.rails, seldom.rails);
    }

    /// The board's plant is the one that `gmr simulate` runs, but for the battery's sag: that
    /// limits the loop's output by some 0.1 V less than the log's 12 V, seldom in a training drive.
    /// 0.1 % of the speed, 1 % of the power.
    #[test]
    fn it_drives_as_the_simulated_log_does() {
        let record = simulate(&scenario()).unwrap();
        let mut run = Lockstep::new(scenario()).unwrap();
        let (mut speed, mut power, mut speed_off, mut power_off) = (0.0, 0.0, 0.0, 0.0);
        for (k, &time_s) in record.time_s.iter().enumerate() {
            advance_to(&mut run, (time_s * 1e6).round() as u64);
            let truth = run.truth();
            speed += record.wheel_rad_s[0][k].powi(2);
            speed_off += (record.wheel_rad_s[0][k] - truth.wheel_rad_s[0]).powi(2);
            power += record.true_power_w[k].powi(2);
            power_off += (record.true_power_w[k] - truth.actuation_w).powi(2);
        }
        assert!(
            speed_off < 1e-6 * speed && power_off < 1e-4 * power,
            "{speed_off} {speed} {power_off} {power}"
        );
    }

    /// The angle is the integral of the speed, between steps too: by trapezoids over 40 µs, within
    /// 2 · 10⁻⁶ rad after 3 s.
    #[test]
    fn the_angle_follows_the_speed() {
        let mut run = Lockstep::new(scenario()).unwrap();
        let start = run.wheels()[1];
        let (mut angle, mut last) = (start.angle_rad, start.speed_rad_s);
        for k in 1..=75_000_u64 {
            advance_to(&mut run, k * 40);
            let wheel = run.wheels()[1];
            angle += 0.5 * 40e-6 * (last + wheel.speed_rad_s);
            last = wheel.speed_rad_s;
            assert!((wheel.angle_rad - angle).abs() < 2e-6, "{k}: {} {angle}", wheel.angle_rad);
        }
        assert!((angle - start.angle_rad).abs() > 1.0);
    }

    /// By hand: 1 kg up 0.1 rad at 0.1 m/s needs 97.9 mW at the wheels, after gears of 0.61 and
    /// with hotter copper.
    #[test]
    fn effects_of_the_robot_act_and_those_of_a_log_are_refused() {
        let climb = |texts: &[&str]| {
            let mut scenario = scenario();
            scenario.profile = Profile::from_twists([(0.0, [0.0; 3]), (1.0, [0.1, 0.0, 0.0])]);
            scenario.effects = texts.iter().map(|text| Effect::parse(text).unwrap()).collect();
            let mut run = Lockstep::new(scenario)?;
            advance_to(&mut run, 5_000_000);
            Ok::<f64, Error>(run.truth().actuation_w)
        };
        let added = climb(&["grade=0.1"]).unwrap() - climb(&[]).unwrap();
        assert!((0.098 / 0.61..0.098 / 0.61 * 1.3).contains(&added), "{added}");
        assert_eq!(climb(&["sensor-gain=0.1"]).unwrap_err().exit_code(), 2);
    }

    #[test]
    fn energies_are_powers_times_time_and_add_up() {
        let mut run = Lockstep::new(scenario()).unwrap();
        let (mut actuation, mut motors) = (0.0, 0.0);
        let mut time = 0;
        while let Some(span) = run.advance_towards(10_000_000) {
            time += span.length_us;
            actuation += run.truth().actuation_w * span.length_us as f64 * 1e-6;
            motors += span.rails[1].power_w * span.length_us as f64 * 1e-6;
        }
        let truth = run.truth();
        assert_eq!(time, 10_000_000);
        assert!((truth.actuation_j - actuation).abs() < 1e-9 && (truth.rails_j[1] - motors).abs() < 1e-9);
        // The servos' electronics: 0.104 A at 11.9 V.
        let electronics = (truth.rails_j[1] - truth.actuation_j) / 10.0;
        assert!((electronics - 1.24).abs() < 0.01, "{electronics}");
        let [battery, motors, computer, lidar] = truth.rails_j;
        assert!((battery - motors - (computer + lidar + 5.0) / 0.9).abs() < 1e-9);
    }
}
