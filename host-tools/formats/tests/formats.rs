//! Logs of writers that are not ours (tests/data/make.py), and what is wrong with logs.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use log_formats::merge::{Clock, Merged, Request, merge};
use log_formats::table::{self, Cell, Taker};
use log_formats::write::{Mcap, Parquet};
use log_formats::{Bag, Ending, Error, Field, Result, paths};

/// When the drive of tests/data began.
const START_NS: i64 = 1_760_000_000_000_000_000;

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

fn fields(names: &[&str]) -> Vec<Field> {
    names.iter().map(|name| Field::parse(name).unwrap()).collect()
}

fn request(base: &[&str], others: &[&str]) -> Request {
    Request { base: fields(base), others: fields(others), greatest_gap_s: 2.0, clock: Clock::Stamp }
}

fn rows(bag: &Bag, request: &Request) -> Result<(Vec<Vec<f64>>, Merged)> {
    let mut rows = Vec::new();
    let merged = merge(bag, request, &mut |time, numbers| {
        rows.push([&[time], numbers].concat());
        Ok(())
    })?;
    Ok((rows, merged))
}

#[derive(Default)]
struct Table {
    columns: Vec<String>,
    rows: Vec<Vec<Cell>>,
}

impl Taker for Table {
    fn columns(&mut self, columns: &[String]) -> Result<()> {
        self.columns = columns.to_vec();
        Ok(())
    }
    fn row(&mut self, row: &[Cell]) -> Result<()> {
        self.rows.push(row.to_vec());
        Ok(())
    }
}

fn csv() -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(data("drive.csv")).unwrap();
    text.lines().skip(1).map(|line| line.split(',').map(|field| field.parse().unwrap()).collect()).collect()
}

/// All numbers but time have 64 bits in each format: they are the same. Bags count nanoseconds,
/// ULog microseconds.
#[test]
fn the_same_drive_in_every_format_has_the_same_numbers() {
    let expected = csv();
    let ros = request(
        &["/joint_states:velocity[wheel_left_joint]", "/joint_states:velocity[wheel_right_joint]"],
        &["/power:data", "/total_mass:data"],
    );
    let px4 = request(
        &["wheel_encoders:wheel_speed[1]", "wheel_encoders:wheel_speed[0]"],
        &["drive_power:power_w", "payload:mass_kg"],
    );
    for (file, request) in
        [("drive.mcap", &ros), ("second.mcap", &ros), ("drive.db3", &ros), ("drive.ulg", &px4)]
    {
        let bag = Bag::open(&data(file), false).unwrap();
        let (read, merged) = rows(&bag, request).unwrap();
        assert_eq!((read.len(), merged.ending), (expected.len(), Ending::Whole), "{file}");
        for (row, expected) in read.iter().zip(&expected) {
            assert!((row[0] - expected[0]).abs() < 1e-9, "{file}");
            assert_eq!(row[1..], expected[1..], "{file}");
        }
    }
    let mut table = Table::default();
    table::parquet(&data("drive.parquet"), &mut table).unwrap();
    assert_eq!(table.columns, ["time_s", "wheel1_rad_s", "wheel2_rad_s", "power_w", "mass_kg"]);
    let numbers = |row: &Vec<Cell>| {
        row.iter().map(|cell| if let Cell::Number(x) = cell { *x } else { f64::NAN }).collect()
    };
    let read: Vec<Vec<f64>> = table.rows.iter().map(numbers).collect();
    assert_eq!(read, expected);
}

/// What MCAP's writer in TypeScript leaves (make_third.mjs): with every index, without any, without
/// chunks, and of ROS 1.
#[test]
fn the_same_drive_in_every_form_of_mcap_has_the_same_numbers() {
    let expected = &csv()[..200];
    let ros = request(
        &["/joint_states:velocity[wheel_left_joint]", "/joint_states:velocity[wheel_right_joint]"],
        &["/power:data", "/total_mass:data"],
    );
    for file in ["core-zstd.mcap", "core-bare.mcap", "core-plain.mcap", "core-ros1.mcap"] {
        let bag = Bag::open(&data(file), false).unwrap();
        let (read, merged) = rows(&bag, &ros).unwrap();
        assert_eq!((read.len(), merged.ending, merged.start_ns), (200, Ending::Whole, START_NS), "{file}");
        for (row, expected) in read.iter().zip(expected) {
            assert!((row[0] - expected[0]).abs() < 1e-9, "{file}");
            assert_eq!(row[1..], expected[1..], "{file}");
        }
    }
}

