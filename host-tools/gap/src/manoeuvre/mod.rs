//! The manoeuvre that distinguishes hypotheses: the speed profile within the robot's limits that is
//! expected to tell most of them.

pub mod advice;
pub mod effort;
pub mod family;
pub mod information;
pub mod limits;
pub mod room;
pub mod separate;

use std::path::Path;

use logs::robot::Robot;
use logs::runs::Runs;
use serde_json::{Value, json};
use support::error::{Error, Result};
use support::output::write_whole;

pub use family::Knots;

use self::family::{Block, Recipe, blocks};
use self::information::{ENOUGH, Tie};
use self::limits::Limits;
use self::room::Room;
use self::separate::{Ground, Products};
use crate::report::{Report, Rival};
use residuals::thresholds::detect::NO_DIFFERENCE;
use residuals::thresholds::manoeuvre::{DURATIONS_S, LEADS_S, MOST_BLOCKS, RUNS, RUNS_TRIED, TRUSTED};
use residuals::thresholds::split::PARTS;
use residuals::types::Verdict;

/// Two hypotheses, and by how many standard errors they would differ.
#[derive(Debug, Clone, PartialEq)]
pub struct Pair {
    /// Their ids.
    pub ids: [String; 2],
    /// Expected difference.
    pub z: f64,
}

/// What a drive is asked to be.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Wish {
    /// The probability, 0 to 1, of distinguishing the rivals. Without one, the drive is the best of
    /// [`RUNS`] runs.
    pub probability: Option<f64>,
    /// To stay in this room.
    pub room: Option<Room>,
}

/// What to drive.
#[derive(Debug, Clone, PartialEq)]
pub struct Suggestion {
    /// The profile; none where no drive distinguishes any of the hypotheses.
    pub knots: Option<Knots>,
    /// What it does, in words.
    pub words: String,
    /// How often to drive it.
    pub runs: usize,
    /// The probability that this distinguishes the closest pair.
    pub probability: f64,
    /// The one that was asked for.
    pub wanted: Option<f64>,
    /// Total masses to drive it with, by turns, kg.
    pub masses_kg: Vec<f64>,
    /// Hypotheses, and how well the profile distinguishes them.
    pub pairs: Vec<Pair>,
    /// Entropy of the rivals' probabilities, nats: now, and as the drive is expected to leave it.
    pub open_nats: [f64; 2],
    /// Runs of the same profile needed without the effect, with the robot as in the fit: no run
    /// shows the model's error along it yet. 0 where the field's are enough.
    pub reference_runs: usize,
    /// What else to record for those that it does not distinguish.
    pub record: Vec<String>,
}

