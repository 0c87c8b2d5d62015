//! Recording a board: over a clean line, over bad ones, and when the cable is pulled.

use std::ops::ControlFlow;
use std::time::Duration;

use board::client::Client;
use board::mcap_lines::McapLines;
use board::recorder::{Ending, Options, Recording, record};
use board::transport::Transport;
use support::error::Result;

use crate::common::Bench;
use crate::common::board::{BadLine, Fault, TestBoard, sample};
use firmware::control_table::{self as table, Item};
use firmware::dynamixel::packet::{Instruction, Parser, encode};
use firmware::dynamixel::status::Refusal;
use firmware::record::Record;

/// A board that estimates.
fn with_coefficients() -> TestBoard {
    TestBoard::new().holding(Item::Coefficients, &crate::common::board::burger_coefficients())
}

/// Records into a text.
fn recorded<T: Transport>(line: T, options: &Options) -> (Result<Recording>, String, Client<T>) {
    let (mut client, board) = Client::connect(line).unwrap();
    let mut text = String::new();
    let result = record(
        &mut client,
        &board,
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
    Options { duration: Some(Duration::from_secs(seconds)), ..Options::default() }
}

/// The fields of a line; `None` where there is nothing.
fn fields(line: &str) -> Vec<Option<f64>> {
    line.split(',').map(|field| (!field.is_empty()).then(|| field.parse().unwrap())).collect()
}

/// Number of the sample at this time: see [`sample`].
fn sequence(time_s: f64) -> u32 {
    (time_s * crate::common::board::RATE_HZ as f64).round() as u32 - 1
}

/// The speeds and powers of every line are those of the sample at its time, bit for bit.
fn assert_samples(text: &str) {
    for line in text.lines().skip(1) {
        let fields = fields(line);
        let Record { wheel_speed, rail_power, battery_voltage, .. } = sample(sequence(fields[0].unwrap()));
        let [left, right] = wheel_speed.unwrap();
        let expected = [Some(left), Some(right), rail_power[1], battery_voltage];
        let values: Vec<Option<f32>> =
            line.split(',').skip(1).map(|field| field.parse().ok()).take(4).collect();
        assert_eq!(values, expected, "{line}");
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

/// The same lines as MCAP: read back, every number is the same, and what is empty stays so.
#[test]
fn a_recording_as_mcap_is_the_same_log() {
    let (_, text, _) = recorded(with_coefficients(), &seconds(5));
    let bench = Bench::new();
    let file = std::fs::File::create(bench.path("run.mcap")).unwrap();
    let mut mcap = McapLines::new(file);
    // As the recorder hands them out: some lines at a time, the header with the first.
    let lines: Vec<&str> = text.split_inclusive('\n').collect();
    for some in lines.chunks(7) {
        mcap.append(&some.concat()).unwrap();
    }
    mcap.finish().unwrap();
    bench.done(&["convert", "run.mcap", "--out", "run.csv"]);
    let numbers = |text: &str| -> Vec<Vec<Option<f64>>> { text.lines().skip(1).map(fields).collect() };
    assert_eq!(numbers(&bench.text("run.csv")), numbers(&text));
    assert_eq!(bench.text("run.csv").lines().next(), text.lines().next());
}

#[test]
fn every_sample_of_the_duration_is_in_the_log() {
    let (recording, text, client) = recorded(with_coefficients(), &seconds(10));
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
    let (_, text, _) = recorded(with_coefficients(), &seconds(1));
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
    let options = Options { mass_kg: Some(2.5), ..seconds(1) };
    let (_, text, _) = recorded(TestBoard::new(), &options);
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
        Fault::Stale(11),
    ] {
        let (recording, text, client) = recorded(BadLine::new(TestBoard::new(), fault), &seconds(20));
        let recording = recording.unwrap_or_else(|error| panic!("{fault:?}: {error}"));
        assert!(matches!(recording.ending, Ending::Complete), "{fault:?}: {:?}", recording.ending);
        assert_eq!((recording.rows, recording.lost), (4000, 0), "{fault:?}");
        assert_continuous(&text);
        assert_samples(&text);
        let is_noticed = !matches!(fault, Fault::DoubledAnswer(_) | Fault::Stale(_));
        assert_eq!(client.retries() > 0, is_noticed, "{fault:?}");
    }
}

/// A board that remembers 12 samples: a lost answer, noticed after 50 ms, costs some.
#[test]
fn lost_samples_are_counted() {
    let small = TestBoard::with_memory(12);
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
    let (mut client, board) = Client::connect(pulled).unwrap();
    let mut text = String::new();
    let mut append = |lines: &str| {
        text.push_str(lines);
        Ok(())
    };
    let result = record(&mut client, &board, &seconds(1), &mut append, &mut |_| ControlFlow::Continue(()));
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
    let (mut client, board) = Client::connect(TestBoard::new()).unwrap();
    let mut text = String::new();
    let mut append = |lines: &str| {
        text.push_str(lines);
        Ok(())
    };
    let recording = record(&mut client, &board, &Options::default(), &mut append, &mut |now| {
        if now.rows >= 100 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    let recording = recording.unwrap();
    assert!(matches!(recording.ending, Ending::Stopped));
    assert!((100..116).contains(&recording.rows), "{}", recording.rows);
}

/// Something else that speaks the protocol: its model, and what it answers to a read of address
/// 512.
struct Other {
    model: u16,
    version: std::result::Result<u16, Refusal>,
    answer: Vec<u8>,
}

impl Transport for Other {
    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        let mut parser = Parser::<256>::default();
        parser.feed(bytes);
        let packet = parser.next_packet().unwrap().unwrap();
        let (error, data) = match (Instruction::from_code(packet.instruction), self.version) {
            (Some(Instruction::Ping), _) => (0, [&self.model.to_le_bytes()[..], &[5]].concat()),
            (_, Ok(version)) => (0, version.to_le_bytes().to_vec()),
            (_, Err(refusal)) => (refusal as u8, Vec::new()),
        };
        let mut buffer = [0; 256];
        let id = firmware::control_table::BOARD_ID;
        self.answer = encode(id, Instruction::Status, &[&[error], &data], &mut buffer).unwrap().to_vec();
        Ok(())
    }

    fn receive(&mut self, buffer: &mut [u8], _: Duration) -> Result<usize> {
        let count = self.answer.len().min(buffer.len());
        buffer[..count].copy_from_slice(&self.answer[..count]);
        self.answer.drain(..count);
        Ok(count)
    }

    fn now(&self) -> Duration {
        Duration::ZERO
    }
}

/// The stock firmware has the same model number, and nothing at 512: its library reads zeros there
/// or refuses (fact sheet: D2A slave.cpp).
#[test]
fn other_boards_are_told_apart() {
    let stock = "runs the stock firmware";
    for (model, version, said) in [
        (0x5000, Ok(0), stock),
        (0x5000, Err(Refusal::Range), stock),
        (0x5000, Ok(1), "is version 1; expected 5"),
        (1060, Ok(1), "is of model 0x0424; expected 0x5000"),
    ] {
        let error = Client::connect(Other { model, version, answer: Vec::new() }).err().unwrap().to_string();
        assert!(error.contains(said), "{error}");
    }
}

/// An answer that was left over is never taken for another's, of the same length or not.
#[test]
fn an_answer_belongs_to_its_question() {
    let late = Fault::LateAnswer(5, Duration::from_millis(70));
    for fault in [Fault::DoubledAnswer(1), late, Fault::Repeated] {
        let (mut client, _) = Client::connect(BadLine::new(TestBoard::new(), fault)).unwrap();
        for _ in 0..50 {
            assert_eq!(client.get::<u16>(&table::SAMPLE_RATE).unwrap(), 200, "{fault:?}");
            if !matches!(fault, Fault::Repeated) {
                // In one go with the right answer, only its length tells it apart.
                assert_eq!(client.get::<u16>(&table::RECORD_SIZE).unwrap(), 60, "{fault:?}");
            }
            assert_eq!(client.get::<u8>(&table::DEVICE_ID).unwrap(), 200, "{fault:?}");
        }
    }
}

/// A device may say that an instruction arrived broken (error 3): it is sent again, for a while.
#[test]
fn what_arrived_broken_is_sent_again() {
    let mut client =
        Client::new(Other { model: 0x5000, version: Err(Refusal::Checksum), answer: Vec::new() });
    let error = client.get::<u16>(&table::TABLE_VERSION).unwrap_err().to_string();
    assert!(error.contains("arrives broken each time"), "{error}");
    assert!(client.retries() > 5);
}

/// Nobody: an answer to that within the client's patience of 5 s and the last attempt.
#[test]
fn silence_is_no_wait_for_ever() {
    struct Silence(Duration);
    impl Transport for Silence {
        fn send(&mut self, _: &[u8]) -> Result<()> {
            Ok(())
        }
        fn receive(&mut self, _: &mut [u8], limit: Duration) -> Result<usize> {
            self.0 += limit;
            Ok(0)
        }
        fn now(&self) -> Duration {
            self.0
        }
    }
    let mut client = Client::new(Silence(Duration::ZERO));
    let error = client.ping().unwrap_err().to_string();
    assert!(error.contains("no answer for 5 s"), "{error}");
    assert!(client.now() < Duration::from_secs(6), "{:?}", client.now());
}

/// Noise: other packets and bytes that are none are passed over, and end some time.
#[test]
fn noise_is_no_answer() {
    struct Noise(u64);
    impl Transport for Noise {
        fn send(&mut self, _: &[u8]) -> Result<()> {
            Ok(())
        }
        fn receive(&mut self, buffer: &mut [u8], limit: Duration) -> Result<usize> {
            self.0 += 1 + limit.as_micros() as u64 / 10;
            // Headers without end, and once in a while silence.
            let noise = [0xFF, 0xFF, 0xFD, 0x00, BOARD, 0x04];
            let count = if self.0.is_multiple_of(3) { 0 } else { buffer.len().min(noise.len()) };
            buffer[..count].copy_from_slice(&noise[..count]);
            Ok(count)
        }
        fn now(&self) -> Duration {
            Duration::from_micros(self.0)
        }
    }
    const BOARD: u8 = firmware::control_table::BOARD_ID;
    assert!(Client::new(Noise(0)).ping().is_err());
}

/// The command, on a serial port.
#[cfg(unix)]
mod command {
    use std::process::Stdio;
    use std::time::{Duration, Instant};

    use serde_json::Value;

    use super::{assert_continuous, assert_samples};
    use crate::common::board::TestBoard;
    use crate::common::board::terminal::Terminal;
    use crate::common::{Bench, Ran, number};

    fn two_seconds<'a>(terminal: &'a Terminal, mass: &'a str) -> [&'a str; 9] {
        ["record", "--port", terminal.name(), "--out", "run.csv", "--duration", "2", "--mass", mass]
    }

    #[test]
    fn the_log_and_the_figures() {
        let (bench, terminal) = (Bench::new(), Terminal::new(TestBoard::new()));
        let report = bench.json(&two_seconds(&terminal, "2.5"));
        assert_eq!(report["rows"], 400, "{report}");
        assert_eq!((&report["lost"], &report["ended"]), (&0.into(), &"complete".into()), "{report}");
        assert!((number(&report["rate_hz"]) - 200.0).abs() < 0.01, "{report}");
        assert_eq!(report["board"]["robot"], "TurtleBot3 Burger");
        let text = bench.text("run.csv");
        assert_eq!(text.lines().count(), 401);
        assert_continuous(&text);
        assert_samples(&text);
    }

    /// The log is one that the other commands read: rows with an empty column that is not needed
    /// count.
    #[test]
    fn other_commands_read_the_log() {
        let (bench, terminal) = (Bench::new(), Terminal::new(TestBoard::new()));
        bench.done(&two_seconds(&terminal, "1"));
        let report = bench.json(&["inspect", "--robot", "burger", "run.csv"]);
        assert_eq!(report["rows"], 400, "{report}");
        assert!((number(&report["rate_hz"]) - 200.0).abs() < 0.01, "{report}");
    }

    #[test]
    fn a_pulled_cable_is_a_failure_that_says_what_was_saved() {
        let mut pulled = TestBoard::new();
        pulled.pulled_at = Some(Duration::from_secs(2));
        let (bench, terminal) = (Bench::new(), Terminal::new(pulled));
        let Ran { code, stderr, .. } =
            bench.gmr(&["record", "--port", terminal.name(), "--out", "run.csv", "--duration", "20"]);
        assert_eq!(code, Some(1), "{stderr}");
        assert!(
            stderr.contains("the port is gone") && stderr.contains("saved up to then: run.csv: "),
            "{stderr}"
        );
        assert_eq!(stderr.lines().count(), 1, "{stderr}");
        let text = bench.text("run.csv");
        assert!(text.ends_with('\n') && text.lines().count() > 200, "{}", text.lines().count());
        assert_continuous(&text);
    }

    /// Starts a recording without an end, and does something to it after a second.
    fn interrupted(
        bench: &Bench,
        terminal: &Terminal,
        signal: rustix::process::Signal,
    ) -> std::process::Output {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_gmr"));
        command.args(["record", "--port", terminal.name(), "--out"]).arg(bench.path("run.csv"));
        let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let begun = Instant::now();
        while !bench.path("run.csv").exists() && begun.elapsed() < Duration::from_secs(20) {
            std::thread::sleep(Duration::from_millis(10));
        }
        std::thread::sleep(Duration::from_secs(1));
        let pid = rustix::process::Pid::from_child(&child);
        rustix::process::kill_process(pid, signal).unwrap();
        child.wait_with_output().unwrap()
    }

    #[test]
    fn ctrl_c_ends_a_recording_well() {
        let (bench, terminal) = (Bench::new(), Terminal::new(TestBoard::new()));
        let output = interrupted(&bench, &terminal, rustix::process::Signal::INT);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{stderr}");
        assert!(stderr.contains("samples"), "{stderr}");
        assert_continuous(&bench.text("run.csv"));
    }

    #[test]
    fn a_kill_leaves_whole_lines() {
        let (bench, terminal) = (Bench::new(), Terminal::new(TestBoard::new()));
        interrupted(&bench, &terminal, rustix::process::Signal::KILL);
        let text = bench.text("run.csv");
        assert!(text.ends_with('\n'));
        // What was taken within a second; some may not have been asked for yet.
        assert!(text.lines().count() > 150, "{}", text.lines().count());
        assert_continuous(&text);
        assert_samples(&text);
    }

    #[test]
    fn an_existing_log_stays_unless_forced() {
        let (bench, terminal) = (Bench::new(), Terminal::new(TestBoard::new()));
        bench.put("run.csv", "precious");
        let arguments = ["record", "--port", terminal.name(), "--out", "run.csv", "--duration", "0.5"];
        let ran = bench.gmr(&arguments);
        assert_eq!(ran.code, Some(1));
        assert!(ran.stderr.contains("--force"), "{}", ran.stderr);
        assert_eq!(bench.text("run.csv"), "precious");
        bench.done(&[&arguments[..], &["--force"]].concat());
        assert_eq!(bench.text("run.csv").lines().count(), 101);
    }

    /// Also with --force: the old log goes when there is something new.
    #[test]
    fn a_board_that_is_not_there_costs_no_log() {
        let bench = Bench::new();
        bench.put("run.csv", "precious");
        let ran = bench.gmr(&["record", "--port", "no-such-port", "--out", "run.csv", "--force"]);
        assert_eq!(ran.code, Some(1));
        assert!(
            ran.stderr.contains("no-such-port: there is no such port; this machine has"),
            "{}",
            ran.stderr
        );
        assert_eq!(bench.text("run.csv"), "precious");
    }

    #[test]
    fn a_port_is_for_one() {
        let (bench, terminal) = (Bench::new(), Terminal::new(TestBoard::new()));
        let _first = board::serial::Serial::open(&terminal.path).unwrap();
        let ran = bench.gmr(&["record", "--port", terminal.name(), "--out", "run.csv", "--duration", "0.2"]);
        assert_eq!(ran.code, Some(1));
        assert!(ran.stderr.contains("is in use by another program"), "{}", ran.stderr);
    }

    #[test]
    fn a_file_is_no_port() {
        let bench = Bench::new();
        bench.put("file", "text");
        let ran = bench.gmr(&["record", "--port", "file", "--out", "run.csv"]);
        assert_eq!(ran.code, Some(1));
        assert!(ran.stderr.contains("file: is no serial port"), "{}", ran.stderr);
    }

    #[test]
    fn lengths_and_masses_are_positive() {
        let bench = Bench::new();
        for wrong in [["--mass", "-1"], ["--mass", "NaN"], ["--duration", "0"], ["--duration", "-3"]] {
            let ran = bench.gmr(&[&["record", "--port", "p", "--out", "run.csv"], &wrong[..]].concat());
            assert_eq!(ran.code, Some(2), "{wrong:?}: {}", ran.stderr);
        }
    }

    #[test]
    fn watching_shows_what_the_board_knows() {
        let mut board = TestBoard::new();
        board.state.snapshot.rails[1].power = Some(3.25);
        board.state.snapshot.rails[1].health = firmware::power_sensors::Health::Ok;
        board.state.counters.bus_errors = 7;
        let totals = firmware::totals::Totals {
            energy_mj: [7_200_000, 0, 0, 0],
            distance_cm: 1234,
            driving_s: 1800,
            on_s: 3600,
        };
        board.state.ledger.load(Ok(Some(totals)));
        let (bench, terminal) = (Bench::new(), Terminal::new(board));
        let status = bench.json(&["watch", "--once", "--port", terminal.name()]);
        assert_eq!(
            (&status["rails"][1]["power_w"], &status["rails"][1]["health"]),
            (&3.25.into(), &"ok".into())
        );
        assert_eq!(
            (&status["rails"][0]["power_w"], &status["mass_kg"]),
            (&Value::Null, &Value::Null),
            "{status}"
        );
        assert_eq!(status["rails"][0]["total_j"], 7200.0);
        assert_eq!(
            (&status["totals"]["distance_m"], &status["totals"]["unkept"]),
            (&12.34.into(), &Value::Null),
            "{status}"
        );
        assert_eq!(status["faults"], serde_json::json!([["I2C errors", 7]]));
        let text = bench.done(&["watch", "--once", "--port", terminal.name()]).stdout;
        for said in [
            "TurtleBot3 Burger",
            "motors     3.250 W",
            "nothing is stored",
            "I2C errors 7",
            "12.3 m in 0.50 of 1.00 h",
        ] {
            assert!(text.contains(said), "{said}: {text}");
        }
    }

    /// What PlotJuggler gets: each look as a datagram, the very line of --json; nobody listening is
    /// no fault.
    #[test]
    fn watching_sends_each_look_where_it_is_told() {
        let mut board = TestBoard::new();
        board.state.snapshot.rails[1].power = Some(3.25);
        board.state.snapshot.rails[1].health = firmware::power_sensors::Health::Ok;
        let (bench, terminal) = (Bench::new(), Terminal::new(board));
        let listener = std::net::UdpSocket::bind("127.0.0.1:0").unwrap();
        listener.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
        let to = listener.local_addr().unwrap().to_string();
        let ran = bench.done(&["watch", "--once", "--json", "--port", terminal.name(), "--udp", &to]);
        let mut datagram = [0; 65_536];
        let (size, _) = listener.recv_from(&mut datagram).unwrap();
        let sent = std::str::from_utf8(&datagram[..size]).unwrap();
        assert_eq!(sent, ran.stdout.trim_end());
        let status: Value = serde_json::from_str(sent).unwrap();
        assert_eq!((&status["version"], &status["rails"][1]["power_w"]), (&1.into(), &3.25.into()));
        drop(listener);
        bench.done(&["watch", "--once", "--port", terminal.name(), "--udp", &to]);
        let ran = bench.gmr(&["watch", "--once", "--port", terminal.name(), "--udp", "nowhere"]);
        assert!(ran.code == Some(2) && ran.stderr.contains("expected HOST:PORT"), "{}", ran.stderr);
    }

    /// Without the feature the command says how it is built with it, before it looks for a board.
    #[cfg(not(feature = "foxglove"))]
    #[test]
    fn a_live_view_is_a_feature() {
        let bench = Bench::new();
        let ran = bench.gmr(&["record", "--port", "no-such-port", "--out", "run.csv", "--foxglove"]);
        assert!(ran.code == Some(2) && ran.stderr.contains("--features foxglove"), "{}", ran.stderr);
    }

    /// Windows a second through a pseudo terminal, printed; run with
    /// `--release --ignored --nocapture`.
    #[test]
    #[ignore = "a measurement"]
    fn throughput() {
        use board::client::Client;
        use board::serial::Serial;

        use super::table;

        let terminal = Terminal::new(TestBoard::new());
        let (mut client, _) = Client::connect(Serial::open(&terminal.path).unwrap()).unwrap();
        let begun = Instant::now();
        let windows = 2000;
        for _ in 0..windows {
            client.set(&table::FIFO_ACKNOWLEDGE, 0_u32).unwrap();
            client.block(&table::FIFO_ACKNOWLEDGE, &table::FIFO_WINDOW).unwrap();
        }
        let rate = f64::from(windows) / begun.elapsed().as_secs_f64();
        println!("{rate:.0} windows a second: {:.0} records", rate * table::FIFO_WINDOW_RECORDS as f64);
    }
}