/// The examples that MCAP's makers publish with their crate: an excerpt of their demo.bag, messages
/// of ROS 1. The expected numbers are those of their own reader (PyPI: mcap 1.6.0,
/// mcap-ros1-support 0.9.0; `iter_decoded_messages` with `log_time_order=False`).
#[test]
fn the_examples_of_its_makers_are_read() {
    let Some(folder) = makers_folder() else {
        // As tests/suite/common/skipped.rs says it.
        let why = "the source of the crate mcap is not in cargo's registry";
        let _ = writeln!(std::io::stdout(), "\nSKIPPED: formats::the_examples_of_its_makers_are_read: {why}");
        return;
    };
    for file in ["compressed.mcap", "uncompressed.mcap"] {
        let bag = Bag::open(&folder.join(file), false).unwrap();
        let topics: Vec<_> = bag.topics().iter().map(|topic| (&topic.name[..], topic.messages)).collect();
        assert_eq!(topics, [("/diagnostics", Some(52)), ("/tf", Some(774))], "{file}");
        let frame = "/tf:transforms[0]";
        let of = |path: &str| format!("{frame}.{path}");
        let (x, stamp) = (of("transform.translation.x"), of("header.stamp.nanosec"));
        let (read, merged) = rows(&bag, &request(&[&x, &stamp], &[])).unwrap();
        // By the element's own stamp: 22 were received together with the one before them.
        assert_eq!((read.len(), merged.out_of_order), (774, 0), "{file}");
        assert_eq!(merged.start_ns, 1_490_149_580_117_017_840, "{file}");
        let sums = |rows: &[Vec<f64>]| [1, 2].map(|place| rows.iter().map(|row| row[place]).sum::<f64>());
        let [x, stamps] = sums(&read);
        assert!((x - 2968.29).abs() < 1e-9 && stamps == 387_768_142_298.0, "{file}: {x} {stamps}");
        let status = ["/diagnostics:header.seq", "/diagnostics:status[0].level"];
        let (read, merged) = rows(&bag, &request(&status, &[])).unwrap();
        // By the stamp in their headers.
        assert_eq!((read.len(), merged.start_ns), (52, 1_490_149_580_113_375_843), "{file}");
        assert_eq!(sums(&read), [280_907.0, 3.0], "{file}");
    }
}

/// Where cargo keeps the source of the crate that this one reads MCAP with; `None` where it comes
/// from elsewhere than a registry.
fn makers_folder() -> Option<PathBuf> {
    let lock = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../Cargo.lock");
    let lock = std::fs::read_to_string(lock).unwrap();
    let (_, version) = lock.split_once("name = \"mcap\"\nversion = \"").unwrap();
    let (version, _) = version.split_once('"').unwrap();
    let home = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    let home = home.or_else(|| std::env::home_dir().map(|home| home.join(".cargo")))?;
    let registries = home.join("registry/src").read_dir().ok()?;
    let folders = registries.flatten().map(|entry| entry.path().join(format!("mcap-{version}/tests/data")));
    folders.into_iter().find(|folder| folder.is_dir())
}

/// Charge is published every fourth of the base's times and falls by the same in each: what lies
/// between is on the straight line. Behind the last battery message there is none.
#[test]
fn other_topics_are_interpolated_and_never_extrapolated() {
    let bag = Bag::open(&data("turtlebot3.mcap"), false).unwrap();
    let wanted = request(&["/joint_states:velocity[wheel_left_joint]"], &["/battery_state:percentage"]);
    let (read, _) = rows(&bag, &wanted).unwrap();
    assert_eq!(read.len(), 400);
    for (place, row) in read.iter().enumerate() {
        if place > 396 {
            assert!(row[2].is_nan(), "{place}");
        } else {
            // Floats of four bytes.
            assert!((row[2] - (0.9 - 1e-4 * place as f64)).abs() < 1e-7, "{place}: {}", row[2]);
        }
    }
    let (read, _) = rows(&bag, &Request { greatest_gap_s: 0.1, ..wanted }).unwrap();
    assert!(read.iter().enumerate().all(|(place, row)| row[2].is_nan() == (place % 4 != 0)));
}

/// The arm's joints come on the same topic, and make no rows.
#[test]
fn other_publishers_of_a_topic_make_no_rows() {
    let bag = Bag::open(&data("husarion.db3"), false).unwrap();
    let joints = bag.topics().iter().position(|topic| topic.name == "/joint_states").unwrap();
    assert!(bag.names(joints).unwrap().contains(&"arm_joint".to_owned()));
    let (read, merged) = rows(&bag, &request(&["/joint_states:velocity[rr_wheel_joint]"], &[])).unwrap();
    assert_eq!((read.len(), merged.out_of_order), (400, 0));
}

