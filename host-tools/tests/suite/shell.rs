//! What a shell wants of a command: completions, man pages, examples, robot.toml made and found.

use std::fmt::Write as _;
use std::path::Path;

use crate::common::{Bench, ROBOT, drive};

/// Commands in the order of `gmr --help`.
pub(crate) fn commands(help: &str) -> Vec<&str> {
    help.lines()
        .skip_while(|line| !line.starts_with("Commands:"))
        .skip(1)
        .take_while(|line| line.starts_with("  "))
        .filter_map(|line| line.strip_prefix("  ").filter(|line| !line.starts_with(' ')))
        .filter_map(|line| line.split_whitespace().next())
        .filter(|name| *name != "help")
        .collect()
}

/// docs/commands.md is what each command's `--help` prints.
#[test]
fn the_page_of_commands_is_what_they_say() {
    let bench = Bench::new();
    let help = bench.done(&["--help"]).stdout;
    let mut page = "# Commands\n\nThis page is what `gmr COMMAND --help` prints.\n".to_owned();
    for name in commands(&help) {
        let said = bench.done(&[name, "--help"]).stdout;
        let said: Vec<&str> = said.lines().map(str::trim_end).collect();
        let _ = write!(page, "\n## gmr {name}\n\n```text\n{}\n```\n", said.join("\n"));
    }
    let committed = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/commands.md");
    if std::env::var_os("GMR_BLESS").is_some() {
        std::fs::write(&committed, &page).unwrap();
    }
    let old = std::fs::read_to_string(&committed).unwrap_or_default();
    assert!(old == page, "docs/commands.md is out of date: GMR_BLESS=1 writes it anew");
}

#[test]
fn completions_and_pages_know_every_command() {
    let bench = Bench::new();
    let help = bench.done(&["--help"]).stdout;
    let commands = commands(&help);
    assert!(commands.len() > 15, "{commands:?}");
    bench.done(&["man", "--out", "."]);
    for shell in ["bash", "zsh", "fish"] {
        let script = bench.done(&["completions", shell]).stdout;
        for command in &commands {
            assert!(script.contains(command), "{shell}: {command}");
        }
    }
    for command in &commands {
        let page = bench.text(&format!("gmr-{command}.1"));
        assert!(page.contains(".TH gmr-"), "{command}");
    }
    assert!(bench.done(&["man"]).stdout.contains(".TH gmr"));
    bench.done(&["man", "--out", "new/pages"]);
    assert!(bench.text("new/pages/gmr-fit.1").contains(".TH gmr-fit"));
    assert_eq!(bench.gmr(&["man", "--out", "gmr-fit.1/pages"]).code, Some(1));
}

/// Every help ends with a line that can be typed; none has colours where nobody can see them.
#[test]
fn every_help_has_an_example() {
    let bench = Bench::new();
    let names = [
        "look",
        "inspect",
        "convert",
        "simulate",
        "fit",
        "gram",
        "fleet",
        "estimate",
        "predict",
        "export",
        "compare",
        "gap",
        "gap-bench",
        "reproduce",
        "record",
        "flash",
        "watch",
        "node",
        "new-robot",
        "completions",
        "man",
    ];
    for name in names {
        let help = bench.done(&[name, "--help"]).stdout;
        assert!(help.contains(&format!("\n  gmr {name}")), "{name}: {help}");
        assert!(!help.contains('\u{1b}'), "{name}");
    }
}

#[test]
fn a_new_robot_is_one_that_commands_take() {
    let bench = Bench::new();
    let flags = [
        "new-robot",
        "--name",
        "My \"robot\"",
        "--kinematics",
        "differential",
        "--wheel-radius",
        "0.033",
        "--track",
        "0.16",
        "--empty",
        "1",
        "--full",
        "6",
        "--capacity",
        "1.8",
        "--cells",
        "3",
    ];
    bench.done(&flags);
    bench.put("log.csv", drive(20.0, 50.0, |_| 2.0));
    let ran = bench.done(&["inspect", "--robot", "robot.toml", "log.csv"]);
    assert!(!ran.stdout.is_empty());
    // What is there is left alone; nobody is asked where nobody can answer; nonsense is refused
    // before it is written.
    assert_eq!(bench.gmr(&flags).code, Some(1));
    let ran = bench.gmr(&["new-robot", "--name", "x", "--out", "other.toml"]);
    assert!(ran.code == Some(2) && ran.stderr.contains("--kinematics is missing"), "{}", ran.stderr);
    let mut wrong = flags.to_vec();
    wrong[8] = "-0.16";
    let ran = bench.gmr(&[&wrong[..], &["--out", "other.toml"]].concat());
    assert!(ran.code != Some(0) && !bench.path("other.toml").exists(), "{}", ran.stderr);

    // Lengths and masses take units, and make the same robot.
    let with = |changed: &[(&str, &str)]| {
        let mut flags = flags.map(str::to_owned).to_vec();
        for (flag, value) in changed {
            let at = flags.iter().position(|given| given == flag).unwrap();
            flags[at + 1] = (*value).to_owned();
        }
        let given: Vec<&str> = flags.iter().map(String::as_str).chain(["--out", "units.toml"]).collect();
        bench.gmr(&given)
    };
    for (radius, empty) in [("33 mm", "1000 g"), ("33mm", "1kg"), ("3.3 cm", "1"), ("0.033 m", "1 kg")] {
        assert_eq!(with(&[("--wheel-radius", radius), ("--empty", empty)]).code, Some(0), "{radius}");
        assert_eq!(bench.text("units.toml"), bench.text("robot.toml"), "{radius}, {empty}");
        std::fs::remove_file(bench.path("units.toml")).unwrap();
    }
    for wrong in ["33 kg", "-1", "", "mm", "nan", "1 2"] {
        assert_eq!(with(&[("--wheel-radius", wrong)]).code, Some(2), "{wrong}");
    }
}

/// From the folder of the logs upwards; said, and given up where --robot says another.
#[test]
fn robot_toml_is_found_upward() {
    let bench = Bench::new();
    bench.put("robot.toml", ROBOT.replace("name = \"exact\"", "name = \"found\""));
    std::fs::create_dir_all(bench.path("logs/monday")).unwrap();
    bench.put("logs/monday/log.csv", drive(20.0, 50.0, |_| 2.0));
    let gmr = |arguments: &[&str]| {
        let mut command = assert_cmd::Command::cargo_bin("gmr").unwrap();
        let output = command.current_dir(bench.path("logs/monday")).args(arguments).output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let (code, said) = gmr(&["inspect", "log.csv"]);
    assert!(code == Some(0) && said.contains("the robot is that of"), "{said}");
    let (code, said) = gmr(&["inspect", "--robot", "burger", "log.csv"]);
    assert!(code == Some(0) && !said.contains("the robot is that of"), "{said}");
}
