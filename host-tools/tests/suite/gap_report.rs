//! The page that `gmr gap --report` writes: read strictly as XML, and opened in a browser where
//! there is one.

use std::path::Path;
use std::sync::OnceLock;

use crate::common::browser::Browser;
use crate::common::{Bench, keys, number, simulate};
use roxmltree::{Document, Node, ParsingOptions};
use serde_json::Value;

/// A name that would be markup if it were not escaped.
const NASTY: &str = "<b>&'field'.csv";

/// Of the field runs.
const MASSES: [&str; 8] = ["1.2", "5.6", "2.4", "4.1", "3.3", "1.8", "5.0", "2.9"];

/// A folder with field runs on a slope, their page and their answer: all tests look at the same.
fn sloped() -> &'static (Bench, String, Value) {
    static BENCH: OnceLock<(Bench, String, Value)> = OnceLock::new();
    BENCH.get_or_init(|| {
        let bench = Bench::new();
        let clean: Vec<String> = (1..=6).map(|k| format!("base_{k}.csv")).collect();
        for (k, name) in clean.iter().enumerate() {
            simulate(&bench, name, k, &(k + 1).to_string(), 100 + k, &[]);
        }
        let clean: Vec<&str> = clean.iter().map(String::as_str).collect();
        bench.done(&[&["fit", "--out", "base.toml"], &clean[..]].concat());
        let mut field: Vec<String> = (1..=MASSES.len()).map(|k| format!("field_{k}.csv")).collect();
        // The fifth of eight masses is in the middle of its three: this run stays locked, and is
        // drawn over time.
        field[4] = NASTY.to_owned();
        for (k, name) in field.iter().enumerate() {
            simulate(&bench, name, k, MASSES[k], 200 + k, &["--effect", "grade=0.02:along=travel"]);
        }
        let field: Vec<&str> = field.iter().map(String::as_str).collect();
        let line = ["gap", "--coeffs", "base.toml", "--report", "page.html"];
        let report = bench.json(&[&line[..], &field].concat());
        let page = bench.text("page.html");
        if let Some(kept) = std::env::var_os("GMR_KEEP_FIGURES") {
            std::fs::write(Path::new(&kept).with_extension("html"), &page).unwrap();
        }
        (bench, page, report)
    })
}

fn parsed(page: &str) -> Document<'_> {
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    Document::parse_with_options(page, options).unwrap()
}

fn all<'a>(page: &'a Document<'_>, name: &'static str) -> impl Iterator<Item = Node<'a, 'a>> {
    page.descendants().filter(move |node| node.has_tag_name(name))
}

fn text(node: Node<'_, '_>) -> String {
    node.descendants().filter_map(|node| node.text().filter(|_| node.is_text())).collect()
}

#[test]
fn the_page_is_well_formed_and_says_what_the_json_says() {
    let (_, page, report) = sloped();
    assert_eq!(report["verdict"], "named", "{report:#}");
    let page = parsed(page);
    let verdict = all(&page, "h1").next().unwrap();
    assert_eq!(verdict.attribute("data-verdict"), Some("named"));
    assert!(text(verdict).contains("lacks grade"), "{}", text(verdict));
    let whole = text(page.root());
    let [before, floor] = ["gap_before_w", "noise_floor_w"].map(|key| number(&report[key]));
    for said in [
        "the road slopes: gravity pulls along the way".to_owned(),
        format!("{before:.3} W"),
        format!("{floor:.4} W"),
        "compute-load".to_owned(),
        "needs cpu_percent".to_owned(),
        "winding_loss".to_owned(),
        "base.toml".to_owned(),
        env!("CARGO_PKG_VERSION").to_owned(),
        report["noise_floor_how"].as_str().unwrap().to_owned(),
    ] {
        assert!(whole.contains(&said), "{said}");
    }
}

/// One `<svg>` a figure, each with a name, a description and something drawn.
#[test]
fn every_plot_is_there_and_described() {
    let (_, page, report) = sloped();
    let page = parsed(page);
    let figures: Vec<_> = all(&page, "figure").collect();
    assert_eq!(all(&page, "svg").count(), figures.len());
    let mut titles = Vec::new();
    for figure in figures {
        let drawings: Vec<_> = figure.children().filter(|node| node.has_tag_name("svg")).collect();
        let [drawing] = drawings[..] else { panic!("{} drawings in a figure", drawings.len()) };
        assert_eq!(drawing.attribute("role"), Some("img"));
        let label = drawing.attribute("aria-label").unwrap();
        let title = text(drawing.first_element_child().unwrap());
        assert!(label.starts_with(&title) && label.len() > title.len() + 10, "{label}");
        let shapes = ["rect", "polyline", "line", "circle", "polygon"];
        assert!(drawing.descendants().filter(|node| shapes.contains(&node.tag_name().name())).count() > 8);
        titles.push(title);
    }
    let locked = report["confirm_runs"].as_array().unwrap().len();
    assert_eq!(titles.iter().filter(|title| title.starts_with("Power over time")).count(), locked);
    for title in [
        "Gap on the locked runs",
        "Residual map, before",
        "Residual map, after",
        "Residual by speed",
        "Residual by acceleration",
        "Residual by turn rate",
        "Residual by mass",
        "Residual by time",
        "Residual by side",
        "Residual by heading",
        "Round 1: what each candidate explains",
    ] {
        assert!(titles.iter().any(|drawn| drawn == title), "{title}: {titles:?}");
    }
}

