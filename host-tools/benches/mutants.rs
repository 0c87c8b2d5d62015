//! Commands against inputs that somebody has spoiled: `cargo xtask mutate [COUNT [SEED]]`, COUNT
//! files of every case in turn.
//!
//! Every input starts as a good file and is changed in one to four ways: bytes, lines, fields,
//! columns, values of keys; of what is no text: bytes, pieces, and numbers of four and eight bytes
//! that may be lengths. The command that reads it runs in a process of its own, with 2 GB of
//! memory, and has to keep what all commands promise: it ends within 5 s, with exit code 0, 1 or 2;
//! what it prints is printable, in lines that end, and nothing that a crate says when it panics; a
//! refusal is one line and leaves every file as it was; no input is ever changed; a page holds
//! nothing that acts on a terminal; coefficients that it writes are read by `estimate` and `flash`.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// Inputs of each case, unless the caller says otherwise.
const COUNT: u64 = 500;
const LIMIT: Duration = Duration::from_secs(5);
/// KiB of address space, as `ulimit -v` takes them.
const MEMORY: u64 = 2_000_000;
/// Characters of a line.
const LONGEST_LINE: usize = support::printable::LONGEST_LINE;

const ROBOT: &str = "name = \"mine\"\nkinematics = \"differential\"\nwheel_radius_m = 0.033\ntrack_m = 0.16\n\
                     gyration_radius_m = 0.06\nmass_no_load_kg = 1\nmass_full_load_kg = 6\nfilter_cutoff_hz = 2\n";
const EFFECTS: &str = "[[effect]]\nid = \"mine\"\nformula = \"v * mass\"\nunit = \"W\"\nsign = \"positive\"\n\
                       range = [0.0, 1.0]\nmeaning = \"mine\"\n";
const PROFILE: &str = "time_s,v_m_s,omega_rad_s\n0,0,0\n2,0.1,0\n5,0.2,0.5\n8,0,0\n";

const PLAN: &str = "distance_m,speed_m_s,turn_rad,pause_s,leg\n2,0.2,0,0,out\n3,0.15,1.57,5,back\n";

/// A command, and which of its files is spoiled.
struct Case {
    name: &'static str,
    spoiled: &'static str,
    arguments: &'static [&'static str],
}

