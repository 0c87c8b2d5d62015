//! The results of a reproduction: everything that its tables, figures and page show.

use serde_json::{Value, json};

use super::figures::{Figure, Sources, all};
use super::price::{Input, Price, price};
use super::print::{self, Difference};
use super::regime::{self, Rails};
use super::settings::Settings;
use super::spread::Spread;
use super::standing::{self, Goal, Standings};
use super::table::{Column, Format, Mark, Row, Table, column};
use super::{price as prices, recalibration, section6, section7, windows};

/// All of it, as data.
pub struct Study {
    pub(super) settings: Settings,
    pub(super) goals: Vec<Goal>,
    pub(super) standings: Standings,
    /// In the order of the paper.
    pub(super) tables: Vec<Table>,
    pub(super) figures: Vec<Figure>,
    pub(super) price: Price,
    pub(super) differences: Vec<Difference>,
    share_known: Spread,
    persistence: [Spread; 2],
    static_power_w: (f64, f64),
}

/// The seeds' results, in their order; the first one is drawn.
pub(super) struct Outcomes {
    pub(super) section6: Vec<section6::Seed>,
    pub(super) section7: Vec<section7::Seed>,
    pub(super) recalibration: Vec<recalibration::Seed>,
    pub(super) rails: Rails,
    pub(super) differences: Vec<Difference>,
}

const LEFT_OUT: [Column; 2] =
    [column("name", "model", Format::Words), column("reason", "why", Format::Words)];

impl Study {
    pub(super) fn of(settings: &Settings, mut outcomes: Outcomes) -> Self {
        let simulation = section6::rows(&outcomes.section6);
        let windows = windows::rows(outcomes.section7.iter().map(|seed| seed.windows.as_slice()));
        let models = section7::models(&outcomes.section7);
        let known: Vec<f64> = outcomes.section7.iter().map(|seed| 100.0 * seed.known_share).collect();
        let share_known = Spread::over(&known);
        let persistence = Spread::of_each(outcomes.section7.iter().map(|seed| seed.persistence_r2));
        let goals = standing::goals(&windows, &models);
        let points = recalibration::prices(&outcomes.recalibration);
        let price = price(&Input { points, ..Input::default() });
        let left_out = outcomes.section7.first().map_or(&[][..], |seed| &seed.left_out);
        let left_out = left_out.iter().map(|baseline| {
            Row::new(Mark::None, [baseline.name.clone().into(), baseline.reason.clone().into()])
        });
        let tables = vec![
            standing::goals_table(&goals),
            section6::table(&simulation),
            regime::knobs(),
            regime::nearness(&windows, &models, &share_known),
            windows::table(&windows),
            standing::models(&models, &persistence),
            Table {
                name: "left-out",
                title: "Baselines that these logs do not allow",
                columns: &LEFT_OUT,
                rows: left_out.collect(),
                note: String::new(),
            },
            recalibration::table(&outcomes.recalibration),
            prices::table(&price),
            print::table(&outcomes.differences),
        ];
        let figures = all(&Sources {
            simulation: &simulation,
            section6: &outcomes.section6.iter_mut().find_map(|seed| seed.courses.take()).unwrap_or_default(),
            rails: &outcomes.rails,
            section7: &outcomes.section7.iter_mut().find_map(|seed| seed.courses.take()).unwrap_or_default(),
            windows: &windows,
            models: &models,
            price: &price,
        });
        Self {
            settings: settings.clone(),
            standings: Standings::of(&models),
            goals,
            tables,
            figures,
            price,
            differences: outcomes.differences,
            share_known,
            persistence,
            static_power_w: outcomes.rails.gaussian_w,
        }
    }

    /// All tables as text.
    pub fn text(&self) -> String {
        let tables: Vec<String> = self.tables.iter().map(ToString::to_string).collect();
        format!("{}. Figures are {INTERVALS}.\n\n{}", self.settings.words(), tables.join("\n"))
    }

    /// The figures for scripts, with all digits; without series over time.
    pub fn json(&self) -> Value {
        let table = |name: &str| self.tables.iter().find(|table| table.name == name).map(Table::json);
        json!({
            "settings": self.settings,
            "goals": table("goals"),
            "standings": self.standings,
            "published_simulation": section6::published(),
            "simulation": table("simulation"),
            "knobs": table("knobs"),
            "nearness": table("nearness"),
            "static_power_w": self.static_power_w,
            "windows": table("windows"),
            "models": table("models"),
            "left_out": table("left-out"),
            "share_known": self.share_known,
            "persistence_r2": { "sample": self.persistence[0], "second": self.persistence[1] },
            "recalibration": table("recalibration"),
            "price": self.price,
            "print": self.differences,
        })
    }
}

/// How to read a figure with an interval.
pub(super) const INTERVALS: &str = "means over seeds with the 95 % intervals of the means [low, high]; an end that few seeds would put \
                         beyond what a figure can be (an error below 0, R² above 1) is shown at that limit";
