//! Page, tables and files of a made-up study.

use std::collections::BTreeMap;
use std::path::Path;

use roxmltree::{Document, ParsingOptions};

use super::testing::{METHODS, study, study_with};
use super::{figures, output, page};

fn parsed(page: &str) -> Document<'_> {
    Document::parse_with_options(page, ParsingOptions { allow_dtd: true, ..ParsingOptions::default() })
        .unwrap()
}

fn text(node: roxmltree::Node<'_, '_>) -> String {
    node.descendants().filter_map(|node| node.text().filter(|_| node.is_text())).collect()
}

/// Every file below, by its name.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = BTreeMap::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        if path.is_dir() {
            all.extend(files(&path).into_iter().map(|(inner, bytes)| (format!("{name}/{inner}"), bytes)));
        } else {
            all.insert(name, std::fs::read(&path).unwrap());
        }
    }
    all
}

#[test]
fn the_page_is_well_formed_and_shows_every_figure_and_table() {
    let study = study(40);
    let drawn = page::text(&study).unwrap();
    let page = parsed(&drawn);
    let ids: Vec<&str> = page.descendants().filter_map(|node| node.attribute("id")).collect();
    for figure in &study.figures {
        assert!(ids.contains(&figure.name), "{}", figure.name);
    }
    for table in &study.tables {
        assert!(ids.contains(&&*format!("table-{}", table.name)), "{}", table.name);
    }
    for svg in page.descendants().filter(|node| node.has_tag_name("svg")) {
        let shapes = ["rect", "polyline", "line", "circle", "polygon"];
        let count = svg.descendants().filter(|node| shapes.contains(&node.tag_name().name())).count();
        assert!(count > 8, "{:?}: {count}", svg.attribute("aria-label"));
    }
    assert!(text(page.root()).contains(METHODS[2]), "a name with markup is text");
    assert!(text(page.root()).contains("cut, ends at "), "bars that are cut say so");
    for outside in ["http:", "https:", "<script", "<link", "@import", "url(", "<corrected>"] {
        assert!(!drawn.contains(outside), "{outside}");
    }
}

/// Losses show at the top, in the table and in the marks.
#[test]
fn a_baseline_that_beats_ours_is_shown() {
    let lost = study_with(20, 6, 1);
    let drawn = page::text(&lost).unwrap();
    let page = parsed(&drawn);
    let header = page.descendants().find(|node| node.has_tag_name("header")).unwrap();
    assert!(text(header).contains("Ahead of ours in MAPE or R²: linear"), "{}", text(header));
    assert!(text(header).contains("at least 0.93: missed"), "{}", text(header));
    let marked = page.descendants().filter(|node| node.attribute("class") == Some("against")).map(text);
    let marked: Vec<String> = marked.collect();
    assert!(
        marked.iter().any(|row| row.starts_with("linear") && row.ends_with("beats ours (0 of 20)")),
        "{marked:?}"
    );
    let lines = lost.text();
    assert!(lines.lines().any(|line| line.starts_with("! linear")), "{lines}");
    assert!(!study(6).text().contains("! linear"));
}

#[test]
fn one_seed_tells_nothing_apart() {
    let one = study_with(1, 6, 0);
    let drawn = page::text(&one).unwrap();
    let page = text(parsed(&drawn).root());
    assert!(
        page.contains("One seed: no intervals, nothing can be told apart; 4 of 4 goals reached"),
        "{page}"
    );
    assert!(!page.contains("Ours is ahead of") && page.contains("Seed 1. "), "{page}");
    assert!(one.text().starts_with("Seed 1. "));
    assert!(study(6).text().starts_with("Seeds 1 to 20. "));
}

#[test]
fn the_folder_holds_everything_and_the_same_study_gives_the_same_bytes() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("out");
    let study = study(40);
    output::save(&study, &folder).unwrap();
    let first = files(&folder);
    for figure in &study.figures {
        for format in ["svg", "png"] {
            let name = format!("figures/{}.{format}", figure.name);
            assert!(first.get(&name).is_some_and(|bytes| bytes.len() > 2000), "{name}");
        }
    }
    let tables = String::from_utf8(first["tables.txt"].clone()).unwrap();
    assert!(tables.contains("Section 6") && tables.contains("baseline-34"), "{tables}");
    let json: serde_json::Value = serde_json::from_slice(&first["study.json"]).unwrap();
    assert_eq!(json["models"].as_array().unwrap().len(), 40);
    assert_eq!(json["goals"][0]["reached"], true);
    assert!(first["study.json"].len() < 200_000, "no traces");
    assert_eq!(first.len(), 3 + 2 * study.figures.len());
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
    assert!(error.contains("holds thesis.tex, which is not of a reproduction; expected"), "{error}");
    assert_eq!(files(place.path()).len(), 1);
    let error = output::check(&place.path().join("thesis.tex")).unwrap_err().to_string();
    assert!(error.contains("is not a folder; expected"), "{error}");
    assert!(output::check(&place.path().join("nowhere/out")).is_err());
    assert!(output::check(&place.path().join("new")).is_ok());
    // The folder of another site may have our names, but none of our figures.
    let site = place.path().join("site");
    std::fs::create_dir(&site).unwrap();
    assert!(output::check(&site).is_ok(), "empty");
    std::fs::write(site.join("index.html"), "welcome").unwrap();
    let error = output::check(&site).unwrap_err().to_string();
    assert!(error.contains("holds no study.json; expected"), "{error}");
}

#[test]
fn an_earlier_reproduction_with_other_files_in_it_is_left_alone() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("out");
    output::save(&study(4), &folder).unwrap();
    for name in ["mine.txt", "figures/mine.svg", "figures/fig05.txt"] {
        std::fs::write(folder.join(name), "mine").unwrap();
        let before = files(&folder);
        let error = output::save(&study(4), &folder).unwrap_err().to_string();
        assert!(error.contains(&format!("holds {name}, which is not of a reproduction")), "{error}");
        assert_eq!(files(&folder), before);
        std::fs::remove_file(folder.join(name)).unwrap();
    }
    output::check(&folder).unwrap();
    assert_eq!(study(4).figures.iter().map(|figure| figure.name).collect::<Vec<_>>(), figures::NAMES);
}

#[cfg(unix)]
#[test]
fn a_link_stays_and_the_folder_behind_it_is_replaced() {
    use std::os::unix::fs::symlink;
    let place = tempfile::tempdir().unwrap();
    let [folder, link] = ["real", "link"].map(|name| place.path().join(name));
    output::save(&study(4), &folder).unwrap();
    let before = files(&folder);
    symlink(&folder, &link).unwrap();
    output::save(&study(6), &link).unwrap();
    assert!(link.is_symlink() && files(&folder) != before);
    assert_eq!(std::fs::read_dir(place.path()).unwrap().count(), 2);
    symlink(place.path().join("gone"), place.path().join("dangling")).unwrap();
    let error = output::check(&place.path().join("dangling")).unwrap_err().to_string();
    assert!(error.contains("is a link to nothing; expected"), "{error}");
}
