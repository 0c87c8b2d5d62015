//! Flashing: what is refused and why, images, and the bootloader.

use board::image_file;
use board::store_image::StoreImage;

use crate::common::{Bench, ROBOT, number};
use firmware::control_table::Item;
use firmware::items::{Calibration, RobotIdentity, check_coefficients, is_signed_by, key_of_hex, parts};

/// A robot whose filter is slow enough for boards, and its name.
const BOARD_ROBOT: (&str, &str) = ("filter_cutoff_hz = 20\n", "filter_cutoff_hz = 2\n");

/// A robot and coefficients for it, as [`common::TRUTH`] has them.
fn bench() -> Bench {
    let bench = Bench::new();
    bench.put("robot.toml", ROBOT.replace(BOARD_ROBOT.0, BOARD_ROBOT.1));
    bench.put("train.csv", crate::common::drive(40.0, 100.0, |time| if time < 20.0 { 1.0 } else { 6.0 }));
    bench.done(&["fit", "--robot", "robot.toml", "--out", "c.toml", "train.csv"]);
    bench
}

const FLASH: [&str; 5] = ["flash", "--robot", "robot.toml", "--coeffs", "c.toml"];

fn with<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&FLASH[..], more].concat()
}

/// What a store's image holds is taken by the board's own check.
#[test]
fn an_image_file_holds_what_a_board_takes() {
    let bench = bench();
    for name in ["store.bin", "store.hex"] {
        let report = bench.json(&with(&["--out", name, "--calibrate", "motors=0.998,battery=1.002"]));
        assert_eq!(report["verified"], true, "{report}");
        assert_eq!(number(&report["address"]), f64::from(0x0801_0000), "{report}");
        let mut image = image_file::read(&bench.path(name)).unwrap();
        let identity = RobotIdentity::decode(&image.stored(Item::Robot).unwrap()).unwrap();
        assert_eq!(identity.name.as_str(), "exact");
        let coefficients = image.stored(Item::Coefficients).unwrap();
        let coefficients = check_coefficients(&coefficients, &identity, 200).unwrap();
        assert!((coefficients.robot.cutoff_hz - 2.0).abs() < 1e-6);
        let calibration = Calibration::decode(&image.stored(Item::Calibration).unwrap()).unwrap();
        assert_eq!(calibration.power_factors, [1.002, 0.998, 1.0, 1.0]);
    }
    assert_eq!(std::fs::read(bench.path("store.bin")).unwrap().len(), 65536);
}

/// Intel HEX: an extended linear address 0801h first (`:02 0000 04 0801 F1`), the end record last;
/// the sum of a line's bytes is 0 (Intel, Hexadecimal Object File Format Specification, 1988).
#[test]
fn intel_hex_says_where_it_belongs() {
    let bench = bench();
    bench.done(&with(&["--out", "store.hex"]));
    let text = bench.text("store.hex");
    assert_eq!(text.lines().next(), Some(":020000040801F1"));
    assert_eq!(text.lines().last(), Some(":00000001FF"));
    assert_eq!(text.lines().count(), 2 + 65536 / 32);
    for line in text.lines() {
        let bytes = (1..line.len()).step_by(2).map(|at| u8::from_str_radix(&line[at..at + 2], 16).unwrap());
        assert_eq!(bytes.fold(0_u8, u8::wrapping_add), 0, "{line}");
    }
}

#[test]
fn a_damaged_image_file_is_noticed() {
    let bench = bench();
    bench.done(&with(&["--out", "store.hex"]));
    let text = bench.text("store.hex");
    // The second and third line of data change places: every line is sound.
    let mut swapped: Vec<&str> = text.lines().collect();
    swapped.swap(2, 3);
    assert_ne!(swapped[2], swapped[3]);
    for damaged in [
        swapped.join("\n"),
        // One address, which breaks the line's checksum; a line less; the end missing.
        text.replacen(":20002000", ":20002100", 1),
        text.lines().filter(|line| !line.starts_with(":20010000")).map(|line| format!("{line}\n")).collect(),
        text.lines().take(100).map(|line| format!("{line}\n")).collect(),
    ] {
        bench.put("damaged.hex", damaged);
        assert!(image_file::read(&bench.path("damaged.hex")).is_err());
    }
}