const CASES: [Case; 23] = [
    Case {
        name: "inspect log",
        spoiled: "log.csv",
        arguments: &["inspect", "--robot", "robot.toml", "log.csv"],
    },
    Case {
        name: "fit log",
        spoiled: "log.csv",
        arguments: &["fit", "--robot", "robot.toml", "--out", "new.toml", "log.csv"],
    },
    Case {
        name: "estimate log",
        spoiled: "log.csv",
        arguments: &["estimate", "--robot", "robot.toml", "--coeffs", "c.toml", "--window", "5", "log.csv"],
    },
    Case {
        name: "compare log",
        spoiled: "log.csv",
        arguments: &[
            "compare",
            "--robot",
            "robot.toml",
            "--models",
            "signed,linear",
            "--window",
            "5",
            "--train",
            "log.csv",
        ],
    },
    Case {
        name: "inspect robot",
        spoiled: "robot.toml",
        arguments: &["inspect", "--robot", "robot.toml", "log.csv"],
    },
    Case {
        name: "fit robot",
        spoiled: "robot.toml",
        arguments: &["fit", "--robot", "robot.toml", "--out", "new.toml", "log.csv"],
    },
    Case {
        name: "estimate coefficients",
        spoiled: "c.toml",
        arguments: &["estimate", "--robot", "robot.toml", "--coeffs", "c.toml", "--window", "5", "log.csv"],
    },
    Case {
        name: "flash coefficients",
        spoiled: "c.toml",
        arguments: &["flash", "--robot", "robot.toml", "--coeffs", "c.toml", "--out", "new.bin"],
    },
    Case {
        name: "gap effects",
        spoiled: "mine.toml",
        // One run is too few: what is asked is whether the file is read.
        arguments: &[
            "gap",
            "--robot",
            "robot.toml",
            "--coeffs",
            "c.toml",
            "--effects",
            "mine.toml",
            "field.csv",
        ],
    },
    Case {
        name: "simulate profile",
        spoiled: "profile.csv",
        arguments: &[
            "simulate",
            "--profile",
            "profile.csv",
            "--duration",
            "3",
            "--rate",
            "20",
            "--out",
            "new.csv",
        ],
    },
    Case {
        name: "look drive.mcap",
        spoiled: "drive.mcap",
        arguments: &["look", "drive.mcap", "--page", "new.html"],
    },
    Case {
        name: "look core-zstd.mcap",
        spoiled: "core-zstd.mcap",
        arguments: &["look", "core-zstd.mcap", "--page", "new.html"],
    },
    Case {
        name: "look core-ros1.mcap",
        spoiled: "core-ros1.mcap",
        arguments: &["look", "core-ros1.mcap", "--page", "new.html"],
    },
    Case {
        name: "look drive.db3",
        spoiled: "drive.db3",
        arguments: &["look", "drive.db3", "--page", "new.html"],
    },
    Case {
        name: "look drive.ulg",
        spoiled: "drive.ulg",
        arguments: &["look", "drive.ulg", "--page", "new.html"],
    },
    Case {
        name: "look drive.parquet",
        spoiled: "drive.parquet",
        arguments: &["look", "drive.parquet", "--page", "new.html"],
    },
    Case {
        name: "convert turtlebot3.mcap",
        spoiled: "turtlebot3.mcap",
        arguments: &[
            "convert",
            "--robot",
            "robot.toml",
            "--allow-truncated",
            "turtlebot3.mcap",
            "--out",
            "new.csv",
        ],
    },
    Case {
        name: "convert compressed.db3",
        spoiled: "compressed.db3",
        arguments: &[
            "convert",
            "--robot",
            "robot.toml",
            "--allow-truncated",
            "compressed.db3",
            "--out",
            "new.csv",
        ],
    },
    Case {
        name: "convert drive.ulg",
        spoiled: "drive.ulg",
        arguments: &[
            "convert",
            "--robot",
            "robot.toml",
            "--allow-truncated",
            "drive.ulg",
            "--out",
            "new.csv",
        ],
    },
    Case {
        name: "convert drive.parquet",
        spoiled: "drive.parquet",
        arguments: &[
            "convert",
            "--robot",
            "robot.toml",
            "--allow-truncated",
            "drive.parquet",
            "--out",
            "new.csv",
        ],
    },
    Case {
        name: "fit --grams",
        spoiled: "sums.json",
        arguments: &["fit", "--robot", "robot.toml", "--model", "eq18", "--grams", "sums.json"],
    },
    Case {
        name: "fit --grams --coeffs",
        spoiled: "near.json",
        arguments: &[
            "fit",
            "--robot",
            "robot.toml",
            "--coeffs",
            "c.toml",
            "--out",
            "new.toml",
            "--grams",
            "near.json",
        ],
    },
    Case {
        name: "predict plan",
        spoiled: "plan.csv",
        arguments: &[
            "predict",
            "--robot",
            "robot.toml",
            "--coeffs",
            "c.toml",
            "--plan",
            "plan.csv",
            "--mass",
            "3",
        ],
    },
];

const FILES: [&str; 9] = [
    "log.csv",
    "field.csv",
    "robot.toml",
    "c.toml",
    "mine.toml",
    "profile.csv",
    "plan.csv",
    "sums.json",
    "near.json",
];

/// Those of other formats, as the reader's tests have them.
const RECORDED: [&str; 8] = [
    "drive.mcap",
    "core-zstd.mcap",
    "core-ros1.mcap",
    "turtlebot3.mcap",
    "drive.db3",
    "compressed.db3",
    "drive.ulg",
    "drive.parquet",
];

