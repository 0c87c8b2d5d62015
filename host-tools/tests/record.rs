//! Recording a board: over a clean line, over bad ones, and when the cable is pulled.

#[path = "common/board.rs"]
mod board;
mod common;

use std::ops::ControlFlow;
use std::time::Duration;

use board::{BadLine, Fault, TestBoard, sample};
use firmware::control_table as table;
use firmware::record::Record;
use host_tools::board::client::Client;
use host_tools::board::recorder::{Ending, Options, Recording, record};
use host_tools::board::transport::Transport;
use host_tools::error::Result;

/// Records into a text.
fn recorded<T: Transport>(line: T, options: &Options) -> (Result<Recording>, String, Client<T>) {
    let (mut client, found) = Client::connect(line).unwrap();
    let mut text = String::new();
    let result = record(
        &mut client,
        &found,
        options,
        &mut |lines| {
            assert!(lines.ends_with('\n'), "a line without its end");
            text.push_str(lines);
            Ok(())
        },
        &mut |_| ControlFlow::Continue(()),
    );
    (result, text, client)
}

fn seconds(seconds: u64) -> Options {
    Options { duration: Some(Duration::from_secs(seconds)), mass_kg: None }
}

/// The fields of a line; `None` where there is nothing.
fn fields(line: &str) -> Vec<Option<f64>> {
    line.split(',').map(|field| (!field.is_empty()).then(|| field.parse().unwrap())).collect()
}

/// Number of the sample at this time: see [`sample`].
fn sequence(time_s: f64) -> u32 {
    (time_s * board::RATE_HZ as f64).round() as u32 - 1
}

/// The speeds and powers of every line are those of the sample at its time, bit for bit.
fn assert_samples(text: &str) {
    for line in text.lines().skip(1) {
        let fields = fields(line);
        let Record { wheel_speed, rail_power, battery_voltage, .. } = sample(sequence(fields[0].unwrap()));
        let [left, right] = wheel_speed.unwrap();
        let expected = [Some(left), Some(right), rail_power[1], battery_voltage];
        let found: Vec<Option<f32>> =
            line.split(',').skip(1).map(|field| field.parse().ok()).take(4).collect();
        assert_eq!(found, expected, "{line}");
        assert_eq!(
            fields[5..9],
            rail_power.map(|power| power.map(|power| power.to_string().parse().unwrap()))
        );
    }
}

/// Every sample from the first to the last is there, once.
fn assert_continuous(text: &str) {
    let times: Vec<u32> = text.lines().skip(1).map(|line| sequence(fields(line)[0].unwrap())).collect();
    assert!(!times.is_empty());
    for pair in times.windows(2) {
        assert_eq!(pair[1], pair[0] + 1);
    }
}

#[test]
fn every_sample_of_the_duration_is_in_the_log() {
    let (recording, text, client) = recorded(TestBoard::new(), &seconds(10));
    let recording = recording.unwrap();
    assert!(matches!(recording.ending, Ending::Complete));
    assert_eq!((recording.rows, recording.lost, recording.incomplete, client.retries()), (2000, 0, 0, 0));
    assert_eq!(text.lines().count(), 2001);
    assert_eq!(
        text.lines().next().unwrap(),
        "time_s,wheel1_rad_s,wheel2_rad_s,power_w,bus_v,battery_w,motors_w,computer_w,lidar_w,board_power_w,\
         board_mass_kg,board_mass_low_kg,board_mass_high_kg"
    );
    assert_continuous(&text);
    assert_samples(&text);
}

/// 80 samples were taken before anybody asked.
#[test]
fn the_log_begins_when_it_is_asked_for() {
    let (_, text, _) = recorded(TestBoard::new(), &seconds(1));
    let first = sequence(fields(text.lines().nth(1).unwrap())[0].unwrap());
    assert!((80..90).contains(&first), "{first}");
}

#[test]
fn what_is_unknown_is_empty() {
    let (_, text, _) = recorded(TestBoard::new(), &seconds(1));
    for line in text.lines().skip(1) {
        let fields = fields(line);
        // No lidar; no mass before sample 100.
        assert_eq!(fields[8], None, "{line}");
        assert_eq!(fields[10].is_some(), sequence(fields[0].unwrap()) >= 100, "{line}");
        assert!(!line.contains("NaN"));
    }
}

#[test]
fn the_columns_are_those_there_is_something_for() {
    let mut without = TestBoard::new();
    // None stored.
    without.put(&table::COEFFICIENTS_STATE, &[1]);
    let options = Options { mass_kg: Some(2.5), ..seconds(1) };
    let (_, text, _) = recorded(without, &options);
    assert!(text.lines().next().unwrap().ends_with(",lidar_w,mass_kg"), "{text}");
    assert!(text.lines().skip(1).all(|line| line.ends_with(",2.5")));
}

