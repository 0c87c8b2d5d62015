// Made by image.py; do not edit.

/// The robot's.
pub(crate) const NAME: &str = "reference";

/// SI units.
pub(crate) const GYRATION_RADIUS: f32 = 0.09000000357627869;

/// SI units.
pub(crate) const DEAD_BAND: f32 = 0.019999999552965164;

/// SI units.
pub(crate) const CUTOFF_HZ: f32 = 2.0;

/// SI units.
pub(crate) const NO_LOAD: f32 = 1.0;

/// SI units.
pub(crate) const FULL_LOAD: f32 = 6.0;

/// SI units.
pub(crate) const STATIC_POWER: f32 = 6.39300012588501;

/// SI units.
pub(crate) const NOISE_DENSITY: f32 = 0.003100000089034438;

/// SI units.
pub(crate) const NOISE_MODEL_STD: f32 = 0.012000000104308128;

/// SI units.
pub(crate) const RESIDUAL_STD: f32 = 0.03400000184774399;

/// SI units.
pub(crate) const NOISE_TAIL: f32 = 1.25;

/// The signed torque model's parameters; the drive is regenerative.
pub(crate) const TORQUE: [f32; 7] = [0.03999999910593033, 0.012000000104308128, 0.006000000052154064, 0.008100000210106373, 1.3300000429153442, 6.5, 0.0];

/// R.
pub(crate) const ROWS: [[f32; 2]; 3] = [[0.016499999910593033, 0.016499999910593033], [0.0, 0.0], [-0.20624999701976776, 0.20624999701976776]];

/// All of that, encoded.
pub(crate) const IMAGE: [u8; 164] = [71, 77, 82, 67, 1, 0, 164, 0, 2, 1, 2, 8, 114, 101, 102, 101, 114, 101, 110, 99, 101, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 236, 81, 184, 61, 10, 215, 163, 60, 0, 0, 0, 64, 0, 0, 128, 63, 0, 0, 192, 64, 117, 147, 204, 64, 95, 41, 75, 59, 166, 155, 68, 60, 150, 67, 11, 61, 0, 0, 160, 63, 10, 215, 35, 61, 166, 155, 68, 60, 166, 155, 196, 59, 221, 181, 4, 60, 113, 61, 170, 63, 0, 0, 208, 64, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 43, 135, 60, 2, 43, 135, 60, 0, 0, 0, 0, 0, 0, 0, 0, 51, 51, 83, 190, 51, 51, 83, 62, 27, 130, 58, 77];
