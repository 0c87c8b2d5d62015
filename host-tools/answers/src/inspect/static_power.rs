//! P_static of Eq. 29 for every state: how many there are is found from the data.
//!
//! Block means of power at standstill are cut where their mean changes; pieces whose boundary is no
//! step (drift) are joined in time; what is left is gathered into levels. Two levels closer than
//! one standard deviation of the samples are one state: their Gaussians could not be distinguished
//! anyway.

use numerics::robust::MEDIAN_TO_STD;
use serde::Serialize;

use super::blocks::Block;
use super::segment::{self, Point};
use super::sketch::median;

/// Whether the robot moved while its power was at a level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Moving {
    /// It stood: the wheels say so, or no level is lower.
    No,
    /// The log does not tell.
    Unknown,
    /// Without wheels: the level recurs, and always above what surrounds it or as a short passage.
    Yes,
}

/// One level of power, as a Gaussian (Eq. 29).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StaticState {
    /// Mean, W.
    pub mean_w: f64,
    /// Standard deviation of the samples, W.
    pub std_w: f64,
    /// Share of the samples at standstill; without wheels, of all samples.
    pub share: f64,
    /// Whether the robot moved.
    pub moving: Moving,
    /// Standard error of the mean, W, with the noise's autocorrelation.
    pub std_err_w: f64,
    /// Time spent there, s.
    pub dwell_s: f64,
    /// Stretches of time spent there.
    pub stretches: u32,
    /// Start and end of each, s; of a log with thousands of them, of several together.
    pub visits: Vec<(f64, f64)>,
}

impl StaticState {
    /// Whether this is less than nothing, by more than noise: no robot draws that while it stands.
    pub fn is_offset(&self) -> bool {
        self.mean_w < -3.0 * self.std_err_w.max(1e-3 * self.std_w)
    }
}

/// All levels of a log, the lowest first.
#[derive(Debug, Clone, Default)]
pub struct StaticPower {
    /// Levels at which the robot stands, or may stand.
    pub standing: Vec<StaticState>,
    /// Levels taken for motion.
    pub moving: Vec<StaticState>,
    /// Share of samples in transitions and levels too short to be a state.
    pub brief_share: f64,
}

/// Powers beyond this are none, and their squares would be no numbers.
const LARGEST_W: f64 = 1e100;
/// Fewest blocks of a piece: shorter ones cannot be told from outliers.
const SHORTEST: usize = 3;
/// Fewest blocks at standstill for a figure at all.
const FEWEST: usize = 2;
/// Fewest blocks of all the visits of a state.
const FEWEST_OF_STATE: usize = 4;
/// Blocks on either side of a boundary that tell a step from a drift.
const NEAR: usize = 6;
/// Standard errors that a step must exceed.
const STEP_Z: f64 = 5.0;
/// Levels closer than this share of the whole range are one, should there be no noise at all.
const RESOLUTION: f64 = 0.01;

/// Consecutive blocks at one level.
#[derive(Debug, Clone, Copy)]
struct Piece {
    from: usize,
    to: usize,
    mean: f64,
    weight: f64,
    level: usize,
}

impl StaticPower {
    /// The levels of the blocks in which the robot stands. `has_wheels` says whether the log itself
    /// tells standstill.
    pub fn of(blocks: &[Block], has_wheels: bool) -> Self {
        let usable = |block: &Block| block.still && block.mean.abs() < LARGEST_W && block.squares.is_finite();
        let blocks: Vec<Block> = blocks.iter().copied().filter(usable).collect();
        if blocks.len() < FEWEST {
            return Self::default();
        }
        let noise = Noise::of(&blocks);
        let points: Vec<Point> = noise
            .tamed
            .iter()
            .zip(&blocks)
            .map(|(&value, block)| Point { value, weight: block.count / noise.typical_count })
            .collect();
        // Yao's penalty for the position and the level of a change, inflated by the
        // autocorrelation.
        let penalty = 3.0 * (points.len() as f64).ln().max(2.0) * noise.inflation;
        let mut from = 0;
        let mut pieces = Vec::new();
        for to in segment::pieces(&points, noise.block_std.powi(2), penalty, SHORTEST) {
            pieces.push(Piece::new(&points, from, to));
            from = to;
        }
        join_drifts(&mut pieces, &points, &noise);
        let levels = gather(&mut pieces, noise.closest_levels());
        describe(&blocks, &pieces, levels, &noise, has_wheels)
    }
}

impl Piece {
    fn new(points: &[Point], from: usize, to: usize) -> Self {
        let weight: f64 = points[from..to].iter().map(|point| point.weight).sum();
        let sum: f64 = points[from..to].iter().map(|point| point.weight * point.value).sum();
        Self { from, to, mean: sum / weight, weight, level: 0 }
    }
}