/// From a new key to an image whose signature is of the key that `gmr key` says.
#[test]
fn an_image_file_is_signed() {
    let bench = bench();
    let public = bench.json(&["key", "new", "robots.key"])["public_key"].as_str().unwrap().to_owned();
    assert_eq!(bench.done(&["key", "show", "robots.key"]).stdout.trim(), public);
    assert_eq!(bench.gmr(&["key", "new", "robots.key"]).code, Some(1));
    assert_eq!(
        bench.json(&with(&["--out", "store.bin", "--sign", "robots.key"]))["items"][1]["signed"],
        true
    );
    let held = image_file::read(&bench.path("store.bin")).unwrap().stored(Item::Coefficients).unwrap();
    let (image, signature) = parts(&held);
    assert!(is_signed_by(&key_of_hex(&public).unwrap(), image, signature.unwrap()));
    let ran = bench.gmr(&with(&["--out", "s.bin", "--sign", "robot.toml"]));
    assert!(ran.code == Some(1) && ran.stderr.contains("64 hexadecimal digits"), "{}", ran.stderr);
}

/// Nothing else in a store is lost by an item that is put into it.
#[test]
fn a_store_image_keeps_its_other_items() {
    let mut image = StoreImage::erased();
    assert!(image.stored(Item::Calibration).unwrap().is_empty());
    let calibration = Calibration { power_factors: [1.25, 1.0, 1.0, 0.75] }.encode();
    image.put(Item::Calibration, &calibration).unwrap();
    // Many times over: the store moves from one sector to the other.
    for round in 0..300_u16 {
        image.put(Item::Coefficients, &round.to_le_bytes().repeat(100)).unwrap();
    }
    let mut again = StoreImage::from_bytes(image.as_bytes().to_vec()).unwrap();
    assert_eq!(again.stored(Item::Calibration).unwrap(), calibration);
    assert_eq!(again.stored(Item::Coefficients).unwrap(), 299_u16.to_le_bytes().repeat(100));
    assert!(again.stored(Item::Robot).unwrap().is_empty());
    assert!(StoreImage::from_bytes(vec![0; 65535]).is_err());
}

#[test]
fn coefficients_of_another_robot_go_nowhere() {
    let bench = bench();
    bench.put("other.toml", bench.text("robot.toml").replace("track_m = 0.16", "track_m = 0.2"));
    let ran = bench.gmr(&["flash", "--robot", "other.toml", "--coeffs", "c.toml", "--out", "store.bin"]);
    assert_eq!(ran.code, Some(1));
    assert!(ran.stderr.contains("c.toml") && ran.stderr.contains("another robot"), "{}", ran.stderr);
    assert!(!bench.path("store.bin").exists());
}

#[test]
fn a_robot_with_more_wheels_is_refused() {
    let bench = bench();
    bench.put(
        "omni.toml",
        "name = \"omni\"\nkinematics = \"omni3\"\nwheel_radius_m = 0.05\narm_m = 0.2\nmass_no_load_kg = 1\n\
         mass_full_load_kg = 6\n",
    );
    let ran = bench.gmr(&["flash", "--robot", "omni.toml", "--coeffs", "c.toml", "--out", "store.bin"]);
    assert_eq!(ran.code, Some(1));
    assert!(ran.stderr.contains("has 3 driven wheels; the board drives 2"), "{}", ran.stderr);
}

