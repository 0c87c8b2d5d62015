//! `gmr simulate` from the outside: what it writes, what it refuses.

use std::path::Path;

use assert_cmd::Command;

fn gmr(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::cargo_bin("gmr").expect("gmr is built with its tests");
    command.current_dir(folder).arg("simulate").args(arguments);
    command
}

fn write(folder: &Path, name: &str, arguments: &[&str]) -> String {
    gmr(folder, arguments).args(["--out", name]).assert().success();
    std::fs::read_to_string(folder.join(name)).expect("the log was written")
}

/// The columns of a log without its header.
fn columns(log: &str) -> Vec<Vec<f64>> {
    let rows: Vec<Vec<f64>> = log
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|cell| cell.parse().expect("every cell is a number")).collect())
        .collect();
    (0..rows[0].len()).map(|c| rows.iter().map(|row| row[c]).collect()).collect()
}

#[test]
fn the_header_and_rows_are_those_of_a_run_log() {
    let folder = tempfile::tempdir().unwrap();
    let log = write(folder.path(), "a.csv", &["--duration", "5", "--mass", "1@0,6@2", "--rate", "50"]);
    assert!(log.starts_with("time_s,wheel1_rad_s,wheel2_rad_s,power_w,mass_kg\n0.000000,0.0000000,"));
    assert!(log.ends_with('\n'));
    let columns = columns(&log);
    // One row at 0 s and 50 in each of 5 s.
    assert_eq!(columns[0].len(), 251);
    assert_eq!((columns[4][99], columns[4][100]), (1.0, 6.0));
    for (kinematics, wheels) in [("skid", 4), ("omni", 3), ("mecanum", 4)] {
        let options = ["--kinematics", kinematics, "--no-mass", "--truth", "--duration", "5"];
        let log = write(folder.path(), "b.csv", &options);
        let header = log.lines().next().unwrap();
        assert_eq!(header.split(',').filter(|name| name.starts_with("wheel")).count(), wheels);
        assert!(header.ends_with(",power_w,true_power_w"), "{header}");
    }
}

#[test]
fn the_same_seed_writes_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let log = |name: &str, seed: &str| {
        let options = ["--sensors", "servo", "--power-autocorrelation", "0.2", "--jitter", "0.0002"];
        write(folder.path(), name, &[&options[..], &["--duration", "20", "--seed", seed]].concat())
    };
    let first = log("a.csv", "7");
    assert_eq!(first, log("b.csv", "7"));
    assert_ne!(first, log("c.csv", "8"));
}

#[test]
fn the_log_has_the_resolution_of_its_sensors() {
    let folder = tempfile::tempdir().unwrap();
    let options = ["--sensors", "servo", "--duration", "20", "--truth"];
    let columns = columns(&write(folder.path(), "a.csv", &options));
    // INA219 at 12 V: 0.1 mA codes are 1.2 mW. Encoder: whole ticks of 2π/4096 in 5 ms; the log has
    // 1e-7 rad/s.
    let whole =
        |values: &[f64], step: f64| values.iter().all(|x| (x / step - (x / step).round()).abs() < 1e-3);
    assert!(whole(&columns[3], 1.2e-3), "no whole codes of power");
    assert!(whole(&columns[1], std::f64::consts::TAU / 4096.0 / 0.005), "no whole ticks of speed");
    let noise: Vec<f64> = columns[3].iter().zip(&columns[5]).map(|(a, b)| a - b).collect();
    let rms = (noise.iter().map(|x| x * x).sum::<f64>() / noise.len() as f64).sqrt();
    // 0.1 W over 4001 samples: 1.1 % standard error; averaging over 2 ms, 3 ms ago, adds some mW.
    assert!((rms / 0.1 - 1.0).abs() < 0.06, "{rms}");
}

#[test]
fn the_noise_has_the_autocorrelation_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let options = ["--profile", "standstill", "--power-noise", "0.1", "--power-autocorrelation", "0.6"];
    let noise = &columns(&write(folder.path(), "a.csv", &options))[3];
    let square: f64 = noise.iter().map(|x| x * x).sum();
    let lagged: f64 = noise.windows(2).map(|x| x[0] * x[1]).sum();
    // 20 001 samples: √((1 − 0.36)/n) = 0.0057; four of them.
    assert!((lagged / square - 0.6).abs() < 0.023, "{}", lagged / square);
}

#[test]
fn static_power_is_added_to_the_log() {
    let folder = tempfile::tempdir().unwrap();
    let options = ["--profile", "standstill", "--static-power", "6.4", "--duration", "2"];
    assert!(columns(&write(folder.path(), "a.csv", &options))[3].iter().all(|&p| p == 6.4));
}