/// Noise of samples and of block means, estimated so that changes of level do not count.
struct Noise {
    /// Standard deviation of samples within blocks.
    sample_std: f64,
    /// Standard deviation of block means within a level.
    block_std: f64,
    /// Long-run variance of block means over their variance: (1 + ρ)/(1 − ρ) of an AR(1).
    inflation: f64,
    /// Samples of a usual block.
    typical_count: f64,
    /// Block means with lone outliers drawn in.
    tamed: Vec<f64>,
}

impl Noise {
    fn of(blocks: &[Block]) -> Self {
        let means: Vec<f64> = blocks.iter().map(|block| block.mean).collect();
        let typical_count = median(&mut blocks.iter().map(|block| block.count).collect::<Vec<_>>());
        let stds = blocks.iter().filter(|block| block.count >= 4.0).map(Block::std);
        let sample_std = median(&mut stds.collect::<Vec<_>>());
        let low = means.iter().copied().fold(f64::INFINITY, f64::min);
        let high = means.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let floor = (RESOLUTION * (high - low)).max(1e-9 * high.abs()).max(f64::MIN_POSITIVE.sqrt());

        // For an AR(1) with correlation ρ the variance of x(k+2) − x(k) is 1 + ρ times that of
        // x(k+1) − x(k); medians of their magnitudes hardly see the few that cross a change.
        let spread = |apart: usize| {
            let mut steps: Vec<f64> =
                means.iter().zip(means.iter().skip(apart)).map(|(a, b)| (b - a).abs()).collect();
            MEDIAN_TO_STD * median(&mut steps)
        };
        let (one, two) = (spread(1), spread(2));
        let enough = means.len() >= 12 && one > 0.0;
        let correlation = if enough { ((two / one).powi(2) - 1.0).clamp(0.0, 0.9) } else { 0.3 };
        let from_steps = one / (2.0 * (1.0 - correlation)).sqrt();
        let from_samples = sample_std / typical_count.sqrt();
        let block_std = if enough { from_steps } else { from_samples.max(from_steps) }.max(0.1 * floor);

        let tamed = (0..means.len())
            .map(|k| {
                let around = &means[k.saturating_sub(2)..(k + 3).min(means.len())];
                let middle = median(&mut around.to_vec());
                means[k].clamp(middle - 3.0 * block_std, middle + 3.0 * block_std)
            })
            .collect();
        Self {
            sample_std: sample_std.max(floor),
            block_std,
            inflation: (1.0 + correlation) / (1.0 - correlation),
            typical_count,
            tamed,
        }
    }

    /// Levels closer than this are one.
    fn closest_levels(&self) -> f64 {
        self.sample_std.max(3.0 * self.block_std)
    }

    /// Standard error of the mean of so many blocks.
    fn std_err(&self, weight: f64) -> f64 {
        self.block_std * (self.inflation / weight).sqrt().min(1.0)
    }
}

/// Joins neighbours in time between which there is no step: a drift was cut into stairs.
fn join_drifts(pieces: &mut Vec<Piece>, points: &[Point], noise: &Noise) {
    loop {
        let jump = |pair: &[Piece]| {
            let before = Piece::new(points, pair[0].from.max(pair[0].to.saturating_sub(NEAR)), pair[0].to);
            let after = Piece::new(points, pair[1].from, pair[1].to.min(pair[1].from + NEAR));
            let limit = noise
                .sample_std
                .max(STEP_Z * noise.std_err(before.weight).hypot(noise.std_err(after.weight)));
            (after.mean - before.mean).abs() / limit
        };
        let smallest = pieces.windows(2).map(jump).enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
        match smallest {
            Some((first, size)) if size < 1.0 => {
                let end = pieces.remove(first + 1).to;
                pieces[first] = Piece::new(points, pieces[first].from, end);
            }
            _ => return,
        }
    }
}

/// Gives every piece its level, 0 being the lowest: the closest two are joined until all are apart.
/// The number of levels.
fn gather(pieces: &mut [Piece], closest: f64) -> usize {
    let mut clusters: Vec<(f64, f64, Vec<usize>)> =
        pieces.iter().enumerate().map(|(index, piece)| (piece.mean, piece.weight, vec![index])).collect();
    clusters.sort_by(|a, b| a.0.total_cmp(&b.0));
    loop {
        let gaps = clusters.windows(2).map(|pair| pair[1].0 - pair[0].0).enumerate();
        match gaps.min_by(|a, b| a.1.total_cmp(&b.1)) {
            Some((first, gap)) if gap < closest => {
                let (mean, weight, members) = clusters.remove(first + 1);
                let into = &mut clusters[first];
                into.0 = (into.0 * into.1 + mean * weight) / (into.1 + weight);
                into.1 += weight;
                into.2.extend(members);
            }
            _ => break,
        }
    }
    for (level, (_, _, members)) in clusters.iter().enumerate() {
        for &member in members {
            pieces[member].level = level;
        }
    }
    clusters.len()
}