/// A format that this version does not know, and a filter that a board at 200 Hz cannot have.
#[test]
fn what_no_board_would_take_is_refused_at_home() {
    let bench = bench();
    let good = bench.text("c.toml");
    for (from, to, said) in [
        ("format = 1", "format = 5", "format 5; expected 1, 2, 3 or 4"),
        ("filter_cutoff_hz = 2.0", "filter_cutoff_hz = 150.0", "cutoff is beyond"),
        ("filter_cutoff_hz = 2.0", "filter_cutoff_hz = 0.001", "expected 0.1 or more"),
        ("viscous = ", "viscous = 1e9 #", "a value that no robot has"),
        ("density_w2_s = ", "density_w2_s = 1e9 #", "a mass that stays unknown"),
    ] {
        assert!(good.contains(from), "{good}");
        bench.put("c.toml", good.replace(from, to));
        let ran = bench.gmr(&with(&["--out", "store.bin"]));
        assert_eq!(ran.code, Some(1), "{to}");
        assert!(ran.stderr.contains(said) && ran.stderr.contains("c.toml"), "{to}: {}", ran.stderr);
        assert!(!bench.path("store.bin").exists());
    }
}

#[test]
fn wrong_usage_is_said() {
    let bench = bench();
    for (arguments, said) in [
        (with(&[]), "required"),
        (with(&["--dfu", "--port", "p"]), "cannot be used with"),
        (with(&["--read", "--port", "p"]), "cannot be used with"),
        (with(&["--rollback", "--port", "p"]), "cannot be used with"),
        (vec!["flash", "--rollback", "--out", "s.bin"], "cannot be used with"),
        (with(&["--out", "store.elf"]), ".bin or .hex"),
        (with(&["--out", "s.bin", "--calibrate", "wheels=1"]), "a rail of battery, motors, computer, lidar"),
        (with(&["--out", "s.bin", "--calibrate", "motors=x"]), "RAIL=FACTOR"),
        (with(&["--out", "s.bin", "--calibrate", "motors=1,motors=1"]), "twice"),
        (with(&["--out", "s.bin", "--calibrate", "motors=3"]), "0.5 to 2"),
        (with(&["--port", "p", "--timeout", "-1"]), "0 or more"),
        (vec!["flash", "--port", "p"], "nothing to flash"),
    ] {
        let ran = bench.gmr(&arguments);
        assert_eq!(ran.code, Some(2), "{arguments:?}: {}", ran.stderr);
        assert!(ran.stderr.contains(said), "{arguments:?}: {}", ran.stderr);
    }
    assert!(!bench.path("s.bin").exists());
}

#[cfg(not(feature = "probe"))]
#[test]
fn without_the_feature_it_says_how_to_get_it() {
    let ran = bench().gmr(&with(&["--probe"]));
    assert_eq!(ran.code, Some(2));
    assert!(ran.stderr.contains("--features probe"), "{}", ran.stderr);
}

/// A board in its bootloader: a script in the place of dfu-util, with a file as its flash.
#[cfg(unix)]
mod bootloader {
    use std::process::Output;

    use super::*;

    fn gmr(bench: &Bench, arguments: &[&str], spoil: &str) -> Output {
        let programs = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/suite/common/bin");
        let path = format!("{programs}:{}", std::env::var("PATH").unwrap());
        std::process::Command::new(env!("CARGO_BIN_EXE_gmr"))
            .current_dir(bench.path(""))
            .env("PATH", path)
            .env("SPOIL", spoil)
            .args(arguments)
            .output()
            .unwrap()
    }

    fn stderr(output: &Output) -> String {
        String::from_utf8(output.stderr.clone()).unwrap()
    }

    /// Flash with somebody else's bytes: the stock firmware's settings.
    fn foreign() -> Vec<u8> {
        (0..65536_u32).map(|index| (index % 251) as u8).collect()
    }

