//! Mistakes of somebody's first hour: each ends in one line that names the remedy, and none writes
//! a file.

use crate::common::{Bench, HEADER, ROBOT, drive, excerpt, fitted};

/// A log of the drive with another power, and without its masses.
fn with_power(log: &str, power: impl Fn(f64) -> f64) -> String {
    let mut text = "time_s,wheel1_rad_s,wheel2_rad_s,power_w\n".to_owned();
    for line in log.lines().skip(1) {
        let mut fields: Vec<String> = line.split(',').take(4).map(str::to_owned).collect();
        fields[3] = power(fields[3].parse().unwrap()).to_string();
        text += &(fields.join(",") + "\n");
    }
    text
}

/// The drive of [`drive`] with ten seconds of standing before it.
fn standing_first(mass: f64) -> String {
    let mut text = HEADER.to_owned();
    for row in 0..1000 {
        text += &format!("{:.4},0,0,0,{mass}\n", f64::from(row) * 0.01);
    }
    for line in drive(60.0, 100.0, |_| mass).lines().skip(1) {
        let (time, rest) = line.split_once(',').unwrap();
        text += &format!("{:.4},{rest}\n", time.parse::<f64>().unwrap() + 10.0);
    }
    text
}

/// Logs of all the mistakes, and coefficients that somebody forced.
fn bench() -> Bench {
    let bench = fitted();
    bench.put("burger.toml", ROBOT.replace("exact", "Burger of somebody"));
    for (mass, name) in [(1.0, "empty"), (6.0, "full")] {
        let log = standing_first(mass);
        bench.put(&format!("{name}.csv"), &log);
        bench.put(&format!("bare_{name}.csv"), with_power(&log, |power| power));
        // 6.4 W of computer and lidar; 60 times what driving takes.
        bench.put(&format!("total_{name}.csv"), with_power(&log, |power| power + 6.4));
        bench.put(&format!("negative_{name}.csv"), with_power(&log, |power| -power));
    }
    bench.put("again.csv", bench.text("empty.csv"));
    bench.put("milli.csv", with_power(&bench.text("empty.csv"), |power| 1e3 * power));
    bench.put("watts.csv", bench.text("empty.csv").replacen("power_w", "motor_watts", 1));
    bench.put("left.csv", bench.text("empty.csv").replacen("wheel1_rad_s", "left_wheel_speed", 1));
    bench.put("semicolons.csv", bench.text("empty.csv").replace(',', ";"));
    bench.put("void.csv", "");
    bench.put(
        "still.csv",
        (0..2000)
            .fold(HEADER.to_owned(), |text, row| text + &format!("{:.2},0,0,0,1\n", f64::from(row) * 0.01)),
    );
    for bag in ["positive.mcap", "two.mcap"] {
        bench.put(bag, std::fs::read(excerpt("turtlebot3-bags").join(bag)).unwrap());
    }
    bench.put("plan.csv", "distance_m,speed_m_s\n5,0.15\n");
    let total = ["total_empty.csv=1", "total_full.csv=6", "--force", "--out", "forced.toml"];
    let forced = bench.done(&[&["fit", "--robot", "robot.toml"], &total[..]].concat());
    assert!(
        forced.stdout.starts_with("NOT USABLE (total_empty.csv: power_w is total power"),
        "{}",
        forced.stdout
    );
    bench
}