/// Searches the profile from which most information about the hypotheses of an ambiguous report is
/// expected. `None` where there is no tie.
///
/// # Errors
/// As [`Runs::condition`].
pub fn suggest(
    robot: &Robot,
    runs: &Runs,
    clean: Option<&Runs>,
    report: &Report,
    wish: &Wish,
) -> Result<Option<Suggestion>> {
    let (Verdict::Ambiguous, Some(basis)) = (report.verdict, &report.basis) else { return Ok(None) };
    let hypotheses = (0..)
        .zip(&report.ties)
        .flat_map(|(round, tie)| tie.iter().map(move |hypothesis| (round, hypothesis.clone())));
    let (seen, unseen): (Vec<_>, Vec<_>) =
        hypotheses.partition(|(_, hypothesis)| separate::foreseen(hypothesis));
    let (rounds, seen): (Vec<usize>, Vec<Rival>) = seen.into_iter().unzip();
    let known = runs.subset(&report.split.open).with_clean(clean);
    let tie = |round| {
        let of_it = (0..seen.len()).filter(|place| rounds[*place] == round);
        Tie::of(of_it.map(|place| &seen[place].candidate.id[..]), &report.rivals)
    };
    let ties: Vec<Tie> = (0..report.ties.len()).map(tie).collect();
    let limits = Limits::new(robot, &known);
    let search = Search {
        field: runs,
        blocks: wish.room.map_or_else(blocks, |room| room.fitted(blocks(), &limits)),
        limits,
        ground: Ground { runs: known, basis, hypotheses: &seen, has_clean: clean.is_some() },
        rounds,
        ties,
        loads: [robot.mass_no_load_kg(), robot.mass_full_load_kg()],
    };
    let mut pairs = Vec::new();
    let mut best = None;
    let (mut reference_runs, mut count) = (0, RUNS);
    let now = search.open(&[]);
    if now > 0.0 {
        let mut recipe = search.best(0)?;
        let mut loaded = search.loaded(&recipe, 0)?;
        if search.open(&loaded.1) > ENOUGH && clean.is_some() {
            let other = search.best(RUNS)?;
            let with_clean = search.loaded(&other, RUNS)?;
            // Twice the runs have to halve what is left open.
            if search.open(&with_clean.1) < 0.5 * search.open(&loaded.1) {
                (recipe, loaded, reference_runs) = (other, with_clean, RUNS);
            }
        }
        let masses;
        (masses, pairs) = loaded;
        if let Some(wanted) = wish.probability {
            (recipe, count, pairs) = search.effort(recipe, &masses, reference_runs, wanted)?;
        }
        best = Some((recipe, masses));
    }
    let mut record: Vec<String> =
        unseen.iter().map(|(_, hypothesis)| advice::to_record(&hypothesis.candidate.id)).collect();
    for pair in pairs.iter().filter(|pair| TRUSTED * pair.z < NO_DIFFERENCE) {
        record.extend(pair.ids.iter().map(|id| advice::to_record(id)));
    }
    record.sort();
    record.dedup();
    let probability = if pairs.is_empty() { 0.0 } else { effort::probability(worst(&pairs)) };
    let best = best.filter(|_| pairs.iter().any(|pair| pair.z >= NO_DIFFERENCE));
    if best.is_none() {
        (count, reference_runs) = (0, 0);
    }
    let (knots, words, masses_kg) = match best {
        Some((recipe, masses)) => {
            (Some(recipe.knots(&search.blocks, &search.limits)), recipe.words(&search.blocks), masses)
        }
        None => (None, String::new(), Vec::new()),
    };
    let (runs, wanted, open_nats) = (count, wish.probability, [now, search.open(&pairs)]);
    Ok(Some(Suggestion {
        knots,
        words,
        runs,
        probability,
        wanted,
        masses_kg,
        pairs,
        open_nats,
        reference_runs,
        record,
    }))
}

/// The search over the family.
struct Search<'a> {
    field: &'a Runs,
    ground: Ground<'a>,
    limits: Limits,
    blocks: Vec<Block>,
    /// The round in which each hypothesis tied: only those of one round are hypotheses.
    rounds: Vec<usize>,
    /// The rivals of each round.
    ties: Vec<Tie>,
    /// The lightest and the heaviest total mass, kg.
    loads: [f64; 2],
}

