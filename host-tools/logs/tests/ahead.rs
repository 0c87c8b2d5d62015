//! One large log, read by one thread and by several: rows, lines, what is left out and what is
//! wrong are the same to the bit.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use logs::{ColumnRequest, Exclusions, LogReader, Role};
use rayon::ThreadPoolBuilder;
use support::context::Context;

/// Rows of a log of some megabytes: more than one thread reads alone, and more than wait at a time.
const ROWS: usize = 200_000;

/// All that a reader says of a log.
#[derive(Debug, PartialEq)]
struct Said {
    rows: Vec<(u64, Vec<u64>)>,
    ending: Result<(), String>,
    exclusions: Exclusions,
    runs: Vec<String>,
}

fn said(log: &Path, requests: &[ColumnRequest], threads: usize) -> Said {
    let read = || {
        let mut reader = LogReader::open(&Context::default(), log, requests).unwrap();
        let (mut values, mut rows) = (vec![0.0; requests.len()], Vec::new());
        let ending = loop {
            match reader.next_row(&mut values) {
                Ok(Some(line)) => rows.push((line, values.iter().map(|value| value.to_bits()).collect())),
                Ok(None) => break Ok(()),
                Err(error) => break Err(error.to_string()),
            }
        };
        Said { rows, ending, exclusions: reader.exclusions(), runs: reader.run_names().to_vec() }
    };
    ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(read)
}

/// What one thread says, where several say the same.
fn agreed(log: &Path, requests: &[ColumnRequest]) -> Said {
    let alone = said(log, requests, 1);
    for threads in [2, 4] {
        let together = said(log, requests, threads);
        assert!(together == alone, "{threads} threads: {:?} {:?}", together.ending, alone.ending);
    }
    alone
}

fn number(name: &str) -> ColumnRequest {
    ColumnRequest::required(name, Role::Number)
}

fn time() -> ColumnRequest {
    ColumnRequest::required("time_s", Role::Time)
}

/// The header and rows of a log, its line ends, and a change of one of its rows (from 0).
fn text(end: &str, change: impl Fn(usize) -> Option<String>) -> String {
    let mut text = format!("time_s,power_w,note{end}");
    for row in 0..ROWS {
        let own = format!("{:.2},{:.7},{}", 0.01 * row as f64, (0.37 * row as f64).sin(), row % 97);
        let _ = write!(text, "{}{end}", change(row).unwrap_or(own));
    }
    text
}

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn put(&self, text: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join("large.csv");
        std::fs::write(&path, text).unwrap();
        path
    }
}

#[test]
fn a_text_is_the_same_rows() {
    let folder = Folder::new();
    // Where every column is a number that is wanted lines are read in one go.
    for requests in [vec![time(), number("power_w"), number("note")], vec![number("power_w"), time()]] {
        for end in ["\n", "\r\n"] {
            let all = agreed(&folder.put(text(end, |_| None)), &requests);
            assert_eq!((all.rows.len(), all.ending), (ROWS, Ok(())));
            assert_eq!(all.rows[ROWS - 1].0, ROWS as u64 + 1);
        }
    }
}

/// Rows that have no number are left out, and counted from the first on.
#[test]
fn what_a_text_lacks_is_left_out() {
    let folder = Folder::new();
    let hole =
        |row: usize| (row % 100_000 == 49_999).then(|| format!("{:.2},nan,\"a, b\"", 0.01 * row as f64));
    let all = agreed(&folder.put(text("\n", hole)), &[time(), number("power_w")]);
    assert_eq!((all.exclusions.non_finite, all.exclusions.first_non_finite_line), (2, Some(50_001)));
    // A last line without its end may be short, and blank lines behind it are nothing.
    for (rest, cut_line) in [("1200.5,7.0,1", 1), ("\n \n\r\n", 0), ("", 0)] {
        let all = agreed(&folder.put(text("\n", |_| None) + rest), &[time(), number("power_w")]);
        assert_eq!((all.rows.len(), all.exclusions.cut_line, all.ending), (ROWS, cut_line, Ok(())));
    }
}

/// The first wrong row is told, wherever it is, with its line and column.
#[test]
fn what_is_wrong_with_a_text_is_told_of_its_line() {
    let folder = Folder::new();
    let wrong = [
        ("1000.00,abc,1", ":100002:power_w: \"abc\" is not a number"),
        ("1000.00,1,1,1", ":100002: 4 fields; expected 3"),
        ("1.00,1,1", ":100002:time_s: time 1 follows 999.99"),
        ("", ":100002: blank line in the middle"),
    ];
    for (line, expected) in wrong {
        // Another fault behind it is not the first.
        let change = |row| match row {
            100_000 => Some(line.to_owned()),
            100_400 => Some("x,y,z".to_owned()),
            _ => None,
        };
        let all = agreed(&folder.put(text("\n", change)), &[time(), number("power_w")]);
        let told = all.ending.unwrap_err();
        assert!(told.contains(expected), "{told}");
        assert_eq!(all.rows.len(), 100_000);
    }
    let long = |row| (row == 100_000).then(|| "9".repeat((1 << 20) + 1));
    let told = agreed(&folder.put(text("\n", long)), &[time(), number("power_w")]).ending.unwrap_err();
    assert!(told.contains(":100002: no line end within 1048576 bytes"), "{told}");
}

/// Runs are counted as they appear, whichever piece they are in; too many are told of their row.
#[test]
fn runs_of_a_text_keep_their_numbers() {
    let folder = Folder::new();
    let log = |length: usize| {
        let mut text = "time_s,run,power_w\n".to_owned();
        for row in 0..ROWS {
            // Back to the first one now and then.
            let run = if row / length % 5 == 4 { 0 } else { row / length };
            let _ =
                writeln!(text, "{:.3},\"drive {run}\",{:.7}", 0.01 * row as f64, (0.37 * row as f64).sin());
        }
        text
    };
    let requests = [time(), ColumnRequest::required("run", Role::Run), number("power_w")];
    let all = agreed(&folder.put(log(3_000)), &requests);
    assert_eq!((all.runs.len(), &all.runs[4][..]), (54, "drive 5"));
    let told = agreed(&folder.put(log(9)), &requests).ending.unwrap_err();
    assert!(told.contains(":run: another run; expected at most 10000"), "{told}");
}

/// The same of Parquet, by its columns; one of them is text.
#[test]
fn parquet_is_the_same_rows() {
    let folder = Folder::new();
    let table = folder.0.path().join("large.parquet");
    let columns = ["time_s", "power_w", "run"].map(str::to_owned);
    let file = std::fs::File::create(&table).unwrap();
    let mut writer = log_formats::write::Parquet::new(file, &columns, &[false, false, true]).unwrap();
    for row in 0..2 * ROWS {
        use log_formats::table::Cell::{Number, Text};
        let power = if row % 100_000 == 99_999 { f64::NAN } else { (0.37 * row as f64).sin() };
        let run = Text(format!("drive {}", row / 50_000));
        writer.row(&[Number(0.01 * row as f64), Number(power), run]).unwrap();
    }
    writer.finish().unwrap();
    let requests = [time(), ColumnRequest::required("run", Role::Run), number("power_w")];
    let all = agreed(&table, &requests);
    assert_eq!((all.rows.len(), all.runs.len(), all.ending), (2 * ROWS - 4, 8, Ok(())));
    assert_eq!(all.exclusions.first_non_finite_line, Some(100_001));
}