fn main() -> ExitCode {
    // `cargo bench` passes flags of its own.
    let numbers: Vec<u64> = std::env::args().filter_map(|argument| argument.parse().ok()).collect();
    let count = numbers.first().copied().unwrap_or(COUNT);
    let seed = numbers.get(1).copied().unwrap_or(1);
    match run(count, seed) {
        Ok(faults) if faults.is_empty() => ExitCode::SUCCESS,
        Ok(faults) => {
            println!("{} faults:", faults.len());
            faults.iter().for_each(|fault| println!("  {fault}"));
            ExitCode::FAILURE
        }
        Err(error) => {
            println!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn run(count: u64, seed: u64) -> std::io::Result<Vec<String>> {
    let folder = tempfile::tempdir()?;
    let good = good(folder.path())?;
    for case in &CASES {
        let ran = gmr(folder.path(), case.arguments)?;
        // A command that is not even understood reads no file, and would pass whatever is in it.
        if ran.code == 2 {
            return Err(std::io::Error::other(format!("{}: {}", case.name, ran.stderr)));
        }
        let written = listing(folder.path())?;
        for name in written.keys().filter(|name| !good.contains_key(name.as_str())) {
            std::fs::remove_file(folder.path().join(name))?;
        }
    }
    let mut faults = Vec::new();
    let mut endings: BTreeMap<(&str, i32), (u64, Duration)> = BTreeMap::new();
    let begun = Instant::now();
    let count = count * CASES.len() as u64;
    for (number, case) in (0..count).zip(CASES.iter().cycle()) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed.wrapping_mul(1 << 32).wrapping_add(number));
        let mut content = good[case.spoiled].clone();
        let is_text = std::str::from_utf8(&content).is_ok();
        for _ in 0..rng.random_range(1..=4) {
            if is_text { spoil(&mut rng, &mut content) } else { spoil_binary(&mut rng, &mut content) }
        }
        std::fs::write(folder.path().join(case.spoiled), &content)?;
        let before = listing(folder.path())?;
        let ran = gmr(folder.path(), case.arguments)?;
        let entry = endings.entry((case.name, ran.code)).or_default();
        entry.0 += 1;
        entry.1 = entry.1.max(ran.time);
        let after = listing(folder.path())?;
        let mut found = ran.faults(&before, &after);
        if ran.code == 0 && after.contains_key("new.toml") {
            found.extend(unread(folder.path())?);
        }
        for fault in found {
            let kept = std::env::temp_dir().join(format!("mutant-{seed}-{number}"));
            std::fs::write(&kept, &content)?;
            faults.push(format!("{}: {fault}; {} of it in {}", case.name, case.spoiled, kept.display()));
        }
        for name in after.keys().filter(|name| !before.contains_key(*name)) {
            std::fs::remove_file(folder.path().join(name))?;
        }
        std::fs::write(folder.path().join(case.spoiled), &good[case.spoiled])?;
    }
    println!("{count} inputs from seed {seed} in {:.0} s", begun.elapsed().as_secs_f64());
    for ((name, code), (count, slowest)) in endings {
        println!("  {name:<22} exit {code}: {count:>5}, slowest {:.2} s", slowest.as_secs_f64());
    }
    Ok(faults)
}

/// The good files, by name, written into the folder as well.
fn good(folder: &Path) -> std::io::Result<BTreeMap<&'static str, Vec<u8>>> {
    std::fs::write(folder.join("robot.toml"), ROBOT)?;
    std::fs::write(folder.join("mine.toml"), EFFECTS)?;
    std::fs::write(folder.join("profile.csv"), PROFILE)?;
    std::fs::write(folder.join("plan.csv"), PLAN)?;
    let simulate = |out, mass, seed| {
        let fixed = ["simulate", "--rate", "20", "--sensors", "servo", "--duration", "40"];
        gmr(folder, &[&fixed[..], &["--mass", mass, "--seed", seed, "--out", out]].concat())
    };
    let done = [
        simulate("log.csv", "1@0,6@20", "1")?,
        simulate("field.csv", "3", "2")?,
        gmr(folder, &["fit", "--robot", "robot.toml", "--out", "c.toml", "log.csv"])?,
        gmr(folder, &["gram", "--robot", "robot.toml", "--cutoff", "2", "--out", "sums.json", "log.csv"])?,
        gmr(
            folder,
            &["gram", "--robot", "robot.toml", "--coeffs", "c.toml", "--out", "near.json", "log.csv"],
        )?,
    ];
    for name in RECORDED {
        let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("formats/tests/data").join(name);
        std::fs::copy(from, folder.join(name))?;
    }
    if let Some(failed) = done.iter().find(|ran| ran.code != 0) {
        return Err(std::io::Error::other(failed.stderr.clone()));
    }
    FILES.iter().chain(&RECORDED).map(|name| Ok((*name, std::fs::read(folder.join(name))?))).collect()
}