#[test]
fn nothing_is_fetched_and_nothing_of_a_file_is_markup() {
    let (_, page, report) = sloped();
    for outside in ["http:", "https:", "<script", "<link", "@import", "url(", "<b>"] {
        assert!(!page.contains(outside), "{outside}");
    }
    assert!(report["confirm_runs"].as_array().unwrap().iter().any(|run| run == NASTY));
    let page = parsed(page);
    assert!(all(&page, "svg").any(|drawing| text(drawing).contains(NASTY)));
}

/// Cells hold runs, before and after.
#[test]
fn localisation_names_every_axis_before_and_after() {
    let (_, _, report) = sloped();
    let cells = report["localisation"].as_array().unwrap();
    for axis in ["speed", "acceleration", "turn-rate", "mass", "time", "side", "heading", "standing"] {
        assert!(cells.iter().any(|cell| cell["axis"] == axis), "{axis}");
    }
    for cell in cells {
        assert_eq!(
            keys(cell),
            [
                "axis",
                "from",
                "to",
                "mean_residual_w",
                "band_w",
                "mean_after_w",
                "band_after_w",
                "runs",
                "words"
            ]
        );
        assert!(number(&cell["runs"]) >= 3.0 && number(&cell["band_w"]) >= 0.0, "{cell}");
    }
    // Fast and ahead is where a slope costs most, and it is gone afterwards.
    let fast = |key: &str| {
        let speeds = cells.iter().filter(|cell| cell["axis"] == "speed");
        number(&speeds.max_by(|a, b| number(&a["to"]).total_cmp(&number(&b["to"]))).unwrap()[key])
    };
    assert!(fast("mean_residual_w") > fast("band_w"), "{cells:?}");
    assert!(fast("mean_after_w").abs() < 0.1 * fast("mean_residual_w"), "{cells:?}");
}

/// The text fits on a screen of 24 lines and 96 columns, and the page can be had with it.
#[test]
fn the_summary_fits_on_a_screen() {
    let (bench, _, _) = sloped();
    let ran = bench.done(&[
        "gap",
        "--coeffs",
        "base.toml",
        "field_1.csv",
        "field_2.csv",
        "field_3.csv",
        "field_4.csv",
    ]);
    assert!(ran.stdout.lines().count() <= 23, "{}", ran.stdout);
    assert!(ran.stdout.lines().all(|line| line.chars().count() <= 96), "{}", ran.stdout);
    assert!(ran.stdout.contains("noise floor") && ran.stdout.contains("Next: "), "{}", ran.stdout);
    assert!(ran.stderr.lines().all(|line| line.starts_with("gmr: ")), "no bar where there is no terminal");
}

#[test]
fn a_page_that_cannot_be_written_is_refused_before_the_work() {
    let bench = Bench::new();
    let files = bench.files();
    let pdf = bench.gmr(&["gap", "--report", "page.pdf", "no-such-log.csv"]);
    assert_eq!((pdf.code, &*pdf.stderr), (Some(2), "gmr: page.pdf: reports are written as .html\n"));
    let nowhere = bench.gmr(&["gap", "--report", "nowhere/page.html", "no-such-log.csv"]);
    assert_eq!(nowhere.code, Some(1));
    assert_eq!(
        nowhere.stderr,
        "gmr: nowhere/page.html: the folder nowhere does not exist; expected one to write into\n"
    );
    assert_eq!(bench.files(), files);
}

/// Counts what a browser shows: drawings that take up room, and the verdict in letters of some
/// height.
const PROBE: &str = "<script>
addEventListener('load', () => {
  const shown = [...document.querySelectorAll('figure svg')].filter(svg => {
    const box = svg.getBoundingClientRect();
    return box.width > 200 && box.height > 100;
  });
  const verdict = document.getElementById('verdict');
  document.body.setAttribute('data-plots', shown.length);
  document.body.setAttribute('data-height', Math.round(verdict.getBoundingClientRect().height));
  document.body.setAttribute('data-wide', document.documentElement.scrollWidth > innerWidth);
});
</script></body>";

/// In a window as wide as a laptop's and in one as wide as a phone's.
#[test]
fn a_browser_shows_the_plots_and_the_verdict() {
    let (bench, page, _) = sloped();
    let Some(browser) = Browser::find() else { return };
    bench.put("probed.html", page.replace("</body>", PROBE));
    let plots = all(&parsed(page), "figure").count();
    for width in [1280, 500] {
        let dom = browser.show(&bench.path("probed.html"), width);
        assert!(dom.contains(&format!("data-plots=\"{plots}\"")), "{dom}");
        assert!(dom.contains("data-wide=\"false\""), "wider than the window of {width}");
        let height = dom.split("data-height=\"").nth(1).and_then(|rest| rest.split('"').next()).unwrap();
        assert!(height.parse::<u32>().unwrap() > 20, "{height}");
    }
}
