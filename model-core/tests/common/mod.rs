//! Robots, motions and noise that several tests share.
#![allow(dead_code, reason = "every test crate uses its own part")]

use model_core::coefficients::{Coefficients, Name, Robot};
use model_core::conditioning::Conditioning;
use model_core::effects::Columns;
use model_core::kinematics::{Kinematics, MassMatrix};
use model_core::model::{MassRange, Model};
use model_core::motion::Wheel;
use model_core::payload::Noise;
use model_core::torque::{Drive, TorqueModel};
use proptest::prelude::*;

/// SplitMix64: the same numbers on every machine and with every version of every crate.
pub(crate) struct Rng(u64);

impl Rng {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in `low`..`high`.
    pub(crate) fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Standard normal (Box and Muller).
    pub(crate) fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform(0.0, 1.0)).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform(0.0, 1.0)).cos()
    }
}

/// First-order autoregressive noise of unit variance.
pub(crate) struct Ar1 {
    rho: f64,
    value: f64,
}

impl Ar1 {
    /// Autocorrelation e^(−t / `time`) at samples `period` apart; white for `time` = 0.
    pub(crate) fn new(time: f64, period: f64, rng: &mut Rng) -> Self {
        let rho = if time > 0.0 { (-period / time).exp() } else { 0.0 };
        Self { rho, value: rng.normal() }
    }

    pub(crate) fn step(&mut self, rng: &mut Rng) -> f64 {
        self.value = self.rho * self.value + (1.0 - self.rho * self.rho).sqrt() * rng.normal();
        self.value
    }

    /// Spectral density at frequency 0 (two-sided, unit variance): Σ_k ρ^|k| Δt.
    pub(crate) fn density(&self, period: f64) -> f64 {
        period * (1.0 + self.rho) / (1.0 - self.rho)
    }
}

/// The TurtleBot3 Burger: wheel radius 33 mm, track 160 mm, radius of gyration 64 mm.
pub(crate) fn burger() -> (Kinematics<f64, 2>, MassMatrix<f64, 2>) {
    let kinematics = Kinematics::differential(0.033, 0.16).unwrap();
    (kinematics, kinematics.mass_matrix(0.064).unwrap())
}

/// 1 kg empty, 5 kg of payload.
pub(crate) fn range() -> MassRange<f64> {
    MassRange::new(1.0, 6.0).unwrap()
}

/// Parameters of a small servo-driven robot.
pub(crate) fn servo() -> TorqueModel<f64> {
    TorqueModel {
        coulomb: 0.03,
        rolling: 0.01,
        viscous: 0.01,
        rotor_inertia: 0.003,
        inertia_gain: 1.3,
        winding_loss: 3.0,
        scrub: 0.0,
        imbalance: 0.0,
        gear_loss: 0.0,
        bridge_drop: 0.0,
        wheel_friction_share: 0.0,
    }
}

/// All of the above in one.
pub(crate) fn coefficients() -> Coefficients<f64, 2> {
    let (kinematics, mass_matrix) = burger();
    Coefficients {
        robot: Robot {
            name: Name::new("Burger"),
            kinematics,
            gyration_radius: 0.064,
            mass_matrix,
            dead_band: 0.02,
            cutoff_hz: 2.0,
            conditioning: Conditioning::PLAIN,
            range: range(),
            static_power: 6.4,
        },
        model: Model::Signed { torque: servo(), drive: Drive::Dissipative },
        noise: Noise { density: 1e-4, model_std: 0.0, tail: 1.0, residual_std: 0.0 },
        columns: Columns::NONE,
        identifies_mass: true,
        ground_adapts: false,
    }
}

/// A turning wheel: speeds of both signs beyond any dead band, accelerations and inertial torques
/// of all signs.
pub(crate) fn wheel() -> impl Strategy<Value = Wheel<f64>> {
    (0.05..10.0_f64, any::<bool>(), -30.0..30.0_f64, -0.1..0.1_f64).prop_map(
        |(speed, forward, acceleration, inertial_torque)| {
            let direction = if forward { 1.0 } else { -1.0 };
            Wheel {
                speed: direction * speed,
                acceleration,
                inertial_torque,
                direction,
                scrub: 0.0,
                side: 0.0,
            }
        },
    )
}

/// Plausible parameters of small and large robots.
pub(crate) fn torque_model() -> impl Strategy<Value = TorqueModel<f64>> {
    (0.0..1.0_f64, 0.0..0.1_f64, 0.0..0.5_f64, 0.0..0.5_f64, 0.0..3.0_f64, 0.0..5.0_f64).prop_map(
        |(coulomb, rolling, viscous, rotor_inertia, inertia_gain, winding_loss)| TorqueModel {
            coulomb,
            rolling,
            viscous,
            rotor_inertia,
            inertia_gain,
            winding_loss,
            scrub: 0.0,
            imbalance: 0.0,
            gear_loss: 0.0,
            bridge_drop: 0.0,
            wheel_friction_share: 0.0,
        },
    )
}

/// `one` and `other` agree to `relative` of `scale`.
pub(crate) fn close(one: f64, other: f64, scale: f64, relative: f64) -> bool {
    (one - other).abs() <= relative * scale
}
