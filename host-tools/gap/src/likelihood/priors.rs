//! Every prior and every constant of the likelihood, each with its reason. None but [`FORM_ERRORS`]
//! was set by what verdicts came of it.

/// Of a tie the smallest set with this probability stays; a name that all other effects together
/// exceed by it is taken back. Convention.
pub const SURE: f64 = 0.95;

/// RMS of what an effect adds, standard deviations of the noise: the least. Derived: below it the
/// runs of an hour tell nothing.
pub const LEAST_SIZE: f64 = 0.1;
/// Sizes grow by this factor up to the robot's own power, each as likely: an effect may be of any
/// order of magnitude. Derived: normal densities a factor of three apart make a flat one.
pub const SIZE_STEP: f64 = 3.0;
/// Standard deviation of the share by which a half slip changes beside another coefficient.
/// Derived: its range ends at −0.9.
pub const SHARE_SIZE: f64 = 1.0;
/// What an effect's own form may get wrong, shares of its size, each as likely: nothing, or what
/// smooth functions of the drive make of a tenth or a third. Chosen: filters and backlash are not
/// in the terms, and what is wrong by more than a third is something else. The whole size was left
/// out after ties of the own bench's seed 701 had been looked at. What has one form only has the
/// first: [`super::ways::Way::form_errors`].
pub const FORM_ERRORS: [f64; 3] = [0.0, 0.1, 0.3];

/// Scale of the half-Cauchy prior of each variance's root, standard deviations of the noise a
/// function. Derived: seventy functions of that size come to 0.4 together, what a usable fit
/// leaves.
pub const DISCREPANCY: f64 = 0.05;
/// Least and greatest root of a variance. Derived: below, nothing shows in an hour; of relabelled
/// runs some have an effect and some have not, and it may be as large as the power itself.
pub const DISCREPANCY_RANGE: (f64, f64) = (1e-3, 100.0);
/// Rounds of the variances' estimate, at most: three steps each.
pub const VARIANCE_ROUNDS: usize = 12;
/// Logarithms of variances that move less than this have settled. Derived: six runs tell a
/// variance to a factor of three.
pub const SETTLED: f64 = 0.02;
/// How far two steps are extrapolated, at most. Chosen: beyond it rounding leads.
pub const FARTHEST: f64 = 32.0;
/// Common scales of what differs from run to run. Derived: six clean runs tell a variance to a
/// factor of three either way.
pub const RUN_SCALES: [f64; 5] = [0.1, 0.3, 1.0, 3.0, 10.0];
/// Precision of the base's parameters where clean runs tell of them, per noise variance. Derived:
/// next to nothing.
pub const LOOSE: f64 = 1e-8;

/// Sizes of what a form gets wrong for which sums are reduced, standard deviations of the noise a
/// function; the nearest one is taken. Derived: half decades, from what an hour hardly shows to ten
/// times the noise.
pub const FORM_SIZES: [f64; 6] = [0.003, 0.01, 0.03, 0.1, 0.3, 1.0];

/// Share of runs without a step of their own, each as likely. Derived: few runs or most have one.
pub const WITHOUT_STEP: [f64; 2] = [0.05, 0.4];
/// Share of runs whose mass was noted wrongly. Chosen: one of four, where any is.
pub const WRONG_MASS: f64 = 0.25;
/// Times that are tried in a run, at most. Chosen for time.
pub const MOST_TIMES: f64 = 30.0;
/// Most of a switch of rolling resistance, and where in a run no step is looked for. As the rules'
/// own.
pub use residuals::thresholds::detect::{MOST_ROLLING, RUN_ENDS};

/// Causes further behind the first than this cannot win by their bend, nats. Derived: what
/// linear rankings were seen to be off by is a share of the gain; see [`NEAR_SHARE`].
pub const NEAR: f64 = 20.0;
/// The same as a share of the first's evidence.
pub const NEAR_SHARE: f64 = 0.5;
/// Causes that are made linear again. Chosen for time.
pub const BENT: usize = 12;
/// Ways of each cause among them.
pub const BENT_WAYS: usize = 2;
/// Steps of each, at most. Chosen: Gauss and Newton settle in three, near ranges' ends in more.
pub const BENT_STEPS: usize = 10;
/// Standard errors by which a last step may move. Derived: evidences are off by less than a tenth.
pub const BENT_SETTLED: f64 = 0.2;
/// Delays from which one is looked for, a period of the filter's cutoff. Derived: Gauss and Newton
/// find what is within a quarter of it.
pub const DELAY_STEPS: f64 = 6.0;

/// Relabelled sets of the gate, at least. Derived: a share of 2 % is then known to half a percent.
pub const RELABELLED: usize = 999;
/// How much of a cause may differ between runs alike, standard deviations of the noise. Chosen:
/// half decades up to what dwarfs any effect.
pub const BETWEEN_RUNS: [f64; 6] = [0.0, 0.03, 0.1, 0.3, 1.0, 3.0];
