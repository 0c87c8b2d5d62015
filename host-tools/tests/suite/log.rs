//! The log reader against logs as they come: good, odd and broken.

use std::fmt::Write as _;
use std::path::PathBuf;

use logs::robot::Robot;
use logs::{ColumnRequest, DriveReader, Header, LogReader, Record, Role};
use support::context::Context;
use support::error::Error;

/// A log in a folder that lives as long as it.
struct Log {
    _folder: tempfile::TempDir,
    path: PathBuf,
}

fn log(content: impl AsRef<[u8]>) -> Log {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.csv");
    std::fs::write(&path, content).unwrap();
    Log { _folder: folder, path }
}

fn requests() -> [ColumnRequest; 3] {
    [
        ColumnRequest::required("time_s", Role::Time),
        ColumnRequest::required("power_w", Role::Number),
        ColumnRequest::optional("mass_kg", Role::MaybeNumber),
    ]
}

fn rows(log: &Log) -> Result<(Vec<[f64; 3]>, LogReader), Error> {
    let mut reader = LogReader::open(&Context::default(), &log.path, &requests())?;
    let (mut rows, mut values) = (Vec::new(), [0.0; 3]);
    while reader.next_row(&mut values)?.is_some() {
        rows.push(values);
    }
    Ok((rows, reader))
}

/// The message for a log that cannot be read, without the folder.
fn message(content: impl AsRef<[u8]>) -> String {
    let log = log(content);
    let error = rows(&log).err().expect("the log is broken");
    assert_eq!(error.exit_code(), 1);
    let text = error.to_string();
    assert_eq!(text.lines().count(), 1, "one clear line: {text}");
    text.split_once("run.csv").expect("the file is named").1.to_owned()
}

#[test]
fn columns_come_in_the_order_asked_for_whatever_else_the_log_holds() {
    let log = log("mass_kg,note,power_w,time_s,cpu\n1.5,a,2.25,0,9\n1.5,\"b, c\",-3e1,0.5,9\n");
    let (rows, reader) = rows(&log).unwrap();
    assert_eq!(rows, [[0.0, 2.25, 1.5], [0.5, -30.0, 1.5]]);
    assert_eq!(reader.columns(), ["mass_kg", "note", "power_w", "time_s", "cpu"]);
    assert!(reader.has(2));
}

#[test]
fn line_ends_of_windows_byte_order_mark_spaces_quotes_and_blank_last_lines_do_not_matter() {
    let log = log("\u{feff}\"time_s\" , power_w\r\n 0 ,\t1.5\r\n\"1\",2\r\n\r\n  \r\n");
    let (rows, reader) = rows(&log).unwrap();
    assert_eq!(rows.iter().map(|row| (row[0], row[1])).collect::<Vec<_>>(), [(0.0, 1.5), (1.0, 2.0)]);
    assert!(rows[0][2].is_nan() && !reader.has(2), "an absent optional column is NaN");
    assert_eq!(reader.exclusions().total(), 0);
}

#[test]
fn every_number_of_f64_survives() {
    let written = [0.1, 1.0 / 3.0, 1e-300, -2.2250738585072014e-308, 123456789.12345679, f64::MAX];
    let mut text = "time_s,power_w\n".to_owned();
    for (time, value) in written.iter().enumerate() {
        writeln!(text, "{time},{value}").unwrap();
    }
    let (rows, _) = rows(&log(text)).unwrap();
    assert_eq!(rows.iter().map(|row| row[1]).collect::<Vec<_>>(), written);
}

#[test]
fn rows_longer_than_one_read_are_joined() {
    // More than the 1 MiB buffer, with lines of changing length so that the cuts fall everywhere.
    let mut text = "time_s,power_w,filler\n".to_owned();
    let count = 60_000;
    for row in 0..count {
        writeln!(text, "{row},{}.5,{}", row * 2, "x".repeat(row % 37)).unwrap();
    }
    let (rows, _) = rows(&log(text)).unwrap();
    assert_eq!(rows.len(), count);
    assert!(rows.iter().enumerate().all(|(k, row)| row[0] == k as f64 && row[1] == 2.0 * k as f64 + 0.5));
}

