//! Plots with zoom. uPlot draws them; the page contains it. Where no scripts run, a plain drawing
//! stays in their place.

use maud::{Markup, PreEscaped, html};
use plotters::style::Color as _;
use serde::Serialize;
use support::error::{Error, Result};

use super::html::{drawing, page};
use super::{Cells, Colour, Page, Panel, TimeSeries};

/// What is drawn: curves over one x, pieces apart by a y of NaN.
#[derive(Debug, Clone, Serialize)]
pub struct Zoomed {
    x_label: String,
    y_label: String,
    x: Vec<f64>,
    curves: Vec<Curve>,
    /// Upper and lower curve of each band, from 1.
    bands: Vec<[usize; 2]>,
}

#[derive(Debug, Clone, Serialize)]
struct Curve {
    name: String,
    colour: String,
    /// Of the band below it.
    fill: String,
    /// Pixels.
    width: f64,
    y: Vec<f64>,
}

impl Curve {
    fn new(name: &str, colour: Colour, width: f64, y: Vec<f64>) -> Self {
        let (red, green, blue) = colour.rgb();
        let fill = format!("rgba({red},{green},{blue},0.22)");
        Self { name: name.to_owned(), colour: format!("rgb({red},{green},{blue})"), fill, width, y }
    }
}

impl Zoomed {
    /// The first line of a series.
    pub fn of_line(series: &TimeSeries) -> Option<Self> {
        let line = series.lines.first()?;
        let (x, y) = line.points.iter().copied().unzip();
        let curves = vec![Curve::new(&line.name, line.colour, 1.5, y)];
        Some(Self {
            x_label: "time (s)".to_owned(),
            y_label: series.y_label.clone(),
            x,
            curves,
            bands: Vec::new(),
        })
    }

    /// The first set of cells: a step each, with its band around it.
    pub fn of_cells(cells: &Cells) -> Option<Self> {
        let series = cells.series.first()?;
        let ends = |of: &dyn Fn(f64, f64) -> f64| -> Vec<f64> {
            let steps = series
                .cells
                .iter()
                .flat_map(|&(_, _, mean, band)| [of(mean, band), of(mean, band), f64::NAN]);
            steps.collect()
        };
        let curve = |name: &str, width, of: &dyn Fn(f64, f64) -> f64| {
            Curve::new(name, series.colour, width, ends(of))
        };
        let curves = vec![
            curve("mean", 3.0, &|mean, _| mean),
            curve("+ standard deviation", 0.5, &|mean, band| mean + band),
            curve("− standard deviation", 0.5, &|mean, band| mean - band),
        ];
        Some(Self {
            x_label: cells.x_label.clone(),
            y_label: cells.y_label.clone(),
            x: series.cells.iter().flat_map(|&(from, to, ..)| [from, to, to]).collect(),
            curves,
            bands: vec![[2, 3]],
        })
    }

    /// As JSON that neither HTML nor XML takes for anything else.
    fn json(&self) -> Result<String> {
        let text = serde_json::to_string(self).map_err(|error| Error::failed(error.to_string()))?;
        Ok(text.replace('&', "\\u0026").replace('<', "\\u003c").replace('>', "\\u003e"))
    }
}

/// A plot with its numbers.
///
/// # Errors
/// It cannot be drawn.
pub fn figure(
    panel: impl Into<Panel>,
    zoomed: Option<&Zoomed>,
    (width, height): (u32, u32),
    title: &str,
    about: &str,
) -> Result<Markup> {
    let numbers = zoomed.map(Zoomed::json).transpose()?;
    let numbers = numbers.map(|json| html! { script type="application/json" { (PreEscaped(json)) } });
    drawing(&Page::new([panel.into()]).with_panels_of(width, height), title, about, numbers)
}

const LIBRARY: &str = include_str!("../../assets/uPlot.iife.min.js");
const LIBRARY_STYLE: &str = include_str!("../../assets/uPlot.min.css");
const SCRIPT: &str = include_str!("zoom.js");

/// The page around a body with such plots.
pub fn document(title: &str, body: Markup) -> String {
    // Commented out for HTML, so that a strict reader of XML takes the page as well.
    let script = |text: &str| html! { script { (PreEscaped(format!("//<![CDATA[\n{text}\n//]]>"))) } };
    // Fingers scroll the page up and down; across and together they are the plot's.
    let style = format!(
        "{LIBRARY_STYLE}\nfigure .uplot {{ color: #222; }}\nfigure .u-over {{ touch-action: pan-y; }}"
    );
    page(title, &style, html! { (body) (script(LIBRARY)) (script(SCRIPT)) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CellSeries, palette};

    /// No label can end the numbers early; a cell is one step with a gap after it.
    #[test]
    fn numbers_are_neither_html_nor_xml() {
        let series =
            CellSeries { name: String::new(), colour: palette(0), cells: vec![(0.0, 1.0, 5.0, 2.0)] };
        let label = "</script> & <b>".to_owned();
        let cells = Cells {
            title: String::new(),
            x_label: label.clone(),
            y_label: label,
            y_range: None,
            series: vec![series],
        };
        let json = Zoomed::of_cells(&cells).unwrap().json().unwrap();
        assert!(!json.contains(['<', '>', '&']), "{json}");
        let read: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert_eq!(read["x_label"], "</script> & <b>");
        assert_eq!(read["x"], serde_json::json!([0.0, 1.0, 1.0]));
        assert_eq!(read["curves"][1]["y"], serde_json::json!([7.0, 7.0, null]));
        assert_eq!(read["curves"][2]["y"], serde_json::json!([3.0, 3.0, null]));
    }
}
