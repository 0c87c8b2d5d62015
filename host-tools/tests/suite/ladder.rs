//! README.md and docs/ladder.md are what a newcomer copies: every command in them runs, in order;
//! and the book that they open has every page.

use std::path::{Path, PathBuf};

use crate::common::{Bench, excerpt};

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs")
}

/// A fenced block: what stands behind its three ticks, and its lines.
fn blocks(page: &str) -> Vec<(String, String)> {
    let mut blocks = Vec::new();
    let mut open: Option<(String, String)> = None;
    for line in page.lines() {
        match (line.strip_prefix("```"), open.take()) {
            (Some(kind), None) => open = Some((kind.to_owned(), String::new())),
            (Some(_), Some(block)) => blocks.push(block),
            (None, Some((kind, text))) => open = Some((kind, text + line + "\n")),
            (None, None) => {}
        }
    }
    blocks
}

/// The command of this line has such options.
fn knows_options(bench: &Bench, line: &str) {
    let words: Vec<&str> = line.split_whitespace().skip(1).collect();
    let help = bench.done(&[words[0], "--help"]).stdout;
    for option in words.iter().filter(|word| word.starts_with("--")) {
        assert!(help.contains(option), "{line}: {option}");
    }
}

/// In a folder with the bags that README names, a route, and no robot.toml until `gmr new-robot`
/// has its turn, whose questions newcomer.rs answers. The gap wants more drives than there are.
#[test]
fn every_command_of_the_readme_runs() {
    let bench = Bench::new();
    for (name, bag) in [("bag", "empty"), ("empty", "empty"), ("full", "full"), ("run", "full")] {
        let content = std::fs::read(excerpt("turtlebot3-bags").join(format!("{bag}.mcap"))).unwrap();
        bench.put(&format!("{name}.mcap"), content);
    }
    bench.put("route.csv", "distance_m,speed_m_s\n40,0.2\n");
    let ladder = std::fs::read_to_string(docs().join("ladder.md")).unwrap();
    let robot = blocks(&ladder).into_iter().find(|(kind, _)| kind == "toml robot.toml").unwrap().1;
    let page = std::fs::read_to_string(docs().join("../README.md")).unwrap();
    let mut ran = Vec::new();
    for (_, text) in blocks(&page).into_iter().filter(|(kind, _)| kind.starts_with("sh")) {
        for line in text.lines() {
            let line = line.split(" # ").next().unwrap();
            let words: Vec<&str> = line.split_whitespace().collect();
            match words[..] {
                // newcomer.rs has the demo, and this is a part of the tests.
                ["cargo", ..] => {}
                ["gmr", "new-robot"] => bench.put("robot.toml", &robot),
                ["gmr", "gap", ..] => knows_options(&bench, line),
                ["gmr", ref command @ ..] => {
                    bench.done(command);
                    ran.push(command[0].to_owned());
                }
                _ => panic!("a line that nobody runs: {line}"),
            }
        }
    }
    assert_eq!(ran, ["look", "inspect", "fit", "estimate", "predict"]);
    assert!(["bag.html", "coefficients.toml", "run.png"].iter().all(|made| bench.path(made).exists()));
}

#[test]
fn every_command_of_the_ladder_runs() {
    let bench = Bench::new();
    for bag in ["empty.mcap", "full.mcap"] {
        bench.put(bag, std::fs::read(excerpt("turtlebot3-bags").join(bag)).unwrap());
    }
    let page = std::fs::read_to_string(docs().join("ladder.md")).unwrap();
    let mut ran = 0;
    for (kind, text) in blocks(&page) {
        match kind.split_once(' ').unwrap_or((&kind, "")) {
            ("sh", "") => {
                for line in text.lines() {
                    let words: Vec<&str> = line.split_whitespace().collect();
                    assert_eq!(words[0], "gmr", "{line}");
                    bench.done(&words[1..]);
                    ran += 1;
                }
            }
            // Without a board: whether there are such options.
            ("sh", "board") => text.lines().for_each(|line| knows_options(&bench, line)),
            ("csv" | "toml", name) => bench.put(name, text),
            (other, _) => panic!("a block that nobody runs: {other}"),
        }
    }
    assert!(ran > 10, "{ran}");
    for made in ["bag.html", "run.png", "gap.html", "fleet.yaml", "wheel.xml"] {
        assert!(bench.path(made).exists(), "{made}");
    }
}

#[test]
fn the_book_has_every_page_and_no_other() {
    let summary = std::fs::read_to_string(docs().join("SUMMARY.md")).unwrap();
    let mut pages: Vec<String> = std::fs::read_dir(docs())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.ends_with(".md") && name != "SUMMARY.md")
        .collect();
    let linked = summary.split('(').skip(1).map(|rest| rest.split(')').next().unwrap().to_owned());
    let mut listed: Vec<String> = linked.filter(|page| !page.contains('/')).collect();
    pages.sort();
    listed.sort();
    assert_eq!(pages, listed);
}
