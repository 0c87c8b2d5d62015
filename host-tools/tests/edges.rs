//! The edges of every command: an output that is also an input is refused, names cannot act on a terminal, pipes are read once, and
//! nothing is read without bound.

mod common;

use std::fs::File;
use std::io::Write as _;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::thread;

use common::{Bench, ROBOT, drive};

/// Robot, log and coefficients.
fn bench() -> Bench {
    let bench = Bench::new();
    bench.put("robot.toml", ROBOT);
    bench.put("good.csv", drive(40.0, 100.0, |time| if time < 20.0 { 1.0 } else { 6.0 }));
    bench.done(&["fit", "--robot", "robot.toml", "--out", "c.toml", "good.csv"]);
    bench
}

/// The one line that a refused command says; every file is as it was.
fn refusal(bench: &Bench, arguments: &[&str], code: i32) -> String {
    let content = |name: &String| std::fs::read(bench.path(name)).ok();
    let before: Vec<_> = bench.files().iter().map(|name| (name.clone(), content(name))).collect();
    let ran = bench.gmr(arguments);
    assert_eq!(ran.code, Some(code), "{arguments:?}: {}", ran.stderr);
    assert_eq!(ran.stdout, "", "{arguments:?}");
    assert_eq!(ran.stderr.lines().count(), 1, "{arguments:?}: {}", ran.stderr);
    let after: Vec<_> = bench.files().iter().map(|name| (name.clone(), content(name))).collect();
    assert!(before == after, "{arguments:?} changed a file");
    ran.stderr.trim_end().strip_prefix("gmr: ").unwrap().to_owned()
}

/// By whatever name: its own, a hard link's, a symbolic link's.
#[test]
fn an_output_that_is_an_input_is_refused() {
    let bench = bench();
    std::fs::hard_link(bench.path("good.csv"), bench.path("hard.svg")).unwrap();
    symlink("c.toml", bench.path("soft.toml")).unwrap();
    symlink("c.toml", bench.path("soft.bin")).unwrap();
    let cases: [(&[&str], &str, &str); 9] = [
        (&["fit", "--robot", "robot.toml", "--out", "good.csv", "good.csv"], "good.csv", "good.csv"),
        (&["fit", "--robot", "robot.toml", "--out", "robot.toml", "good.csv"], "robot.toml", "robot.toml"),
        (&["fit", "--robot", "robot.toml", "--out", "hard.svg", "good.csv"], "hard.svg", "good.csv"),
        (
            &["estimate", "--robot", "robot.toml", "--coeffs", "c.toml", "--plot", "hard.svg", "good.csv"],
            "hard.svg",
            "good.csv",
        ),
        (&["inspect", "--robot", "robot.toml", "--plot", "hard.svg", "good.csv"], "hard.svg", "good.csv"),
        (
            &["compare", "--robot", "robot.toml", "--plot", "hard.svg", "--train", "good.csv"],
            "hard.svg",
            "good.csv",
        ),
        (
            &["gap", "--robot", "robot.toml", "--coeffs", "c.toml", "--out", "soft.toml", "field.csv"],
            "soft.toml",
            "c.toml",
        ),
        (
            &["flash", "--robot", "robot.toml", "--coeffs", "c.toml", "--out", "soft.bin"],
            "soft.bin",
            "c.toml",
        ),
        (&["simulate", "--profile", "good.csv", "--out", "good.csv"], "good.csv", "good.csv"),
    ];
    // A log of the field, of which only the first row matters here.
    bench.put("field.csv", drive(40.0, 100.0, |_| 3.0));
    for (arguments, output, input) in cases {
        let expected =
            format!("{output}: is to be written, but read as well, as {input}; expected another file");
        assert_eq!(refusal(&bench, arguments, 2), expected);
    }
    let twice = ["--out", "new.html", "--report", "new.html", "field.csv"];
    let gap = ["gap", "--robot", "robot.toml", "--coeffs", "c.toml"];
    let found = refusal(&bench, &[&gap[..], &twice].concat(), 2);
    assert!(found.starts_with("new.html: is to be written twice"), "{found}");
    // What is read through one name may be written to another.
    bench.done(&["fit", "--robot", "robot.toml", "--out", "new.toml", "good.csv"]);
}

/// A link that leads nowhere yet stays one; links in a circle are refused.
#[test]
fn a_link_stays_a_link() {
    let bench = bench();
    symlink("there.toml", bench.path("dangling.toml")).unwrap();
    bench.done(&["fit", "--robot", "robot.toml", "--out", "dangling.toml", "good.csv"]);
    assert!(bench.path("dangling.toml").is_symlink() && !bench.path("there.toml").is_symlink());
    assert_eq!(bench.text("there.toml"), bench.text("c.toml"));
    symlink("b.toml", bench.path("a.toml")).unwrap();
    symlink("a.toml", bench.path("b.toml")).unwrap();
    let found = refusal(&bench, &["fit", "--robot", "robot.toml", "--out", "a.toml", "good.csv"], 1);
    assert!(found.starts_with("a.toml: "), "{found}");
    assert!(bench.path("a.toml").is_symlink() && bench.path("b.toml").is_symlink());
}

/// What a terminal would act on, as it may stand in a file.
const WILD: &str = "\u{1b}]0;title\u{7}\u{1b}[2Jx\u{9b}2J\u{202e}y";

