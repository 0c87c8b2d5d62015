//! What sensing costs against what it saves.

use crate::report::{Curve, Curves, Marks, Page, palette};

use super::{Colours, Figure, black};
use crate::reproduce::price::{Price, Priced, Split};

/// Ours, or whichever method comes first, split over the windows of its middle task.
pub(super) fn price(price: &Price, colours: &Colours) -> Figure {
    let mut tasks: Vec<f64> = Vec::new();
    let mut methods: Vec<&str> = Vec::new();
    for priced in &price.priced {
        if !tasks.contains(&priced.task_s) {
            tasks.push(priced.task_s);
        }
        if !methods.contains(&priced.method.as_str()) {
            methods.push(&priced.method);
        }
    }
    let middle = tasks.get(tasks.len().saturating_sub(1) / 2).copied().unwrap_or(f64::NAN);
    let fits: Vec<&Priced> = price.priced.iter().filter(|priced| priced.task_s == middle).collect();
    let none = f64::NAN;
    let totals = methods.iter().map(|method| Curve {
        name: (*method).to_owned(),
        colour: colours.get(method),
        points: fits
            .iter()
            .filter(|priced| priced.method == **method)
            .map(|priced| (priced.window_s, priced.total_j, none, none))
            .collect(),
    });
    let best = price.best.iter().filter(|best| best.task_s == middle);
    let total = Curves {
        title: format!("(a) Cost of a task of {middle} s"),
        labels: ["window (s)".to_owned(), "cost (J)".to_owned()],
        curves: totals.collect(),
        marks: vec![Marks {
            name: "least".to_owned(),
            colour: black(),
            points: best.map(|best| (best.window_s, best.total_j)).collect(),
        }],
        ..Curves::default()
    };
    let first = methods.first().copied().unwrap_or("");
    type Part = fn(&Split) -> f64;
    let parts: [(&str, usize, Part); 5] = [
        ("error before the estimate", 1, |split| split.before_j),
        ("error behind the estimate", 4, |split| split.after_j),
        ("shunt", 3, |split| split.shunt_j),
        ("sensors", 2, |split| split.sensors_j),
        ("computing", 5, |split| split.computing_j),
    ];
    let parts = parts.map(|(name, colour, part)| Curve {
        name: name.to_owned(),
        colour: palette(colour),
        points: fits
            .iter()
            .filter(|priced| priced.method == first)
            .map(|priced| (priced.window_s, part(&priced.split), none, none))
            .collect(),
    });
    let split = Curves {
        title: format!("(b) Its parts, {first}"),
        labels: ["window (s)".to_owned(), "cost (J)".to_owned()],
        log: true,
        curves: parts.to_vec(),
        ..Curves::default()
    };
    Figure {
        name: "price",
        title: "Price of sensing and computing".to_owned(),
        caption: format!(
            "Beyond the paper, which names this trade and leaves it open: a task of {middle} s begins with another payload, power is \
             predicted with the old mass for a window, then with the new one. A mispredicted joule counts as one spent. Parts that are \
             not above 0 do not show in (b)."
        ),
        page: Page::new([total.into(), split.into()]).with_panels_of(1000, 360),
    }
}