#[test]
fn a_profile_file_is_driven() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("p.csv"), "time_s,v_m_s,omega_rad_s\n0,0,0\n1,0.1,0\n9,0.1,0\n")
        .unwrap();
    let columns = columns(&write(folder.path(), "a.csv", &["--profile", "p.csv", "--duration", "5"]));
    // 0.1 m/s on wheels of 33 mm.
    assert!((columns[1][400] - 0.1 / 0.033).abs() < 0.01, "{}", columns[1][400]);
}

#[test]
fn standard_output_takes_the_log_or_the_summary() {
    let folder = tempfile::tempdir().unwrap();
    let to_file = write(folder.path(), "a.csv", &["--duration", "3"]);
    let output = gmr(folder.path(), &["--duration", "3", "--out", "-"]).output().unwrap();
    assert_eq!(String::from_utf8(output.stdout).unwrap(), to_file);
    let output = gmr(folder.path(), &["--duration", "3", "--json", "--out", "a.csv"]).output().unwrap();
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(summary["rows"], 301);
    assert_eq!((&summary["file"], &summary["seed"]), (&"a.csv".into(), &1.into()));
    assert_eq!(summary["geometry"]["wheel_radius_m"], 0.033);
    assert!(output.stderr.is_empty(), "no progress bar where no terminal is");
}

/// Exit code 2 and one line that names what was allowed.
#[test]
fn wrong_usage_is_named_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let cases: [(&[&str], &str); 18] = [
        (&["--rate", "0"], "rate 0; allowed: Hz, above 0"),
        (&["--rate", "-5"], "rate -5; allowed"),
        (&["--rate", "nan"], "rate NaN; allowed"),
        (&["--rate", "1e9"], "above 0 to 4000"),
        (&["--duration", "0"], "duration 0; allowed"),
        (&["--duration", "inf"], "duration inf; allowed"),
        (&["--mass", "1@0,6"], "allowed: KG or KG@SECONDS"),
        (&["--mass", "-1"], "mass -1 kg"),
        (&["--power-autocorrelation", "1"], "above -1, below 1"),
        (&["--power-noise", "-0.1"], "power noise -0.1; allowed: W, 0 or more"),
        (&["--averages", "3"], "allowed: 1, 2, 4, 8"),
        (&["--jitter", "0.1"], "jitter 0.1; allowed"),
        (&["--profile", "trainig"], "allowed: training, test, constant, standstill"),
        (&["--speed", "0.1"], "--profile constant only"),
        (&["--profile", "constant", "--speed", "5"], "allowed: up to 0.2 m/s"),
        (&["--drive-efficiency", "5e-324"], "allowed: 0.01 to 1"),
        (&["--drive-efficiency", "nan"], "drive efficiency NaN; allowed: 0.01 to 1"),
        (&["--columns", "pitch,imu,pitch"], "--columns names pitch twice; expected every name once"),
    ];
    for (arguments, expected) in cases {
        let output = gmr(folder.path(), arguments).args(["--out", "x.csv"]).output().unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(message.contains(expected) && message.lines().count() == 1, "{arguments:?}: {message}");
    }
    // clap's own refusals.
    for arguments in
        [&["--plant", "rocket", "--out", "x.csv"][..], &["--rate", "fast", "--out", "x.csv"], &[]]
    {
        gmr(folder.path(), arguments).assert().code(2);
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn a_failure_leaves_the_old_log_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("x.csv"), "old").unwrap();
    std::fs::write(folder.path().join("p.csv"), "time_s,v_m_s,omega_rad_s\n0,0,0\n1,fast,0\n").unwrap();
    let output = gmr(folder.path(), &["--profile", "p.csv", "--out", "x.csv", "--force"]).output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert_eq!(message, "gmr: p.csv:3:v_m_s: found `fast`; expected a number\n");
    assert_eq!(std::fs::read_to_string(folder.path().join("x.csv")).unwrap(), "old");
    let output = gmr(folder.path(), &["--profile", "lost.csv", "--out", "y.csv"]).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8(output.stderr).unwrap().starts_with("gmr: lost.csv: "));
    let output = gmr(folder.path(), &["--duration", "2", "--out", "nowhere/y.csv"]).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    // Killed in the middle of a long run: the name is not taken.
    let mut long = std::process::Command::new(assert_cmd::cargo::cargo_bin!("gmr"))
        .current_dir(folder.path())
        .args(["simulate", "--duration", "1000000", "--out", "x.csv", "--force"])
        .spawn()
        .unwrap();
    std::thread::sleep(std::time::Duration::from_millis(500));
    long.kill().unwrap();
    long.wait().unwrap();
    assert_eq!(std::fs::read_to_string(folder.path().join("x.csv")).unwrap(), "old");
}

