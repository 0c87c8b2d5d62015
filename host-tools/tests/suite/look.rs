//! `gmr look`: logs at a glance, without a robot.toml.

use std::path::Path;

use serde_json::Value;

use crate::common::browser::Browser;
use crate::common::{Bench, near};

fn copy(bench: &Bench, name: &str) -> String {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("formats/tests/data").join(name);
    bench.put(name, std::fs::read(from).unwrap());
    name.to_owned()
}

fn look(bench: &Bench, log: &str) -> Value {
    bench.json(&["look", log])
}

/// Summed here from the rows that the bag was made of: its odometry is v = r (w1 + w2) / 2, its
/// power comes with every row.
#[test]
fn energy_and_way_are_those_of_the_drive() {
    let bench = Bench::new();
    let log = copy(&bench, "odometry.mcap");
    copy(&bench, "drive.csv");
    let drive = bench.text("drive.csv");
    let rows: Vec<Vec<f64>> = drive
        .lines()
        .skip(1)
        .take(400)
        .map(|line| line.split(',').map(|field| field.parse().unwrap()).collect())
        .collect();
    let (mut way, mut energy) = (0.0, 0.0);
    for row in &rows[1..] {
        way += 0.05 * (0.033 * 0.5 * (row[1] + row[2])).abs();
        energy += 0.05 * row[3];
    }
    let report = look(&bench, &log);
    near(&report["distance_m"], way, 1e-9);
    // Power bears no stamp: it comes 20 ms behind the odometry's, and the first row is before it.
    near(&report["energy_j"], energy, 0.02);
    assert_eq!(report["rows"], 400);
    assert_eq!(report["longest_gap_s"], 0.0);
    let cells = report["power_over_speed"].as_array().unwrap();
    assert!(cells.len() >= 2, "{cells:?}");
}

/// Each robot's bag, and what would make more of it.
#[test]
fn the_cheapest_sensor_is_named() {
    let bench = Bench::new();
    let next = |log: &str| look(&bench, &copy(&bench, log))["next"].as_str().unwrap().to_owned();
    assert!(
        next("turtlebot3.mcap").starts_with("one INA219 in the motors' wire"),
        "{}",
        next("turtlebot3.mcap")
    );
    assert!(next("clearpath.mcap").starts_with("no sensor: a second log with the full payload"));
    assert!(next("husarion.db3").starts_with("no sensor: a second log with the full payload"));
    assert!(next("odometry.mcap").starts_with("no sensor: a second log with the full payload"));
    assert!(next("drive.parquet").starts_with("nothing"));
    let turtle = look(&bench, "turtlebot3.mcap");
    assert!(turtle["energy_j"].is_null() && turtle["charge"]["drawn_ah"].is_null());
    near(&turtle["charge"]["first"], 0.9, 1e-6);
    assert!(turtle["impossible"][0].as_str().unwrap().contains("current is 0 in every message"));
}

