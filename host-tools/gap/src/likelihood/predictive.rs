//! Confirmation: each field run predicted from all others, with the cause and without.

use numerics::intervals::{MeanInterval, mean_interval};

use super::evidence::{Totals, reduce};
use super::products::Posed;
use super::relinearise::{marginals, products};
use super::scored::{Case, Scales};
use super::ways::Way;

/// By how much likelier a field run is, nats, when the cause is told of the others: mean over the
/// runs with its 95 % interval. `None` where a run cannot be left out.
pub fn score(posed: &Posed<'_>, scales: &Scales, way: &Way, coefficients: &[f64]) -> Option<MeanInterval> {
    let way = &Way { first: 0, ..way.clone() };
    let middle = scales.likeliest();
    let Case { form, scale, .. } = scales.cases[middle];
    let runs = marginals(posed, scales, &products(posed, way, coefficients), scale)?;
    // ln evidence of the cause over none; where the linear model starts is none of both.
    let evidence = |left_out: Option<usize>| {
        let kept = runs.iter().enumerate().filter(|(run, _)| Some(*run) != left_out);
        let with = Totals::of(posed.shape, kept.clone().map(|(run, own)| (posed.is_field(run), own)));
        let with = reduce(&with, posed.shape, &scales.variances, form)?;
        let none = Totals::of(posed.shape, kept.map(|(run, _)| (false, &scales.in_case(middle)[run])));
        let none = reduce(&none, posed.shape, &scales.variances, form)?;
        Some(way.gain(&with, &scales.sizes) - 0.5 * (with.minus_two_log - none.minus_two_log))
    };
    let all = evidence(None)?;
    let field = (0..runs.len()).filter(|&run| posed.is_field(run));
    let each: Option<Vec<f64>> = field.map(|run| Some(all - evidence(Some(run))?)).collect();
    Some(mean_interval(&each?))
}