#[test]
fn effects_are_listed_and_act_on_the_log() {
    let folder = tempfile::tempdir().unwrap();
    let list = gmr(folder.path(), &["--effects"]).assert().success();
    let list = String::from_utf8(list.get_output().stdout.clone()).unwrap();
    assert!(list.starts_with("grade\n") && list.contains("size: slope angle, rad, -0.3 to 0.3\n"), "{list}");
    assert_eq!(list.lines().filter(|line| !line.starts_with(' ')).count(), 21);
    let json = gmr(folder.path(), &["--effects", "--json"]).assert().success();
    let json: serde_json::Value = serde_json::from_slice(&json.get_output().stdout).unwrap();
    let json = &json["effects"];
    let ids = json.as_array().unwrap().iter().map(|entry| entry["id"].as_str().unwrap());
    assert!(ids.eq(list.lines().filter(|line| !line.starts_with(' '))), "{json:#}");
    assert_eq!(json[0]["range"], serde_json::json!([-0.3, 0.3]));

    let log = |name: &str, effects: &[&str]| {
        let options = ["--sensors", "servo", "--duration", "5", "--columns", "pitch,temps,bus_v,cpu"];
        let effects: Vec<&str> = effects.iter().flat_map(|effect| ["--effect", effect]).collect();
        write(folder.path(), name, &[&options[..], &effects].concat())
    };
    let (clean, nothing) = (log("a.csv", &[]), log("b.csv", &["grade=0", "supply-sag=0", "speed-scale=0"]));
    assert_eq!(clean, nothing);
    let effects = ["grade=0.05:along=travel", "winding-temperature=30:heat=room:tau=1", "supply-sag=1"];
    let with = log("c.csv", &effects);
    assert_eq!(with, log("d.csv", &effects));
    let header = "power_w,mass_kg,pitch_rad,motor1_temp_c,motor2_temp_c,bus_v,cpu_percent";
    assert!(with.lines().next().unwrap().ends_with(header), "{with}");
    let columns = columns(&with);
    assert!(columns[5].iter().all(|&pitch| pitch == 0.05));
    // 30 K but for e⁻⁵ of it.
    assert!((columns[7].last().unwrap() - 25.0 - 30.0 * (1.0 - (-5.0_f64).exp())).abs() < 0.02);
    // Voltage at the drives: never above the supply's 12 V, below it as soon as something moves.
    assert!(columns[8].iter().all(|&v| v <= 12.0) && columns[8].iter().any(|&v| v < 11.98));
}

/// What baselines of the literature read: the commanded motion, an IMU, the floor, the slope.
#[test]
fn further_columns_tell_command_floor_and_acceleration() {
    let folder = tempfile::tempdir().unwrap();
    let further = ["--columns", "command,imu,friction,slope,pitch", "--duration", "20"];
    let log = |name: &str, rest: &[&str]| write(folder.path(), name, &[&further[..], rest].concat());
    let effects = ["--effect", "grade=-0.1:heading=0.5", "--effect", "rolling-resistance-change=0.01:at=10"];
    let text = log("a.csv", &effects);
    let header = "cmd_v_m_s,cmd_omega_rad_s,accel_x_m_s2,accel_y_m_s2,accel_z_m_s2,rolling_friction,static_friction,\
                  slope_heading_rad,pitch_rad";
    assert!(text.lines().next().unwrap().ends_with(header), "{text}");
    let series = columns(&text);
    let [left, right] = [&series[1], &series[2]];
    let [command_v, command_omega] = [&series[5], &series[6]];
    let rms = |values: &[f64]| (values.iter().map(|x| x * x).sum::<f64>() / values.len() as f64).sqrt();
    // The speed loop follows to a few percent of the speeds (wheels of 33 mm, 160 mm apart).
    let off = |command: &[f64], of: &dyn Fn(f64, f64) -> f64| {
        let driven: Vec<f64> = left.iter().zip(right).map(|(l, r)| of(*l, *r)).collect();
        let error: Vec<f64> = command.iter().zip(&driven).map(|(c, d)| c - d).collect();
        rms(&error) / rms(command)
    };
    assert!(off(command_v, &|l, r| 0.0165 * (l + r)) < 0.05);
    assert!(off(command_omega, &|l, r| 0.033 / 0.16 * (r - l)) < 0.05);
    // Rest in the first half second on −0.1 rad: uphill is behind, at 0.5 − π; the nose's part of
    // the slope is pitch.
    let (heading, pitch) = (series[12][0], series[13][0]);
    assert!((heading - (std::f64::consts::PI - 0.5)).abs() < 1e-6, "{heading}");
    assert!((pitch.sin() - 0.1_f64.sin() * heading.cos()).abs() < 1e-6, "{pitch}");
    let mean = |column: usize| series[column][..50].iter().sum::<f64>() / 50.0;
    let sin = 0.1_f64.sin();
    // 50 readings of 0.019 m/s² noise: 0.0027 m/s²; four of them.
    for (column, expected) in [
        (7, 9.80665 * sin * heading.cos()),
        (8, -9.80665 * sin * heading.sin()),
        (9, 9.80665 * 0.1_f64.cos()),
    ] {
        assert!((mean(column) - expected).abs() < 0.011, "{column}: {} {expected}", mean(column));
    }
    // A sample shows the step before it.
    assert_eq!((series[10][999], series[10][1001]), (0.032, 0.042));
    assert!(series[11].iter().all(|&friction| friction == 0.0), "nothing scrubs");
    let scrubbed = columns(&log("b.csv", &["--effect", "turning-scrub=0.3"]));
    assert_eq!(scrubbed[11][5], 0.3);
    assert_eq!((scrubbed[12][5], scrubbed[13][5]), (0.0, 0.0), "level");
    // Other columns do not move the robot.
    let plain =
        columns(&write(folder.path(), "c.csv", &["--duration", "20", "--effect", "turning-scrub=0.3"]));
    assert_eq!(plain, scrubbed[..5]);
    // A planar robot is told to go sideways, too.
    let planar = log("d.csv", &["--kinematics", "omni"]);
    assert!(
        planar.lines().next().unwrap().contains(",cmd_vx_m_s,cmd_vy_m_s,cmd_omega_rad_s,accel_x"),
        "{planar}"
    );
}