/// Whatever a bad line does, it costs time and no sample.
#[test]
fn bad_lines_lose_no_sample() {
    let late = Duration::from_millis(300);
    for fault in [
        Fault::LostRequest(7),
        Fault::BrokenRequest(7),
        Fault::LostAnswer(7),
        Fault::ShortAnswer(7),
        Fault::BrokenAnswer(3),
        Fault::DoubledAnswer(2),
        Fault::LateAnswer(9, late),
    ] {
        let (recording, text, client) = recorded(BadLine::new(TestBoard::new(), fault), &seconds(20));
        let recording = recording.unwrap_or_else(|error| panic!("{fault:?}: {error}"));
        assert!(matches!(recording.ending, Ending::Complete), "{fault:?}: {:?}", recording.ending);
        assert_eq!((recording.rows, recording.lost), (4000, 0), "{fault:?}");
        assert_continuous(&text);
        assert_samples(&text);
        assert_eq!(client.retries() > 0, !matches!(fault, Fault::DoubledAnswer(_)), "{fault:?}");
    }
}

/// A board that remembers 12 samples: a lost answer, noticed after 50 ms, costs some.
#[test]
fn lost_samples_are_counted() {
    let mut small = TestBoard::new();
    small.capacity = 12;
    let (recording, text, _) = recorded(BadLine::new(small, Fault::LostAnswer(40)), &seconds(20));
    let recording = recording.unwrap();
    assert!(recording.lost > 0);
    assert_eq!(recording.rows + recording.lost, 4000, "{} lost", recording.lost);
    assert_eq!(text.lines().count() as u64, recording.rows + 1);
    assert_samples(&text);
}

#[test]
fn a_pulled_cable_leaves_a_log_up_to_the_last_sample() {
    let mut pulled = TestBoard::new();
    pulled.pulled_at = Some(Duration::from_millis(5_123));
    let (recording, text, _) = recorded(pulled, &seconds(60));
    let recording = recording.unwrap();
    let Ending::Lost(error) = &recording.ending else { panic!("{:?}", recording.ending) };
    assert!(error.to_string().contains("the port is gone"), "{error}");
    assert_continuous(&text);
    let last = fields(text.lines().last().unwrap())[0].unwrap();
    // It is asked every 40 ms.
    assert!((5.05..5.13).contains(&last), "{last}");
    assert_eq!(recording.rows as usize, text.lines().count() - 1);
}

#[test]
fn a_cable_pulled_at_once_is_an_error() {
    let mut pulled = TestBoard::new();
    // After three instructions of 0.5 ms, which say who is there.
    pulled.pulled_at = Some(pulled.now() + Duration::from_millis(32));
    let (mut client, found) = Client::connect(pulled).unwrap();
    let mut text = String::new();
    let mut append = |lines: &str| {
        text.push_str(lines);
        Ok(())
    };
    let result = record(&mut client, &found, &seconds(1), &mut append, &mut |_| ControlFlow::Continue(()));
    assert!(result.unwrap_err().to_string().contains("the port is gone"));
    assert_eq!(text, "");
}

#[test]
fn a_board_that_starts_again_ends_the_log() {
    let mut restarting = TestBoard::new();
    restarting.restart_at = Some(Duration::from_secs(3));
    let (recording, text, _) = recorded(restarting, &seconds(60));
    let recording = recording.unwrap();
    assert!(matches!(recording.ending, Ending::Restarted), "{:?}", recording.ending);
    assert_continuous(&text);
    let last = fields(text.lines().last().unwrap())[0].unwrap();
    assert!((2.9..=3.0).contains(&last), "{last}");
}

#[test]
fn a_board_that_takes_no_samples_is_no_wait_for_ever() {
    let mut idle = TestBoard::new();
    idle.is_sampling = false;
    let (recording, text, client) = recorded(idle, &Options::default());
    assert!(recording.unwrap_err().to_string().contains("no sample for 5 s"));
    assert!(client.now() < Duration::from_secs(7));
    assert_eq!(text, "");
}

#[test]
fn whoever_watches_may_stop() {
    let (mut client, found) = Client::connect(TestBoard::new()).unwrap();
    let mut text = String::new();
    let mut append = |lines: &str| {
        text.push_str(lines);
        Ok(())
    };
    let recording = record(&mut client, &found, &Options::default(), &mut append, &mut |now| {
        if now.rows >= 100 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    let recording = recording.unwrap();
    assert!(matches!(recording.ending, Ending::Stopped));
    assert!((100..116).contains(&recording.rows), "{}", recording.rows);
}