fn describe(
    blocks: &[Block],
    pieces: &[Piece],
    levels: usize,
    noise: &Noise,
    has_wheels: bool,
) -> StaticPower {
    let total: f64 = blocks.iter().map(|block| block.count).sum();
    let mut power = StaticPower { brief_share: 1.0, ..StaticPower::default() };
    for level in 0..levels {
        let visits: Vec<&[Piece]> =
            pieces.chunk_by(|a, b| a.level == b.level).filter(|v| v[0].level == level).collect();
        let spans = visits.iter().map(|visit| (visit[0].from, visit[visit.len() - 1].to));
        // Blocks at the ends of a visit may straddle a change.
        let inner = |(from, to): (usize, usize)| if to - from > 4 { (from + 1, to - 1) } else { (from, to) };
        let members: Vec<&Block> =
            spans.clone().flat_map(|span| &blocks[inner(span).0..inner(span).1]).collect();
        let all: Vec<&Block> = spans.clone().flat_map(|(from, to)| &blocks[from..to]).collect();
        if all.len() < FEWEST_OF_STATE && levels > 1 {
            continue;
        }
        let count: f64 = members.iter().map(|block| block.count).sum();
        let mean = members.iter().map(|block| block.count * block.mean).sum::<f64>() / count;
        let squares: f64 =
            members.iter().map(|block| block.squares + block.count * (block.mean - mean).powi(2)).sum();
        let share = all.iter().map(|block| block.count).sum::<f64>() / total;
        power.brief_share -= share;
        let state = StaticState {
            mean_w: mean,
            std_w: (squares / count).sqrt(),
            share,
            // Of one level alone a log without wheels does not say whether the robot stood.
            moving: match (has_wheels, level, levels) {
                (true, _, _) => Moving::No,
                (false, 0, 1) => Moving::Unknown,
                (false, 0, _) => Moving::No,
                _ => moving(pieces, level),
            },
            std_err_w: noise.std_err(count / noise.typical_count),
            dwell_s: all.iter().map(|block| block.seconds).sum(),
            stretches: spans.clone().map(|(from, to)| begun(&blocks[from..to])).sum(),
            visits: spans.flat_map(|(from, to)| stretches(&blocks[from..to])).collect(),
        };
        if state.moving == Moving::Yes { power.moving.push(state) } else { power.standing.push(state) }
    }
    power.brief_share = power.brief_share.max(0.0);
    power
}

/// Stretches of standing in a visit to a level: one, where that came about while the robot stood.
fn begun(blocks: &[Block]) -> u32 {
    blocks.iter().map(|block| block.stretches).sum::<u32>().max(1)
}

/// Blocks as stretches of standing: start and end, s. What lies between two of them was no
/// standing.
fn stretches(blocks: &[Block]) -> Vec<(f64, f64)> {
    let mut stretches: Vec<(f64, f64)> = Vec::new();
    for block in blocks {
        match stretches.last_mut() {
            Some(last) if block.stretches == 0 => last.1 = block.to_s,
            _ => stretches.push((block.from_s, block.to_s)),
        }
    }
    stretches
}

/// Whether a level above the lowest looks like motion in a log that does not tell: it recurs, and
/// every time it either rises above what surrounds it or is passed through quickly.
fn moving(pieces: &[Piece], level: usize) -> Moving {
    let visits: Vec<(usize, usize)> = pieces
        .chunk_by(|a, b| a.level == b.level)
        .map(|visit| (visit[0].level, visit[visit.len() - 1].to - visit[0].from))
        .collect();
    // How long the robot stays at a level, when it does: single visits may be cut off by the ends
    // of the log.
    let stay =
        |level: usize| visits.iter().filter(|visit| visit.0 == level).map(|visit| visit.1).max().unwrap_or(0);
    let mut signs = 0;
    for (index, &(_, length)) in visits.iter().enumerate().filter(|(_, visit)| visit.0 == level) {
        let before = index.checked_sub(1).map(|before| visits[before]);
        let (before, after) = match (before, visits.get(index + 1)) {
            (Some(before), Some(after)) => (before, after),
            // Cut off by an end of the log: no sign, unless it stands below its one neighbour.
            (Some((beside, _)), None) | (None, Some(&(beside, _))) if beside < level => continue,
            _ => return Moving::Unknown,
        };
        let above = before.0 < level && after.0 < level;
        let passage =
            (before.0 < level) != (after.0 < level) && 2 * length <= stay(before.0).min(stay(after.0));
        if !above && !passage {
            return Moving::Unknown;
        }
        signs += 1;
    }
    if signs >= 2 { Moving::Yes } else { Moving::Unknown }
}