impl Search<'_> {
    fn planned(&self, recipe: &Recipe, masses: &[f64]) -> Result<Runs> {
        let knots = recipe.knots(&self.blocks, &self.limits);
        separate::planned(self.field, &knots, &self.limits, masses)
    }

    /// How well each pair of ids is distinguished after so many runs. An effect may show in several
    /// ways: the closest two count.
    fn separations(
        &self,
        known: &Products,
        recipe: &Recipe,
        masses: &[f64],
        reference: usize,
        runs: usize,
    ) -> Result<Vec<Pair>> {
        let open = 1.0 - 1.0 / PARTS as f64;
        let weight = open * runs as f64 / masses.len() as f64;
        let planned = self.ground.of(&self.planned(recipe, masses)?);
        let mut pairs: Vec<Pair> = Vec::new();
        let clean = reference as f64 / masses.len() as f64;
        for (i, j, z) in self.ground.separations(known, &planned, weight, clean) {
            let ids = [i, j].map(|place| self.ground.hypotheses[place].candidate.id.clone());
            if self.rounds[i] != self.rounds[j] || ids[0] == ids[1] {
                continue;
            }
            let swapped = [ids[1].clone(), ids[0].clone()];
            match pairs.iter_mut().find(|pair| pair.ids == ids || pair.ids == swapped) {
                Some(pair) => pair.z = pair.z.min(z),
                None => pairs.push(Pair { ids, z }),
            }
        }
        Ok(pairs)
    }

    /// Nats that are open where pairs differ so much.
    fn open(&self, pairs: &[Pair]) -> f64 {
        self.ties.iter().map(|tie| tie.open(pairs)).sum()
    }

    /// Products of the recorded runs, scaled as for recipes of that length.
    fn known(&self, duration_s: f64) -> Result<Products> {
        let recipe = Recipe { lead_s: 0.0, duration_s, blocks: vec![0] };
        Ok(self.ground.known(&self.planned(&recipe, &self.loads)?))
    }

    /// Chooses blocks one by one, each the best with those before, as long as too much is open;
    /// then rest and length.
    fn best(&self, reference: usize) -> Result<Recipe> {
        let known = self.known(DURATIONS_S[0])?;
        let mut best: Option<(f64, Recipe)> = None;
        while best.as_ref().is_none_or(|(open, recipe)| *open > ENOUGH && recipe.blocks.len() < MOST_BLOCKS) {
            let mut further: Option<(f64, Recipe)> = None;
            for block in 0..self.blocks.len() {
                for lead_s in LEADS_S {
                    // The rest is chosen with the first block, and kept.
                    if best.as_ref().is_some_and(|(_, best)| best.lead_s != lead_s) {
                        continue;
                    }
                    let before = best.iter().flat_map(|(_, best)| best.blocks.iter().copied());
                    let recipe = Recipe {
                        lead_s,
                        duration_s: DURATIONS_S[0],
                        blocks: before.chain([block]).collect(),
                    };
                    let open = self.open(&self.separations(&known, &recipe, &self.loads, reference, RUNS)?);
                    if further.as_ref().is_none_or(|(least, _)| open < *least) {
                        further = Some((open, recipe));
                    }
                }
            }
            let is_better = |next: &(f64, Recipe)| best.as_ref().is_none_or(|(least, _)| next.0 < *least);
            match further.filter(is_better) {
                Some(next) => best = Some(next),
                None => break,
            }
        }
        let (_, mut recipe) = best.ok_or_else(|| Error::failed("no profile can be tried"))?;
        for duration_s in DURATIONS_S {
            recipe.duration_s = duration_s;
            let pairs = self.separations(&self.known(duration_s)?, &recipe, &self.loads, reference, RUNS)?;
            if self.open(&pairs) <= ENOUGH {
                break;
            }
        }
        Ok(recipe)
    }

    /// The least driving time, as length and number of runs, that distinguishes all pairs with a
    /// probability. Where none that is tried suffices, the best.
    fn effort(
        &self,
        recipe: Recipe,
        masses: &[f64],
        reference: usize,
        wanted: f64,
    ) -> Result<(Recipe, usize, Vec<Pair>)> {
        let mut tried = Vec::new();
        for duration_s in DURATIONS_S {
            let recipe = Recipe { duration_s, ..recipe.clone() };
            let known = self.known(duration_s)?;
            for runs in RUNS_TRIED {
                let pairs = self.separations(&known, &recipe, masses, reference, runs)?;
                tried.push((recipe.clone(), runs, pairs));
            }
        }
        let reached = |tried: &(Recipe, usize, Vec<Pair>)| effort::probability(worst(&tried.2));
        let time = |(recipe, runs, _): &(Recipe, usize, Vec<Pair>)| recipe.duration_s * *runs as f64;
        let enough = tried.iter().filter(|tried| reached(tried) >= wanted);
        let shortest = enough.min_by(|a, b| time(a).total_cmp(&time(b)));
        let best = || {
            tried.iter().max_by(|a, b| reached(a).total_cmp(&reached(b)).then(time(b).total_cmp(&time(a))))
        };
        shortest.or_else(best).cloned().ok_or_else(|| Error::failed("no profile can be tried"))
    }

    /// The loads to drive it with, and the pairs' z: light and heavy by turns where that is enough,
    /// otherwise those that leave least open.
    fn loaded(&self, recipe: &Recipe, reference: usize) -> Result<(Vec<f64>, Vec<Pair>)> {
        let known = self.known(recipe.duration_s)?;
        let with =
            |loads: &[f64]| Ok((loads.to_vec(), self.separations(&known, recipe, loads, reference, RUNS)?));
        let mut best: (Vec<f64>, Vec<Pair>) = with(&self.loads)?;
        for load in self.loads {
            if self.open(&best.1) <= ENOUGH {
                break;
            }
            let one = with(&[load])?;
            if self.open(&one.1) < self.open(&best.1) {
                best = one;
            }
        }
        Ok(best)
    }
}

