//! The paper's figures as data, in panels of series and axes, for the page and for files.

use report::{
    Bars, Binned, Curve, Curves, Gaussian, Histogram, Line, Marks, Page, Panel, Stroke, TimeSeries, palette,
};

use crate::compare::MassSource;

use super::colours::{Colours, black};
use super::contender::CONTENDERS;
use super::course::{Course, masses, powers, speeds, validation};
use super::price::{Price, Priced, Split};
use super::regime::Rails;
use super::section7::{Courses, ModelRow};
use super::spread::Spread;
use super::table::{distinct, number};
use super::windows::{PUBLISHED_WORST, WindowRow};

/// One figure of the paper, or one that it lacks.
pub(super) struct Figure {
    /// Name of its files.
    pub(super) name: &'static str,
    /// Its title.
    pub(super) title: &'static str,
    /// What the paper's figure shows, and what is seen here.
    pub(super) caption: String,
    /// The panels.
    pub(super) page: Page,
}

/// What figures are drawn from.
pub(super) struct Sources<'a> {
    /// Every contender on any drives, then on gentle ones.
    pub(super) simulation: &'a [(String, [Spread; 5])],
    /// Training, test with a known change, test with a moving window.
    pub(super) section6: &'a [Course; 3],
    pub(super) rails: &'a Rails,
    pub(super) section7: &'a Courses,
    pub(super) windows: &'a [WindowRow],
    pub(super) models: &'a [ModelRow],
    pub(super) price: &'a Price,
}

/// Names of all figures, in the paper's order.
pub(super) const NAMES: [&str; 12] = [
    "fig05", "fig06", "fig07", "fig09", "fig10", "fig11", "fig12", "fig13", "fig14", "fig15", "models",
    "price",
];