/// Receipts of the TurtleBot3's are 20 ms behind its stamps; its commands have no stamp.
#[test]
fn the_clock_is_the_stamp_or_the_receipt() {
    let bag = Bag::open(&data("turtlebot3.mcap"), false).unwrap();
    let wanted = request(&["/joint_states:velocity[wheel_left_joint]"], &["/cmd_vel:linear.x"]);
    let late = |clock| {
        let (read, _) = rows(&bag, &Request { clock, ..wanted.clone() }).unwrap();
        read.iter().position(|row| !row[2].is_nan()).unwrap()
    };
    assert_eq!((late(Clock::Stamp), late(Clock::Receipt)), (1, 0));
}

#[test]
fn what_is_not_there_is_refused_with_the_nearest() {
    let bag = Bag::open(&data("turtlebot3.mcap"), false).unwrap();
    let refused = |base: &str| rows(&bag, &request(&[base], &[])).unwrap_err().to_string();
    let topic = refused("/joint_state:velocity[0]");
    assert!(topic.starts_with("has no topic /joint_state; it has: /joint_states, "), "{topic}");
    let field = refused("/battery_state:volts");
    assert!(field.contains("(sensor_msgs/msg/BatteryState) has no number volts; it has: voltage"), "{field}");
    for file in ["clearpath.mcap", "husarion.db3", "drive.ulg"] {
        let bag = Bag::open(&data(file), false).unwrap();
        assert!(bag.topics().iter().all(|topic| !paths(topic).unwrap().is_empty()), "{file}");
    }
    let bag = Bag::open(&data("compressed.db3"), false).unwrap();
    let error = rows(&bag, &request(&["/odom:twist.twist.linear.x"], &[])).unwrap_err().to_string();
    assert!(error.starts_with("topic /odom: its messages are compressed one by one (zstd)"), "{error}");
}

/// Wherever a file ends, it is refused as cut off; what is left of a bag or ULog gives the first of
/// its rows, on request.
#[test]
fn a_cut_file_is_refused_and_its_rest_read_on_request() {
    let folder = tempfile::tempdir().unwrap();
    let ros = request(&["/joint_states:velocity[wheel_left_joint]"], &[]);
    let px4 = request(&["wheel_encoders:wheel_speed[1]"], &[]);
    let whole = csv();
    for (file, request) in [("drive.mcap", &ros), ("drive.ulg", &px4)] {
        let bytes = std::fs::read(data(file)).unwrap();
        for share in [0.31, 0.61, 0.91, 0.999] {
            let cut = folder.path().join(file);
            std::fs::write(&cut, &bytes[..(share * bytes.len() as f64) as usize]).unwrap();
            let refused = Bag::open(&cut, false);
            assert!(matches!(refused, Err(Error::Truncated(_))), "{file} {share}: {refused:?}");
            let Ok(bag) = Bag::open(&cut, true) else {
                assert!(share < 0.5, "{file} {share}");
                continue;
            };
            let (read, merged) = rows(&bag, request).unwrap();
            let expected = &whole[..read.len()];
            assert!(read.iter().zip(expected).all(|(row, expected)| row[1] == expected[1]), "{file} {share}");
            assert!(share > 0.99 || matches!(merged.ending, Ending::Cut(_)), "{file} {share}");
            assert!(
                share < 0.5 || read.len() as f64 > (share - 0.35) * whole.len() as f64,
                "{file} {share}: {}",
                read.len()
            );
        }
    }
    let bytes = std::fs::read(data("drive.parquet")).unwrap();
    let cut = folder.path().join("drive.parquet");
    std::fs::write(&cut, &bytes[..bytes.len() - 10]).unwrap();
    let refused = table::parquet(&cut, &mut Table::default());
    assert!(matches!(refused, Err(Error::Truncated(_))), "{refused:?}");
}

/// A parameter whose name is said to be longer than its message, which px4-ulog 0.6.1 does not look
/// at.
#[test]
fn a_wrong_length_within_a_ulog_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("wrong.ulg");
    let mut bytes = std::fs::read(data("drive.ulg")).unwrap();
    let place = bytes.windows(17).position(|text| text == b"Fdrive_power:uint").unwrap();
    bytes[place] = b'P';
    std::fs::write(&file, bytes).unwrap();
    let error = Bag::open(&file, true).unwrap_err().to_string();
    assert!(error.contains("ULog"), "{error}");
}

