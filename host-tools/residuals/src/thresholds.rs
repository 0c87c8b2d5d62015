//! Every constant that the workflow decides by: its value, its unit, and where it comes from.
//!
//! *Derived* says from what. *Tuned* says on what: the own bench is `gmr gap-bench` (one plant, 60
//! s runs at 20 Hz, 0.05 W of noise). Where neither the history nor docs/gap.md say which run of
//! it, the run is unknown: such a value holds for one plant. What is only layout (cells of a map,
//! lines of a screen) is marked so: no verdict depends on it.

/// Splitting, and the least that each step needs.
pub mod split {
    /// Open runs, at least. Derived: with one left out, two remain, whose scatter can be estimated.
    pub const LEAST_OPEN: usize = 3;
    /// Runs are dealt into so many parts, in the order of masses: one part is asked what the others
    /// show. Of field runs one part is locked, and confirms. Chosen.
    pub const PARTS: usize = 3;
}

/// Whitening, weights and the variance of scores.
pub mod noise {
    /// Order of the autoregression, rows. Chosen by a prototype on its own 20 Hz sets ("about 8");
    /// run unknown.
    pub const ORDER: usize = 8;
    /// White noise added to the autocovariance, as a share of the variance: behind a low-pass
    /// filter the noise has next to no power above the cutoff, and without this floor the whitener
    /// would lift that band. Tuned on the own bench, run unknown.
    pub const WHITE_FLOOR: f64 = 0.03;
    /// Lengths of the blocks whose scores are taken for independent, s: noise with a long memory
    /// scatters more over long ones. Tuned on the own bench's autocorrelated and heteroscedastic
    /// sets, run unknown.
    pub const BLOCKS_S: [f64; 2] = [4.0, 15.0];
    /// Added to the diagonal of scaled products: columns that repeat each other share what they
    /// explain. Derived: far below the share of any noise (1 per row), far above rounding.
    pub const RIDGE: f64 = 1e-6;
    /// The whitener of the first residual shows a better one; weights and regression settle in as
    /// many passes. Chosen for time; run unknown.
    pub const PASSES: usize = 2;

    /// Clean runs that scatter so many times less than the field have another noise: a simulator's,
    /// or none. Chosen: an effect that no column explains (bursts, a rattle) triples no run's
    /// scatter in the own bench.
    pub const QUIETER: f64 = 4.0;
    /// Their spread is reduced to this share at least. Chosen: their misfit is no noise, and has to
    /// stay visible.
    pub const LEAST_QUIET: f64 = 0.1;

    /// Levels of jerk, acceleration and power. Chosen; run unknown.
    pub const LEVELS: usize = 8;
    /// Least rows of a level. Derived: their mean square is then known to some 25 %.
    pub const LEAST_ROWS: usize = 40;
    /// Rounds that settle what each of several explains beyond the others: measures of the scatter,
    /// times of a step in several runs. Chosen; run unknown.
    pub const ROUNDS: usize = 3;
    /// Rows before and after that share in the jerk of a row. Derived: the filter's memory at some
    /// three rows per period of its cutoff.
    pub const REACH: usize = 2;
}

/// Posing the problem: base, discrepancy, linearisation.
pub mod problem {
    /// Columns of which base and effects leave less than this share are no columns of their own.
    /// Derived: rounding of the numerical slopes is about 1e-5 of a column, of which a thousandth
    /// is far.
    pub const LEAST_SHARE: f64 = 1e-3;
    /// Added to the diagonal of the scaled normal matrix. Derived: rounding of some ninety columns
    /// that nearly repeat each other.
    pub const RIDGE: f64 = 1e-9;
    /// Total masses that differ by less than this share are one: they do not show the effect of
    /// mass on power, and one that is lighter than the empty robot by no more may be its own. Chosen:
    /// a scale's error and a battery's swap are below it, any payload worth an estimate above.
    pub const ONE_MASS: f64 = 0.1;
    /// Share of a variance below which it is next to none. Clean runs that have no more of a signal's
    /// variance in the field say nothing about it. A current that explains no more of the measured
    /// power's is no part of it, and may be a cause. Tuned on a door that was shut in the clean runs
    /// (tests/gap_user_effects.rs) and a measured slope, no bench; each side's current of a Husky has
    /// 0.3 to 0.7.
    pub const NEXT_TO_NONE: f64 = 0.1;
    /// Longest delay of a measuring chain in clean runs, rows. Chosen: an encoder's mean over a
    /// sample and a sensor's over another.
    pub const MOST_DELAY_ROWS: f64 = 2.0;
    /// It is fitted to this share of a row. Derived: a hundredth of a row moves no score by a
    /// tenth.
    pub const DELAY_ACCURACY_ROWS: f64 = 0.01;
    /// How much less is known of a parameter of which the base's fit knew nothing, sizes. Chosen:
    /// an order of magnitude.
    pub const UNKNOWN: f64 = 10.0;
    /// A Gauss–Newton step is halved so many times, at most. Chosen.
    pub const HALVINGS: usize = 5;
    /// A step that gains less in χ² was the last. Derived: a tenth of what one parameter gains by
    /// chance.
    pub const LEAST_STEP_GAIN: f64 = 0.1;
    /// Steps of a fit, at most. Chosen: three left a delay of 0.126 s at 0.092
    /// (benches/robots/gap_sizes.py, `sensor-delay`, seed 5); most fits end long before this by the
    /// gain of a step.
    pub const MOST_FIT_STEPS: usize = 16;
}