/// The command, its exit code, and what its one line says.
const MISTAKES: [(&str, i32, &str); 26] = [
    // Power.
    ("fit total_empty.csv=1 total_full.csv=6 --out new.toml", 1, "add static_power_w = 6.40 to robot.toml"),
    ("fit negative_empty.csv=1 negative_full.csv=6 --out new.toml", 1, "read it with --flip-power"),
    ("estimate --coeffs forced.toml empty.csv", 1, "NOT USABLE (total_empty.csv: power_w is total"),
    (
        "predict --coeffs forced.toml --plan plan.csv --mass 1",
        1,
        "NOT USABLE (total_empty.csv: power_w is total",
    ),
    ("export mjcf --coeffs forced.toml --out new.xml", 1, "NOT USABLE (total_empty.csv: power_w is total"),
    (
        "flash --robot robot.toml --coeffs forced.toml --out new.bin",
        1,
        "NOT USABLE (total_empty.csv: power_w is total",
    ),
    ("gap --coeffs forced.toml empty.csv", 1, "NOT USABLE (total_empty.csv: power_w is total"),
    // Masses.
    ("fit bare_empty.csv bare_full.csv --out new.toml", 2, "bare_empty.csv=KG bare_full.csv=KG"),
    ("compare --train bare_empty.csv bare_full.csv --plot new.svg", 2, "bare_empty.csv=KG bare_full.csv=KG"),
    ("fit bare_empty.csv=0 bare_full.csv=6 --out new.toml", 2, "expected a total mass above 0 kg"),
    ("fit empty.csv again.csv --out new.toml", 2, "the same log as empty.csv; expected every run once"),
    ("inspect empty.csv again.csv", 2, "the same log as empty.csv; expected every run once"),
    ("convert bare_empty.csv=1 bare_full.csv --out new.csv", 2, "expected bare_full.csv=KG"),
    // Columns and files.
    ("fit watts.csv --out new.toml", 1, "perhaps motor_watts: rename it to power_w"),
    ("inspect left.csv --plot new.svg", 1, "perhaps left_wheel_speed: rename it to wheel1_rad_s"),
    ("fit semicolons.csv --out new.toml", 1, "expected commas between fields"),
    ("fit void.csv --out new.toml", 1, "is empty; expected a run log"),
    ("fit still.csv --out new.toml", 1, "the robot never moves"),
    ("inspect empty.csv full.csv --plot new.svg", 2, "expected one"),
    ("look empty.csv full.csv --page new.html", 2, "expected one"),
    (
        "fit two.mcap=1 --out new.toml",
        1,
        "has several topics with the wheels' joints: /joint_states, /other/joint_states",
    ),
    ("fit positive.mcap=1 --out new.toml", 1, "read it with --flip-power"),
    // Robots.
    ("inspect --robot burgr empty.csv", 2, "husky or the path of a robot.toml (gmr new-robot writes one)"),
    ("fit --robot lost.toml empty.csv", 1, "expected a robot.toml (gmr new-robot writes one)"),
    ("estimate --robot husky --coeffs c.toml empty.csv", 1, "these coefficients are for another robot"),
    ("new-robot --name R --kinematics differential --wheel-radius 33kg --out new.toml", 2, "mm, cm, m, in"),
];

#[test]
fn mistakes_of_a_first_hour_end_in_one_line_with_the_remedy() {
    let bench = bench();
    let files = bench.files();
    for (command, code, remedy) in MISTAKES {
        let ran = bench.gmr(&command.split(' ').collect::<Vec<_>>());
        assert_eq!(ran.code, Some(code), "{command}: {}{}", ran.stdout, ran.stderr);
        assert!(ran.stderr.contains(remedy), "{command}: {}", ran.stderr);
        assert_eq!((ran.stderr.lines().count(), &*ran.stdout), (1, ""), "{command}: {}", ran.stderr);
        assert_eq!(bench.files(), files, "{command}");
    }
}

/// What `inspect` calls ready is not refused by `fit`, and the other way round.
#[test]
fn inspect_says_first_what_a_fit_would_refuse() {
    let bench = bench();
    for (logs, remedy) in [
        ("total_empty.csv=1 total_full.csv=6", "Add static_power_w = 6.40 to robot.toml"),
        ("negative_empty.csv=1 negative_full.csv=6", "Read it with --flip-power"),
        ("milli.csv=1", "Read it with --power-unit mW"),
    ] {
        for log in logs.split(' ') {
            let ran = bench.done(&["inspect", log]);
            let first = ran.stdout.lines().next().unwrap();
            assert!(first.contains("NOT READY: ") && first.contains(remedy), "{first}");
        }
    }
    let both = bench.done(&["inspect", "bare_empty.csv=1", "bare_full.csv=6"]);
    let first = both.stdout.lines().next().unwrap();
    assert_eq!(first, "READY for gmr fit: 2 runs at 1, 6 kg; for gmr gap record 4 more clean runs");
    // The remedies are ones.
    let flipped = "fit --flip-power negative_empty.csv=1 negative_full.csv=6 --out new.toml";
    let ran = bench.done(&flipped.split(' ').collect::<Vec<_>>());
    assert!(ran.stdout.starts_with("Usable: explains 9"), "{}", ran.stdout);
    assert!(ran.stdout.lines().next().unwrap().contains(" of the power at 1 and 6 kg (error "));
    bench.put("total.toml", format!("{ROBOT}static_power_w = 6.4\n"));
    let total = "fit --robot total.toml total_empty.csv=1 total_full.csv=6";
    assert!(bench.done(&total.split(' ').collect::<Vec<_>>()).stdout.starts_with("Usable: "));
    let look = bench.done(&["look", "negative_full.csv"]).stdout;
    assert!(look.lines().next().unwrap().ends_with("Read it with --flip-power"), "{look}");
    // A battery under a name of its own is known by its type.
    let look = bench.done(&["look", "positive.mcap"]).stdout;
    assert!(look.lines().next().unwrap().ends_with("Read it with --flip-power"), "{look}");
    let look = bench.done(&["look", "--flip-power", "positive.mcap"]).stdout;
    assert!(look.lines().next().unwrap().contains(" W driving, 6.4"), "{look}");
    let look = bench.done(&["look", "total_full.csv"]).stdout;
    assert!(look.lines().next().unwrap().ends_with(" W driving, 6.40 W standing"), "{look}");
}