/// An MCAP file of one schema, one channel and one message, by its specification; `place` names the
/// length within a record, in their order, that says 4 GB.
fn mcap_with_a_wrong_length(place: usize) -> Vec<u8> {
    const MARK: &[u8] = b"\x89MCAP0\r\n";
    let mut lengths = 0;
    let mut text = |text: &str| {
        let length = if lengths == place { u32::MAX } else { text.len() as u32 };
        lengths += 1;
        [&length.to_le_bytes(), text.as_bytes()].concat()
    };
    let schema = [&[1, 0][..], &text("p/A"), &text("ros2msg"), &text("float64 x\n")].concat();
    let [topic, encoding, key, value] = ["/t", "cdr", "key", "value"].map(&mut text);
    let map = text(&String::from_utf8_lossy(&[key, value].concat()));
    let channel = [&[1, 0, 1, 0][..], &topic, &encoding, &map].concat();
    let message = [&[1, 0][..], &[0; 4 + 8 + 8], &[0, 1, 0, 0], &1_f64.to_le_bytes()].concat();
    let record =
        |(opcode, body): (u8, &[u8])| [&[opcode], &(body.len() as u64).to_le_bytes()[..], body].concat();
    let records =
        [(1, &[0; 8][..]), (3, &schema), (4, &channel), (5, &message), (15, &[0; 4]), (2, &[0; 20])]
            .map(record);
    [MARK, &records.concat(), MARK].concat()
}

/// Each length within a record as long as it can say, in a process that may have 2 GB: the file
/// breaks off there, and no memory is asked for. Its own process, as the limit is one of processes.
#[test]
fn no_length_within_an_mcap_takes_memory() {
    const LENGTHS: usize = 8;
    const FOLDER: &str = "LOG_FORMATS_WRONG_LENGTHS";
    let file = |folder: &Path, place: usize| folder.join(format!("{place}.mcap"));
    if let Some(folder) = std::env::var_os(FOLDER) {
        let is_whole = |place| {
            let bag = Bag::open(&file(Path::new(&folder), place), false)?;
            let wanted: Vec<usize> = (0..bag.topics().len()).collect();
            Ok::<_, Error>(matches!(bag.read(&wanted, &mut |_, _, _| Ok(true))?, Ending::Whole))
        };
        let whole: Vec<bool> = (0..=LENGTHS).map(|place| is_whole(place).unwrap_or(false)).collect();
        assert_eq!(whole, [[false; LENGTHS].as_slice(), &[true]].concat());
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    for place in 0..=LENGTHS {
        std::fs::write(file(folder.path(), place), mcap_with_a_wrong_length(place)).unwrap();
    }
    let ran = std::process::Command::new("sh")
        .args(["-c", "ulimit -v 2000000; exec \"$0\" \"$@\""])
        .arg(std::env::current_exe().unwrap())
        .args(["--exact", "no_length_within_an_mcap_takes_memory"])
        .env(FOLDER, folder.path())
        .output()
        .unwrap();
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&[ran.stdout, ran.stderr].concat()));
}

#[test]
fn clocks_are_not_mixed() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mixed.mcap");
    let mut writer =
        mcap::Writer::new(std::io::BufWriter::new(std::fs::File::create(&file).unwrap())).unwrap();
    let schema = |stamped: bool| {
        let header = r#""header":{"type":"object","properties":{"stamp":{"type":"object","properties":{"sec":{"type":"integer"},"nanosec":{"type":"integer"}}}}},"#;
        format!(
            r#"{{"type":"object","properties":{{{}"x":{{"type":"number"}}}}}}"#,
            if stamped { header } else { "" }
        )
    };
    let mut channels = Vec::new();
    for (topic, stamped) in [("/a", true), ("/b", false)] {
        let id = writer.add_schema(topic, "jsonschema", schema(stamped).as_bytes()).unwrap();
        channels.push(writer.add_channel(id, topic, "json", &std::collections::BTreeMap::new()).unwrap());
    }
    for second in 0..5_u64 {
        for (place, text) in [
            format!(r#"{{"header":{{"stamp":{{"sec":{second},"nanosec":1}}}},"x":1}}"#),
            r#"{"x":2}"#.to_owned(),
        ]
        .iter()
        .enumerate()
        {
            let time = 1_700_000_000_000_000_000 + second * 1_000_000_000;
            let header = mcap::records::MessageHeader {
                channel_id: channels[place],
                sequence: 0,
                log_time: time,
                publish_time: time,
            };
            writer.write_to_known_channel(&header, text.as_bytes()).unwrap();
        }
    }
    writer.finish().unwrap();
    drop(writer);
    let bag = Bag::open(&file, false).unwrap();
    let wanted = request(&["/a:x"], &["/b:x"]);
    let error = rows(&bag, &wanted).unwrap_err().to_string();
    assert!(
        error.starts_with("mixes clocks: messages of /a are stamped, those of /b are timed by their receipt"),
        "{error}"
    );
    let (read, _) = rows(&bag, &Request { clock: Clock::Receipt, ..wanted }).unwrap();
    assert_eq!(read.len(), 5);
    assert_eq!(read[4], [4.0, 1.0, 2.0]);
}

