//! Calls that read bags at the same time.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::{TryLockError, mpsc};
use std::thread;
use std::time::Duration;

use support::context::Context;

use super::{Known, Reading, prepare};
use crate::robot::Robot;
use crate::{ColumnRequest, LogReader, MASS, POWER, Role};

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../formats/tests/data").join(name)
}

/// A robot whose power is read from this topic.
fn robot(topic: &str) -> Robot {
    let text = include_str!("../../../robots/burger.toml");
    Robot::parse(&format!("{text}\n[topics]\npower = \"{topic}\"\n")).unwrap()
}

fn context(topic: &str) -> Context {
    Context::default().with_reading(Reading { robot: robot(topic), allow_cut: false, verbose: true })
}

/// Powers and masses of a log's rows.
fn rows(context: &Context, log: &Path) -> Vec<[f64; 2]> {
    let requests = [POWER, MASS].map(|name| ColumnRequest::required(name, Role::Number));
    let mut reader = LogReader::open(context, log, &requests).unwrap();
    let (mut row, mut rows) = ([0.0; 2], Vec::new());
    while reader.next_row(&mut row).unwrap().is_some() {
        rows.push(row);
    }
    rows
}

/// Two hundred times two robots read the same two bags at once: power is what each robot's file
/// says, in every row, and so is what is said of it.
#[test]
fn each_call_reads_by_its_own_robot() {
    let bags = ["drive.mcap", "second.mcap"].map(data);
    let read = |topic: &str, is_right: fn(&[f64; 2]) -> bool| {
        for place in 0..200 {
            let (context, bag) = (context(topic), &bags[place % 2]);
            let rows = rows(&context, bag);
            let said = context.take_notices().lines.join("\n");
            assert!(rows.len() > 1000 && rows.iter().all(is_right), "{topic}, pair {place}");
            assert!(said.contains(&format!("power_w from {topic}")), "{said}");
        }
    };
    thread::scope(|scope| {
        scope.spawn(|| read("/total_mass:data", |[power, mass]| power == mass));
        scope.spawn(|| read("/power:data", |[power, mass]| power != mass));
    });
}

/// A bag comes through a pipe whose writer takes its time. Whoever reads another one of the same
/// call meanwhile does not wait for it.
#[test]
fn a_slow_bag_keeps_no_other_waiting() {
    let [slow, other] = ["second.mcap", "drive.mcap"].map(data);
    let bytes = std::fs::read(slow).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe.mcap");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let context = context("/power:data");
    thread::scope(|scope| {
        let slow = scope.spawn(|| rows(&context, &pipe).len());
        let mut writer = std::fs::OpenOptions::new().write(true).open(&pipe).unwrap();
        writer.write_all(&bytes[..1000]).unwrap();
        // Until it is being turned into rows, by whatever lock.
        let known = context.kept::<Known>();
        let is_begun = || match known.try_lock() {
            Ok(known) => known.contains_key(&pipe),
            Err(TryLockError::WouldBlock) => true,
            Err(TryLockError::Poisoned(_)) => false,
        };
        while !is_begun() {
            thread::sleep(Duration::from_millis(1));
        }
        let (sender, receiver) = mpsc::channel();
        let (context, other) = (&context, &other);
        scope.spawn(move || sender.send(rows(context, other).len()));
        let read = receiver.recv_timeout(Duration::from_secs(30));
        writer.write_all(&bytes[1000..]).unwrap();
        drop(writer);
        assert!(read.is_ok_and(|count| count > 1000), "{read:?}");
        assert!(slow.join().unwrap() > 1000);
    });
}

/// What was turned into rows before it is opened is said where it is opened, once; the rows go with
/// the call.
#[test]
fn rows_go_when_the_call_ends() {
    let bags = ["drive.mcap", "second.mcap", "drive.csv"].map(data);
    let context = context("/power:data");
    prepare(&context, &bags);
    assert!(context.take_notices().lines.is_empty());
    let known = context.kept::<Known>();
    assert_eq!(known.lock().unwrap().len(), 2);
    for _ in 0..2 {
        rows(&context, &bags[1]);
    }
    let lines = context.take_notices().lines;
    assert!(lines.len() == 1 && lines[0].contains("second.mcap: "), "{lines:?}");
    let rows_of_the_call = std::sync::Arc::downgrade(&known);
    drop((known, context));
    assert!(rows_of_the_call.upgrade().is_none());
}
