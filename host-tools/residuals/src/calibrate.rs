//! What clean runs show of each other: structure without any effect.
//!
//! A model whose form is not quite the robot's leaves structure between any two sets of runs. Here
//! some clean runs are analysed as if they came from the field, with the others as the clean ones.
//! The structure of the field has to exceed theirs.

use logs::runs::Runs;
use model::effects::Candidate;
use rayon::prelude::*;

use super::detect::structure;
use super::predictor::Predictor;
use super::problem::open::open_problem;
use super::split::by_mass;
use super::thresholds::calibrate::{DEALS, FOLDS, LEAST_RUNS};
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
    let shown = (0..DEALS * FOLDS).into_par_iter().map(|number| {
        let (deal, fold) = (number / FOLDS, number % FOLDS);
        let side = |asked: bool| -> Vec<usize> {
            let dealt = |rank: usize| (rank + deal * (rank / FOLDS)) % FOLDS;
            let of = |(rank, place): (usize, &usize)| ((dealt(rank) == fold) == asked).then_some(*place);
            order.iter().enumerate().filter_map(of).collect()
        };
        let open = clean.subset(&side(true)).with_clean(Some(&clean.subset(&side(false))));
        let problem = open_problem(
            Predictor { clean_delay, ..Predictor::new(&open, base.drive) },
            &[],
            base,
            parameters,
            list,
            options,
        );
        structure(&problem, &problem.start(), list, &[]).greatest
    });
    let shown: Vec<f64> = shown.collect();
    let most = |folds: &[f64]| folds.iter().copied().filter(|z| z.is_finite()).max_by(f64::total_cmp);
    let deals: Vec<f64> = shown.chunks(FOLDS).filter_map(most).collect();
    (!deals.is_empty()).then(|| deals.iter().sum::<f64>() / deals.len() as f64)
}
