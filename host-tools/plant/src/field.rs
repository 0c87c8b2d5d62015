//! Sets of runs as a robot would bring them home: some clean ones to fit, more of them in which
//! something may hide.

use rand::RngExt;
use rand::seq::SliceRandom;

use super::effects::Effect;
use super::encoder::SpeedSource;
use super::ina219::Ina219;
use super::kinematics::Kinematics;
use super::noise::{Stream, stream};
use super::sensors::PowerSource;
use super::{PayloadSchedule, PlantSet, ProfileKind, Scenario, Sensors};

/// What the runs of a set have in common.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// Motors.
    pub plant: PlantSet,
    /// Wheel layout.
    pub kinematics: Kinematics,
    /// Number of clean runs.
    pub base_runs: usize,
    /// Number of runs in the field.
    pub field_runs: usize,
    /// Length of a run, s.
    pub duration_s: f64,
    /// Samples per second, Hz.
    pub rate_hz: f64,
    /// The least and the greatest total mass, kg.
    pub mass_kg: (f64, f64),
    /// Noise of the power sensor.
    pub noise: Noise,
    /// What hides in the field's runs. A mislabelled payload is in every third of them, everything
    /// else in all.
    pub effects: Vec<Effect>,
}

/// Noise of the power sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Standard deviation, W.
    pub std_w: f64,
    /// What is added to it for every watt.
    pub per_w: f64,
    /// Correlation from sample to sample.
    pub autocorrelation: f64,
    /// Degrees of freedom of Student's t; none for Gaussian noise.
    pub tail: Option<f64>,
}

impl Noise {
    /// White Gaussian noise.
    pub fn white(std_w: f64) -> Self {
        Self { std_w, per_w: 0.0, autocorrelation: 0.0, tail: None }
    }

    /// Gaussian noise of which a sample resembles the last one.
    pub fn autocorrelated(std_w: f64, autocorrelation: f64) -> Self {
        Self { autocorrelation, ..Self::white(std_w) }
    }

    /// White noise with rare large values: Student's t with 4 degrees of freedom.
    pub fn heavy_tailed(std_w: f64) -> Self {
        Self { tail: Some(4.0), ..Self::white(std_w) }
    }

    /// White noise that doubles from rest to `power_w`.
    pub fn heteroscedastic(std_w: f64, power_w: f64) -> Self {
        Self { per_w: std_w / power_w, ..Self::white(std_w) }
    }
}

impl Default for Field {
    /// 6 clean runs and 12 in the field, 60 s at 20 Hz, 1 to 6 kg, 0.05 W of white noise, nothing
    /// hidden.
    ///
    /// Gear motors, because every effect of the dictionary can be as large as that noise and still
    /// be plausible. On the servo copper, leads and braking cannot: it is slow, and most of what it
    /// draws turns its own gears.
    fn default() -> Self {
        Self {
            plant: PlantSet::Gearmotor,
            kinematics: Kinematics::Differential,
            base_runs: 6,
            field_runs: 12,
            duration_s: 60.0,
            rate_hz: 20.0,
            mass_kg: (1.0, 6.0),
            noise: Noise::white(0.05),
            effects: Vec::new(),
        }
    }
}

/// Seeds of one set: far enough from the next set's that no two share a run.
const SEEDS_PER_SET: u64 = 1000;

impl Field {
    /// The clean runs of set `seed`: training drives, the lightest and the heaviest load among
    /// them.
    pub fn base(&self, seed: u64) -> Vec<Scenario> {
        let (low, high) = self.mass_kg;
        let last = self.base_runs.saturating_sub(1).max(1) as f64;
        let masses = (0..self.base_runs).map(|k| low + (high - low) * k as f64 / last);
        (0..)
            .zip(masses)
            .map(|(k, mass)| self.run(ProfileKind::Training, mass, seed * SEEDS_PER_SET + k))
            .collect()
    }

    /// The field's runs of set `seed`: training and test drives by turns, masses spread over the
    /// range in random order.
    pub fn field(&self, seed: u64) -> Vec<Scenario> {
        let first = seed * SEEDS_PER_SET + SEEDS_PER_SET / 2;
        let mut rng = stream(first, Stream::Field);
        let (low, high) = self.mass_kg;
        let mut masses: Vec<f64> = (0..self.field_runs)
            .map(|k| {
                let place = (k as f64 + rng.random_range(0.0..1.0)) / self.field_runs as f64;
                // Somebody put it on scales that show 10 g.
                (100.0 * (low + (high - low) * place)).round() / 100.0
            })
            .collect();
        masses.shuffle(&mut rng);
        (0..)
            .zip(masses)
            .map(|(k, mass)| {
                let kind = if k % 2 == 0 { ProfileKind::Training } else { ProfileKind::Test };
                let mut run = self.run(kind, mass, first + k);
                run.effects = self.effects.clone();
                run.effects.retain(|effect| effect.id() != "payload-mislabel" || k % 3 == 1);
                run
            })
            .collect()
    }