/// Masses behind the names are those of columns, in the coefficients as well.
#[test]
fn masses_behind_names_are_those_of_columns() {
    let bench = bench();
    let fit = |logs: [&str; 2], out: &str| bench.json(&["fit", logs[0], logs[1], "--out", out]);
    let named = fit(["bare_empty.csv=1", "bare_full.csv=6"], "named.toml");
    let told = fit(["empty.csv", "full.csv"], "told.toml");
    assert_eq!(named["masses_kg"], serde_json::json!([1.0, 6.0]));
    assert_eq!((&named["parameters"], &named["verdict"]), (&told["parameters"], &"usable".into()));
    let text = bench.text("named.toml");
    assert!(text.contains("weighed_kg = [1.0, 6.0]") && text.contains("verdict = \"usable\""), "{text}");
    assert!(!bench.text("told.toml").contains("weighed_kg"));
    // A file of that very name wins.
    bench.put("bare_full.csv=6", bench.text("full.csv"));
    assert_eq!(fit(["empty.csv", "bare_full.csv=6"], "odd.toml")["parameters"], told["parameters"]);
}

/// What was fitted without a verdict goes on being read, and R² decides.
#[test]
fn coefficients_without_a_verdict_are_read_by_their_r2() {
    let bench = bench();
    let old = |file: &str| {
        let text = bench.text(file);
        text.lines()
            .filter(|line| !line.starts_with("verdict") && !line.starts_with("why_not"))
            .map(|line| format!("{line}\n"))
            .collect::<String>()
    };
    bench.put("old.toml", old("c.toml"));
    bench.put("old_forced.toml", old("forced.toml"));
    bench.done(&["estimate", "--coeffs", "old.toml", "log.csv"]);
    let refused = bench.gmr(&["estimate", "--coeffs", "old_forced.toml", "log.csv"]);
    assert_eq!(refused.code, Some(1));
    assert!(refused.stderr.contains(":r2: NOT USABLE (R² −"), "{}", refused.stderr);
    // Whoever insists has it, and is told.
    let forced = bench.done(&["estimate", "--force", "--coeffs", "forced.toml", "log.csv"]);
    assert!(forced.stderr.contains("and used because of --force"), "{}", forced.stderr);
}

/// What is there, what is missing, and one command to go on with.
#[test]
fn the_doctor_says_what_comes_next() {
    let bench = Bench::new();
    let next = || bench.json(&["doctor"])["next"].as_str().unwrap().to_owned();
    let state = |what: &str| {
        let report = bench.json(&["doctor"]);
        let checks = report["checks"].as_array().unwrap();
        checks.iter().find(|check| check["what"] == what).unwrap()["state"].clone()
    };
    assert_eq!(next(), "gmr demo, or record a drive into this folder");
    bench.put("log.csv", drive(120.0, 100.0, |time| if time < 60.0 { 1.0 } else { 6.0 }));
    assert_eq!((next(), state("robot.toml")), ("gmr new-robot".to_owned(), "missing".into()));
    bench.put("robot.toml", ROBOT);
    assert_eq!((next(), state("coefficients")), ("gmr inspect log.csv".to_owned(), "missing".into()));
    bench.done(&["fit", "--out", "coefficients.toml", "log.csv"]);
    assert_eq!(next(), "gmr estimate --coeffs coefficients.toml log.csv");
    bench.put("robot.toml", "name = 1\n");
    assert_eq!((next(), state("robot.toml")), ("mend robot.toml".to_owned(), "wrong".into()));
    let text = bench.done(&["doctor"]).stdout;
    assert!(text.starts_with("Next: mend robot.toml\n"), "{text}");
}

/// The main job without a robot, without a question: a payload, a named effect, one page.
#[test]
fn the_demo_ends_with_a_page() {
    let bench = Bench::new();
    let ran = bench.done(&["demo", "--no-open"]);
    let mut lines = ran.stdout.lines();
    for begin in
        ["READY for gmr fit: 6 runs at 1, 6 kg and gmr gap", "Usable: explains 99.", "Payload 3.0", "NAMED: "]
    {
        let line = lines.next().unwrap();
        assert!(line.starts_with(begin), "{line}");
    }
    assert_eq!(lines.next(), Some("open gmr-demo/index.html"));
    let page = bench.text("gmr-demo/index.html");
    let read = roxmltree::Document::parse(page.strip_prefix("<!DOCTYPE html>\n").unwrap()).unwrap();
    assert_eq!(read.descendants().filter(|node| node.has_tag_name("pre")).count(), 5);
    assert!(page.contains("the model lacks grade") && page.contains("<svg"), "{page}");
    // Once more over its own, and not over what is somebody's.
    bench.done(&["demo", "--no-open"]);
    bench.put("gmr-demo/index.html", "mine");
    assert_eq!(bench.gmr(&["demo", "--no-open"]).code, Some(1));
}