/// All files of a folder.
fn listing(folder: &Path) -> std::io::Result<BTreeMap<String, Vec<u8>>> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        found.insert(entry.file_name().to_string_lossy().into_owned(), std::fs::read(entry.path())?);
    }
    Ok(found)
}

/// How a command ended.
struct Ran {
    code: i32,
    stdout: String,
    stderr: String,
    time: Duration,
    ended: bool,
}

/// Runs the command within its limits; -1 where a signal ended it.
fn gmr(folder: &Path, arguments: &[&str]) -> std::io::Result<Ran> {
    let begun = Instant::now();
    let seconds = LIMIT.as_secs() + 1;
    let limited = format!("ulimit -v {MEMORY}; exec timeout --signal=KILL {seconds} \"$0\" \"$@\"");
    let output = Command::new("sh")
        .args(["-c", &limited, env!("CARGO_BIN_EXE_gmr")])
        .args(arguments)
        .current_dir(folder)
        .stdin(Stdio::null())
        // As many threads as cores have stacks that count against the limit.
        .env("RAYON_NUM_THREADS", "2")
        .output()?;
    let time = begun.elapsed();
    Ok(Ran {
        code: output.status.code().unwrap_or(-1),
        stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
        stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
        time,
        ended: time < LIMIT,
    })
}

impl Ran {
    /// What the command did not keep of what all commands promise.
    fn faults(&self, before: &BTreeMap<String, Vec<u8>>, after: &BTreeMap<String, Vec<u8>>) -> Vec<String> {
        let mut faults = Vec::new();
        if !self.ended {
            faults.push(format!("took {:.1} s", self.time.as_secs_f64()));
        }
        if !(0..=2).contains(&self.code) {
            faults.push(format!("exit code {}: {}", self.code, self.stderr));
        }
        let harmful = |text: &str| text.chars().any(|c| c != '\n' && support::printable::is_harmful(c));
        if harmful(&self.stdout) || harmful(&self.stderr) {
            faults.push("prints what acts on a terminal".to_owned());
        }
        if ["panicked", "RUST_BACKTRACE", "/registry/", "/rustc/", "memory allocation"]
            .iter()
            .any(|sign| self.stderr.contains(sign))
        {
            faults.push(format!("prints what a crate says: {}", self.stderr));
        }
        if after.get("new.html").is_some_and(|page| harmful(&String::from_utf8_lossy(page))) {
            faults.push("writes a page with what acts on a terminal".to_owned());
        }
        if self.stderr.lines().any(|line| line.chars().count() > LONGEST_LINE) {
            faults.push("a line without end".to_owned());
        }
        for (name, content) in before {
            if after.get(name) != Some(content) {
                faults.push(format!("changed {name}"));
            }
        }
        if self.code > 0 {
            let refusals = self.stderr.lines().count();
            // Unknown keys of a robot are named before whatever else is wrong.
            if refusals == 0 || (refusals > 1 && !self.stderr.contains("unknown key")) {
                faults.push(format!("{refusals} lines: {}", self.stderr));
            }
            if !self.stdout.is_empty() {
                faults.push("prints figures, and fails".to_owned());
            }
            if after.len() != before.len() {
                faults.push("leaves a file".to_owned());
            }
        }
        faults
    }
}