/// What clean runs show of each other.
pub mod calibrate {
    /// Fewest clean runs. Derived: two of a kind, and four that say what is usual.
    pub const LEAST_RUNS: usize = 6;
}

/// Detection: whether there is structure.
pub mod detect {
    /// |z| beyond which there is structure, and a name stands out. Tuned on the own bench's
    /// effect-free sets (0 alarms of 300; 0 of 200 of the second judge in
    /// docs/results/gap-judge.txt). Some sixty columns of normal scores ask for 3.5 only: what is
    /// above it stands for scores that are no normal variables.
    pub const STRUCTURE: f64 = 5.3;
    /// Share that is no difference: no term of the model is exact. So much of an effect's own gain in
    /// χ² may be left as structure, and rivals that are worse by less tie. Every parameter of the base
    /// is as uncertain beyond its covariance, and changes of the power below this share of its
    /// greatest are taken for linear (second-order terms are then below 1e-4). Tuned for ties on the
    /// own bench, run unknown.
    pub const INEXACT: f64 = 0.01;
    /// Standard errors below which a difference is none: of two effects' fits (a tie), of the drives
    /// that they predict, of a single run's step or mass from zero. A row whose residual is beyond it
    /// counts linearly: a burst, or the kink of a start. Derived: 1 of 400 normal scores.
    pub const NO_DIFFERENCE: f64 = 3.0;
    /// |z| that is noise whatever was searched for. Below it no name is looked for, and the field
    /// scatters no more than clean runs do. Derived: the greatest of a hundred normal scores is below
    /// it in 95 of 100 sets.
    pub const NOTHING_LEFT: f64 = 3.5;
    /// The same as [`STRUCTURE`] without clean runs, which show the model's errors without any
    /// effect. Tuned on the own bench without clean runs, run unknown.
    pub const STRUCTURE_ALONE: f64 = 20.0;

    /// Mean squares that exceed those of clean runs by less than this factor are no disturbance:
    /// runs differ. Tuned on the own bench, run unknown.
    pub const DISTURBANCE: f64 = 1.5;
    /// Residuals beyond this many standard deviations of clean runs count as this many: one stray
    /// row is no disturbance. Chosen.
    pub const MOST_SIGMAS: f64 = 6.0;

    /// Share of a run at its ends in which no step is looked for: one there is next to none, or
    /// next to always. Chosen.
    pub const RUN_ENDS: f64 = 0.1;
    /// Times that are tried lie this far apart at least, s. Derived: some two periods of the
    /// filter's cutoff.
    pub const TIME_GRID_S: f64 = 1.0;
    /// Times that are tried in a run, at most; of so many the best gains 2 ln 120 = 9.6 in χ² by
    /// chance. Chosen for time.
    pub const MOST_TIMES: f64 = 120.0;
    /// A floor's step is implausible beyond so many times the base's rolling resistance. Chosen:
    /// sand against tiles is some twenty.
    pub const MOST_ROLLING: f64 = 20.0;
}

