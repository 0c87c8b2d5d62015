//! Figures are drawn in both formats, without fonts of the system.

use report::{
    Band, Binned, Curve, Curves, Gaussian, Histogram, Line, Page, Stroke, TimeSeries, Validated, Validation,
    palette,
};

/// A page with every panel, on invented data.
fn page() -> Page {
    let wave = |t: f64| 4.0 + 3.0 * (0.3 * t).sin();
    let noise = |k: i32| f64::from(k * 7919 % 101) / 101.0 - 0.5;
    let time = |k: i32| f64::from(k) * 0.01;
    let measured = (0..20_000).map(|k| (time(k), wave(time(k)) + noise(k))).collect();
    let predicted = (0..20_000).map(|k| (time(k), wave(time(k)))).collect();
    let line = |name: &str, points, colour, stroke| Line { name: name.to_owned(), points, colour, stroke };
    let power = TimeSeries {
        title: "Power: measured and predicted".to_owned(),
        y_label: "power (W)".to_owned(),
        lines: vec![
            line("measured", measured, palette(0), Stroke::Faint),
            line("predicted", predicted, palette(1), Stroke::Solid),
        ],
        ..TimeSeries::default()
    };
    let seconds = || (5..200).map(f64::from);
    let estimate = |t: f64| if t < 15.0 { f64::NAN } else { 3.0 + 0.3 * (0.1 * t).sin() };
    let mass = TimeSeries {
        title: "Mass, windows of 10 s".to_owned(),
        y_label: "mass (kg)".to_owned(),
        y_range: Some((0.0, 6.0)),
        bands: vec![Band {
            name: "95 % interval".to_owned(),
            points: seconds().map(|t| (t, estimate(t) - 0.5, estimate(t) + 0.5)).collect(),
            colour: palette(0),
        }],
        lines: vec![
            line("estimate", seconds().map(|t| (t, estimate(t))).collect(), palette(0), Stroke::Solid),
            line("truth", seconds().map(|t| (t, 3.0)).collect(), palette(6), Stroke::Dashed),
        ],
    };
    let mut binned = Binned::new("Predicted against measured", 0.5);
    for k in 0..20_000 {
        binned.add("signed torque (default)", wave(time(k)) + noise(k), wave(time(k)));
        binned.add("linear regression", wave(time(k)) + noise(k), 2.0 + 0.5 * wave(time(k)));
    }
    let values =
        (0..20_000).map(|k| if k % 3 == 0 { 8.6 } else { 9.7 } + 0.5 * (noise(k) + noise(3 * k + 1)));
    let gaussian = |name: &str, mean, share, index| Gaussian {
        name: name.to_owned(),
        mean,
        std: 0.2,
        share,
        colour: palette(index),
    };
    let gaussians = vec![gaussian("8.60 ± 0.20 W", 8.6, 0.33, 0), gaussian("9.70 ± 0.20 W", 9.7, 0.67, 1)];
    let histogram = Histogram::new("Static power", "power (W)", values, gaussians);
    Page::new([power.into(), mass.into(), binned.into(), histogram.into()])
}

#[test]
fn every_panel_is_drawn_in_both_formats() {
    let folder = tempfile::tempdir().unwrap();
    let (svg, png) = (folder.path().join("page.svg"), folder.path().join("page.PNG"));
    page().save(&svg).unwrap();
    page().save(&png).unwrap();
    let text = std::fs::read_to_string(&svg).unwrap();
    for word in ["predicted", "95 % interval", "truth", "linear regression", "9.70 ± 0.20 W", "power (W)"] {
        assert!(text.contains(word), "{word}");
    }
    // 20,000 points a curve would take 200 bytes and more per pixel column: they were thinned out.
    assert!(text.len() < 400_000, "{} bytes", text.len());
    let bytes = std::fs::read(&png).unwrap();
    assert!(bytes.starts_with(b"\x89PNG") && bytes.len() > 20_000, "{} bytes", bytes.len());
    if let Some(kept) = std::env::var_os("GMR_KEEP_FIGURES") {
        std::fs::write(kept, bytes).unwrap();
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "nothing half written stays");
}

#[test]
fn empty_panels_and_lone_points_are_drawn_too() {
    let folder = tempfile::tempdir().unwrap();
    let empty = Histogram::new("", "", [], Vec::new());
    let lone = TimeSeries {
        lines: vec![Line {
            name: String::new(),
            points: vec![(1.0, 2.0)],
            colour: palette(0),
            stroke: Stroke::Solid,
        }],
        ..TimeSeries::default()
    };
    let none = f64::NAN;
    let curve = |points| Curve { name: "method".to_owned(), colour: palette(0), points };
    // Of these only the last but one has a place on an axis of powers of ten.
    let points =
        vec![(5.0, none, none, none), (10.0, -1.0, none, 2.0), (20.0, 0.1, 0.05, 0.2), (40.0, 0.0, 0.0, 0.0)];
    let decades = Curves { log: true, from: Some(0.0), curves: vec![curve(points)], ..Curves::default() };
    let unknown = Validated { name: "method".to_owned(), colour: palette(0), pairs: vec![(1.0, none)] };
    let page = Page::new([
        empty.into(),
        lone.into(),
        Binned::new("", 0.5).into(),
        Curves::default().into(),
        decades.into(),
        Validation { quantity: String::new(), methods: vec![unknown] }.into(),
    ]);
    page.save(&folder.path().join("empty.svg")).unwrap();
    page.save(&folder.path().join("empty.png")).unwrap();
}

#[test]
fn other_formats_are_wrong_usage() {
    let error = page().save(std::path::Path::new("figure.pdf")).unwrap_err();
    assert_eq!(error.exit_code(), 2);
    assert_eq!(error.to_string(), "figure.pdf: figures are written as .svg or .png");
}