/// Why the coefficients that a fit has written are not read again, if they are not.
fn unread(folder: &Path) -> std::io::Result<Option<String>> {
    let robot = ["--robot", "robot.toml", "--coeffs", "new.toml"];
    let estimate = gmr(folder, &[&["estimate"], &robot[..], &["--window", "5", "log.csv"]].concat())?;
    let flash = gmr(folder, &[&["flash"], &robot[..], &["--out", "flashed.bin"]].concat())?;
    let _ = std::fs::remove_file(folder.join("flashed.bin"));
    // A log that was cut short is no fault of the coefficients.
    let refused = [estimate, flash].into_iter().find(|ran| ran.code != 0 && ran.stderr.contains("new.toml"));
    Ok(refused.map(|ran| format!("wrote what it does not read: {}", ran.stderr.trim_end())))
}

/// Values that nobody expects.
const WILD: [&str; 24] = [
    "nan",
    "-inf",
    "1e308",
    "-1e308",
    "1e-320",
    "0",
    "-0",
    "-1",
    "1e9",
    "1000000",
    "\"\"",
    "",
    "true",
    "[1, 2]",
    "0x7f",
    "1,5",
    "\"1,5\"",
    "\u{1b}[2J",
    "\u{9b}2J",
    "\u{202e}",
    "\"a\nb\"",
    "18446744073709551616",
    "=1+1",
    "\u{0}",
];

/// Changes a text in one way.
fn spoil(rng: &mut ChaCha8Rng, content: &mut Vec<u8>) {
    match rng.random_range(0..9) {
        0 => bytes(rng, content),
        1 => cut(rng, content),
        2 => lines(rng, content),
        3 => column(rng, content),
        4 => ends(rng, content),
        5 | 6 => field(rng, content),
        _ => value(rng, content),
    }
}

/// Changes what is no text in one way: lengths are numbers of four or eight bytes, little or big
/// end first.
fn spoil_binary(rng: &mut ChaCha8Rng, content: &mut Vec<u8>) {
    let places = content.len().saturating_sub(8);
    match rng.random_range(0..6) {
        0 => bytes(rng, content),
        1 => cut(rng, content),
        // A piece of it at another place.
        2 if places > 0 => {
            let (from, to) = (rng.random_range(0..places), rng.random_range(0..places));
            let length = rng.random_range(1..=(content.len() - from.max(to)).min(4096));
            content.copy_within(from..from + length, to);
        }
        _ if places > 0 => {
            // Beginnings and ends are where directories are.
            let at = match rng.random_range(0..3) {
                0 => rng.random_range(0..places.min(256)),
                1 => places - rng.random_range(0..places.min(2048)),
                _ => rng.random_range(0..places),
            };
            let number = [
                0,
                1,
                0x7f,
                0xff,
                0xffff,
                1 << 24,
                1 << 31,
                u64::from(u32::MAX),
                1 << 40,
                u64::MAX >> 1,
                u64::MAX,
            ][rng.random_range(0..11)];
            let wide = number.to_le_bytes();
            let place = &mut content[at..];
            match rng.random_range(0..3) {
                0 => place[..8].copy_from_slice(&wide),
                1 => place[..4].copy_from_slice(&wide[..4]),
                _ => place[..4].copy_from_slice(&(number as u32).to_be_bytes()),
            }
        }
        _ => {}
    }
}

fn bytes(rng: &mut ChaCha8Rng, content: &mut Vec<u8>) {
    for _ in 0..rng.random_range(1..=8) {
        if content.is_empty() {
            return;
        }
        let at = rng.random_range(0..content.len());
        match rng.random_range(0..3) {
            0 => content[at] = rng.random(),
            1 => content.insert(at, rng.random()),
            _ => _ = content.remove(at),
        }
    }
}