#[test]
fn effects_that_do_not_exist_or_are_too_large_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    for (effect, named) in [
        ("slope=0.1", "effect `slope`; allowed: grade, winding-temperature"),
        ("grade=2", "effect grade=2; allowed: -0.3 to 0.3 (slope angle, rad)"),
        ("wheel-drag=0.1:wheel=3", "effect wheel-drag=0.1: wheel=3; allowed: 1 to 2"),
    ] {
        let refused = gmr(folder.path(), &["--effect", effect, "--out", "x.csv"]).assert().code(2);
        let text = String::from_utf8(refused.get_output().stderr.clone()).unwrap();
        assert!(text.contains(named) && text.lines().count() == 1, "{text}");
        assert!(!folder.path().join("x.csv").exists());
    }
}

#[test]
fn noise_may_have_heavy_tails_and_grow_with_the_power() {
    let folder = tempfile::tempdir().unwrap();
    let extreme = |options: &[&str]| {
        let still = ["--profile", "standstill", "--power-noise", "0.1", "--duration", "100"];
        let columns = columns(&write(folder.path(), "a.csv", &[&still[..], options].concat()));
        columns[3].iter().fold(0.0_f64, |most, noise| most.max(noise.abs()))
    };
    // 10 001 samples: the largest is at 3.9 σ, seldom above 4.9 (1 %); of t with 3 degrees at
    // √(1/3)·22 = 13 σ.
    assert!(extreme(&[]) < 0.5);
    assert!(extreme(&["--power-noise-tail", "3"]) > 0.7);
    gmr(folder.path(), &["--power-noise-tail", "2", "--out", "x.csv"]).assert().code(2);
    let moving = ["--profile", "constant", "--truth", "--power-noise-per-watt", "0.2", "--duration", "60"];
    let columns = columns(&write(folder.path(), "a.csv", &moving));
    let noise: Vec<f64> =
        columns[3].iter().zip(&columns[5]).skip(1000).map(|(read, truth)| read / truth - 1.0).collect();
    let rms = (noise.iter().map(|x| x * x).sum::<f64>() / noise.len() as f64).sqrt();
    // A fifth of the power, over 5001 samples: 1 % standard error.
    assert!((rms / 0.2 - 1.0).abs() < 0.04, "{rms}");
}

/// The largest seed has its own drives, which repeat.
#[test]
fn the_largest_seed_drives() {
    let folder = tempfile::tempdir().unwrap();
    let log = |name: &str, drive: &str, seed: &str| {
        write(folder.path(), name, &["--experiment", drive, "--seed", seed])
    };
    let largest = u64::MAX.to_string();
    let training = log("a.csv", "training", &largest);
    assert_eq!(training, log("b.csv", "training", &largest));
    assert_ne!(training, log("c.csv", "training", "1"));
    assert_ne!(training, log("d.csv", "test", &largest));
}