#[test]
fn a_missing_column_is_named_with_those_present() {
    let text = message("time_s,watts\n0,1\n1,1\n");
    assert_eq!(
        text,
        ":1: column power_w is missing; the log has: time_s, watts; perhaps watts: rename it to power_w"
    );
}

#[test]
fn text_in_a_number_names_line_column_and_text() {
    let text = message("time_s,power_w\n0,1\n1,abc\n2,1\n");
    assert_eq!(text, ":3:power_w: \"abc\" is not a number; expected a number");
    let text = message("time_s,power_w\n0,1.5W\n1,1\n");
    assert_eq!(text, ":2:power_w: \"1.5W\" is not a number; expected a number");
    let text = message(format!("time_s,power_w\n0,{}\n1,1\n", "long".repeat(40)));
    assert!(text.len() < 100, "{text}");
}

#[test]
fn fields_too_few_or_too_many_name_the_line() {
    assert_eq!(message("time_s,power_w,x\n0,1,1\n1,1\n2,1,1\n"), ":3: 2 fields; expected 3 as in the header");
    assert_eq!(message("time_s,power_w\n0,1\n1\n2,1\n"), ":3: 1 field; expected 2 as in the header");
    assert_eq!(
        message("time_s,power_w\n0,1,7\n1,1\n"),
        ":2: 3 fields; expected 2 as in the header (decimal commas? write numbers with a point)"
    );
}

#[test]
fn time_must_increase_and_both_times_are_named() {
    let expected = ":4:time_s: time 0.5 follows 1; expected time to increase from row to row (sort the rows, or tell runs apart by a column run)";
    assert_eq!(message("time_s,power_w\n0,1\n1,1\n0.5,1\n"), expected);
    let expected =
        ":3:time_s: time 0 follows 0; expected time to increase from row to row (keep one row of each time)";
    assert_eq!(message("time_s,power_w\n0,1\n0,1\n"), expected);
    // A row that is excluded for its power still has a time.
    assert!(message("time_s,power_w\n0,1\n5,\n4,1\n").starts_with(":4:time_s: time 4 follows 5"));
}

#[test]
fn time_may_restart_where_the_run_changes() {
    let log = log("time_s,run,power_w\n0,first,1\n1,first,1\n0,second,1\n1,second,1\n");
    let requests = [ColumnRequest::required("time_s", Role::Time), ColumnRequest::required("run", Role::Run)];
    let mut reader = LogReader::open(&Context::default(), &log.path, &requests).unwrap();
    let (mut runs, mut values) = (Vec::new(), [0.0; 2]);
    while reader.next_row(&mut values).unwrap().is_some() {
        runs.push(values[1]);
    }
    assert_eq!(runs, [0.0, 0.0, 1.0, 1.0]);
    assert_eq!(reader.run_names(), ["first", "second"]);
}

#[test]
fn rows_without_a_finite_number_are_excluded_and_counted() {
    let log = log("time_s,power_w,mass_kg\n0,1,\n1,NaN,2\n2,,2\n3,inf,2\n4,5,2\n");
    let (rows, reader) = rows(&log).unwrap();
    assert_eq!(rows.iter().map(|row| row[0]).collect::<Vec<_>>(), [0.0, 4.0]);
    assert!(rows[0][2].is_nan(), "an optional number may be missing");
    let expected = "excluded 3 rows with NaN, inf or no value (first: line 3)";
    assert_eq!(reader.exclusions().to_string(), expected);
}

#[test]
fn a_last_line_that_was_cut_is_excluded_even_if_its_fields_look_whole() {
    for tail in ["3,12", "3", "3,"] {
        let log = log(format!("time_s,power_w\n0,1\n1,1\n2,1\n{tail}"));
        let (rows, reader) = rows(&log).unwrap();
        assert_eq!(rows.len(), 3);
        let expected = "excluded 1 last line without a line end (the file was cut there)";
        assert_eq!(reader.exclusions().to_string(), expected);
    }
}

