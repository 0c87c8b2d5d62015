//! Figures of every robot for Prometheus: one line a robot and figure.

use std::fmt;
use std::path::Path;

use prometheus_client::collector::Collector;
use prometheus_client::encoding::text::encode;
use prometheus_client::encoding::{DescriptorEncoder, EncodeMetric as _};
use prometheus_client::metrics::MetricType;
use prometheus_client::metrics::gauge::ConstGauge;
use prometheus_client::registry::Registry;
use support::error::{Error, Result};
use support::output::write_content;

use super::rank::Standing;
use super::workflow::Report;

/// What a robot's line says; none where it is not known.
type Figure = fn(&Report, &Standing) -> Option<f64>;

/// Name, what it is, figure. All are gauges: logs may be taken away again.
const FIGURES: [(&str, &str, Figure); 8] = [
    ("gmr_robot_energy_joules", "Energy of all runs that count", |_, one| Some(one.energy_j)),
    ("gmr_robot_distance_meters", "Way of all runs that count", |_, one| Some(one.distance_m)),
    ("gmr_robot_energy_per_meter_joules", "What a metre costs", |_, one| one.energy_per_metre_j_m),
    ("gmr_robot_mean_mass_kilograms", "Mean total mass over time", |_, one| Some(one.mean_mass_kg)),
    ("gmr_robot_straight_watts", "Driving straight without payload, by its own coefficients", |_, one| {
        one.straight_w
    }),
    ("gmr_robot_runs", "Runs that count", |_, one| Some(one.runs as f64)),
    ("gmr_robot_has_changed", "1 where a coefficient has changed beyond chance", |report, one| {
        let is_it = report.changes.iter().any(|change| change.robot == one.robot);
        Some(f64::from(u8::from(is_it)))
    }),
    ("gmr_robot_stands_out", "1 where a coefficient is unlike the other robots'", |report, one| {
        let is_it = report.outliers.robots.iter().any(|outlier| outlier.robot == one.robot);
        Some(f64::from(u8::from(is_it)))
    }),
];

/// In the order of the ranking, which a family of the library would not keep.
#[derive(Debug)]
struct Robots(Report);

impl Collector for Robots {
    fn encode(&self, mut encoder: DescriptorEncoder<'_>) -> fmt::Result {
        for (name, about, figure) in FIGURES {
            let mut family = encoder.encode_descriptor(name, about, None, MetricType::Gauge)?;
            for standing in &self.0.robots {
                if let Some(value) = figure(&self.0, standing).filter(|value| value.is_finite()) {
                    let labels = [("robot", standing.robot.as_str())];
                    ConstGauge::new(value).encode(family.encode_family(&labels)?)?;
                }
            }
        }
        Ok(())
    }
}

/// Writes them, whole or not at all: a scraper never reads half a file.
///
/// # Errors
/// What the operating system refuses.
pub(super) fn save(file: &Path, report: &Report) -> Result<()> {
    let mut registry = Registry::default();
    registry.register_collector(Box::new(Robots(report.clone())));
    let mut text = String::new();
    encode(&mut text, &registry).map_err(|error| Error::failed(error.to_string()).in_file(file))?;
    write_content(file, text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::disagree::Disagreements;
    use crate::outlier::Outliers;

    /// As the exposition format asks: help and type once a figure, escaped names. Unknown values
    /// are left out.
    #[test]
    fn names_do_no_harm_and_what_is_unknown_is_not_there() {
        let standing = Standing {
            robot: "7\"\\\n} 1".to_owned(),
            energy_per_metre_j_m: None,
            distance_m: 0.0,
            energy_j: 12.5,
            mean_mass_kg: f64::NAN,
            runs: 3,
            days: 1,
            straight_w: None,
        };
        let report = Report {
            finding: String::new(),
            logs: 1,
            rows: 1,
            robots: vec![standing],
            changes: Vec::new(),
            questions: 0,
            threshold: None,
            silent: Vec::new(),
            outliers: Outliers::default(),
            disagreements: Disagreements::default(),
            runs: Vec::new(),
        };
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("fleet.prom");
        save(&file, &report).unwrap();
        let text = std::fs::read_to_string(file).unwrap();
        let energy = "# HELP gmr_robot_energy_joules Energy of all runs that count\n# TYPE gmr_robot_energy_joules gauge\n\
                      gmr_robot_energy_joules{robot=\"7\\\"\\\\\\n} 1\"} 12.5\n";
        assert!(text.starts_with(energy), "{text}");
        assert_eq!(text.lines().filter(|line| !line.starts_with('#')).count(), 5, "{text}");
        assert!(text.ends_with("# EOF\n"));
    }
}
