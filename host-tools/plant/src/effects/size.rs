//! How large an effect is: what it adds to the logged power.

use support::error::{Error, Result};

use super::super::scenario::Scenario;
use super::super::simulation::{Record, simulate};
use super::Effect;

/// Span over which the added power is averaged, s: what a log's filter would not pass does not
/// count.
const SMOOTHING_S: f64 = 0.25;

/// How near to the wanted size [`scale_to`] comes.
const TOLERANCE: f64 = 0.02;

/// What effects add to the logged power.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Added {
    /// Root mean square over all runs, W.
    pub rms_w: f64,
    /// Mean over all runs, W.
    pub mean_w: f64,
}

/// What the effects of these runs add to their logged power: every run is simulated with its
/// effects and without, with the same seeds but without noise of the power sensor.
///
/// # Errors
/// What [`Scenario::check`] finds; an effect that makes no sense in one of the runs.
pub fn added(runs: &[Scenario]) -> Result<Added> {
    let clean = without_effects(runs)?;
    compare(runs, &clean)
}

/// The effect in the size that adds `rms_w` to the logged power of these runs (within 2 %); its
/// sign and options are kept, effects that the runs have already are left out. Three or four runs
/// of a minute tell the size well; every run is simulated some four times.
///
/// # Errors
/// Failed: no plausible size adds so much. What [`Scenario::check`] finds; an effect that makes no
/// sense for the robot.
pub fn scale_to(effect: &Effect, runs: &[Scenario], rms_w: f64) -> Result<Effect> {
    if !(rms_w.is_finite() && rms_w > 0.0) {
        return Err(Error::usage(format!("an added power of {rms_w} W; allowed: above 0")));
    }
    let clean = without_effects(runs)?;
    let (low, high) = effect.entry().range;
    let end = if effect.size() < 0.0 { low } else { high };
    let adds = |size: f64| -> Result<(Effect, f64)> {
        let effect = effect.clone().with_size(size)?;
        let runs: Vec<Scenario> =
            runs.iter().map(|run| Scenario { effects: vec![effect.clone()], ..run.clone() }).collect();
        Ok((effect, compare(&runs, &clean)?.rms_w))
    };
    // Most effects are nearly in proportion to their size: a power law through the last two sizes.
    let mut size = 0.1 * end;
    let mut last: Option<(f64, f64)> = None;
    for _ in 0..20 {
        let (effect, rms) = adds(size)?;
        if (rms / rms_w - 1.0).abs() <= TOLERANCE {
            return Ok(effect);
        }
        if size == end && rms < rms_w {
            let id = effect.id();
            return Err(Error::failed(format!(
                "effect {id} adds {rms:.3} W at most, at {end}; expected {rms_w:.3} W: too little moves it in these runs"
            )));
        }
        let exponent = match last {
            Some((before, rms_before)) if rms > 0.0 && rms_before > 0.0 && rms != rms_before => {
                ((rms / rms_before).ln() / (size / before).ln()).clamp(0.3, 3.0)
            }
            _ => 1.0,
        };
        last = Some((size, rms));
        let step = (rms_w / rms.max(1e-9)).powf(1.0 / exponent).clamp(0.01, 100.0);
        size *= step;
        if size.abs() > end.abs() {
            size = end;
        }
    }
    Err(Error::failed(format!("effect {}: no size was found that adds {rms_w} W", effect.id())))
}

fn without_effects(runs: &[Scenario]) -> Result<Vec<Record>> {
    runs.iter().map(|run| simulate(&Scenario { effects: Vec::new(), ..quiet(run) })).collect()
}

/// The same run with a power sensor that has no noise.
fn quiet(run: &Scenario) -> Scenario {
    let mut run = run.clone();
    (run.sensors.power_noise_w, run.sensors.power_noise_per_w) = (0.0, 0.0);
    run
}

