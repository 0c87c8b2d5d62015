//! docs/ladder.md is what a newcomer copies: every command in it runs, in order; and the book that
//! it opens has every page.

use std::path::{Path, PathBuf};

use crate::common::{Bench, excerpt};

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs")
}

/// A fenced block: what stands behind its three ticks, and its lines.
fn blocks(page: &str) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let mut open: Option<(String, String)> = None;
    for line in page.lines() {
        match (line.strip_prefix("```"), open.take()) {
            (Some(kind), None) => open = Some((kind.to_owned(), String::new())),
            (Some(_), Some(block)) => found.push(block),
            (None, Some((kind, text))) => open = Some((kind, text + line + "\n")),
            (None, None) => {}
        }
    }
    found
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
            ("sh", "board") => {
                for line in text.lines() {
                    let words: Vec<&str> = line.split_whitespace().skip(1).collect();
                    let help = bench.done(&[words[0], "--help"]).stdout;
                    for option in words.iter().filter(|word| word.starts_with("--")) {
                        assert!(help.contains(option), "{line}: {option}");
                    }
                }
            }
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
