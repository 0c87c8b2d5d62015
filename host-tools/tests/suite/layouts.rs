//! The layouts in docs/ show topics that `gmr node` has.

use logs::robot::NodeSettings;
use serde_json::Value;

fn document(name: &str) -> String {
    let path = format!("{}/../docs/{name}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(path).unwrap()
}

/// What both show: mass, interval, power measured and predicted.
fn expected() -> Vec<String> {
    let node = NodeSettings::default();
    let mut names =
        vec![node.payload, node.payload_low, node.payload_high, node.measured_power, node.predicted_power];
    names.sort();
    names
}

#[test]
fn foxgloves_shows_payload_and_power() {
    let layout: Value = serde_json::from_str(&document("layouts/foxglove.json")).unwrap();
    let panels = layout["configById"].as_object().unwrap();
    let mut shown: Vec<String> = panels
        .values()
        .flat_map(|panel| panel["paths"].as_array().unwrap())
        .map(|path| path["value"].as_str().unwrap().strip_suffix(".data").unwrap().to_owned())
        .collect();
    shown.sort();
    assert_eq!(shown, expected());
    for panel in panels.values() {
        // Lichtblick, Foxglove's open fork, has its own name for the title.
        assert!(panel["foxglovePanelTitle"].is_string());
        assert_eq!(panel["lichtblickPanelTitle"], panel["foxglovePanelTitle"]);
    }
    for place in ["first", "second"] {
        assert!(panels.contains_key(layout["layout"][place].as_str().unwrap()), "{place}");
    }
}

#[test]
fn plotjugglers_shows_payload_and_power() {
    let text = document("layouts/plotjuggler.xml");
    let tree = roxmltree::Document::parse(&text).unwrap();
    let curves = tree.descendants().filter(|node| node.has_tag_name("curve"));
    let mut shown: Vec<String> = curves
        .map(|curve| curve.attribute("name").unwrap().strip_suffix("/data").unwrap().to_owned())
        .collect();
    shown.sort();
    assert_eq!(shown, expected());
}