/// Numbers whose digits are hard, in both formats that are written.
#[test]
fn what_is_written_comes_back_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let columns = ["time_s", "x", "run"].map(str::to_owned);
    let numbers =
        [0.1 + 0.2, 5e-324, -0.0, 1.797_693_134_862_315_7e308, f64::NAN, 8.41e21, 2.0_f64.powi(-1074 + 52)];
    let rows: Vec<Vec<Cell>> = numbers
        .iter()
        .enumerate()
        .map(|(place, x)| {
            vec![
                Cell::Number(place as f64 * 0.05),
                Cell::Number(*x),
                Cell::Text(format!("run {}, \"a\"", place / 3)),
            ]
        })
        .collect();
    let (parquet, mcap) = (folder.path().join("a.parquet"), folder.path().join("a.mcap"));
    let create = |path: &Path| std::fs::File::create(path).unwrap();
    let mut writer = Parquet::new(create(&parquet), &columns, &[false, false, true]).unwrap();
    rows.iter().for_each(|row| writer.row(row).unwrap());
    writer.finish().unwrap();
    let mut writer = Mcap::new(create(&mcap), &columns, &[false, false, true]).unwrap();
    rows.iter().for_each(|row| writer.row(row).unwrap());
    writer.finish().unwrap();

    let mut from_parquet = Table::default();
    table::parquet(&parquet, &mut from_parquet).unwrap();
    let bag = Bag::open(&mcap, false).unwrap();
    let mut from_mcap = Table::default();
    table::json_topic(&bag, table::topic(&bag).unwrap(), &mut from_mcap).unwrap();
    for table in [from_parquet, from_mcap] {
        assert_eq!(table.columns, columns);
        for (row, expected) in table.rows.iter().zip(&rows) {
            for (cell, expected) in row.iter().zip(expected) {
                match (cell, expected) {
                    (Cell::Number(a), Cell::Number(b)) => assert_eq!(a.to_bits(), b.to_bits(), "{a} {b}"),
                    (a, b) => assert_eq!(a, b),
                }
            }
        }
        assert_eq!(table.rows.len(), rows.len());
    }
}

/// A recording split at a time gives the rows of the whole one; each file's own mistakes are named
/// by it.
#[test]
fn a_split_recording_is_one_bag() {
    let whole = Bag::open(&data("drive.db3"), false).unwrap();
    let ros = request(&["/joint_states:velocity[wheel_left_joint]"], &["/power:data"]);
    let (expected, _) = rows(&whole, &ros).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let connection = rusqlite::Connection::open(data("drive.db3")).unwrap();
    let middle: i64 = connection
        .query_row("SELECT (min(timestamp) + max(timestamp)) / 2 FROM messages", [], |row| row.get(0))
        .unwrap();
    for (name, rest) in [("a_0.db3", ">="), ("a_1.db3", "<")] {
        std::fs::copy(data("drive.db3"), folder.path().join(name)).unwrap();
        let part = rusqlite::Connection::open(folder.path().join(name)).unwrap();
        let delete = format!("DELETE FROM messages WHERE timestamp {rest} ?1");
        assert!(part.execute(&delete, [middle]).unwrap() > 100);
    }
    let refused = |expected: &str| {
        let error = Bag::open(folder.path(), false).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    };
    refused("without metadata.yaml");
    let metadata = |files: &str| {
        let text = format!("rosbag2_bagfile_information:\n  version: 5\n  relative_file_paths:\n{files}");
        std::fs::write(folder.path().join("metadata.yaml"), text).unwrap();
    };
    metadata("");
    refused("no relative_file_paths");
    metadata("    - a_0.db3\n    - a_2.db3\n");
    refused("has no a_2.db3");
    metadata("    - ../a_0.db3\n");
    refused("expected a file of this folder");
    metadata("    - a_0.db3\n    - a_1.db3\n");
    let split = Bag::open(folder.path(), false).unwrap();
    assert_eq!(rows(&split, &ros).unwrap().0, expected);
    assert_eq!(split.topics().len(), whole.topics().len());
    std::fs::write(folder.path().join("a_1.db3"), "text").unwrap();
    refused("its file a_1.db3 is no MCAP");
}
