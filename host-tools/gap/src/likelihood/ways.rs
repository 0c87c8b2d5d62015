//! The ways in which effects may show in all field runs alike, as columns.

use std::mem::discriminant;

use model::effects::{Candidate, Detail, Regressor, STATIC_STEP, SURFACE_SWITCH, Switched};
use model_core::effects::Term;

use super::evidence::{Reduced, gain, gain_of_several, likeliest};
use super::normal::log_mean;
use super::priors::{FORM_ERRORS, LEAST_SIZE, MOST_ROLLING, MOST_TIMES, RUN_ENDS, SHARE_SIZE, SIZE_STEP};
use nalgebra::{DMatrix, DVector};

/// One of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Way {
    /// What shows.
    pub candidate: Candidate,
    /// Unit of each coefficient: a unit's RMS is the noise's standard deviation.
    pub units: Vec<f64>,
    /// The first of its columns among those of all ways.
    pub first: usize,
}

/// Of every candidate, and steps at one time of all runs, at a grid. `lengths` are those of the
/// field runs, s, `rolling` the base's, N·m/kg; `removed` has ids that are not asked for.
pub fn ways(list: &[Candidate], removed: &[String], lengths: &[f64], rolling: f64) -> Vec<Way> {
    let mut candidates: Vec<Candidate> = list.to_vec();
    let shortest = lengths.iter().copied().fold(f64::INFINITY, f64::min);
    let most = MOST_ROLLING * rolling.max(1e-3);
    let any = (f64::NEG_INFINITY, f64::INFINITY);
    let allowed = |id: &str| removed.iter().all(|removed| removed != id);
    for at_s in times(shortest) {
        let detail = Detail::At { at_s };
        let way = |entry: &model::effects::Entry, term, range| {
            entry.candidate(vec![Regressor::Term(term)], range, detail.clone(), 0.0)
        };
        if allowed(STATIC_STEP.id) {
            candidates.push(way(&STATIC_STEP, Term::StepAt(at_s), any));
        }
        if allowed(SURFACE_SWITCH.id) {
            candidates.push(way(&SURFACE_SWITCH, Term::RollingFrom(at_s), (-most, most)));
        }
    }
    let mut first = 0;
    let with_place = |candidate: Candidate| {
        let way = Way { units: vec![1.0; candidate.regressors.len()], candidate, first };
        first += way.units.len();
        way
    };
    candidates.into_iter().map(with_place).collect()
}

/// Times within a run, s, that are tried for a step.
pub fn times(length: f64) -> Vec<f64> {
    if !length.is_finite() {
        return Vec::new();
    }
    let step = (length / MOST_TIMES).max(residuals::thresholds::detect::TIME_GRID_S);
    let all = (1..).map(|k| step * f64::from(k)).take_while(|at| *at <= (1.0 - RUN_ENDS) * length);
    all.filter(|at| *at >= RUN_ENDS * length).collect()
}

/// What switches, and its range.
pub fn switched(slips: bool, rolling: f64) -> Vec<(Switched, (f64, f64))> {
    let most = MOST_ROLLING * rolling.max(1e-3);
    let mut switches =
        vec![(Switched::Static, (f64::NEG_INFINITY, f64::INFINITY)), (Switched::Rolling, (-most, most))];
    if slips {
        switches.push((Switched::HalfSlip, model::effects::HALF_SLIP));
    }
    switches
}

/// Sizes that an effect may have, standard deviations of the noise: up to the robot's own power.
pub fn sizes(most: f64) -> Vec<f64> {
    let all = (0..).map(|k| LEAST_SIZE * SIZE_STEP.powi(k));
    all.take_while(|size| *size < SIZE_STEP * most.max(LEAST_SIZE)).collect()
}

impl Way {
    /// Ways of one family share its probability: the same shape at other widths, times or delays.
    pub fn is_of_family(&self, other: &Self) -> bool {
        let (a, b) = (&self.candidate, &other.candidate);
        let same = |(a, b): (&Regressor, &Regressor)| match (a, b) {
            (Regressor::Term(a), Regressor::Term(b)) => discriminant(a) == discriminant(b),
            (a, b) => discriminant(a) == discriminant(b),
        };
        a.id == b.id
            && a.regressors.len() == b.regressors.len()
            && a.regressors.iter().zip(&b.regressors).all(same)
            && discriminant(&a.detail) == discriminant(&b.detail)
    }