/// The closest pair's z.
fn worst(pairs: &[Pair]) -> f64 {
    pairs.iter().map(|pair| pair.z).fold(f64::INFINITY, f64::min)
}

impl Suggestion {
    /// Writes the profile as `gmr simulate --profile` takes it; whole or not at all.
    ///
    /// # Errors
    /// What the operating system reports.
    pub fn write(&self, file: &Path) -> Result<()> {
        let Some(knots) = &self.knots else { return Ok(()) };
        write_whole(file, |out| {
            let refused = |error: std::io::Error| Error::io(file, &error);
            writeln!(out, "time_s,v_m_s,omega_rad_s").map_err(refused)?;
            for (time, [speed, turn]) in knots {
                writeln!(out, "{time:.4},{speed:.6},{turn:.6}").map_err(refused)?;
            }
            Ok(())
        })
    }

    /// Length of the profile, s.
    pub fn duration_s(&self) -> Option<f64> {
        self.knots.as_ref()?.last().map(|(time, _)| *time)
    }

    /// For scripts.
    pub fn json(&self) -> Value {
        let pairs: Vec<Value> =
            self.pairs.iter().map(|pair| json!({"rivals": pair.ids, "expected_z": pair.z})).collect();
        json!({
            "duration_s": self.duration_s(),
            "does": self.words,
            "runs": self.knots.as_ref().map(|_| self.runs),
            "driving_s": self.duration_s().map(|duration| duration * self.runs as f64),
            "probability": self.probability,
            "wanted_probability": self.wanted,
            "reference_runs": self.reference_runs,
            "masses_kg": self.masses_kg,
            "separates": pairs,
            "open_nats": self.open_nats,
            "record": self.record,
        })
    }

    /// Lines for the terminal.
    pub fn lines(&self, file: &Path) -> String {
        let mut out = String::new();
        if let Some(duration) = self.duration_s() {
            let masses: Vec<String> = self.masses_kg.iter().map(|mass| format!("{mass}")).collect();
            out += &format!(
                "to tell them apart: drive {} ({duration:.0} s) {} times, with {} kg in all\n  {}\n",
                file.display(),
                self.runs,
                masses.join(" and "),
                self.words
            );
            if self.reference_runs > 0 {
                out += &format!(
                    "  and {} times more with the robot as it was in the fit, added to the clean runs (--base): what the model gets \
                     wrong along it is not known yet\n",
                    self.reference_runs
                );
            }
            let pairs: Vec<String> =
                self.pairs.iter().map(|pair| format!("{} z = {:.1}", pair.ids.join(" / "), pair.z)).collect();
            let [now, after] = self.open_nats;
            let stays = 100.0 * after / now;
            out += &format!("  expected: {}; {stays:.0} % of the doubt stays\n", pairs.join("; "));
            if let Some(wanted) = self.wanted {
                let short =
                    if self.probability < wanted { ": no drive that was tried does better" } else { "" };
                out += &format!(
                    "  {:.0} min of driving part them with {:.0} % probability ({:.0} % asked for{short})\n",
                    duration * self.runs as f64 / 60.0,
                    100.0 * self.probability,
                    100.0 * wanted
                );
            }
        } else {
            out += "no drive tells them apart\n";
        }
        if !self.record.is_empty() {
            out += &format!("  record as well: {}\n", self.record.join("; "));
        }
        out
    }
}
