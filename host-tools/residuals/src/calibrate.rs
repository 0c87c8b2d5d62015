//! What clean runs show of each other: structure that no effect has made.
//!
//! A model whose form is not quite the robot's leaves structure between any two handfuls of runs.
//! How much, the clean runs tell: some are asked about as if they came from the field, with the
//! others as the clean ones. What the field shows has to exceed that.

use logs::runs::Runs;
use model::effects::Candidate;
use rayon::prelude::*;

use super::detect::structure;
use super::problem::open::open_problem;
use super::split::by_mass;
use super::thresholds::calibrate::{DEALS, LEAST_RUNS, PARTS};
use super::twin::Twin;
use super::types::{Base, Options};

/// The most structure, |z|, that parts of the clean runs show of each other, the mean of all deals;
/// `None` where they are too few to be parted.
pub fn shown_by_clean(
    clean: &Runs,
    lag: f64,
    base: &Base,
    parameters: usize,
    list: &[Candidate],
    options: &Options,
) -> Option<f64> {
    if clean.runs.len() < LEAST_RUNS {
        return None;
    }
    let order = by_mass(clean);
    let shown = (0..DEALS * PARTS).into_par_iter().map(|part| {
        let (deal, part) = (part / PARTS, part % PARTS);
        let side = |asked: bool| -> Vec<usize> {
            let dealt = |rank: usize| (rank + deal * (rank / PARTS)) % PARTS;
            let of = |(rank, place): (usize, &usize)| ((dealt(rank) == part) == asked).then_some(*place);
            order.iter().enumerate().filter_map(of).collect()
        };
        let open = clean.subset(&side(true)).with_clean(Some(&clean.subset(&side(false))));
        let problem = open_problem(
            Twin { runs: &open, drive: base.drive, lag, early: 0.0 },
            &[],
            base,
            parameters,
            list,
            options,
        );
        structure(&problem, &problem.start(), list, &[]).greatest
    });
    let shown: Vec<f64> = shown.collect();
    let most = |parts: &[f64]| parts.iter().copied().filter(|z| z.is_finite()).max_by(f64::total_cmp);
    let deals: Vec<f64> = shown.chunks(PARTS).filter_map(most).collect();
    (!deals.is_empty()).then(|| deals.iter().sum::<f64>() / deals.len() as f64)
}