    fn run(&self, kind: ProfileKind, mass_kg: f64, seed: u64) -> Scenario {
        let mut run = Scenario::new(self.plant, self.kinematics, kind, self.duration_s, seed);
        run.rate_hz = self.rate_hz;
        run.payload = PayloadSchedule::constant(mass_kg);
        run.sensors = Sensors {
            speed: SpeedSource::Encoder,
            power: PowerSource::Ina219,
            // 20 mΩ measure up to 16 A in steps of 1 mA (shunt codes of 10 µV are 0.5 mA).
            ina219: Ina219 {
                shunt_ohm: 0.02,
                current_lsb_a: 1e-3,
                averages: Ina219::averages_within(1.0 / self.rate_hz),
            },
            power_noise_w: self.noise.std_w,
            power_noise_per_w: self.noise.per_w,
            power_noise_tail: self.noise.tail,
            power_autocorrelation: self.noise.autocorrelation,
            ..Sensors::exact()
        };
        run
    }
}

#[cfg(test)]
mod tests {
    use super::super::effects::entries;
    use super::super::effects::size::added;
    use super::super::simulate;
    use super::*;

    #[test]
    fn a_set_has_other_runs_than_the_next_and_always_the_same() {
        let field = Field { duration_s: 5.0, ..Field::default() };
        let all: Vec<Scenario> = [field.base(1), field.field(1), field.base(2), field.field(2)].concat();
        assert_eq!(all.len(), 36);
        for (i, run) in all.iter().enumerate() {
            assert!(all[..i].iter().all(|other| other.seed != run.seed));
        }
        assert_eq!(field.field(1), field.field(1));
        assert_ne!(field.field(1)[0].payload, field.field(2)[0].payload);
    }

    /// Twelve strata of 1 to 6 kg: no two masses further apart than two strata, both ends within
    /// the first.
    #[test]
    fn masses_cover_the_range() {
        let mut masses: Vec<f64> =
            Field::default().field(3).iter().map(|run| run.payload.mass_at(0.0)).collect();
        masses.sort_by(f64::total_cmp);
        let stratum = 5.0 / 12.0 + 0.01;
        assert!(
            masses[0] >= 1.0
                && masses[0] <= 1.0 + stratum
                && masses[11] >= 6.0 - stratum
                && masses[11] <= 6.0
        );
        assert!(masses.windows(2).all(|pair| pair[1] - pair[0] <= 2.0 * stratum), "{masses:?}");
        let base: Vec<f64> = Field::default().base(3).iter().map(|run| run.payload.mass_at(0.0)).collect();
        assert_eq!(base, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    }

    /// Half the noise, the least size of a comparison, is within every effect's plausible range.
    #[test]
    fn every_effect_can_be_seen_in_the_field() {
        let field = Field::default();
        for entry in entries() {
            let size = match entry.id {
                // More, and a wheel lifts off.
                "payload-offset" => 0.07,
                _ => entry.range.1,
            };
            let effects = vec![Effect::new(entry.id, size).unwrap()];
            let runs: Vec<Scenario> = field.field(1)[..3]
                .iter()
                .map(|run| Scenario { effects: effects.clone(), ..run.clone() })
                .collect();
            let rms_w = added(&runs).unwrap().rms_w;
            assert!(rms_w > 0.5 * field.noise.std_w, "{}: {rms_w} W", entry.id);
        }
    }

    #[test]
    fn the_clean_runs_are_clean_and_a_mislabelled_payload_is_in_every_third() {
        let effects =
            ["grade=0.03", "payload-mislabel=0.5"].map(|text| Effect::parse(text).unwrap()).to_vec();
        let field = Field { effects, ..Field::default() };
        assert!(field.base(1).iter().all(|run| run.effects.is_empty()));
        let count = |id: &str| {
            field.field(1).iter().filter(|run| run.effects.iter().any(|effect| effect.id() == id)).count()
        };
        assert_eq!((count("grade"), count("payload-mislabel")), (12, 4));
    }

    /// What noise adds, as the same run with and without it: 0.05 W white; twice that at 4 W.
    #[test]
    fn the_noise_is_as_asked_for() {
        let spread = |noise: Noise| {
            let quiet = Field { noise: Noise::white(0.0), field_runs: 4, ..Field::default() };
            let loud = Field { noise, ..quiet.clone() };
            let mut still = (0.0, 0.0);
            let mut busy = (0.0, 0.0);
            for (quiet, loud) in quiet.field(1).iter().zip(&loud.field(1)) {
                let (quiet, loud) = (simulate(quiet).unwrap(), simulate(loud).unwrap());
                assert_eq!(quiet.wheel_rad_s, loud.wheel_rad_s);
                for (quiet, loud) in quiet.power_w.iter().zip(&loud.power_w) {
                    let sum = if *quiet < 0.01 { &mut still } else { &mut busy };
                    let scale = 1.0 + noise.per_w * quiet / noise.std_w;
                    *sum = (sum.0 + ((loud - quiet) / scale).powi(2), sum.1 + 1.0);
                }
            }
            [still, busy].map(|(square, count): (f64, f64)| (square / count).sqrt())
        };
        for noise in [Noise::white(0.05), Noise::heteroscedastic(0.05, 4.0), Noise::autocorrelated(0.05, 0.6)]
        {
            let [still, busy] = spread(noise);
            // 400 samples at rest: standard error 3.5 %, with the correlation of 0.6 5.2 %; steps
            // of 12 mW add 0.2 %.
            assert!((still / 0.05 - 1.0).abs() < 0.15 && (busy / 0.05 - 1.0).abs() < 0.06, "{still} {busy}");
        }
    }
}