/// Every figure, in the order of [`NAMES`].
pub(super) fn all(sources: &Sources<'_>) -> Vec<Figure> {
    let Sources { simulation, section6, rails, section7, windows, models, price } = *sources;
    let [training, test, moving] = section6;
    let colours = &colours(sources);
    let figure = |name, title, caption: String, height, panels: Vec<Panel>| Figure {
        name,
        title,
        caption,
        page: Page::new(panels).with_panels_of(1000, height),
    };
    let contenders = &simulation[..CONTENDERS.len().min(simulation.len())];
    let each = |of: &dyn Fn(&str, &[Spread; 5]) -> String| -> String {
        let all: Vec<String> = contenders.iter().map(|(name, figures)| of(name, figures)).collect();
        all.join(", ")
    };
    let (mean, std) = rails.gaussian_w;
    let first: Vec<String> = models
        .iter()
        .take(2)
        .map(|row| {
            let [mape, r2, ..] = row.quality;
            format!("{} MAPE {} %, R² {}", row.name, number(mape.mean, 2), number(r2.mean, 3))
        })
        .collect();
    let short_and_long = section7.moving.iter().zip(["(a)", "(b)", "(c)", "(d)"]);
    vec![
        figure(
            "fig05",
            "Fig. 5: speeds and power of the simulation",
            "The paper: wheel speeds and power of training (no load, from 100 s on 5 kg) and of the test (2 kg, from 50 s on 3 kg), \
             its estimate over the latter. Here: the same payloads on profiles drawn anew, as the paper's are not given. Before a \
             task's first 10 s are over there is no estimate of the mass, and no line."
                .to_owned(),
            280,
            vec![
                speeds("(a) Wheel speeds, training", training).into(),
                powers("(b) Power, training, payload known", training, colours).into(),
                speeds("(c) Wheel speeds, test", test).into(),
                powers("(d) Power, test, payload from 10 s", test, colours).into(),
            ],
        ),
        figure(
            "fig06",
            "Fig. 6: mass over a moving window of 10 s, simulation",
            format!(
                "The paper: its estimate stays within 22 % of the truth, worst where the wheels are slow. Here: the first seed; at the worst \
                 moment, over all seeds, {}. The window still holds the old payload for 10 s behind the change at 50 s.",
                each(&|name, figures| format!("{name} {} %", number(figures[4].mean, 1)))
            ),
            380,
            vec![masses("Estimated mass", moving, colours).into()],
        ),
        figure(
            "fig07",
            "Fig. 7: validation of the predicted power, simulation",
            format!(
                "The paper: predictions about the diagonal with bounded residuals, R² 0.973. Here, over all seeds: {}; drawn is the first seed.",
                each(&|name, figures| format!("{name} R² {}", number(figures[1].mean, 4)))
            ),
            440,
            vec![validation(test, colours).into()],
        ),
        figure(
            "fig09",
            "Fig. 9: rails, and the static power",
            format!(
                "The paper: battery, actuation and all else while the robot moves without and with full load, and a Gaussian of 6.393 W and \
                 0.29 W for the static power. Here: INA219s in the simulated rails read {} W and {} W. The \
                 simulated computer either waits or works, so its power has two states, and one Gaussian is a poor summary of it.",
                number(mean, 3),
                number(std, 2)
            ),
            340,
            vec![rail_powers(rails).into(), static_power(rails).into()],
        ),
        figure(
            "fig10",
            "Fig. 10: mass since a known payload change",
            "The paper: its cumulative mean converges from both sides as a task goes on. Here: the same average of roots, and our \
             least squares over the same samples with its interval. Roots cut to the range of the robot's masses lean towards the \
             middle of that range, however long they are averaged."
                .to_owned(),
            380,
            vec![masses("Estimated mass, all samples since the change", &section7.cumulative, colours).into()],
        ),
        figure(
            "fig11",
            "Fig. 11: mass over moving windows",
            "The paper: 12.5 s follow the change soon and scatter, 50 s are calm and late. Here: the same trade; the band is our \
             interval, cut where it leaves the range of the estimates. Ours restarts its window when it notices a change of payload, the others have \
             no such detector."
                .to_owned(),
            380,
            short_and_long
                .map(|((window_s, course), letter)| {
                    masses(&format!("{letter} Estimated mass, moving window of {window_s} s"), course, colours).into()
                })
                .collect(),
        ),
        figure(
            "fig12",
            "Fig. 12: error against window, worst-case start",
            "The paper: mass error and MAPE fall with the window, the MAPE hardly beyond 30 s; its two stated windows are the \
             crosses. Here: means over seeds with the 95 % intervals of the means as bands, cut at 0; the mass error is the mean of the worst starts \
             of the two payloads."
                .to_owned(),
            340,
            vec![
                over_windows("(a) Mass error, worst window", "mass error (%)", windows, colours, (0, 1)).into(),
                over_windows("(b) MAPE with the worst window's mass", "MAPE (%)", windows, colours, (2, 2)).into(),
            ],
        ),
        figure(
            "fig13",
            "Fig. 13: power of the test log",
            "The paper: velocities with much noise, and its estimate through a change from 3 to 4 kg. Here: the first seed; ours and \
             the paper's method see the same samples. Ours restarts its window when it notices the change, the paper's has no such detector."
                .to_owned(),
            320,
            vec![
                speeds("(a) Wheel speeds behind the filter", &section7.test).into(),
                powers("(b) Power, moving window of 25 s", &section7.test, colours).into(),
            ],
        ),
        figure(
            "fig14",
            "Fig. 14: validation of the predicted power, experiment's regime",
            format!(
                "The paper: residuals that do not depend on the prediction, MAPE 9.12 %, R² 0.78. Here, over all seeds: {}; drawn is the \
                 first seed.",
                first.join("; ")
            ),
            440,
            vec![validation(&section7.test, colours).into()],
        ),
        figure(
            "fig15",
            "Fig. 15: predicted against measured power",
            "The paper: its method stays nearer to the diagonal than perceptron and regression, at low and at high power. Here: \
             means and standard deviations in bins of 0.1 W (the paper's are 0.5 W), first seed; the two comparisons get what the paper gave them."
                .to_owned(),
            480,
            vec![binned(&section7.test, models, colours).into()],
        ),
        figure(
            "models",
            "Every model's MAPE on the test logs",
            "Beyond the paper: means over seeds. Models with light blue bars are told the true mass, which ours has to find; whatever \
             ends left of the dashed line is ahead of ours in MAPE. Networks are the median of three seeds of their weights, and have to extrapolate: the test turns \
             faster than the training does."
                .to_owned(),
            130 + 24 * models.len() as u32,
            vec![bars(models).into()],
        ),
        prices(price, colours, figure),
    ]
}

