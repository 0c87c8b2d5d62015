//! Page, tables and files of a made-up study.

use std::collections::BTreeMap;
use std::path::Path;

use roxmltree::{Document, ParsingOptions};

use super::testing::{METHODS, spread, study};
use super::{figures, output, page, table};

fn parsed(page: &str) -> Document<'_> {
    Document::parse_with_options(page, ParsingOptions { allow_dtd: true, ..ParsingOptions::default() })
        .unwrap()
}

fn text(node: roxmltree::Node<'_, '_>) -> String {
    node.descendants().filter_map(|node| node.text().filter(|_| node.is_text())).collect()
}

/// Every file below, by its name.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        if path.is_dir() {
            found.extend(files(&path).into_iter().map(|(inner, bytes)| (format!("{name}/{inner}"), bytes)));
        } else {
            found.insert(name, std::fs::read(&path).unwrap());
        }
    }
    found
}

#[test]
fn the_page_is_well_formed_and_shows_every_figure_and_table() {
    let study = study(35);
    let drawn = page::of(&study).unwrap();
    let page = parsed(&drawn);
    let ids: Vec<&str> = page.descendants().filter_map(|node| node.attribute("id")).collect();
    for figure in figures::all(&study) {
        assert!(ids.contains(&figure.name), "{}", figure.name);
    }
    for table in table::Table::all(&study) {
        assert!(ids.contains(&&*format!("table-{}", table.name)), "{}", table.name);
    }
    for svg in page.descendants().filter(|node| node.has_tag_name("svg")) {
        let shapes = ["rect", "polyline", "line", "circle", "polygon"];
        let count = svg.descendants().filter(|node| shapes.contains(&node.tag_name().name())).count();
        assert!(count > 8, "{:?}: {count}", svg.attribute("aria-label"));
    }
    assert!(text(page.root()).contains(METHODS[2]), "a name with markup is text");
    for outside in ["http:", "https:", "<script", "<link", "@import", "url(", "<corrected>"] {
        assert!(!drawn.contains(outside), "{outside}");
    }
}

/// What is lost is on top, in the table and in the marks.
#[test]
fn a_baseline_that_beats_ours_is_shown() {
    let mut lost = study(6);
    lost.experiment.models[2].mape_percent = spread(2.0, 0.3);
    lost.experiment.models[0].r2 = spread(0.90, 0.005);
    let drawn = page::of(&lost).unwrap();
    let page = parsed(&drawn);
    let header = page.descendants().find(|node| node.has_tag_name("header")).unwrap();
    assert!(text(header).contains("Ahead of ours in MAPE or R²: perceptron"), "{}", text(header));
    assert!(text(header).contains("at least 0.93: missed"), "{}", text(header));
    let marked = page.descendants().filter(|node| node.attribute("class") == Some("against")).map(text);
    let marked: Vec<String> = marked.collect();
    assert!(
        marked.iter().any(|row| row.starts_with("perceptron") && row.ends_with("beats ours")),
        "{marked:?}"
    );
    let lines = table::text(&lost);
    assert!(lines.lines().any(|line| line.starts_with("! perceptron")), "{lines}");
    assert!(!table::text(&study(6)).contains("! perceptron"));
}

#[test]
fn the_folder_holds_everything_and_the_same_study_gives_the_same_bytes() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("out");
    let study = study(35);
    output::save(&study, &folder).unwrap();
    let first = files(&folder);
    for figure in figures::all(&study) {
        for format in ["svg", "png"] {
            let name = format!("figures/{}.{format}", figure.name);
            assert!(first.get(&name).is_some_and(|bytes| bytes.len() > 2000), "{name}");
        }
    }
    let tables = String::from_utf8(first["tables.txt"].clone()).unwrap();
    assert!(tables.contains("Section 6") && tables.contains("baseline-34"), "{tables}");
    let json: serde_json::Value = serde_json::from_slice(&first["study.json"]).unwrap();
    assert_eq!(json["models"].as_array().unwrap().len(), 35);
    assert!(first["study.json"].len() < 200_000, "no traces");
    assert_eq!(first.len(), 3 + 2 * figures::all(&study).len());
    // An earlier reproduction is replaced, and nothing is left beside it.
    output::save(&study, &folder).unwrap();
    assert_eq!(files(&folder), first);
    assert_eq!(std::fs::read_dir(place.path()).unwrap().count(), 1);
    if let Some(kept) = std::env::var_os("GMR_KEEP_FIGURES") {
        let _ = std::fs::remove_dir_all(&kept);
        std::fs::rename(&folder, kept).unwrap();
    }
}

#[test]
fn another_folder_is_left_alone() {
    let place = tempfile::tempdir().unwrap();
    std::fs::write(place.path().join("thesis.tex"), "years of work").unwrap();
    let error = output::save(&study(4), place.path()).unwrap_err().to_string();
    assert!(error.contains("holds something else"), "{error}");
    assert_eq!(files(place.path()).len(), 1);
    assert!(output::check(&place.path().join("thesis.tex")).is_err());
    assert!(output::check(&place.path().join("nowhere/out")).is_err());
    assert!(output::check(&place.path().join("new")).is_ok());
}