fn cut(rng: &mut ChaCha8Rng, content: &mut Vec<u8>) {
    let at = rng.random_range(0..=content.len());
    if rng.random_bool(0.5) {
        content.truncate(at);
    } else {
        content.drain(..at);
    }
}

/// The lines of a text, whatever its bytes.
fn split(content: &[u8]) -> Vec<Vec<u8>> {
    content.split(|byte| *byte == b'\n').map(<[u8]>::to_vec).collect()
}

fn lines(rng: &mut ChaCha8Rng, content: &mut Vec<u8>) {
    let mut lines = split(content);
    let (one, other) = (rng.random_range(0..lines.len()), rng.random_range(0..lines.len()));
    match rng.random_range(0..4) {
        0 => lines.swap(one, other),
        1 => lines.insert(other, lines[one].clone()),
        2 => _ = lines.remove(one),
        _ => lines[one].extend_from_within(..),
    }
    *content = lines.join(&b'\n');
}

/// All values of one column: in another unit, clipped, stuck, turned over, gone.
fn column(rng: &mut ChaCha8Rng, content: &mut Vec<u8>) {
    let (place, kind) = (rng.random_range(0..5), rng.random_range(0..6));
    let factor = 10_f64.powi(rng.random_range(-9..=9));
    let changed = split(content).into_iter().enumerate().map(|(number, line)| {
        let text = String::from_utf8_lossy(&line).into_owned();
        let mut fields: Vec<String> = text.split(',').map(str::to_owned).collect();
        if let Some(field) = fields.get_mut(place)
            && let Ok(number_in_it) = field.parse::<f64>()
        {
            *field = match kind {
                0 => (number_in_it * factor).to_string(),
                1 => number_in_it.min(factor).to_string(),
                2 => factor.to_string(),
                3 => (-number_in_it).to_string(),
                4 if number % 2 == 0 => String::new(),
                4 => field.clone(),
                _ => (number_in_it + factor).to_string(),
            };
        }
        fields.join(",").into_bytes()
    });
    *content = changed.collect::<Vec<_>>().join(&b'\n');
}

/// Line ends and encodings.
fn ends(rng: &mut ChaCha8Rng, content: &mut Vec<u8>) {
    let text = String::from_utf8_lossy(content).into_owned();
    *content = match rng.random_range(0..5) {
        0 => text.replace('\n', "\r").into_bytes(),
        1 => text.replace('\n', "\r\n").into_bytes(),
        2 => text.replace(',', ";").replace('.', ",").into_bytes(),
        3 => text.encode_utf16().flat_map(u16::to_le_bytes).collect(),
        _ => [b"\xEF\xBB\xBF", text.as_bytes()].concat(),
    };
}

fn field(rng: &mut ChaCha8Rng, content: &mut Vec<u8>) {
    let mut lines = split(content);
    let line = rng.random_range(0..lines.len().min(40));
    let text = String::from_utf8_lossy(&lines[line]).into_owned();
    let mut fields: Vec<&str> = text.split(',').collect();
    let place = rng.random_range(0..fields.len());
    fields[place] = WILD[rng.random_range(0..WILD.len())];
    lines[line] = fields.join(",").into_bytes();
    *content = lines.join(&b'\n');
}

/// What stands behind an equals sign, where there is one.
fn value(rng: &mut ChaCha8Rng, content: &mut Vec<u8>) {
    let mut lines = split(content);
    let keys: Vec<usize> = (0..lines.len()).filter(|place| lines[*place].contains(&b'=')).collect();
    if keys.is_empty() {
        return field(rng, content);
    }
    let line = keys[rng.random_range(0..keys.len())];
    let text = String::from_utf8_lossy(&lines[line]).into_owned();
    let (key, _) = text.split_once('=').unwrap_or((&text, ""));
    lines[line] = format!("{key}= {}", WILD[rng.random_range(0..WILD.len())]).into_bytes();
    *content = lines.join(&b'\n');
}
