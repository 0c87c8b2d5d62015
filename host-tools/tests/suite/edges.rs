//! The edges of every command: an output that is also an input is refused, names cannot act on a
//! terminal, pipes are read once, and nothing is read without bound.

use std::fs::File;
use std::io::Write as _;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::sync::LazyLock;
use std::thread;
use std::time::{Duration, Instant};

use crate::common::{Bench, HEADER, ROBOT, drive, number};

/// Robot, log and coefficients; fitted once for all tests.
fn bench() -> Bench {
    static COEFFICIENTS: LazyLock<String> = LazyLock::new(|| {
        let bench = beside();
        bench.done(&["fit", "--robot", "robot.toml", "--out", "c.toml", "good.csv"]);
        bench.text("c.toml")
    });
    let bench = beside();
    bench.put("c.toml", &*COEFFICIENTS);
    bench
}

/// What coefficients are fitted to.
fn beside() -> Bench {
    let bench = Bench::new();
    bench.put("robot.toml", ROBOT);
    bench.put("good.csv", drive(40.0, 100.0, |time| if time < 20.0 { 1.0 } else { 6.0 }));
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
    let said = refusal(&bench, &[&gap[..], &twice].concat(), 2);
    assert!(said.starts_with("new.html: is to be written twice"), "{said}");
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
    let said = refusal(&bench, &["fit", "--robot", "robot.toml", "--out", "a.toml", "good.csv"], 1);
    assert!(said.starts_with("a.toml: "), "{said}");
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
    let ran = bench.done(&["fit", "--verbose", "--robot", "wild.toml", "good.csv"]);
    assert_printable(&ran.stdout);
    assert!(ran.stdout.contains("\n\\u001b]0;title\\u0007") && !ran.stdout.contains("\ngmr: forged"));
    let json = bench.done(&["fit", "--robot", "wild.toml", "--json", "good.csv"]);
    assert_printable(&json.stdout);
    assert!(serde_json::from_str::<serde_json::Value>(&json.stdout).is_ok(), "{}", json.stdout);
    // Unknown keys, headers, file names, effects of the user's own.
    bench.put("key.toml", format!("\"{escaped}\" = 1\n{ROBOT}"));
    assert_printable(&bench.done(&["fit", "--robot", "key.toml", "good.csv"]).stderr);
    bench.put("head.csv", format!("time_s,{WILD}\n1,2\n3,4\n"));
    let said = refusal(&bench, &["fit", "--robot", "robot.toml", "head.csv"], 1);
    assert_printable(&said);
    let name = "wild\u{1b}[2J\ngmr: forged.csv";
    bench.put(name, "time_s\n1\n2\n");
    let said = refusal(&bench, &["fit", "--robot", "robot.toml", name], 1);
    assert!(said.starts_with("wild\\u001b[2J\\u000agmr: forged.csv:"), "{said}");
}

/// A line on standard error ends, however long what it quotes.
#[test]
fn lines_on_standard_error_are_short() {
    let bench = bench();
    let columns: String = (0..4000).map(|k| format!(",column_{k}")).collect();
    bench.put("wide.csv", format!("time_s{columns}\n1\n2\n"));
    let said = refusal(&bench, &["fit", "--robot", "robot.toml", "wide.csv"], 1);
    assert!(said.chars().count() <= 1010 && said.contains('…'), "{} characters", said.len());
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
        let said = refusal(&bench, arguments, 1);
        assert!(said.starts_with("/dev/zero: is longer than 8388608 bytes"), "{said}");
    }
    let said = refusal(&bench, &["fit", "--robot", "robot.toml", "/dev/zero"], 1);
    assert!(said.starts_with("/dev/zero:1: no line end within"), "{said}");
}

/// Another's file is written over only where that is asked for; its own as often as one likes.
#[test]
fn files_of_others_are_kept() {
    let bench = bench();
    bench.put("field.csv", drive(40.0, 100.0, |_| 3.0));
    let estimate = ["estimate", "--robot", "robot.toml", "--coeffs", "c.toml", "good.csv", "--plot"];
    let commands: [(&[&str], &str); 5] = [
        (&["fit", "--robot", "robot.toml", "good.csv", "--out"], "out.toml"),
        (&estimate, "plot.svg"),
        (&estimate, "plot.png"),
        (&["flash", "--robot", "robot.toml", "--coeffs", "c.toml", "--out"], "store.bin"),
        (&["simulate", "--duration", "2", "--out"], "log.csv"),
    ];
    for (command, name) in commands {
        for _ in 0..2 {
            bench.done(&[command, &[name]].concat());
        }
        bench.put(name, "somebody's work");
        let said = refusal(&bench, &[command, &[name]].concat(), 1);
        assert!(said.starts_with(&format!("{name}: exists already")) && said.contains("--force"), "{said}");
        bench.done(&[command, &[name, "--force"]].concat());
        assert_ne!(std::fs::read(bench.path(name)).unwrap(), b"somebody's work");
    }
    // A log that was measured, not simulated.
    bench.put("log.csv", bench.text("good.csv"));
    refusal(&bench, &["simulate", "--duration", "2", "--out", "log.csv"], 1);
}

/// Whoever ends a command from outside finds no temporary file, and no half of one.
#[test]
fn an_end_from_outside_leaves_nothing() {
    use rustix::process::{Pid, Signal, kill_process};
    for signal in [Signal::INT, Signal::TERM, Signal::HUP] {
        let bench = Bench::new();
        let mut child = std::process::Command::new(assert_cmd::cargo::cargo_bin!("gmr"))
            .current_dir(bench.path(""))
            .args(["simulate", "--duration", "1e6", "--out", "long.csv"])
            .spawn()
            .unwrap();
        while bench.files().is_empty() {
            thread::sleep(Duration::from_millis(5));
        }
        assert!(bench.files()[0].starts_with(".gmr-"), "{:?}", bench.files());
        kill_process(Pid::from_child(&child), signal).unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(130), "{signal:?}");
        assert_eq!(bench.files(), Vec::<String>::new(), "{signal:?}");
    }
}