    #[test]
    fn the_store_is_written_and_read_back() {
        let bench = bench();
        bench.put("flash.bin", foreign());
        let output = gmr(&bench, &with(&["--dfu", "--set-robot"]), "");
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let mut image = StoreImage::from_bytes(std::fs::read(bench.path("flash.bin")).unwrap()).unwrap();
        let identity = RobotIdentity::decode(&image.stored(Item::Robot).unwrap()).unwrap();
        check_coefficients(&image.stored(Item::Coefficients).unwrap(), &identity, 200).unwrap();
        // The same again has nothing to write.
        let output = gmr(&bench, &with(&["--dfu", "--set-robot"]), "");
        assert!(String::from_utf8_lossy(&output.stdout).contains("was there already"), "{output:?}");
        assert_eq!(bench.text("writes.txt"), "written\n");
        // And what was there stays.
        let output = gmr(&bench, &["flash", "--dfu", "--calibrate", "lidar=1.5"], "");
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let output = gmr(&bench, &["flash", "--dfu", "--read", "--json"], "");
        let held: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(held["robot"], "exact");
        assert_eq!(
            (&held["coefficients"]["model"], &held["coefficients"]["refused"]),
            (&"signed".into(), &serde_json::Value::Null)
        );
        assert_eq!(
            held["calibration"],
            serde_json::json!({"battery": 1.0, "motors": 1.0, "computer": 1.0, "lidar": 1.5})
        );
    }

    /// On a board in its bootloader too.
    #[test]
    fn the_set_before_comes_back() {
        let bench = bench();
        bench.put("flash.bin", foreign());
        let rollback = ["flash", "--dfu", "--rollback"];
        let output = gmr(&bench, &rollback, "");
        assert!(stderr(&output).contains("no coefficients before"), "{}", stderr(&output));
        assert_eq!(gmr(&bench, &with(&["--dfu", "--set-robot"]), "").status.code(), Some(0));
        let held = || {
            StoreImage::from_bytes(std::fs::read(bench.path("flash.bin")).unwrap())
                .unwrap()
                .stored(Item::Coefficients)
                .unwrap()
        };
        let first = held();
        bench.put("c.toml", bench.text("c.toml").replace("filter_cutoff_hz = 2.0", "filter_cutoff_hz = 2.5"));
        assert_eq!(gmr(&bench, &with(&["--dfu"]), "").status.code(), Some(0));
        assert_ne!(held(), first);
        let output = gmr(&bench, &rollback, "");
        assert!(String::from_utf8_lossy(&output.stdout).contains("in use again"), "{output:?}");
        assert_eq!(held(), first);
    }

    /// A board without an identity of its own is a TurtleBot3 Burger.
    #[test]
    fn a_board_of_another_robot_is_left_alone() {
        let bench = bench();
        bench.put("flash.bin", foreign());
        let output = gmr(&bench, &with(&["--dfu"]), "");
        assert_eq!(output.status.code(), Some(1));
        let said = stderr(&output);
        assert!(
            said.contains(
                "set up for TurtleBot3 Burger, these coefficients are for exact; nothing was stored"
            ),
            "{said}"
        );
        assert_eq!(std::fs::read(bench.path("flash.bin")).unwrap(), foreign());
    }

    #[test]
    fn what_is_read_back_is_compared() {
        let bench = bench();
        bench.put("flash.bin", foreign());
        let spoil = "printf '\\001' | dd of=flash.bin bs=1 seek=100 conv=notrunc 2>/dev/null";
        let output = gmr(&bench, &with(&["--dfu", "--set-robot"]), spoil);
        assert_eq!(output.status.code(), Some(1));
        assert!(
            stderr(&output).contains("what was read back is not what was written"),
            "{}",
            stderr(&output)
        );
    }

    #[test]
    fn no_board_and_no_program_are_said() {
        let bench = bench();
        let output = gmr(&bench, &with(&["--dfu"]), "");
        assert_eq!(output.status.code(), Some(1));
        assert!(stderr(&output).contains("hold BOOT"), "{}", stderr(&output));
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_gmr"))
            .current_dir(bench.path(""))
            .env("PATH", "no-such-folder")
            .args(with(&["--dfu"]))
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(1));
        assert!(stderr(&output).contains("sudo apt install dfu-util"), "{}", stderr(&output));
    }
}

/// A board that runs, without a serial port.
mod running {
    use std::time::Duration;

