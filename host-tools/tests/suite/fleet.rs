//! `gmr fleet`: who changed since when, what is left out, and that whoever is killed goes on.

use std::time::Duration;

use assert_cmd::cargo::CommandCargoExt as _;
use serde_json::Value;

use crate::common::Bench;

const ROBOTS: [&str; 4] = ["a", "b", "c", "d"];
const DAYS: [&str; 4] = ["2026-11-02", "2026-11-03", "2026-11-04", "2026-11-05"];
const FLEET: [&str; 6] = ["fleet", "logs", "--coeffs", "c.toml", "--out", "out"];

/// Four robots on four days, two runs of 40 s each, at payloads that change from run to run. From
/// the third day on the right wheel of c drags.
fn fleet(days: usize) -> Bench {
    let bench = Bench::new();
    bench.simulate("empty.csv", &["--duration", "60", "--rate", "20", "--mass", "1", "--seed", "901"]);
    bench.simulate("full.csv", &["--duration", "60", "--rate", "20", "--mass", "6", "--seed", "902"]);
    bench.done(&["fit", "--out", "c.toml", "empty.csv", "full.csv"]);
    for (r, robot) in ROBOTS.iter().enumerate() {
        for (d, day) in DAYS.iter().take(days).enumerate() {
            let folder = format!("logs/robot={robot}/day={day}");
            std::fs::create_dir_all(bench.path(&folder)).unwrap();
            for run in 0..2 {
                let number = 8 * r + 2 * d + run;
                let (seed, mass) = (number.to_string(), (1 + number % 5).to_string());
                let out = format!("{folder}/{run}.csv");
                let mut rest = vec!["--duration", "40", "--rate", "20", "--seed", &seed, "--mass", &mass];
                rest.extend(["--columns", "command"]);
                if *robot == "c" && d >= 2 {
                    rest.extend(["--effect", "wheel-drag=0.02"]);
                }
                bench.simulate(&out, &rest);
            }
        }
    }
    bench
}

fn notes<'a>(report: &'a Value, run: &str) -> (&'a Value, String) {
    let runs = report["runs"].as_array().unwrap();
    let judged = runs.iter().find(|one| one["run"] == run).unwrap_or_else(|| panic!("no {run}: {runs:?}"));
    (&judged["is_used"], judged["notes"].to_string())
}