/// Behind a limit of the size of files, writing is an error as any other.
#[test]
fn a_file_that_may_not_grow_is_said() {
    let bench = Bench::new();
    let gmr = assert_cmd::cargo::cargo_bin!("gmr");
    // Blocks of 512 bytes in sh.
    let output = std::process::Command::new("sh")
        .current_dir(bench.path(""))
        .args(["-c", "ulimit -f 8; exec \"$0\" simulate --duration 100 --out long.csv"])
        .arg(gmr)
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.starts_with("gmr: long.csv: File too large") && said.lines().count() == 1, "{said}");
    assert_eq!(bench.files(), Vec::<String>::new());
}

/// What spreadsheets and other countries write: the remedy is named.
#[test]
fn other_ways_of_writing_a_log_have_their_remedy() {
    let bench = bench();
    let good = bench.text("good.csv");
    let utf16: Vec<u8> =
        "\u{feff}".chars().chain(good.chars()).flat_map(|c| (c as u16).to_le_bytes()).collect();
    let rows: Vec<&str> = good.lines().collect();
    let doubled = [&rows[..4], &rows[3..]].concat().join("\n") + "\n";
    let turned =
        rows[..1].iter().chain(rows[1..].iter().rev()).map(|row| format!("{row}\n")).collect::<String>();
    let cases: [(Vec<u8>, &str); 7] = [
        (good.replace('\n', "\r").into_bytes(), "tr '\\r' '\\n'"),
        (utf16, "iconv -f UTF-16 -t UTF-8"),
        (
            good.replace(',', ";").replace('.', ",").into_bytes(),
            "expected commas between fields and a point in numbers",
        ),
        (good.replace('.', ",").into_bytes(), "decimal commas? write numbers with a point"),
        (format!("{HEADER}\"0,5\",1,1,1,1\n\"0,6\",1,1,1,1\n").into_bytes(), "a decimal point, not a comma"),
        (doubled.into_bytes(), "keep one row of each time"),
        (turned.into_bytes(), "sort the rows"),
    ];
    for (content, expected) in cases {
        bench.put("other.csv", content);
        for command in [&["fit", "--robot", "robot.toml"][..], &["inspect", "--robot", "robot.toml"]] {
            let said = refusal(&bench, &[command, &["other.csv"]].concat(), 1);
            assert!(said.contains(expected), "{expected}: {said}");
        }
    }
}

/// Caps are stated, and reached soon.
#[test]
fn too_much_is_refused_soon() {
    let bench = bench();
    let columns: String = (0..50_000).map(|k| format!(",column_{k}")).collect();
    bench.put("wide.csv", format!("time_s{columns}\n1\n2\n"));
    let rows: String = (0..80_000).map(|k| format!("{k},1,1,1,1,lap {k}\n")).collect();
    bench.put("laps.csv", format!("{},run\n{rows}", HEADER.trim_end()));
    for (log, expected) in
        [("wide.csv", "50001 columns; expected at most 4096"), ("laps.csv", "at most 10000 in a log")]
    {
        for command in [&["fit", "--robot", "robot.toml"][..], &["inspect", "--robot", "robot.toml"]] {
            let begun = Instant::now();
            let said = refusal(&bench, &[command, &[log]].concat(), 1);
            assert!(said.contains(expected), "{said}");
            assert!(begun.elapsed() < Duration::from_secs(5), "{command:?} {log}: {:?}", begun.elapsed());
        }
    }
}

/// A log that tells its mass, or whoever knows it, gets the power at it; coefficients of one
/// payload have no other.
#[test]
fn power_at_a_known_payload_is_told() {
    let bench = bench();
    bench.put("one.csv", drive(40.0, 100.0, |_| 3.0));
    bench.put(
        "bare.csv",
        drive(40.0, 100.0, |_| 3.0)
            .lines()
            .map(|row| format!("{}\n", row.rsplit_once(',').unwrap().0))
            .collect::<String>(),
    );
    bench.done(&["fit", "--robot", "robot.toml", "--out", "one.toml", "one.csv"]);
    let estimate = |log: &str, further: &[&str]| {
        bench.json(
            &[&["estimate", "--robot", "robot.toml", "--coeffs", "one.toml", "--window", "10", log], further]
                .concat(),
        )
    };
    let told = estimate("one.csv", &[]);
    assert_eq!(told["told"]["mass_kg"], 3.0);
    assert!(number(&told["told"]["r2"]) > 0.999, "{}", told["told"]);
    assert!(told["r2"].is_null() && told["windows"][0]["mass_kg"].is_null());
    assert!(estimate("bare.csv", &[])["told"].is_null());
    let given = estimate("bare.csv", &["--mass", "3"]);
    assert_eq!(given["told"], told["told"]);
    // The wrong payload fits less well.
    assert!(number(&estimate("bare.csv", &["--mass", "6"])["told"]["r2"]) < number(&given["told"]["r2"]));
    let said = refusal(
        &bench,
        &["estimate", "--robot", "robot.toml", "--coeffs", "one.toml", "--mass", "900", "bare.csv"],
        2,
    );
    assert!(said.starts_with("--mass: a total mass of 900 kg; expected from 0.2 to 30 kg"), "{said}");
}