    /// Shares of its size that its form may get wrong: none of a constant, of a factor or of a mass,
    /// which have no other form.
    pub fn form_errors(&self) -> &'static [f64] {
        let has_one_form = |regressor: &Regressor| match regressor {
            Regressor::Term(term) => {
                matches!(term, Term::Constant | Term::WithMotion(_) | Term::StepAt(_) | Term::Gain(_))
            }
            Regressor::Switch(Switched::Static, _)
            | Regressor::Mass(_)
            | Regressor::Masses
            | Regressor::Scale(_) => true,
            _ => false,
        };
        let shares = if self.candidate.regressors.iter().all(has_one_form) { 1 } else { FORM_ERRORS.len() };
        &FORM_ERRORS[..shares]
    }

    /// Columns among those of all ways.
    pub fn columns(&self) -> std::ops::Range<usize> {
        self.first..self.first + self.units.len()
    }

    /// Standard deviations of the coefficients, where the effect is of one size.
    fn scales(&self, size: f64) -> Vec<f64> {
        let each = self.candidate.regressors.iter().zip(&self.units).enumerate();
        each.map(|(place, (regressor, unit))| match regressor {
            Regressor::HalfSlip if place > 0 => SHARE_SIZE * unit,
            _ => size,
        })
        .collect()
    }

    /// ln evidence of it over none, by reduced products.
    pub fn gain(&self, reduced: &Reduced, sizes: &[f64]) -> f64 {
        let (along, gram) = self.products(reduced);
        match self.units[..] {
            [unit] => {
                let (low, high) = self.candidate.range;
                let range = (low * unit, high * unit);
                log_mean(sizes.iter().map(|size| gain(along[0], gram[(0, 0)], *size, range)))
            }
            _ if self.is_plausible(reduced, sizes) => {
                log_mean(sizes.iter().map(|size| gain_of_several(&along, &gram, &self.scales(*size))))
            }
            _ => f64::NEG_INFINITY,
        }
    }

    fn products(&self, reduced: &Reduced) -> (DVector<f64>, DMatrix<f64>) {
        let (first, count) = (1 + self.first, self.units.len());
        let along = reduced.products.view((first, 0), (count, 1)).column(0).into_owned();
        (along, reduced.products.view((first, first), (count, count)).into_owned())
    }

    /// Coefficients that are likeliest, in their own units, with their covariance.
    pub fn likeliest(&self, reduced: &Reduced, sizes: &[f64]) -> Option<(Vec<f64>, DMatrix<f64>)> {
        let (along, gram) = self.products(reduced);
        let most = sizes.iter().copied().fold(LEAST_SIZE, f64::max);
        let (values, covariance) = likeliest(&along, &gram, &self.scales(most))?;
        let mut coefficients: Vec<f64> = values.iter().zip(&self.units).map(|(x, unit)| x / unit).collect();
        if let [only] = &mut coefficients[..] {
            *only = only.clamp(self.candidate.range.0, self.candidate.range.1);
        }
        let covariance = DMatrix::from_fn(gram.nrows(), gram.ncols(), |i, j| {
            covariance[(i, j)] / self.units[i] / self.units[j]
        });
        Some((coefficients, covariance))
    }

    /// Whether several coefficients together are ones that it can have.
    fn is_plausible(&self, reduced: &Reduced, sizes: &[f64]) -> bool {
        let Some((coefficients, _)) = self.likeliest(reduced, sizes) else { return false };
        let (low, high) = self.candidate.range;
        let least = &self.candidate.least;
        match coefficients[..] {
            // Of single runs each is one of its own.
            _ if !least.is_empty() => {
                coefficients.iter().zip(least).all(|(c, least)| c >= least && *c <= high)
            }
            [size, with] if let Some((least, most)) = self.candidate.regressors[1].range() => {
                (low..=high).contains(&size) && (least..=most).contains(&with)
            }
            ref several => several.iter().map(|c| c * c).sum::<f64>().sqrt() <= high,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A reading that is a constant off has no other form; friction near rest may have.
    #[test]
    fn a_constant_has_one_form() {
        let of = |regressors: Vec<Regressor>| {
            let candidate = STATIC_STEP.candidate(regressors, (0.0, 1.0), Detail::Plain, 0.0);
            Way { candidate, units: vec![1.0], first: 0 }.form_errors()
        };
        let (constant, friction) = (Regressor::Term(Term::Constant), Regressor::Term(Term::Stribeck(1.0)));
        assert_eq!(of(vec![constant.clone()]), [0.0]);
        assert_eq!(of(vec![friction.clone()]), FORM_ERRORS);
        assert_eq!(of(vec![constant, friction]), FORM_ERRORS);
    }
}