/// Self-contained, well-formed, and in the colours and width of whoever looks.
#[test]
fn the_page_stands_alone() {
    let bench = Bench::new();
    let log = copy(&bench, "clearpath.mcap");
    let ran = bench.gmr(&["look", &log, "--page", "look.html"]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert!(ran.stdout.contains("It can tell") && ran.stdout.contains("W in motion"), "{}", ran.stdout);
    let page = bench.text("look.html");
    let body = page.strip_prefix("<!DOCTYPE html>\n").unwrap();
    let read = roxmltree::Document::parse(body).unwrap();
    assert!(read.descendants().filter(|node| node.has_tag_name("figure")).count() >= 2);
    // What it runs it brings; without scripts the drawings stay.
    let of_name = |name: &'static str| read.descendants().filter(move |node| node.has_tag_name(name));
    assert!(of_name("script").all(|script| script.attribute("src").is_none()));
    assert!(of_name("link").count() == 0 && !page.contains("@import") && !page.contains("url("));
    for figure in of_name("figure") {
        let numbers =
            figure.descendants().find(|node| node.attribute("type") == Some("application/json")).unwrap();
        let numbers: Value = serde_json::from_str(numbers.text().unwrap()).unwrap();
        let length = numbers["x"].as_array().unwrap().len();
        assert!(length > 2 && numbers["curves"][0]["y"].as_array().unwrap().len() == length);
        assert!(figure.children().any(|node| node.has_tag_name("svg")));
    }
    assert!(page.contains("width=device-width") && page.contains("light dark"));
    // Its own page is written over, a log is not.
    assert_eq!(bench.gmr(&["look", &log, "--page", "look.html"]).code, Some(0));
    assert_eq!(bench.gmr(&["look", &log, "--page", &log]).code, Some(2));
}

/// Zooms the first plot as a mouse does, and writes down what was to be seen before and after.
const PROBE: &str = "<script>
addEventListener('load', () => {
  const plot = document.querySelector('figure').plot;
  const [over, body] = [plot.over, document.body];
  const place = over.getBoundingClientRect();
  const seen = () => plot.scales.x.max - plot.scales.x.min;
  const mouse = (kind, share) => over.dispatchEvent(new MouseEvent(kind, {
    bubbles: true, button: 0, movementX: 9, clientX: place.left + share * place.width, clientY: place.top + 50,
  }));
  setTimeout(() => {
    const all = seen();
    mouse('mouseenter', 0.25); mouse('mousemove', 0.25); mouse('mousedown', 0.25); mouse('mousemove', 0.75); mouse('mouseup', 0.75);
    setTimeout(() => {
      body.setAttribute('data-share', Math.round(100 * seen() / all));
      mouse('dblclick', 0.5);
      setTimeout(() => {
        body.setAttribute('data-again', Math.round(100 * seen() / all));
        body.setAttribute('data-plots', document.querySelectorAll('figure canvas').length);
        body.setAttribute('data-wide', document.documentElement.scrollWidth > innerWidth);
      }, 100);
    }, 100);
  }, 100);
});
</script></body>";

/// Half of the plot, dragged over, is half of the time; twice there, and all of it is back. On a
/// laptop and on a phone.
#[test]
fn a_browser_zooms_the_plots() {
    let Some(browser) = Browser::find() else { return };
    let bench = Bench::new();
    let log = copy(&bench, "clearpath.mcap");
    bench.done(&["look", &log, "--page", "look.html"]);
    let page = bench.text("look.html");
    let plots = page.matches("application/json").count();
    assert!(plots >= 2);
    // The last one: uPlot's text has one as well.
    let end = page.rfind("</body>").unwrap();
    bench.put("probed.html", format!("{}{PROBE}{}", &page[..end], &page[end + "</body>".len()..]));
    for width in [1280, 500] {
        let dom = browser.show(&bench.path("probed.html"), width);
        let of = |name: &str| {
            let value = dom.split(&format!("data-{name}=\"")).nth(1).and_then(|rest| rest.split('"').next());
            value.map(str::to_owned).unwrap_or_default()
        };
        assert_eq!((of("plots"), of("wide")), (plots.to_string(), "false".to_owned()), "{width}");
        let share: f64 = of("share").parse().unwrap();
        assert!((share - 50.0).abs() <= 2.0, "{share} at {width}");
        assert_eq!(of("again"), "100", "{width}");
    }
}

/// The folder that ROS 2's recorder leaves is its file.
#[test]
fn a_folder_of_a_bag_is_looked_at_as_its_file() {
    let bench = Bench::new();
    std::fs::create_dir(bench.path("bag")).unwrap();
    let file = copy(&bench, "clearpath.mcap");
    std::fs::copy(bench.path(&file), bench.path("bag/bag_0.mcap")).unwrap();
    bench
        .put("bag/metadata.yaml", "rosbag2_bagfile_information:\n  relative_file_paths:\n    - bag_0.mcap\n");
    let (mut whole, mut folder) = (look(&bench, &file), look(&bench, "bag"));
    for answer in [&mut whole, &mut folder] {
        answer.as_object_mut().unwrap().retain(|key, _| key != "log" && key != "file" && key != "bytes");
    }
    assert_eq!(whole, folder);
    bench.done(&["convert", "--robot", "husky", "bag", "--out", "rows.csv"]);
    assert!(bench.text("rows.csv").lines().count() > 100);
    let ran = bench.gmr(&["look", "."]);
    assert!(ran.code == Some(1) && ran.stderr.contains("metadata.yaml"), "{}", ran.stderr);
}
