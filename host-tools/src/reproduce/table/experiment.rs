//! Section 7's tables.

use super::{Mark, Row, Table, error, figure, number, plain, r2, share, with_unit};
use crate::compare::MassSource;
use crate::reproduce::section7::PUBLISHED_WORST;
use crate::reproduce::standing::{self, Standing};
use crate::reproduce::study::{Experiment, ModelRow};

pub(super) fn goals(experiment: &Experiment) -> Table {
    let rows = standing::goals(experiment).into_iter().map(|goal| {
        let reached = goal.is_reached();
        let limit = format!("{} {}", if goal.at_least { "≥" } else { "≤" }, number(goal.limit, 2));
        let found = goal.found.map_or("–".to_owned(), |found| figure(&found, goal.unit, 3));
        let verdict = match reached {
            Some(true) => "reached",
            Some(false) => "missed",
            None => "not measured",
        };
        Row {
            cells: vec![
                goal.what.to_owned(),
                with_unit(limit, goal.unit),
                with_unit(found, goal.unit),
                verdict.to_owned(),
            ],
            mark: if reached == Some(false) { Mark::Against } else { Mark::None },
        }
    });
    Table {
        name: "goals",
        title: "What is asked of ours in the experiment's regime".to_owned(),
        head: vec!["figure", "#goal", "#ours", "verdict"],
        rows: rows.collect(),
        note: format!("by the mean over seeds; mass error, worst window: {WORST_MASS}"),
    }
}

pub(super) fn knobs(experiment: &Experiment) -> Table {
    let rows = experiment
        .knobs
        .iter()
        .map(|knob| plain(vec![knob.name.to_owned(), knob.value.clone(), knob.reason.to_owned()]));
    Table {
        name: "knobs",
        title: "Section 7: how the experiment's regime was set".to_owned(),
        head: vec!["knob", "value", "why"],
        rows: rows.collect(),
        note: "set so that the paper's method and its two comparisons land near their published figures (docs/paper.md says how)".to_owned(),
    }
}

pub(super) fn nearness(experiment: &Experiment) -> Table {
    let rows = experiment.nearness.iter().map(|near| {
        let digits = if near.unit.is_empty() { 3 } else { 2 };
        plain(vec![
            near.what.clone(),
            with_unit(number(near.published, digits), near.unit),
            with_unit(figure(&near.here, near.unit, digits), near.unit),
            with_unit(figure(&near.ours, near.unit, digits), near.unit),
        ])
    });
    Table {
        name: "nearness",
        title: "Section 7: how near the regime comes to what was published".to_owned(),
        head: vec!["figure", "#published", "#the same method here", "#ours on the same logs"],
        rows: rows.collect(),
        note: format!(
            "models are judged over {} % of the samples behind the first window: those at which all that have to find the mass know it",
            share(&experiment.share_known, 1)
        ),
    }
}

/// What the worst window's mass error is (Section 8 words the published ones as averages).
const WORST_MASS: &str = "of each of the two payloads the worst start, the mean of both (an average, as Section 8 words it; the worst start of Section 6's \
                          table is the worst of both)";

pub(super) fn windows(experiment: &Experiment) -> Table {
    let ours = experiment.windows.first().map(|row| row.method.as_str());
    let rows = experiment.windows.iter().map(|row| Row {
        cells: vec![
            number(row.window_s, 1),
            row.method.clone(),
            error(&row.worst_mass_percent, 2),
            error(&row.mean_mass_percent, 2),
            share(&row.known_percent, 1),
            error(&row.mape_percent, 2),
            r2(&row.r2, 3),
        ],
        mark: if Some(row.method.as_str()) == ours { Mark::Ours } else { Mark::None },
    });
    let published = PUBLISHED_WORST.map(|(window_s, mass, mape, r2)| {
        format!("at {window_s} s the paper has {mass} %, {mape} % and {r2}")
    });
    Table {
        name: "windows",
        title: "Fig. 12: error against window, worst-case start".to_owned(),
        head: vec!["#window s", "method", "#mass error, worst %", "#mean %", "#known %", "#MAPE %", "#R²"],
        rows: rows.collect(),
        note: format!(
            "mass error, worst: {WORST_MASS}; MAPE and R² with the worst window's mass; worst mass error, MAPE and R²: {}",
            published.join(", ")
        ),
    }
}

pub(super) fn models(experiment: &Experiment) -> Table {
    let Some((ours, others)) = experiment.models.split_first() else {
        return Table { rows: Vec::new(), ..models_table() };
    };
    let cells = |row: &ModelRow, standing: &str| {
        let published = row
            .published
            .map_or(String::new(), |(mape, r2)| format!("{} / {}", number(mape, 2), number(r2, 2)));
        vec![
            row.name.clone(),
            mass(row.mass).to_owned(),
            error(&row.mape_percent, 2),
            r2(&row.r2, 3),
            error(&row.rmse_w, 3),
            published,
            standing.to_owned(),
        ]
    };
    let others = others.iter().map(|row| {
        let standing = Standing::of(row);
        let mark = if standing == Standing::Behind { Mark::Against } else { Mark::None };
        let of = row.ours_ahead + row.ours_behind;
        Row { cells: cells(row, &format!("{} ({} of {of})", standing.words(), row.ours_ahead)), mark }
    });
    let first = Row { cells: cells(ours, ""), mark: Mark::Ours };
    Table { rows: std::iter::once(first).chain(others).collect(), ..models_table() }
}

fn models_table() -> Table {
    Table {
        name: "models",
        title: "Section 7.2: power of the test logs, moving window of 25 s, every earlier method".to_owned(),
        head: vec!["model", "mass", "#MAPE %", "#R²", "#RMSE W", "#published", "standing"],
        rows: Vec::new(),
        note: "mass: given = the true mass is an input, estimated = found from speed and power, unused = the model has none; \
               published: MAPE % / R²; standing: by the sign test at 5 %, in brackets the seeds in which ours is better by both MAPE and R²; \
               ours restarts its window when it notices a change of payload, the others have no such detector; networks are trained once, \
               with one seed of their weights, and the test turns faster than the training does, where they extrapolate"
            .to_owned(),
    }
}

/// For tables.
pub(in crate::reproduce) fn mass(source: MassSource) -> &'static str {
    match source {
        MassSource::Given => "given",
        MassSource::Estimated => "estimated",
        MassSource::Unused => "unused",
    }
}

pub(super) fn left_out(experiment: &Experiment) -> Table {
    let rows = experiment.left_out.iter().map(|left| plain(vec![left.name.clone(), left.reason.clone()]));
    Table {
        name: "left-out",
        title: "Baselines that these logs do not allow".to_owned(),
        head: vec!["model", "why"],
        rows: rows.collect(),
        note: String::new(),
    }
}
