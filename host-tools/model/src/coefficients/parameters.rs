//! The parameters of each model by name, in the order of their vector: that of `[parameters]` and
//! of the covariance's rows.

use model_core::eq18::REGRESSORS;
use model_core::model::Model;
use model_core::torque::{Drive, PARAMETERS, TorqueModel};

use super::error::InvalidCoefficients;
use super::kind::ModelKind;

/// A parameter's name and unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Quantity {
    /// Its name in files and reports.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
}

const fn quantity(name: &'static str, unit: &'static str) -> Quantity {
    Quantity { name, unit }
}

/// The parameters of the signed torque model; wheels that do not scrub have all but the last.
pub const TORQUE: [Quantity; PARAMETERS] = [
    quantity("coulomb", "N·m"),
    quantity("rolling", "N·m/kg"),
    quantity("viscous", "N·m·s/rad"),
    quantity("rotor_inertia", "kg·m²"),
    quantity("inertia_gain", "1"),
    quantity("winding_loss", "W/(N·m)²"),
    quantity("scrub", "N·m/kg"),
];

/// What the right side's Coulomb torque has beyond the left's, halved; of either sign. Not in the
/// covariance, and only in files whose sides differ.
pub const IMBALANCE: Quantity = quantity("imbalance", "N·m");

/// Share of what passes the gear that it takes. Not in the covariance, and only in files that have
/// it.
pub const GEAR_LOSS: Quantity = quantity("gear_loss", "1");

/// Share of the friction that passes a gear with a loss of its own; 0 in files that do not say it.
pub(super) const WHEEL_FRICTION_SHARE: Quantity = quantity("wheel_friction_share", "1");

/// Voltage that the bridge takes over the motor's constant at the wheel. Not in the covariance, and
/// only in files that have it.
pub const BRIDGE_DROP: Quantity = quantity("bridge_drop", "rad/s");

/// β_0 … β_14 of Eq. 18.
pub const EQ18: [Quantity; REGRESSORS] = [
    quantity("beta0", "W"),
    quantity("beta1", "W/kg"),
    quantity("beta2", "W/kg²"),
    quantity("beta3", "W·s²/rad²"),
    quantity("beta4", "W·s⁴/rad²"),
    quantity("beta5", "W/(N·m)²"),
    quantity("beta6", "N·m"),
    quantity("beta7", "N·m/kg"),
    quantity("beta8", "W·s²/rad"),
    quantity("beta9", "W·s²/(rad·kg)"),
    quantity("beta10", "W/(N·m)"),
    quantity("beta11", "W/(N·m·kg)"),
    quantity("beta12", "kg·m²"),
    quantity("beta13", "1"),
    quantity("beta14", "s²/rad"),
];

/// Names and values of a model's parameters, for wheels that scrub in turns or do not.
pub(super) fn named(model: &Model<f64>, scrubs: bool) -> Vec<(&'static str, f64)> {
    let names = |list: &[Quantity], values: &[f64]| {
        list.iter().zip(values).map(|(quantity, value)| (quantity.name, *value)).collect::<Vec<_>>()
    };
    match model {
        Model::Signed { torque, .. } => names(torque_of(scrubs), &torque.to_array()),
        Model::Eq18 { beta, .. } => names(&EQ18, beta),
    }
}

/// Names and values of what this torque model has of its own, beyond what all have.
pub(super) fn traits(model: &Model<f64>) -> Vec<(&'static str, f64)> {
    let Model::Signed { torque, .. } = model else { return Vec::new() };
    let share = if torque.gear_loss == 0.0 { 0.0 } else { torque.wheel_friction_share };
    let traits = [
        (IMBALANCE.name, torque.imbalance),
        (GEAR_LOSS.name, torque.gear_loss),
        (WHEEL_FRICTION_SHARE.name, share),
        (BRIDGE_DROP.name, torque.bridge_drop),
    ];
    traits.into_iter().filter(|(_, value)| *value != 0.0).collect()
}

/// The torque model's parameters that wheels have.
fn torque_of(scrubs: bool) -> &'static [Quantity] {
    if scrubs { &TORQUE } else { &TORQUE[..PARAMETERS - 1] }
}

/// The model of a file's `[parameters]`.
pub(super) fn model(
    kind: ModelKind,
    parameters: &toml::Table,
    scrubs: bool,
    drive: Drive,
) -> Result<Model<f64>, InvalidCoefficients> {
    let value = |quantity: &Quantity| {
        let number = parameters.get(quantity.name).and_then(number);
        number.ok_or(InvalidCoefficients::NoParameter { name: quantity.name })
    };
    match kind {
        ModelKind::Signed => {
            let mut values = [0.0; PARAMETERS];
            for (place, quantity) in values.iter_mut().zip(torque_of(scrubs)) {
                *place = value(quantity)?;
            }
            let [imbalance, gear_loss, bridge_drop, wheel_friction_share] =
                [IMBALANCE, GEAR_LOSS, BRIDGE_DROP, WHEEL_FRICTION_SHARE]
                    .map(|quantity| parameters.get(quantity.name).and_then(number).unwrap_or(0.0));
            let shared = TorqueModel::from_array(values);
            let torque = TorqueModel { imbalance, gear_loss, bridge_drop, wheel_friction_share, ..shared };
            Ok(Model::Signed { torque, drive })
        }
        ModelKind::Eq18 | ModelKind::Eq18Published => {
            let mut beta = [0.0; REGRESSORS];
            for (place, quantity) in beta.iter_mut().zip(&EQ18) {
                *place = value(quantity)?;
            }
            Ok(Model::Eq18 { gate: kind.gate(), beta })
        }
    }
}

/// A number of either kind that TOML has.
pub(super) fn number(value: &toml::Value) -> Option<f64> {
    value.as_float().or_else(|| Some(value.as_integer()? as f64))
}