    use board::client::Client;
    use board::flasher::{Outcome, Request, Running, Target as _, flash, roll_back};
    use board::signing::SecretKey;
    use board::transport::Transport;
    use firmware::control_table::{self as table, Reason, UploadState};
    use firmware::items::is_signed_by;
    use support::error::Result;

    use super::*;
    use crate::common::board::{BadLine, Fault, TestBoard, WRITING, burger_coefficients, other_coefficients};

    /// Flashes; how often it was waited, too.
    fn flashed<T: Transport>(line: T, request: &Request, timeout_s: u64) -> (Result<Vec<Outcome>>, u32, T) {
        let (mut client, board) = Client::connect(line).unwrap();
        let mut waits = 0;
        let waiting = &mut |_| waits += 1;
        let timeout = Duration::from_secs(timeout_s);
        let result = flash(&mut Running { client: &mut client, board: &board, timeout, waiting }, request);
        (result, waits, client.into_transport())
    }

    fn coefficients() -> Request {
        Request { coefficients: Some(burger_coefficients()), ..Request::default() }
    }

    /// A TurtleBot3 with a wider track.
    fn wider() -> RobotIdentity {
        let mut identity = RobotIdentity::default();
        identity.rows[2] = identity.rows[2].map(|entry| entry * 0.9);
        identity
    }

    #[test]
    fn coefficients_are_stored_and_in_use() {
        let (result, _, board) = flashed(TestBoard::new(), &coefficients(), 60);
        let outcomes = result.unwrap();
        assert_eq!((outcomes.len(), outcomes[0].item, outcomes[0].unchanged), (1, "coefficients", false));
        let mut flash = board.flash.clone();
        assert_eq!(flash.stored(Item::Coefficients).unwrap(), burger_coefficients());
        assert!(board.state.settings().coefficients().is_ok());
        // The second time nothing is written.
        let writes = board.state.counters.store_writes;
        let (result, _, board) = flashed(board, &coefficients(), 60);
        assert!(result.unwrap()[0].unchanged);
        assert_eq!(board.state.counters.store_writes, writes);
    }

    #[test]
    fn it_waits_for_standstill() {
        let mut board = TestBoard::new();
        board.stands_at = Duration::from_secs(12);
        let (result, waits, board) = flashed(board, &coefficients(), 60);
        result.unwrap();
        // Every 0.1 s.
        assert!((100..120).contains(&waits), "{waits}");
        assert!(board.now() < Duration::from_secs(12) + WRITING + Duration::from_secs(1));
    }

    #[test]
    fn it_gives_up_in_time_and_leaves_nothing_behind() {
        let mut board = TestBoard::new();
        board.stands_at = Duration::from_secs(100);
        let (result, _, mut board) = flashed(board, &coefficients(), 5);
        let error = result.unwrap_err().to_string();
        assert!(error.contains("did not stand still within 5 s"), "{error}");
        assert!(board.now() < Duration::from_secs(7));
        assert_eq!(board.state.upload().state(), UploadState::Idle);
        board.advance(Duration::from_secs(200));
        assert!(board.flash.stored(Item::Coefficients).unwrap().is_empty());
    }

    fn rolled_back(board: TestBoard, timeout_s: u64) -> (Result<Outcome>, TestBoard) {
        let (mut client, board) = Client::connect(board).unwrap();
        let timeout = Duration::from_secs(timeout_s);
        let result =
            roll_back(&mut Running { client: &mut client, board: &board, timeout, waiting: &mut |_| {} });
        (result, client.into_transport())
    }