fn assert_printable(text: &str) {
    let harmful = |c: char| c != '\n' && (c.is_control() || ('\u{202a}'..='\u{202e}').contains(&c));
    assert!(!text.chars().any(harmful), "{text:?}");
}

#[test]
fn names_cannot_act_on_a_terminal() {
    let bench = bench();
    let escaped = WILD.chars().map(|c| format!("\\u{:04x}", u32::from(c))).collect::<String>();
    bench.put("wild.toml", ROBOT.replace("\"exact\"", &format!("\"{escaped}\\ngmr: forged\"")));
    let ran = bench.done(&["fit", "--robot", "wild.toml", "good.csv"]);
    assert_printable(&ran.stdout);
    assert!(ran.stdout.starts_with("\\u001b]0;title\\u0007") && !ran.stdout.contains("\ngmr: forged"));
    let json = bench.done(&["fit", "--robot", "wild.toml", "--json", "good.csv"]);
    assert_printable(&json.stdout);
    assert!(serde_json::from_str::<serde_json::Value>(&json.stdout).is_ok(), "{}", json.stdout);
    // Unknown keys, headers, file names, effects of the user's own.
    bench.put("key.toml", format!("\"{escaped}\" = 1\n{ROBOT}"));
    assert_printable(&bench.done(&["fit", "--robot", "key.toml", "good.csv"]).stderr);
    bench.put("head.csv", format!("time_s,{WILD}\n1,2\n3,4\n"));
    let found = refusal(&bench, &["fit", "--robot", "robot.toml", "head.csv"], 1);
    assert_printable(&found);
    let name = "wild\u{1b}[2J\ngmr: forged.csv";
    bench.put(name, "time_s\n1\n2\n");
    let found = refusal(&bench, &["fit", "--robot", "robot.toml", name], 1);
    assert!(found.starts_with("wild\\u001b[2J\\u000agmr: forged.csv:"), "{found}");
}

/// A line on standard error ends, however long what it quotes.
#[test]
fn lines_on_standard_error_are_short() {
    let bench = bench();
    let columns: String = (0..100_000).map(|k| format!(",column_{k}")).collect();
    bench.put("wide.csv", format!("time_s{columns}\n1\n2\n"));
    let found = refusal(&bench, &["fit", "--robot", "robot.toml", "wide.csv"], 1);
    assert!(found.chars().count() <= 4010 && found.ends_with('…'), "{} characters", found.len());
    let keys: String = (0..20_000).map(|k| format!("key_{k} = 1\n")).collect();
    bench.put("keys.toml", keys + ROBOT);
    let ran = bench.done(&["fit", "--robot", "keys.toml", "good.csv"]);
    assert_eq!(ran.stderr.lines().count(), 11, "{}", ran.stderr);
    assert!(ran.stderr.ends_with("and 19990 more unknown keys\n"), "{}", ran.stderr);
}

fn pipe(path: &Path, content: String) -> thread::JoinHandle<()> {
    use rustix::fs::{CWD, FileType, Mode, mknodat};
    mknodat(CWD, path, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
    let path = path.to_owned();
    thread::spawn(move || File::create(path).unwrap().write_all(content.as_bytes()).unwrap())
}

/// A log through a pipe, of which nobody can read the start again, gives what the file gives.
#[test]
fn pipes_are_read_once() {
    let bench = bench();
    let log = bench.text("good.csv");
    let commands: [&[&str]; 4] = [
        &["fit", "--robot", "robot.toml", "--json"],
        &["estimate", "--robot", "robot.toml", "--coeffs", "c.toml", "--json"],
        &["inspect", "--robot", "robot.toml", "--json"],
        &["compare", "--robot", "robot.toml", "--no-perceptron", "--json", "--train"],
    ];
    for (place, command) in commands.into_iter().enumerate() {
        let name = format!("pipe_{place}");
        let writer = pipe(&bench.path(&name), log.clone());
        let piped = bench.done(&[command, &[&name]].concat()).stdout;
        writer.join().unwrap();
        let direct = bench.done(&[command, &["good.csv"]].concat()).stdout;
        let figures = |text: &str, file: &str| -> String {
            // Times of the solver differ, and so does the file's name.
            let lines = text.lines().filter(|line| !line.contains("_s\":"));
            lines.collect::<String>().replace(file, "log")
        };
        assert_eq!(figures(&piped, &name), figures(&direct, "good.csv"), "{command:?}");
    }
}

#[test]
fn what_never_ends_is_refused() {
    let bench = bench();
    for arguments in [
        &["fit", "--robot", "/dev/zero", "good.csv"][..],
        &["estimate", "--robot", "robot.toml", "--coeffs", "/dev/zero", "good.csv"],
        &["gap", "--robot", "robot.toml", "--coeffs", "c.toml", "--effects", "/dev/zero", "good.csv"],
    ] {
        let found = refusal(&bench, arguments, 1);
        assert!(found.starts_with("/dev/zero: is longer than 8388608 bytes"), "{found}");
    }
    let found = refusal(&bench, &["fit", "--robot", "robot.toml", "/dev/zero"], 1);
    assert!(found.starts_with("/dev/zero:1: no line end within"), "{found}");
}