#[test]
fn logs_without_two_rows_say_so() {
    assert_eq!(message(""), ": is empty; expected a run log: a CSV header and at least two rows");
    assert_eq!(message("time_s,power_w\n"), ": the log has no row to use; expected at least two");
    assert_eq!(message("time_s,power_w\n0,1\n"), ": the log has only one row to use; expected at least two");
    assert!(message("time_s,power_w\n0,NaN\n1,NaN\n").contains("excluded 2 rows"));
    assert!(message("time_s,pow").contains("ends within its header"));
}

#[test]
fn what_is_no_log_says_what_it_is() {
    assert!(message([0x1e, 0x8b, 0x08, b'a', b'\n', 0xff]).contains("not UTF-8 text"));
    assert!(message([0x1f, 0x8b, 0x08, b'a', b'\n', 0xff]).contains("is compressed as a whole (gzip)"));
    assert!(message(b"PAR2\0\0\n").contains("not text"));
    assert!(
        message(b"PAR1\0\0\n").contains("is no Parquet file") || message(b"PAR1\0\0\n").contains("cut off")
    );
    assert!(message([0xff, 0xfe, b't', 0, b'\n', 0]).contains("UTF-16"));
    assert!(message("time_s;power_w\n0;1\n1;2\n").contains("separated by ';'; expected commas"));
    assert!(message("0,1\n1,2\n").contains("expected a header"));
    let expected = ":1:power_w: the header names this column twice; expected every name once";
    assert_eq!(message("time_s,power_w,power_w\n0,1,1\n"), expected);
    assert!(message("time_s,power_w\n0,1\n\n1,2\n").starts_with(":3: blank line in the middle"));
    assert!(message(vec![b'x'; 3 << 20]).contains("no line end within"));
}

#[test]
fn paths_that_are_no_file_say_so() {
    let folder = tempfile::tempdir().unwrap();
    let error = Header::open(&Context::default(), folder.path()).err().unwrap().to_string();
    assert!(error.contains("is a folder; expected a run log"), "{error}");
    let error =
        Header::open(&Context::default(), &folder.path().join("absent.csv")).err().unwrap().to_string();
    assert!(error.contains("absent.csv: No such file"), "{error}");
}

fn drive(content: &str) -> Result<(Vec<Record>, DriveReader), Error> {
    let log = log(content);
    let mut reader = DriveReader::open(&Context::default(), &log.path, &Robot::named("burger").unwrap())?;
    let mut records = Vec::new();
    while let Some(record) = reader.next_record()? {
        records.push(record);
    }
    Ok((records, reader))
}

#[test]
fn a_drive_gives_wheels_payload_and_segments() {
    let mut text =
        "time_s,wheel1_rad_s,wheel2_rad_s,power_w,mass_kg,wheel1_rad_s2,wheel2_rad_s2\n".to_owned();
    for step in 0..20 {
        let time = f64::from(step) * 0.1 + if step >= 10 { 5.0 } else { 0.0 };
        let mass = if step < 5 { "" } else { "3" };
        writeln!(text, "{time},{step},-{step},4.5,{mass},0.25,0.5").unwrap();
    }
    let (records, reader) = drive(&text).unwrap();
    assert_eq!(records.len(), 20);
    assert_eq!(records[7].wheel_speed, [7.0, -7.0].into());
    assert_eq!(records[7].wheel_acceleration, Some([0.25, 0.5].into()));
    assert_eq!((records[4].mass_kg, records[5].mass_kg), (None, Some(3.0)));
    assert_eq!(records[7].line, 9);
    let starts: Vec<_> = (0..20).filter(|&k| records[k].starts_segment).collect();
    assert_eq!(starts, [0, 10], "the first row, and the one behind the gap of 5 s");
    let (gaps, longest) = reader.gaps();
    let longest = longest.unwrap();
    assert_eq!((gaps, longest.line), (1, 12));
    assert!((longest.to_s - longest.from_s - 5.1).abs() < 1e-9);
    assert!((reader.period_s() - 0.1).abs() < 1e-9);
}