    /// The set before, of which only the board knows, comes back and is in use; the same once more
    /// takes it away again.
    #[test]
    fn the_set_before_comes_back() {
        let (result, board) = rolled_back(TestBoard::new(), 60);
        assert!(result.unwrap_err().to_string().contains("no coefficients before"));
        let first = other_coefficients();
        let mut board =
            board.holding(Item::Coefficients, &first).holding(Item::Coefficients, &burger_coefficients());
        for expected in [&first, &burger_coefficients()] {
            let (result, after) = rolled_back(board, 60);
            assert_eq!(result.unwrap().crc, firmware::items::checksum(expected));
            assert!(after.state.settings().coefficients().is_ok());
            let mut flash = after.flash.clone();
            assert_eq!(&flash.stored(Item::Coefficients).unwrap(), expected);
            board = after;
        }
        board.stands_at = Duration::from_secs(1000);
        let (result, board) = rolled_back(board, 5);
        assert!(result.unwrap_err().to_string().contains("did not stand still within 5 s"));
        assert_eq!(board.state.upload().state(), UploadState::Idle);
    }

    /// A flash that is full is erased without torque only: who waits in vain is told.
    #[test]
    fn torque_that_stays_on_is_said() {
        let mut board = TestBoard::new();
        board.is_full = true;
        let (result, _, board) = flashed(board, &coefficients(), 5);
        let error = result.unwrap_err().to_string();
        assert!(error.contains("torque was not off within 5 s"), "{error}");
        assert!(board.state.settings().coefficients().is_err());
    }

    /// Of a secret key of 32 sevens, by another program (Python's `cryptography`).
    const PUBLIC: [u8; 32] = [
        0xea, 0x4a, 0x6c, 0x63, 0xe2, 0x9c, 0x52, 0x0a, 0xbe, 0xf5, 0x50, 0x7b, 0x13, 0x2e, 0xc5, 0xf9, 0x95,
        0x47, 0x76, 0xae, 0xbe, 0xbe, 0x7b, 0x92, 0x42, 0x1e, 0xea, 0x69, 0x14, 0x46, 0xd2, 0x2c,
    ];

    fn is_ours(image: &[u8], signature: &[u8; 64]) -> bool {
        is_signed_by(&PUBLIC, image, signature)
    }

    /// The right key, another one, one bit of image or signature, none; and what is signed on a
    /// board that does not ask.
    #[test]
    fn a_board_with_a_key_takes_what_is_signed_with_it() {
        let key = SecretKey::from_seed([7; 32]);
        assert_eq!(key.public_hex(), PUBLIC.iter().map(|byte| format!("{byte:02x}")).collect::<String>());
        let asking = || {
            let mut board = TestBoard::new();
            board.verify = Some(is_ours);
            board.state.needs_signature = true;
            board
        };
        let image = burger_coefficients();
        let signed = key.sign(&image);
        let request = |bytes: &[u8]| Request { coefficients: Some(bytes.to_vec()), ..Request::default() };
        for board in [asking(), TestBoard::new()] {
            let (result, _, board) = flashed(board, &request(&signed), 60);
            let outcomes = result.unwrap();
            assert!(outcomes[0].signed && outcomes[0].bytes == image.len());
            assert!(board.state.settings().coefficients().is_ok());
            let mut flash = board.flash.clone();
            assert_eq!(flash.stored(Item::Coefficients).unwrap(), signed);
        }
        let mut bad = vec![SecretKey::from_seed([8; 32]).sign(&image)];
        for bit in (8 * image.len()..8 * signed.len()).step_by(37) {
            let mut flipped = signed.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            bad.push(flipped);
        }
        // Another image with this one's signature.
        bad.push([&other_coefficients()[..], &signed[image.len()..]].concat());
        for bytes in bad {
            let (result, _, board) = flashed(asking(), &request(&bytes), 60);
            let error = result.unwrap_err().to_string();
            assert!(error.contains(Reason::Signature.text()), "{error}");
            assert!(board.state.settings().coefficients().is_err());
        }
        let (result, _, board) = flashed(asking(), &request(&image), 60);
        assert!(result.unwrap_err().to_string().contains("signed coefficients only; expected --sign"));
        assert_eq!(board.state.upload().state(), UploadState::Idle);
    }