/// Contenders and models with published figures come first, then the others.
fn colours(sources: &Sources<'_>) -> Colours {
    let names = CONTENDERS.iter().map(|contender| contender.name);
    let published = sources.models.iter().filter(|row| row.published.is_some()).map(|row| row.name.as_str());
    let courses = [&sources.section6[1], &sources.section6[2], &sources.section7.test];
    let others = courses.into_iter().flat_map(|course| course.methods.iter().map(|method| &*method.method));
    Colours::of(distinct(names.chain(published).chain(others).map(str::to_owned)))
}

fn rail_powers(rails: &Rails) -> TimeSeries {
    let named = [("battery", 6), ("actuation", 4), ("all else", 5)].into_iter().zip(&rails.powers_w);
    let lines = named.map(|((name, colour), values)| {
        Line::over(name, &rails.time_s, values, palette(colour), Stroke::Solid)
    });
    TimeSeries {
        title: "(a) Power of the rails, mean of 20 samples".to_owned(),
        y_label: "power (W)".to_owned(),
        lines: lines.collect(),
        ..TimeSeries::default()
    }
}

/// Mean and standard deviation of the static power as published (Section 7.1), W.
const STATIC_W: (f64, f64) = (6.393, 0.29);

fn static_power(rails: &Rails) -> Histogram {
    let gaussian = |name: String, (mean, std): (f64, f64), colour| Gaussian {
        name,
        mean,
        std,
        share: 1.0,
        colour: palette(colour),
    };
    let (mean, std) = rails.gaussian_w;
    let here = format!("here: N({}, {}²) W", number(mean, 3), number(std, 2));
    let paper = format!("published: N({}, {}²) W", STATIC_W.0, STATIC_W.1);
    Histogram::new(
        "(b) Static power",
        "static power (W)",
        rails.static_samples_w.iter().copied(),
        vec![gaussian(here, (mean, std), 2), gaussian(paper, STATIC_W, 3)],
    )
}

/// One figure over the windows' lengths: its place in a row, and in what is published after the
/// length.
fn over_windows(
    title: &str,
    y: &str,
    rows: &[WindowRow],
    colours: &Colours,
    place: (usize, usize),
) -> Curves {
    let curve = |method: &'static str| {
        let rows = rows.iter().filter(|row| row.method == method);
        let points = rows.map(|row| {
            let Spread { mean, low, high, .. } = row.figures[place.0];
            (row.window_s, mean, low, high)
        });
        Curve { name: method.to_owned(), colour: colours.get(method), points: points.collect() }
    };
    Curves {
        title: title.to_owned(),
        labels: ["window (s)".to_owned(), y.to_owned()],
        from: Some(0.0),
        curves: distinct(rows.iter().map(|row| row.method)).into_iter().map(curve).collect(),
        marks: vec![Marks {
            name: "published".to_owned(),
            colour: black(),
            points: PUBLISHED_WORST.map(|published| (published[0], published[place.1])).to_vec(),
        }],
        ..Curves::default()
    }
}

/// Bins, W. The paper's are 0.5 W wide: the regime's power would fill only three.
const BIN_W: f64 = 0.1;

/// Ours, the paper's and the two that the paper compares with: nobody could distinguish the curves
/// of all baselines.
fn binned(course: &Course, models: &[ModelRow], colours: &Colours) -> Binned {
    let published = |name: &str| models.iter().any(|row| row.name == name && row.published.is_some());
    let methods = course.methods.iter().enumerate();
    let mut binned = Binned::new("Predicted against measured power", BIN_W);
    for (_, method) in methods.filter(|(place, method)| *place < 2 || published(&method.method)) {
        binned = binned.with_model(&method.method, colours.get(&method.method));
        for (measured, predicted) in course.trace.measured_w.iter().zip(&method.predicted_w) {
            binned.add(&method.method, *measured, *predicted);
        }
    }
    binned
}