#[test]
fn a_drive_of_another_robot_is_refused() {
    let header = "time_s,wheel1_rad_s,wheel2_rad_s,wheel3_rad_s,power_w";
    let text = drive(&format!("{header}\n0,1,1,1,1\n1,1,1,1,1\n")).err().unwrap();
    let expected =
        "the log has 3 wheel speed columns, but robot TurtleBot3 Burger has 2 wheels: wrong robot?";
    assert!(text.to_string().ends_with(expected), "{text}");
    let text = drive("time_s,wheel1_rad_s,power_w\n0,1,1\n1,1,1\n").err().unwrap().to_string();
    assert!(text.contains("the log has 1 wheel speed column, but"), "{text}");
    let text = drive("time_s,power_w\n0,1\n1,1\n").err().unwrap().to_string();
    assert!(text.contains("column wheel1_rad_s is missing"), "{text}");
}

#[test]
fn accelerations_of_some_wheels_only_are_refused() {
    let header = "time_s,wheel1_rad_s,wheel2_rad_s,wheel1_rad_s2,power_w";
    let text = drive(&format!("{header}\n0,1,1,1,1\n1,1,1,1,1\n")).err().unwrap().to_string();
    assert!(text.contains("column wheel2_rad_s2 is missing"), "{text}");
}

#[test]
fn time_in_milliseconds_is_recognised() {
    let text = drive("time_s,wheel1_rad_s,wheel2_rad_s,power_w\n0,1,1,1\n50,1,1,1\n100,1,1,1\n");
    let text = text.err().unwrap().to_string();
    assert!(text.contains(":2:time_s: the median step is 50 s; expected seconds"), "{text}");
}

#[test]
fn a_fault_among_the_rows_read_ahead_comes_after_the_rows_before_it() {
    let log = log("time_s,wheel1_rad_s,wheel2_rad_s,power_w\n0,1,1,1\n1,1,1,1\n2,1,1,1\n3,1,x,1\n");
    let mut reader =
        DriveReader::open(&Context::default(), &log.path, &Robot::named("burger").unwrap()).unwrap();
    for _ in 0..3 {
        assert!(reader.next_record().unwrap().is_some());
    }
    let error = reader.next_record().unwrap_err().to_string();
    assert!(error.contains(":5:wheel2_rad_s: \"x\" is not a number"), "{error}");
}

#[test]
fn extra_columns_come_with_their_row() {
    let mut text = "time_s,wheel1_rad_s,wheel2_rad_s,power_w,pitch_rad\n".to_owned();
    for row in 0..6000 {
        writeln!(text, "{row},1,1,1,{}", 2 * row).unwrap();
    }
    let log = log(text);
    let robot = Robot::named("burger").unwrap();
    let mut reader = DriveReader::open_with(&Context::default(), &log.path, &robot, &["pitch_rad"]).unwrap();
    let mut rows = 0;
    while let Some(record) = reader.next_record().unwrap() {
        assert_eq!(reader.extras(), [2.0 * record.time_s]);
        rows += 1;
    }
    assert_eq!(rows, 6000);
}

/// Rows a second of the typed reader, printed; run with `--release --ignored --nocapture`.
#[test]
#[ignore = "a measurement, 300 MB of disk"]
fn throughput() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.csv");
    {
        use std::io::Write as _;
        let mut file = std::io::BufWriter::new(std::fs::File::create(&path).unwrap());
        writeln!(file, "time_s,wheel1_rad_s,wheel2_rad_s,power_w").unwrap();
        for row in 0..10_000_000_u64 {
            let wave = (row as f64 * 0.001).sin();
            writeln!(
                file,
                "{:.3},{:.5},{:.5},{:.3}",
                row as f64 * 0.005,
                6.0 * wave,
                -5.0 * wave,
                4.0 + wave
            )
            .unwrap();
        }
    }
    let megabytes = std::fs::metadata(&path).unwrap().len() as f64 / 1e6;
    let robot = Robot::named("burger").unwrap();
    for _ in 0..3 {
        let start = std::time::Instant::now();
        let mut reader = DriveReader::open(&Context::default(), &path, &robot).unwrap();
        let (mut rows, mut sum) = (0_u64, 0.0);
        while let Some(record) = reader.next_record().unwrap() {
            rows += 1;
            sum += record.power_w + record.wheel_speed[0];
        }
        let seconds = start.elapsed().as_secs_f64();
        println!(
            "{rows} rows, {megabytes:.0} MB in {seconds:.2} s: {:.0} MB/s (sum {sum:.1})",
            megabytes / seconds
        );
    }
}