    /// A host that was killed left an upload that waits: it is not in the way.
    #[test]
    fn an_abandoned_upload_is_forgotten() {
        let mut board = TestBoard::new();
        board.stands_at = Duration::from_secs(3);
        let (mut client, _) = Client::connect(board).unwrap();
        let calibration = Calibration { power_factors: [0.75; 4] }.encode();
        client.set(&table::UPLOAD_ITEM, Item::Calibration as u8).unwrap();
        client.set(&table::UPLOAD_LENGTH, calibration.len() as u16).unwrap();
        client.set_bytes(&table::UPLOAD_WINDOW, &calibration).unwrap();
        client.set(&table::UPLOAD_COMMAND, 1_u8).unwrap();
        let (result, _, mut board) = flashed(client.into_transport(), &coefficients(), 60);
        result.unwrap();
        assert!(board.flash.stored(Item::Calibration).unwrap().is_empty());
    }

    #[test]
    fn coefficients_of_another_robot_are_not_even_sent() {
        let board = TestBoard::new().holding(Item::Robot, &wider().encode());
        let (result, _, board) = flashed(board, &coefficients(), 60);
        let error = result.unwrap_err().to_string();
        assert!(error.contains("TurtleBot3 Burger of another geometry; nothing was stored"), "{error}");
        assert_eq!(board.state.upload().state(), UploadState::Idle);
        // And with the robot they are taken: it is set first.
        let request = Request { identity: Some(RobotIdentity::default()), ..coefficients() };
        let (result, _, board) = flashed(board, &request, 60);
        let items: Vec<&str> = result.unwrap().iter().map(|outcome| outcome.item).collect();
        assert_eq!(items, ["robot", "coefficients"]);
        assert!(board.state.settings().coefficients().is_ok());
    }

    /// Every reason of the board comes out in words: here past the check at home, by an upload of
    /// its own.
    #[test]
    fn a_refusal_says_why_and_the_old_set_stays() {
        let good = burger_coefficients();
        let spoilt = |at: usize, value: u8| {
            let mut image = good.clone();
            image[at] = value;
            image
        };
        for (image, reason) in [
            (spoilt(0, b'X'), Reason::NotAnImage),
            (spoilt(4, 9), Reason::Version),
            (spoilt(90, good[90] ^ 1), Reason::Checksum),
            (good[..100].to_vec(), Reason::Length),
        ] {
            let board = TestBoard::new().holding(Item::Coefficients, &good);
            let (mut client, board) = Client::connect(board).unwrap();
            let timeout = Duration::from_secs(60);
            let mut running = Running { client: &mut client, board: &board, timeout, waiting: &mut |_| {} };
            let error = running.put(Item::Coefficients, &image).unwrap_err().to_string();
            assert!(error.contains(reason.text()) && error.contains("keeps the coefficients"), "{error}");
            assert_eq!(running.stored(Item::Coefficients).unwrap(), good);
            assert!(client.into_transport().state.settings().coefficients().is_ok());
        }
    }

    #[test]
    fn a_worn_flash_is_said() {
        let mut board = TestBoard::new();
        board.is_worn = true;
        let (result, _, _) = flashed(board, &coefficients(), 60);
        let error = result.unwrap_err().to_string();
        assert!(error.contains(Reason::ReadBack.text()), "{error}");
    }

    #[test]
    fn what_a_board_says_is_compared() {
        let mut board = TestBoard::new();
        board.is_lying = true;
        let (result, _, _) = flashed(board, &coefficients(), 60);
        let error = result.unwrap_err().to_string();
        assert!(error.contains("what was read back is not the coefficients"), "{error}");
    }

    #[test]
    fn a_calibration_keeps_the_other_rails() {
        let old = Calibration { power_factors: [1.25, 1.0, 0.75, 1.0] };
        let board = TestBoard::new().holding(Item::Calibration, &old.encode());
        let request = Request { calibration: Some([None, Some(0.998), None, None]), ..Request::default() };
        let (result, _, board) = flashed(board, &request, 60);
        result.unwrap();
        assert_eq!(board.state.settings().calibration().power_factors, [1.25, 0.998, 0.75, 1.0]);
        assert_eq!(board.state.counters.store_writes, 1);
    }