/// Bars end here: longer ones would flatten the others.
const MOST_MAPE: f64 = 60.0;

/// The worst on top.
fn bars(models: &[ModelRow]) -> Bars {
    let sources = [MassSource::Estimated, MassSource::Unused, MassSource::Given];
    let series = sources.into_iter().zip([0, 4, 5]);
    let mape = |row: &ModelRow| row.quality[0].mean;
    let rows = models.iter().map(|row| {
        let place = sources.iter().position(|source| *source == row.mass).unwrap_or(0);
        (row.name.clone(), vec![(place, mape(row))])
    });
    let mut rows: Vec<(String, Vec<(usize, f64)>)> = rows.collect();
    rows.sort_by(|a, b| b.1[0].1.total_cmp(&a.1[0].1));
    Bars {
        title: "MAPE of every model".to_owned(),
        x_label: "MAPE (%)".to_owned(),
        series: series
            .map(|(source, colour)| (format!("mass {}", source.words()), palette(colour)))
            .collect(),
        rows,
        line: models.first().map(|row| ("ours".to_owned(), mape(row))),
        most: Some(MOST_MAPE),
    }
}

/// Cost of sensing against its savings, over the windows of the middle task; split for the first
/// method.
fn prices(
    price: &Price,
    colours: &Colours,
    figure: impl Fn(&'static str, &'static str, String, u32, Vec<Panel>) -> Figure,
) -> Figure {
    let tasks = distinct(price.priced.iter().map(|priced| priced.task_s));
    let methods = distinct(price.priced.iter().map(|priced| priced.method));
    let middle = tasks.get(tasks.len().saturating_sub(1) / 2).copied().unwrap_or(f64::NAN);
    let curve = |name: &str, colour, method: &str, joules: &dyn Fn(&Priced) -> f64| {
        let tried = price.priced.iter().filter(|priced| priced.task_s == middle && priced.method == method);
        let points = tried.map(|priced| (priced.window_s, joules(priced), f64::NAN, f64::NAN));
        Curve { name: name.to_owned(), colour, points: points.collect() }
    };
    let curves = |title: String, log, curves: Vec<Curve>, marks: Vec<Marks>| Curves {
        title,
        labels: ["window (s)", "cost (J)"].map(str::to_owned),
        log,
        curves,
        marks,
        ..Curves::default()
    };
    let totals =
        methods.iter().map(|method| curve(method, colours.get(method), method, &|priced| priced.total_j));
    let best = price.best.iter().filter(|best| best.task_s == middle);
    let least = Marks {
        name: "least".to_owned(),
        colour: black(),
        points: best.map(|best| (best.window_s, best.total_j)).collect(),
    };
    type Share = fn(&Split) -> f64;
    let shares: [(&str, usize, Share); 5] = [
        ("error before the estimate", 1, |split| split.before_j),
        ("error behind the estimate", 4, |split| split.after_j),
        ("shunt", 3, |split| split.shunt_j),
        ("sensors", 2, |split| split.sensors_j),
        ("computing", 5, |split| split.computing_j),
    ];
    let first = methods.first().copied().unwrap_or("");
    let shares = shares
        .map(|(name, colour, share)| curve(name, palette(colour), first, &|priced| share(&priced.split)));
    figure(
        "price",
        "Price of sensing and computing",
        format!(
            "Beyond the paper, which names this trade and leaves it open: a task of {middle} s begins with another payload, power is \
             predicted with the old mass for a window, then with the new one. A mispredicted joule counts as one spent. Parts that are \
             not above 0 do not show in (b)."
        ),
        360,
        vec![
            curves(format!("(a) Cost of a task of {middle} s"), false, totals.collect(), vec![least]).into(),
            curves(format!("(b) Its parts, {first}"), true, shares.to_vec(), Vec::new()).into(),
        ],
    )
}