fn compare(runs: &[Scenario], clean: &[Record]) -> Result<Added> {
    let (mut square, mut sum, mut count) = (0.0, 0.0, 0.0_f64);
    for (run, clean) in runs.iter().zip(clean) {
        let with = simulate(&quiet(run))?;
        let added: Vec<f64> =
            with.power_w.iter().zip(&clean.power_w).map(|(with, clean)| with - clean).collect();
        for mean in moving_mean(&added, (SMOOTHING_S * run.rate_hz / 2.0) as usize) {
            square += mean * mean;
            sum += mean;
            count += 1.0;
        }
    }
    let count = count.max(1.0);
    Ok(Added { rms_w: (square / count).sqrt(), mean_w: sum / count })
}

/// Means of every value with up to `reach` neighbours on each side.
fn moving_mean(values: &[f64], reach: usize) -> impl Iterator<Item = f64> {
    (0..values.len()).map(move |k| {
        let window = &values[k.saturating_sub(reach)..(k + reach + 1).min(values.len())];
        window.iter().sum::<f64>() / window.len() as f64
    })
}

#[cfg(test)]
mod tests {
    use super::super::super::{Kinematics, PayloadSchedule, PlantSet, ProfileKind};
    use super::*;

    fn runs() -> Vec<Scenario> {
        (1..3)
            .map(|seed| {
                let kind = ProfileKind::Training;
                let mut run = Scenario::new(PlantSet::Gearmotor, Kinematics::Differential, kind, 20.0, seed);
                run.payload = PayloadSchedule::constant(2.0 + seed as f64);
                run.sensors.power_noise_w = 0.3;
                run.rate_hz = 20.0;
                run
            })
            .collect()
    }

    /// An offset of the sensor adds itself: 0.07 W everywhere, whatever the noise.
    #[test]
    fn a_constant_offset_is_as_large_as_it_is() {
        let mut runs = runs();
        for run in &mut runs {
            run.effects = vec![Effect::new("sensor-offset", 0.07).unwrap()];
        }
        let Added { rms_w, mean_w } = added(&runs).unwrap();
        assert!((rms_w - 0.07).abs() < 1e-9 && (mean_w - 0.07).abs() < 1e-9, "{rms_w} {mean_w}");
        let scaled = scale_to(&Effect::new("sensor-offset", -1.0).unwrap(), &runs, 0.05).unwrap();
        assert!((scaled.size() + 0.05).abs() < 0.001 + 1e-9, "{}", scaled.size());
    }

    /// Half a watt for half of the time is 0.5/√2 W in the root mean square; the step's 0.25 s are
    /// smoothed.
    #[test]
    fn a_step_counts_for_the_time_that_it_lasts() {
        let mut runs = runs();
        for run in &mut runs {
            run.effects = vec![Effect::parse("static-step=0.5:at=10").unwrap()];
        }
        let Added { rms_w, mean_w } = added(&runs).unwrap();
        assert!(
            (rms_w - 0.5 / 2.0_f64.sqrt()).abs() < 0.005 && (mean_w - 0.25).abs() < 0.005,
            "{rms_w} {mean_w}"
        );
    }

    #[test]
    fn an_effect_grows_to_the_size_asked_for_or_says_that_it_cannot() {
        let runs = runs();
        for text in ["grade=0.01:along=travel", "stribeck=0.1:width=2", "viscous-change=-0.1", "supply-sag=1"]
        {
            let template = Effect::parse(text).unwrap();
            let scaled = scale_to(&template, &runs, 0.03).unwrap();
            assert_eq!(scaled.size().signum(), template.size().signum(), "{text}");
            assert_eq!(scaled.option("width"), template.option("width"));
            let with: Vec<Scenario> =
                runs.iter().map(|run| Scenario { effects: vec![scaled.clone()], ..run.clone() }).collect();
            let Added { rms_w, .. } = added(&with).unwrap();
            assert!((rms_w / 0.03 - 1.0).abs() < 0.021, "{text}: {rms_w}");
        }
        let error = scale_to(&Effect::new("supply-sag", 1.0).unwrap(), &runs, 50.0).unwrap_err().to_string();
        assert!(error.contains("supply-sag adds") && error.contains("at most"), "{error}");
    }
}