#[test]
fn the_robot_that_changed_is_named_with_its_day_and_no_other() {
    let bench = fleet(4);
    // A log is a log, whatever it is kept in.
    let kept = "logs/robot=b/day=2026-11-02/1";
    let (csv, parquet) = (format!("{kept}.csv"), format!("{kept}.parquet"));
    bench.done(&["convert", &csv, "--out", &parquet]);
    std::fs::remove_file(bench.path(&csv)).unwrap();
    let all = [&FLEET[..], &["--export", "rmf", "--metrics", "fleet.prom"]].concat();
    let report = bench.json(&all);
    let (is_used, said) = notes(&report, "robot=b/day=2026-11-02/1.parquet");
    assert!(is_used == true, "{said}");
    let changes = report["changes"].as_array().unwrap();
    println!("{changes:?}");
    assert_eq!(changes.len(), 1, "{changes:?}");
    let change = &changes[0];
    assert_eq!((&change["robot"], &change["since"]), (&Value::from("c"), &Value::from(DAYS[2])), "{change}");
    let named = format!("{} {}", change["coefficient"], change["or_coefficients"]);
    assert!(named.contains("coulomb"), "{change}");
    assert_eq!(report["robots"].as_array().unwrap().len(), 4);
    let page = bench.text("out/fleet.html");
    assert!(page.contains("since 2026-11-04"));
    let finding = report["finding"].as_str().unwrap();
    assert!(
        finding.starts_with("robot c draws ") && finding.contains("more than the fleet's median"),
        "{finding}"
    );
    assert!(finding.ends_with("; it changed on 2026-11-04"), "{finding}");
    assert!(page.contains("<title>gmr fleet: robot c draws "), "{finding}");

    // A file a robot for Open-RMF, and of the next time how far it is from the last.
    let friction = |report: &Value, key: &str| {
        let exported = report["exported"].as_array().unwrap();
        exported.iter().map(|one| (one["robot"].to_string(), one[key].as_f64())).collect::<Vec<_>>()
    };
    let first = friction(&report, "friction_coefficient");
    assert!(first.len() == 4 && friction(&report, "before").iter().all(|(_, before)| before.is_none()));
    let greatest = first.iter().max_by(|a, b| a.1.partial_cmp(&b.1).unwrap()).unwrap();
    assert_eq!(greatest.0, "\"c\"", "{first:?}");
    let yaml = bench.text("out/rmf/c.yaml");
    assert!(
        yaml.contains("# c: from a fit, at ") && yaml.contains("\n  mechanical_system:\n    mass: "),
        "{yaml}"
    );
    let before = friction(&bench.json(&all), "before");
    for ((_, written), (robot, before)) in first.iter().zip(&before) {
        assert!((written.unwrap() - before.unwrap()).abs() <= 5e-6, "{robot}: as written to five digits");
    }
    bench.put("out/rmf/c.yaml", yaml.replace("friction_coefficient: ", "friction_coefficient: 0.5  # "));
    let said = bench.done(&all).stdout;
    assert!(said.starts_with("robot c draws ") && said.contains(", was 0.50000 when last written"), "{said}");

    // A line a robot and figure, for Prometheus.
    let metrics = bench.text("fleet.prom");
    let lines = |robot: &str| {
        metrics.lines().filter(|line| line.contains(&format!("{{robot=\"{robot}\"}} "))).count()
    };
    assert_eq!(ROBOTS.map(lines), [8; 4], "{metrics}");
    assert!(metrics.contains("gmr_robot_has_changed{robot=\"c\"} 1.0\n"), "{metrics}");
    assert!(metrics.contains("# TYPE gmr_robot_straight_watts gauge\n"), "{metrics}");

    // Runs that are not what they should be are said each, and the rest goes on with the same
    // answer.
    let log = |name: &str| format!("logs/robot={name}");
    let text = bench.text(&(log("a") + "/day=2026-11-02/0.csv"));
    let put = |name: &str, text: &str| bench.put(&(log("a") + "/day=2026-11-02/" + name), text);
    put("cut.csv", text.trim_end());
    let mut lines: Vec<&str> = text.lines().collect();
    lines.swap(100, 200);
    put("jumps.csv", &(lines.join("\n") + "\n"));
    let scaled = |line: &str| {
        let fields = line.split(',').enumerate().map(|(place, field)| match field.parse::<f64>() {
            Ok(speed) if place == 1 || place == 2 => (1.2 * speed).to_string(),
            _ => field.to_owned(),
        });
        fields.collect::<Vec<_>>().join(",")
    };
    put("radius.csv", &(text.lines().map(scaled).collect::<Vec<_>>().join("\n") + "\n"));
    // From row 300 on the clock is 5 s ahead.
    let ahead = |(place, line): (usize, &str)| {
        let (time, rest) = line.split_once(',').unwrap();
        let late = time.parse::<f64>().ok().filter(|_| place >= 300).map(|time| time + 5.0);
        format!("{},{rest}", late.map_or(time.to_owned(), |late| late.to_string()))
    };
    put("ahead.csv", &(text.lines().enumerate().map(ahead).collect::<Vec<_>>().join("\n") + "\n"));
    let whole = std::fs::read(bench.path(&parquet)).unwrap();
    std::fs::write(bench.path(&(log("a") + "/day=2026-11-02/cut.parquet")), &whole[..whole.len() / 2])
        .unwrap();
    // A link whose end is not there yet: nothing that the log itself is to be blamed for.
    let late = log("a") + "/day=2026-11-02/late.csv";
    std::os::unix::fs::symlink(bench.path("late.csv"), bench.path(&late)).unwrap();
    bench.simulate(
        &(log("b") + "/day=2026-11-02/stands.csv"),
        &["--duration", "40", "--rate", "20", "--profile", "standstill"],
    );
    let again = bench.json(&FLEET);
    assert_eq!(again["changes"][0]["robot"], "c");
    assert_eq!(again["changes"].as_array().unwrap().len(), 1, "{}", again["changes"]);
    let a = "robot=a/day=2026-11-02/";
    let (is_used, said) = notes(&again, &format!("{a}cut.csv"));
    assert!(*is_used == true && said.contains("the file was cut there"), "{said}");
    let (is_used, said) = notes(&again, &format!("{a}jumps.csv"));
    assert!(*is_used == false && said.contains("expected time to increase"), "{said}");
    let (is_used, said) = notes(&again, &format!("{a}radius.csv"));
    assert!(*is_used == false && said.contains("of another radius"), "{said}");
    let (is_used, said) = notes(&again, "robot=b/day=2026-11-02/stands.csv");
    assert!(*is_used == false && said.contains("does not move"), "{said}");
    let (is_used, said) = notes(&again, &format!("{a}ahead.csv"));
    assert!(*is_used == true && said.contains("its clock jumps ahead 1 times"), "{said}");
    let (is_used, said) = notes(&again, &format!("{a}cut.parquet"));
    assert!(*is_used == false && said.contains("is cut off or damaged"), "{said}");
    let (is_used, said) = notes(&again, &format!("{a}late.csv"));
    assert!(*is_used == false && said.contains("the next run tries again"), "{said}");
    bench.put("late.csv", &text);
    let third = bench.json(&FLEET);
    let (is_used, said) = notes(&third, &format!("{a}late.csv"));
    assert!(*is_used == true, "{said}");
}

