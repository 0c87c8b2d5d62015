//! Logs that are not what their columns say: named by `inspect`, refused by what computes from
//! them, read rightly with the remedy; and right logs, of which nothing is said.

use fit::entrance;
use logs::robot::Robot;

use crate::common::{Bench, excerpt};
use serde_json::Value;
use support::context::Context;

/// A log as columns.
struct Log {
    header: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Log {
    fn of(text: &str) -> Self {
        let mut lines = text.lines();
        let header = lines.next().unwrap().split(',').map(str::to_owned).collect();
        let rows = lines.map(|line| line.split(',').map(|field| field.parse().unwrap_or(f64::NAN)).collect());
        Self { header, rows: rows.collect() }
    }

    fn place(&self, name: &str) -> usize {
        self.header.iter().position(|column| column == name).unwrap()
    }

    /// One column, changed; the last argument is the row's number.
    fn with(&self, names: &[&str], change: impl Fn(f64, usize) -> f64) -> String {
        let places: Vec<usize> = names.iter().map(|name| self.place(name)).collect();
        let mut text = self.header.join(",") + "\n";
        for (number, row) in self.rows.iter().enumerate() {
            let value = |(place, value): (usize, &f64)| {
                let value = if places.contains(&place) { change(*value, number) } else { *value };
                if value.is_nan() { String::new() } else { value.to_string() }
            };
            text += &row.iter().enumerate().map(value).collect::<Vec<_>>().join(",");
            text.push('\n');
        }
        text
    }
}

const SPEEDS: [&str; 2] = ["wheel1_rad_s", "wheel2_rad_s"];
const POWER: [&str; 1] = ["power_w"];
const MASS: [&str; 1] = ["mass_kg"];

/// A log, made wrong in every way, with the kind of what is to be said and the words that name the
/// remedy.
fn wrong(log: &Log, radius: f64) -> Vec<(&'static str, String, &'static str)> {
    let high = log.rows.iter().map(|row| row[log.place("power_w")]).fold(0.0, f64::max);
    // A second later, by the median step.
    let late = (1.0 / (log.rows[11][0] - log.rows[10][0])).round() as usize;
    let power: Vec<f64> = log.rows.iter().map(|row| row[log.place("power_w")]).collect();
    vec![
        ("rpm", log.with(&SPEEDS, |w, _| w * 60.0 / std::f64::consts::TAU), "--speed-unit rpm"),
        ("m/s", log.with(&SPEEDS, |w, _| w * radius), "--speed-unit m/s"),
        ("mW", log.with(&POWER, |p, _| p * 1e3), "--power-unit mW"),
        ("kW", log.with(&POWER, |p, _| p * 1e-3), "--power-unit kW"),
        ("grams", log.with(&MASS, |m, _| m * 1e3), "--mass-unit g"),
        ("doubled", log.with(&MASS, |m, _| m * 2.0), "twice what it can be"),
        (
            "unlabelled",
            log.with(&MASS, |m, row| if row % 2 == 0 { m } else { f64::NAN }),
            "mass_kg is empty in",
        ),
        ("flipped", log.with(&SPEEDS[1..], |w, _| -w), "--flip-wheel 2"),
        ("clipped", log.with(&POWER, |p, _| p.min(0.4 * high)), "the sensor is clipped"),
        (
            "late",
            log.with(&POWER, |_, row| power[row.saturating_sub(late)]),
            "later than the speeds that explain it",
        ),
    ]
}

fn findings(bench: &Bench, robot: &str, log: &str, further: &[&str]) -> (String, Value) {
    let report = bench.json(&[&["inspect", "--robot", robot, log], further].concat());
    let findings = report["findings"].as_array().unwrap().iter();
    let findings = findings.filter(|finding| finding["severity"] != "note");
    let text = |finding: &Value| {
        format!("{}; {}", finding["text"].as_str().unwrap(), finding["advice"].as_str().unwrap())
    };
    (findings.map(text).collect::<Vec<_>>().join("\n"), report)
}

/// Every wrong log is named, and what names a remedy is cured by it.
fn assert_named(bench: &Bench, robot: &str, log: &Log, radius: f64) {
    bench.put("right.csv", log.with(&[], |value, _| value));
    let (said, right) = findings(bench, robot, "right.csv", &[]);
    assert!(!said.contains("--"), "{said}");
    let known = Robot::load(&Context::default(), robot).unwrap();
    for (name, text, expected) in wrong(log, radius) {
        bench.put("wrong.csv", text);
        let (said, report) = findings(bench, robot, "wrong.csv", &[]);
        assert!(said.contains(expected), "{robot} {name}: {said}");
        let warned = entrance::look(&Context::default(), &known, &[bench.path("wrong.csv")], 1.0).unwrap();
        let warned: String = warned.into_iter().map(|warning| warning.text).collect();
        assert!(warned.contains(expected), "{robot} {name}, as fit sees it: {warned}");
        if let Some(remedy) = expected.strip_prefix("--") {
            // A Husky's slow drives in m/s may be those of a robot with stiff gears.
            let may_be_right = said.contains("may be m/s");
            assert_eq!(may_be_right, (robot, name) == ("husky", "m/s"), "{robot} {name}: {said}");
            assert_eq!(report["fit_for"] == "nothing", !may_be_right, "{robot} {name}: {report}");
            let (flag, value) = remedy.split_once(' ').unwrap();
            let (said, cured) = findings(bench, robot, "wrong.csv", &[&format!("--{flag}"), value]);
            assert!(!said.contains("--"), "{robot} {name}, cured: {said}");
            assert_eq!(cured["fit_for"], right["fit_for"], "{robot} {name}: {said}");
        }
    }
}

#[test]
fn a_burger_s_wrong_logs_are_named() {
    let bench = Bench::new();
    let fixed = ["--rate", "50", "--sensors", "servo", "--duration", "100", "--mass", "1@0,6@50"];
    bench.simulate("log.csv", &fixed);
    assert_named(&bench, "burger", &Log::of(&bench.text("log.csv")), 0.033);
}

/// Its log has no masses: it is given some.
#[test]
fn a_husky_s_wrong_logs_are_named() {
    let bench = Bench::new();
    let text = std::fs::read_to_string(excerpt("husky-currents/flooring_07.csv")).unwrap();
    let keep = |line: &str| line.split(',').take(4).map(str::to_owned).collect::<Vec<_>>().join(",");
    let mut lines = text.lines();
    let mut log = keep(lines.next().unwrap()) + ",mass_kg\n";
    for line in lines {
        log += &format!("{},75\n", keep(line));
    }
    assert_named(&bench, "husky", &Log::of(&log), 0.165);
}

/// What `fit` and `inspect` suspect of a log, of all kinds that are about units, signs, clocks and
/// sensors.
fn suspicions(bench: &Bench, robot: &str, log: &str) -> Vec<String> {
    let (said, _) = findings(bench, robot, log, &[]);
    let words = [
        "--speed-unit",
        "--power-unit",
        "--mass-unit",
        "--flip-wheel",
        "clipped",
        "than the speeds",
        "mass_kg is",
    ];
    said.lines().filter(|line| words.iter().any(|word| line.contains(word))).map(str::to_owned).collect()
}

/// All kinds of drives of simulated robots, and measured ones: none is suspected.
#[test]
fn right_logs_are_not_suspected() {
    let bench = Bench::new();
    let mut judged = 0;
    let omni = "name = \"omni\"\nkinematics = \"omni3\"\nwheel_radius_m = 0.033\narm_m = 0.08\nmass_no_load_kg = 1\nmass_full_load_kg = 6\n";
    let mecanum = "name = \"mecanum\"\nkinematics = \"mecanum\"\nwheel_radius_m = 0.033\nhalf_length_m = 0.08\nhalf_width_m = 0.08\n\
                   mass_no_load_kg = 1\nmass_full_load_kg = 6\n";
    let skid = "name = \"skid\"\nkinematics = \"skid-steer\"\nwheels = 4\nwheel_radius_m = 0.033\ntrack_m = 0.16\nmass_no_load_kg = 1\n\
                mass_full_load_kg = 6\n";
    let total = "name = \"total\"\nkinematics = \"differential\"\nwheel_radius_m = 0.033\ntrack_m = 0.16\nmass_no_load_kg = 1\n\
                 mass_full_load_kg = 6\nstatic_power_w = 6.4\n";
    for (name, text) in
        [("omni.toml", omni), ("mecanum.toml", mecanum), ("skid.toml", skid), ("total.toml", total)]
    {
        bench.put(name, text);
    }
    let drives: [&[&str]; 9] = [
        &["--mass", "1@0,6@30"],
        &["--profile", "test", "--mass", "3"],
        &["--profile", "constant", "--mass", "6"],
        &["--profile", "constant", "--speed", "0.02", "--mass", "3"],
        &["--profile", "constant", "--speed", "0", "--turn", "1", "--mass", "1"],
        &["--profile", "constant", "--speed", "0.1", "--turn", "-0.5", "--mass", "1"],
        &["--sensors", "paper20", "--rate", "20", "--mass", "2@0,4@30"],
        &["--sensors", "servo", "--rate", "50", "--mass", "1.5", "--power-autocorrelation", "0.5"],
        &["--sensors", "exact", "--rate", "10", "--mass", "5", "--effect", "grade=0.05"],
    ];
    let robots: [(&str, &[&str]); 6] = [
        ("burger", &[]),
        ("burger", &["--plant", "table3"]),
        ("burger", &["--plant", "gearmotor"]),
        ("omni.toml", &["--kinematics", "omni"]),
        ("mecanum.toml", &["--kinematics", "mecanum"]),
        ("skid.toml", &["--kinematics", "skid"]),
    ];
    let mut judge = |robot: &str, log: &str, what: &str| {
        let said = suspicions(&bench, robot, log);
        assert!(said.is_empty(), "{robot} {what}: {said:?}");
        judged += 1;
    };
    for (robot, plant) in robots {
        for (seed, drive) in drives.iter().enumerate() {
            let seed = seed.to_string();
            let fixed = ["--rate", "50", "--duration", "60", "--seed", &seed];
            let rate = if drive.contains(&"--rate") { &fixed[2..] } else { &fixed[..] };
            bench.simulate("log.csv", &[plant, rate, drive].concat());
            judge(robot, "log.csv", &format!("{plant:?} {drive:?}"));
        }
    }
    bench.simulate("log.csv", &["--rate", "50", "--duration", "60", "--mass", "2", "--static-power", "6.4"]);
    judge("total.toml", "log.csv", "total power");
    for (robot, folder) in [("husky", "husky-currents"), ("warthog", "warthog"), ("burger", "turtlebot3")] {
        for entry in std::fs::read_dir(excerpt(folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|extension| extension == "csv") {
                judge(robot, path.to_str().unwrap(), "measured");
            }
        }
    }
    assert!(judged >= 60, "{judged} logs");
}

/// Zeros, other units and negative power are refused by all that computes from them, and nothing is
/// written; a right log with the wrong unit given is, too. Whoever knows better says `--force`.
#[test]
fn what_a_log_cannot_be_is_refused_wherever_it_is_used() {
    let bench = Bench::new();
    bench.simulate("log.csv", &["--rate", "50", "--duration", "60", "--mass", "1@0,6@30"]);
    bench.gmr(&["fit", "--out", "right.toml", "log.csv"]);
    let log = Log::of(&bench.text("log.csv"));
    for (text, said) in [
        (log.with(&POWER, |_, _| 0.0), "power_w is 0 while the robot drives"),
        (log.with(&POWER, |power, _| -power), "--flip-power"),
        (log.with(&POWER, |power, _| 1e3 * power), "--power-unit mW"),
        (log.with(&SPEEDS, |speed, _| speed * 60.0 / std::f64::consts::TAU), "--speed-unit rpm"),
    ] {
        bench.put("wrong.csv", text);
        for command in [
            &["fit", "--out", "written"][..],
            &["gap", "--coeffs", "right.toml", "--report", "written.html"],
            &["estimate", "--coeffs", "right.toml", "--plot", "written.svg"],
        ] {
            let refused = bench.gmr(&[command, &["wrong.csv"]].concat());
            let (code, stdout, stderr) = (refused.code, refused.stdout.as_str(), &refused.stderr);
            assert_eq!((code, stdout), (Some(1), ""), "{command:?} {said}");
            assert!(stderr.contains(said) && stderr.contains("wrong.csv"), "{command:?} {said}: {stderr}");
            assert_eq!(stderr.lines().count(), 1, "{stderr}");
        }
        for file in ["written", "written.html", "written.svg"] {
            assert!(!bench.path(file).exists(), "{said}: {file}");
        }
    }
    let forced = bench.gmr(&["estimate", "--coeffs", "right.toml", "--force", "wrong.csv"]);
    assert_eq!(forced.code, Some(0), "{}", forced.stderr);
    assert!(forced.stderr.contains("--speed-unit rpm"), "{}", forced.stderr);
    // One wheel's sign is less sure: no model is fitted to it, and others say it.
    bench.put("turned.csv", log.with(&SPEEDS[1..], |speed, _| -speed));
    let refused = bench.gmr(&["fit", "turned.csv"]);
    assert!(refused.code == Some(1) && refused.stderr.contains("--flip-wheel 2"), "{}", refused.stderr);
    let told = bench.done(&["estimate", "--coeffs", "right.toml", "turned.csv"]);
    assert!(told.stderr.contains("--flip-wheel 2"), "{}", told.stderr);
    let refused = bench.gmr(&["fit", "--power-unit", "kW", "log.csv"]);
    assert_eq!(refused.code, Some(1), "{}", refused.stderr);
    assert!(refused.stderr.contains("power_w looks like mW"), "{}", refused.stderr);
    let refused = bench.gmr(&["inspect", "--flip-wheel", "3", "log.csv"]);
    assert_eq!(refused.code, Some(2), "{}", refused.stderr);
}

/// With its unit given, a log gives what it gives in SI.
#[test]
fn units_are_taken_off_by_every_command() {
    let bench = Bench::new();
    bench.simulate(
        "log.csv",
        &["--rate", "50", "--sensors", "servo", "--duration", "60", "--mass", "1@0,6@30"],
    );
    let log = Log::of(&bench.text("log.csv"));
    let rpm = Log::of(&log.with(&SPEEDS, |w, _| w * 60.0 / std::f64::consts::TAU));
    let milli = Log::of(&rpm.with(&POWER, |p, _| p * 1e3));
    bench.put("other.csv", milli.with(&MASS, |m, _| m * 1e3));
    let units = ["--speed-unit", "rpm", "--power-unit", "mW", "--mass-unit", "g"];
    let close = |ours: &Value, other: &Value| {
        let (ours, other) = (ours.as_f64().unwrap(), other.as_f64().unwrap());
        assert!((ours - other).abs() <= 1e-6 * ours.abs(), "{ours} {other}");
    };
    let fit = bench.json(&["fit", "--out", "c.toml", "log.csv"]);
    close(&fit["r2"], &bench.json(&[&["fit", "other.csv"], &units[..]].concat())["r2"]);
    for command in [
        &["estimate", "--coeffs", "c.toml", "--window", "10"][..],
        &["compare", "--models", "signed", "--window", "10", "--train"],
    ] {
        let ours = bench.json(&[command, &["log.csv"]].concat());
        let other = bench.json(&[command, &["other.csv"], &units].concat());
        let r2 = |report: &Value| {
            if report["r2"].is_null() { report["models"][0]["r2"].clone() } else { report["r2"].clone() }
        };
        close(&r2(&ours), &r2(&other));
    }
}

/// A wheel's sensor that keeps its value, and a power sensor that does: named by `fit`, which sees
/// rows only.
#[test]
fn a_fit_names_sensors_that_stand_still() {
    let bench = Bench::new();
    let simulated = ["--rate", "50", "--sensors", "servo", "--duration", "60", "--mass", "1@0,6@30"];
    bench.simulate("right.csv", &simulated);
    let text = bench.text("right.csv");
    let right = bench.gmr(&["fit", "right.csv"]);
    assert!(!right.stderr.contains("stays at"), "{}", right.stderr);
    let header: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    for column in ["wheel1_rad_s", "power_w"] {
        let place = header.iter().position(|name| *name == column).unwrap();
        let kept = text.lines().nth(1200).unwrap().split(',').nth(place).unwrap();
        let lines = text.lines().enumerate().map(|(row, line)| {
            let fields = line.split(',').enumerate();
            let fields = fields.map(|(at, field)| if at == place && row > 1200 { kept } else { field });
            fields.collect::<Vec<_>>().join(",") + "\n"
        });
        bench.put("stuck.csv", lines.collect::<String>());
        let ran = bench.gmr(&["fit", "stuck.csv"]);
        assert!(
            ran.stderr.contains(&format!("{column} stays at {}", kept.parse::<f64>().unwrap())),
            "{}",
            ran.stderr
        );
    }
}

/// A register of coarse steps at 20 Hz, one wheel of which goes to and fro between two of its steps
/// while the other keeps one: both are held at a speed, and no sensor is stuck. It is where the
/// second wheel leaves for good.
#[test]
fn a_register_of_coarse_steps_does_not_stand_still() {
    let bench = Bench::new();
    let step = 0.024;
    let log = |second: fn(usize) -> f64| {
        let row = |row: usize| {
            let held = (row.min(100) as f64).floor();
            let other = if row < 100 { held } else { 100.0 + second(row) };
            format!(
                "{:.2},{:.3},{:.3},{:.3},2\n",
                0.05 * row as f64,
                step * held,
                step * other,
                0.4 + 0.01 * held
            )
        };
        let rows: String = (0..400).map(row).collect();
        "time_s,wheel1_rad_s,wheel2_rad_s,power_w,mass_kg\n".to_owned() + &rows
    };
    let said = |second: fn(usize) -> f64| {
        bench.put("register.csv", log(second));
        bench.gmr(&["inspect", "register.csv"]).stdout.matches("wheel1_rad_s stays at").count()
    };
    assert_eq!(said(|row| (row / 3 % 2) as f64), 0);
    assert_eq!(said(|row| 10.0 * (row as f64 / 20.0).sin()), 1);
}
