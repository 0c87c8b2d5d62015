//! What clean runs show of each other: structure without any effect.
//!
//! A model whose form is not quite the robot's leaves structure between any two sets of runs. Here
//! some clean runs are analysed as if they came from the field, with the others as the clean ones.
//! The structure of the field has to exceed theirs.
//!
//! The greatest of three folds is a matter of luck. So they are dealt three times, other runs
//! together each time: of six runs no two are together twice.

use logs::runs::Runs;
use model::effects::Candidate;
use rayon::prelude::*;

use super::detect::structure;
use super::predictor::{Predictor, State};
use super::problem::open::{open_with, slopes};
use super::split::by_mass;
use super::thresholds::calibrate::LEAST_RUNS;
use super::thresholds::split::PARTS;
use super::types::{Base, Options};

/// Greatest structure, |z|, of one fold of the clean runs against the others: the mean over all
/// deals. `None` where there are too few runs.
pub fn shown_by_clean(
    clean: &Runs,
    clean_delay: f64,
    base: &Base,
    parameters: usize,
    list: &[Candidate],
    options: &Options,
) -> Option<f64> {
    if clean.runs.len() < LEAST_RUNS {
        return None;
    }
    let order = by_mass(clean);
    let predictor = Predictor { clean_delay, ..Predictor::new(clean, base.drive) };
    let start = State { torque: base.torque, effects: Vec::new() };
    let slopes = slopes(&predictor, &start, parameters, list);
    let shown = (0..PARTS * PARTS).into_par_iter().map(|number| {
        let (deal, fold) = (number / PARTS, number % PARTS);
        let side = |asked: bool| -> Vec<usize> {
            let dealt = |rank: usize| (rank + deal * (rank / PARTS)) % PARTS;
            let of = |(rank, place): (usize, &usize)| ((dealt(rank) == fold) == asked).then_some(*place);
            order.iter().enumerate().filter_map(of).collect()
        };
        let (asked, others) = (side(true), side(false));
        let open = clean.subset(&asked).with_clean(Some(&clean.subset(&others)));
        let predictor = Predictor { runs: &open, ..predictor };
        let slopes = asked.iter().chain(&others).map(|&place| slopes[place].clone()).collect();
        let problem = open_with(predictor, slopes, base, parameters, list, options);
        structure(&problem, &start, list, &[]).greatest
    });
    let shown: Vec<f64> = shown.collect();
    let most = |folds: &[f64]| folds.iter().copied().filter(|z| z.is_finite()).max_by(f64::total_cmp);
    let deals: Vec<f64> = shown.chunks(PARTS).filter_map(most).collect();
    (!deals.is_empty()).then(|| deals.iter().sum::<f64>() / deals.len() as f64)
}