/// Ten times, at ten moments; then to the end: the bytes of a run that nobody disturbed.
#[test]
fn killed_and_resumed_it_writes_the_same() {
    let bench = fleet(2);
    bench.done(&FLEET);
    let outputs = ["grams.jsonl", "fleet.html", "fleet.json"];
    let undisturbed = outputs.map(|name| bench.text(&format!("out/{name}")));
    std::fs::remove_dir_all(bench.path("out")).unwrap();
    let mut killed = 0;
    for moment in 0..10 {
        let mut child = std::process::Command::cargo_bin("gmr")
            .unwrap()
            .args(FLEET)
            .current_dir(bench.path(""))
            .stdout(std::process::Stdio::null())
            .stderr(std::process::Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(2 + 3 * moment));
        child.kill().unwrap();
        killed += u32::from(!child.wait().unwrap().success());
    }
    assert!(killed > 0, "every run was over before it was killed");
    bench.done(&FLEET);
    assert!(outputs.map(|name| bench.text(&format!("out/{name}"))) == undisturbed);

    // A second run reads no log: they may be anything of the same size and ends.
    let before = std::fs::metadata(bench.path("out/read")).unwrap().modified().unwrap();
    bench.done(&FLEET);
    assert_eq!(std::fs::metadata(bench.path("out/read")).unwrap().modified().unwrap(), before);
}

/// A folder's name is text of somebody's: on the page it is shown, and acts on no terminal.
#[test]
fn names_do_nothing_on_the_page() {
    let bench = fleet(1);
    let strange = format!("logs/robot=a\u{1b}[31m\u{202e}<b>/day={}", DAYS[0]);
    std::fs::create_dir_all(bench.path(&strange)).unwrap();
    std::fs::copy(bench.path("empty.csv"), bench.path(&format!("{strange}/0.csv"))).unwrap();
    bench.done(&FLEET);
    let page = bench.text("out/fleet.html");
    assert!(page.contains("a\\u001b[31m\\u202e&lt;b&gt;"), "the name is there");
    assert!(!page.contains('\u{1b}') && !page.contains('\u{202e}'));
}