/// Naming: which hypothesis wins, and what is as good.
pub mod name {
    /// Effects that are added, at most. Chosen: what a dozen runs can distinguish.
    pub const MOST_EFFECTS: usize = 3;
    /// Least gain of each of several effects, the others being known, as a share of what all gain:
    /// less may mop up after a wrong name, unless no structure is left beyond the noise. Tuned on
    /// the own bench's pairs, run unknown.
    pub const LEAST_FURTHER: f64 = 0.1;
    /// Another effect takes the place of one that was named where it is better by more than this, χ²;
    /// a round over the runs' times that gains less was the last. Derived: a column's mean gain by
    /// chance.
    pub const CHANCE: f64 = 1.0;
    /// So many times each effect is asked for again at most, and so many times the effects that
    /// there may be are named: a fit may end elsewhere than before, and go in a circle. Chosen.
    pub const MOST_ASKED: usize = 2;
    /// What each further column of a candidate costs, in χ². Derived: Akaike's criterion.
    pub const COLUMN_PENALTY: f64 = 2.0;
    /// Rows between delays at which a fit may begin. Derived: interpolation is at its worst half a
    /// row from any.
    pub const DELAY_GRID_ROWS: f64 = 0.5;
    /// Standard error of a delay beyond the fit's, samples of the log: what changes faster than
    /// half their rate is sampled at another phase with every fraction of a sample. Tuned on the
    /// own plant at 20 Hz (benches/robots/gap_sizes.py, `sensor-delay`: 19 of 20 intervals hold the
    /// truth).
    pub const DELAY_SAMPLES: f64 = 0.04;
    /// Hypotheses whose shape is searched between those of the dictionary. Chosen for time.
    pub const SHARPENED: usize = 3;
    /// It ends at this share of the interval. Derived: an eighth of a factor of four moves no loss
    /// by as much as a tie.
    pub const SEARCH_TOLERANCE: f64 = 0.125;
    /// Steps in which times are looked for, s. They are long at first: the time at which a step
    /// explains most of a single run is drawn towards that of the others' while these have none.
    /// Chosen: halves of 8 s down to the filter's memory.
    pub const TIME_STEPS_S: [f64; 7] = [8.0, 4.0, 2.0, 1.0, 0.5, 0.25, 0.12];
}

/// Confirmation on the locked runs.
pub mod confirm {
    /// Share of what it adds that a name has to show on the locked runs, and of what field runs have
    /// beyond clean ones that it has to close where the rest scatters more than in clean runs. Tuned
    /// on the own bench; "naming something that closes less than half is usually a wrong name" by a
    /// prototype.
    pub const LEAST_CLOSED: f64 = 0.5;
}

/// Drives that distinguish the rivals of a tie.
pub mod manoeuvre {
    /// Runs of the profile that are asked for. Chosen: with twelve field runs a fourth of all.
    pub const RUNS: usize = 4;
    /// Numbers of runs that are tried where a probability is asked for. Chosen: even, for light and
    /// heavy ones by turns; a day's work at most.
    pub const RUNS_TRIED: [usize; 8] = [4, 6, 8, 12, 16, 24, 32, 48];
    /// Share of the expected difference of rivals that counts: the model's errors where no run has
    /// been yet take the rest. Tuned on `gmr gap-bench --manoeuvre` (27 sets of size 0.5), run
    /// unknown.
    pub const TRUSTED: f64 = 0.5;
    /// Lengths that are tried, s: the first that leaves little enough open, or the last.
    /// Chosen: minutes that people drive. Blocks are chosen at the first.
    pub const DURATIONS_S: [f64; 3] = [60.0, 120.0, 240.0];
    /// Rests before the first motion that are tried, s. Chosen: next to none, and one that offsets
    /// show in.
    pub const LEADS_S: [f64; 2] = [2.0, 15.0];
    /// Most blocks that take turns. Chosen for time.
    pub const MOST_BLOCKS: usize = 4;
    /// Share of the rows whose speeds and accelerations are below what is taken for the robot's
    /// limit. Chosen: the stray hundredth is noise.
    pub const USUAL: f64 = 0.99;
    /// How brisk ramps are where a block is about something else, share of the greatest
    /// acceleration. Chosen.
    pub const EASY: f64 = 0.5;
    /// How uncertain a shape parameter is, as a share of it: a rival may take another width or time
    /// constant. Derived: the dictionary's shapes are a factor of two to three apart.
    pub const SHAPE_UNCERTAINTY: f64 = 0.7;
    /// Relative step of a slope by a shape parameter. Derived: small against that.
    pub const SHAPE_STEP: f64 = 0.1;
    /// Samples per period of the filter's cutoff of a planned drive. Derived: the filter's design
    /// needs two.
    pub const SAMPLES_PER_CUTOFF: f64 = 5.0;
}