    #[test]
    fn bad_lines_store_the_same() {
        for fault in [
            Fault::LostRequest(4),
            Fault::BrokenRequest(4),
            Fault::LostAnswer(3),
            Fault::ShortAnswer(3),
            Fault::BrokenAnswer(3),
            Fault::DoubledAnswer(2),
            Fault::LateAnswer(4, Duration::from_millis(120)),
        ] {
            let request = Request {
                identity: Some(RobotIdentity::default()),
                calibration: Some([Some(1.002); 4]),
                ..coefficients()
            };
            let (result, _, line) = flashed(BadLine::new(TestBoard::new(), fault), &request, 60);
            let outcomes = result.unwrap_or_else(|error| panic!("{fault:?}: {error}"));
            assert_eq!(outcomes.len(), 3);
            let mut flash = line.inner.flash.clone();
            assert_eq!(flash.stored(Item::Coefficients).unwrap(), burger_coefficients(), "{fault:?}");
        }
    }

    #[test]
    fn a_board_that_starts_again_meanwhile_is_said() {
        let mut board = TestBoard::new();
        board.stands_at = Duration::from_secs(100);
        board.restart_at = Some(Duration::from_secs(3));
        let (result, _, _) = flashed(board, &coefficients(), 60);
        let error = result.unwrap_err().to_string();
        assert!(error.contains("forgot the upload: has it started again?"), "{error}");
    }

    /// The command, on a serial port.
    #[cfg(unix)]
    #[test]
    fn the_command_flashes_by_port() {
        let bench = bench();
        let terminal = crate::common::board::terminal::Terminal::new(TestBoard::new());
        let ran = bench.gmr(&with(&["--port", terminal.name()]));
        assert_eq!(ran.code, Some(1));
        let said = "set up for TurtleBot3 Burger, these coefficients are for exact; nothing was stored";
        assert!(ran.stderr.contains(said) && ran.stderr.contains(terminal.name()), "{}", ran.stderr);
        let report =
            bench.json(&with(&["--port", terminal.name(), "--set-robot", "--calibrate", "lidar=0.99"]));
        assert_eq!((&report["target"], &report["robot"]), (&"port".into(), &"exact".into()), "{report}");
        let items: Vec<_> =
            report["items"].as_array().unwrap().iter().map(|item| item["item"].clone()).collect();
        assert_eq!(items, ["robot", "calibration", "coefficients"]);
        let held = bench.json(&["flash", "--read", "--port", terminal.name()]);
        assert_eq!(held["coefficients"]["crc"], report["items"][2]["crc"]);
        assert_eq!(held["coefficients"]["model"], "signed");
        assert_eq!(
            (&held["coefficients"]["refused"], &held["calibration"]["lidar"]),
            (&serde_json::Value::Null, &0.99.into())
        );
        // The same coefficients on ground that adapts are another image, and in use.
        bench.json(&with(&["--port", terminal.name(), "--adapt"]));
        let held = bench.json(&["flash", "--read", "--port", terminal.name()]);
        assert_eq!(
            (&held["coefficients"]["model"], &held["coefficients"]["refused"]),
            (&"signed, ground adapts".into(), &serde_json::Value::Null)
        );
    }

    #[test]
    fn ground_adapts_with_the_signed_model_alone() {
        let bench = bench();
        bench.done(&["fit", "--robot", "robot.toml", "--model", "eq18", "--out", "eq18.toml", "train.csv"]);
        let ran = bench.gmr(&[
            "flash",
            "--robot",
            "robot.toml",
            "--coeffs",
            "eq18.toml",
            "--adapt",
            "--out",
            "store.bin",
        ]);
        assert_eq!(ran.code, Some(1));
        assert!(ran.stderr.contains("eq18.toml") && ran.stderr.contains("--model signed"), "{}", ran.stderr);
        assert!(!bench.path("store.bin").exists());
    }
}
