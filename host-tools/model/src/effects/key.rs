//! Keys of details, in JSON and coefficient files.

pub(super) const ALONG: &str = "along";
pub(super) const AT: &str = "at_s";
pub(super) const BY: &str = "by";
pub(super) const COEFFICIENTS: &str = "coefficients";
pub(super) const EMPTY: &str = "empty_kg";
pub(super) const DEPENDS_ON_MASS: &str = "depends_on_mass";
pub(super) const FROM: &str = "from";
pub(super) const FROM_C: &str = "from_c";
pub(super) const HALF_SLIP: &str = "half_slip";
pub(super) const HOLD: &str = "hold_s";
pub(super) const IN_PROPORTION: &str = "in_proportion";
pub(super) const RUNS: &str = "runs";
pub(super) const SIDE: &str = "side";
pub(super) const SPEED: &str = "speed_rad_s";
pub(super) const STD_ERRS: &str = "std_errs";
pub(super) const TIME_CONSTANT: &str = "time_constant_s";
pub(super) const WHEEL: &str = "wheel";
pub(super) const WITH: &str = "with";
pub(super) const WITH_STATIC: &str = "with_static_w";
