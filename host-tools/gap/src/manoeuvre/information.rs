//! What a drive would tell of the rivals in a tie: the entropy of their probabilities that it is
//! expected to leave.

use super::Pair;
use residuals::thresholds::manoeuvre::TRUSTED;

/// Rivals of one tie.
#[derive(Debug, Clone, PartialEq)]
pub struct Tie {
    /// Ids, and how probable each is now.
    shares: Vec<(String, f64)>,
}

/// Entropy that a name may leave, nats: its effect has a probability of 95 %, another the rest.
const OF_A_NAME: f64 = 0.198_515;

/// Expected entropy that is little enough. By Markov's inequality three drives of four then leave
/// no more than a name does.
pub const ENOUGH: f64 = OF_A_NAME / 4.0;

impl Tie {
    /// Of these ids, in any order and number; alike where not all have a known probability.
    pub fn of<'a>(ids: impl Iterator<Item = &'a str>, known: &[(String, f64)]) -> Self {
        let mut ids: Vec<&str> = ids.collect();
        ids.sort_unstable();
        ids.dedup();
        let share = |id: &str| known.iter().find(|(other, _)| *other == id).map(|(_, share)| *share);
        let shares: Option<Vec<f64>> = ids.iter().map(|id| share(id).filter(|share| *share > 0.0)).collect();
        let shares = shares.unwrap_or_else(|| vec![1.0; ids.len()]);
        let sum: f64 = shares.iter().sum();
        Self {
            shares: ids.into_iter().map(str::to_owned).zip(shares.iter().map(|share| share / sum)).collect(),
        }
    }

    /// Nats that are open after drives along which pairs differ so much; without pairs, now.
    ///
    /// At most this is left where predictions are normal and alike in their scatter (Kolchinsky and
    /// Tracey, Entropy 19, 361, 2017, with Bhattacharyya's distance z² / 8).
    pub fn open(&self, pairs: &[Pair]) -> f64 {
        let left = |(id, share): &(String, f64)| {
            let alike = |other: &str| if other == id { 1.0 } else { (-distance(pairs, id, other)).exp() };
            let sum: f64 = self.shares.iter().map(|(other, of_it)| of_it * alike(other)).sum();
            share * (sum / share).ln()
        };
        self.shares.iter().map(left).sum()
    }
}

/// Bhattacharyya's, of the closest ways in which two effects may show; 0 where no pair has them.
fn distance(pairs: &[Pair], one: &str, other: &str) -> f64 {
    let of_both = |pair: &&Pair| pair.ids == [one, other] || pair.ids == [other, one];
    pairs.iter().find(of_both).map_or(0.0, |pair| (TRUSTED * pair.z).powi(2) / 8.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair(one: &str, other: &str, z: f64) -> Pair {
        Pair { ids: [one.to_owned(), other.to_owned()], z }
    }

    #[test]
    fn what_is_open_lies_between_all_and_nothing() {
        let known = [("a", 0.6), ("b", 0.3), ("c", 0.1)].map(|(id, share)| (id.to_owned(), share));
        let tie = Tie::of(["c", "a", "b", "a"].into_iter(), &known);
        let entropy: f64 = known.iter().map(|(_, share)| -share * share.ln()).sum();
        assert!((tie.open(&[]) - entropy).abs() < 1e-12);
        let apart = |z| vec![pair("a", "b", z), pair("c", "a", z), pair("b", "c", z)];
        assert!(tie.open(&apart(100.0)) < 1e-9);
        // By hand, z = 4 / TRUSTED: e⁻² of another's share stays.
        let by_hand: f64 = known.iter().map(|(_, p)| p * ((p + (1.0 - p) * (-2.0_f64).exp()) / p).ln()).sum();
        assert!((tie.open(&apart(4.0 / TRUSTED)) - by_hand).abs() < 1e-12);
        // A pair that nothing distinguishes does not hide what is told of the third.
        let mut twins = apart(100.0);
        twins[0].z = 0.0;
        let between: f64 = [0.6, 0.3].iter().map(|p| -p * (p / 0.9_f64).ln()).sum();
        assert!((tie.open(&twins) - between).abs() < 1e-9);
    }

    #[test]
    fn rivals_are_alike_where_not_all_are_known() {
        let tie = Tie::of(["a", "b"].into_iter(), &[("a".to_owned(), 0.9)]);
        assert!((tie.open(&[]) - 2.0_f64.ln()).abs() < 1e-12);
    }

    #[test]
    fn a_name_leaves_the_entropy_of_95_percent() {
        let entropy: f64 = [0.95_f64, 0.05].iter().map(|share| -share * share.ln()).sum();
        assert!((entropy - OF_A_NAME).abs() < 1e-6);
    }
}