/// Logs of power only.
pub mod power_only {
    /// Rows a second at most, about: levels closer than the scatter of rows are one. Chosen.
    pub const ROWS_PER_S: f64 = 200.0;
    /// Standard errors that a step has to exceed. Tuned on the TurtleBot3's four logs and simulated
    /// drives of tests/gap_power_only.rs.
    pub const STEP_ERRORS: f64 = 5.0;
    /// Steps of runs are one and the same if they differ by no more than this share, or by
    /// [`NO_DIFFERENCE`](super::detect::NO_DIFFERENCE). As above.
    pub const SAME_SHARE: f64 = 0.25;
    /// Open runs that have to show a step, and returns to a level of rest. Derived: once is no
    /// pattern.
    pub const LEAST_RUNS: usize = 2;
    /// Shortest rest that counts, s. As [`STEP_ERRORS`].
    pub const LEAST_REST_S: f64 = 5.0;
    /// Least share of the time that a rest is returned to. As [`STEP_ERRORS`].
    pub const LEAST_SHARE: f64 = 1.0 / 3.0;
    /// A rest scatters no more than this many times as much as any other: motion is rougher than
    /// standing. As [`STEP_ERRORS`].
    pub const ROUGHER: f64 = 1.3;
    /// Length of the means whose scatter shows how far a rest wanders, s. Chosen.
    pub const WANDER_S: f64 = 2.0;
    /// Blocks of a run in a cell that say something about it. Layout.
    pub const LEAST_BLOCKS: usize = 6;
}

/// What is shown of the residual; no verdict depends on it.
pub mod localise {
    /// Rows of a run in a cell that say something about it. Layout.
    pub const LEAST_ROWS: usize = 10;
    /// Runs with a mean of their own that a band needs. Derived: Student's t of two is 12.7.
    pub const LEAST_RUNS: usize = 3;
    /// Cells of an axis, at most: about equal numbers of rows. Layout.
    pub const CELLS: usize = 6;
    /// Edges are multiples of a round step, at least so many of them over the axis. Layout.
    pub const STEPS: f64 = 40.0;
    /// Turn rates below this share of the greatest are straight ahead. Layout.
    pub const STRAIGHT: f64 = 0.1;
    /// Squares along an axis of the map, about. Layout.
    pub const SQUARES: f64 = 8.0;
}

/// The plant along recorded speeds.
pub mod driven_plant {
    /// Evaluations of an effect's size, at most. Chosen for time: secants of a nearly linear answer
    /// settle in three.
    pub const SIZE_STEPS: usize = 6;
    /// Sizes closer than this share of each other are the same. Derived: far below any
    /// coefficient's error.
    pub const SAME_SIZE: f64 = 2e-3;
    /// The first size that is tried, as a share of the range. Chosen.
    pub const FIRST_SIZE: f64 = 0.02;
    /// Integration step, s: that of the speed loop. What it moves the power by is calibrated away.
    pub const STEP_S: f64 = 1e-3;
    /// Time in which the plant gets to the first speed of a log that does not begin at rest, s.
    /// Chosen.
    pub const LEAD_S: f64 = 1.0;
    /// Speeds are smoothed with a cutoff this many times that of the common filter, forwards and
    /// backwards: what that filter passes stays as it is, and the steps of the encoder do not shake
    /// the plant's motors. Derived: twice the fifth-order filter takes 0.2 % there.
    pub const SMOOTHER: f64 = 2.0;
    /// Cutoffs above this share of the sample rate smooth nothing. Derived: the filter's design
    /// ends at half.
    pub const MOST_CUTOFF: f64 = 0.45;
    /// Steps of the calibration, at most. Chosen for time.
    pub const FIT_STEPS: usize = 4;
    /// A step that gains less than this share of what is left is the last. Chosen.
    pub const LEAST_GAIN: f64 = 1e-3;
    /// Relative step of a numerical derivative. Chosen: large against the plant's rounding, small
    /// against its bends.
    pub const NUDGE: f64 = 0.05;
    /// How far a parameter may be from the set of motors, as a share of it: it stays where the runs
    /// do not determine it. Chosen.
    pub const TRUST: f64 = 1.0;
    /// The plant's delay is fitted to this share of a row. Chosen for time.
    pub const DELAY_STEP_ROWS: f64 = 0.1;
    /// A plant whose wheels miss more than this share of the recorded speeds is another robot: the
    /// user is told. Chosen.
    pub const FOLLOWS: f64 = 0.05;
}
