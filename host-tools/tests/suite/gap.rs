//! What `gmr gap` answers: its JSON, the name of an effect that the plant hid, silence where there
//! is none, and one line for what cannot be worked with.

use std::sync::OnceLock;

use crate::common::{Bench, keys, number, simulate};
use logs::robot::Robot;
use model::coefficients::CoefficientsFile;
use plant::gear::Gear;
use plant::{Columns, Effect, Kinematics, PayloadSchedule, PlantSet, ProfileKind, Scenario};
use serde_json::Value;

const KEYS: [&str; 28] = [
    "version",
    "verdict",
    "effects",
    "ambiguous_with",
    "rivals",
    "suggested_profile",
    "manoeuvre",
    "gap_before_w",
    "gap_after_w",
    "noise_floor_w",
    "noise_floor_unclipped_w",
    "gap_closed",
    "gain_w2",
    "confirmed_share",
    "simulation",
    "simulator",
    "changes",
    "confirm_runs",
    "localisation",
    "rounds",
    "clean_structure",
    "refit",
    "relabelled",
    "notes",
    "noise_floor_how",
    "base_moves",
    "not_testable",
    "next_steps",
];

/// Field runs of a set: enough for four to stay locked.
const FIELD: [&str; 8] = ["1.2", "5.6", "2.4", "4.1", "3.3", "1.8", "5.0", "2.9"];

/// Six clean runs and the coefficients fitted to them.
fn clean() -> &'static Bench {
    static BENCH: OnceLock<Bench> = OnceLock::new();
    BENCH.get_or_init(|| {
        let bench = Bench::new();
        let names: Vec<String> = (1..=6).map(|k| format!("base_{k}.csv")).collect();
        for (k, name) in names.iter().enumerate() {
            simulate(&bench, name, k, &(k + 1).to_string(), 100 + k, &[]);
        }
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        bench.done(&[&["fit", "--out", "base.toml"], &names[..]].concat());
        bench
    })
}

/// A folder with the clean runs, their coefficients, and field runs with an effect.
fn field(more: &[&str]) -> (Bench, Vec<String>) {
    let bench = Bench::new();
    for name in clean().files() {
        bench.put(&name, std::fs::read(clean().path(&name)).unwrap());
    }
    let names: Vec<String> = (1..=FIELD.len()).map(|k| format!("field_{k}.csv")).collect();
    for (k, name) in names.iter().enumerate() {
        simulate(&bench, name, k, FIELD[k], 200 + k, more);
    }
    (bench, names)
}

fn gap(bench: &Bench, names: &[String], more: &[&str]) -> Value {
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    bench.json(&[&["gap"], more, &names[..]].concat())
}

/// A slope of 0.02 that rises ahead: 3 kg at 0.4 m/s take m g v sin(φ) = 0.24 W more, five times
/// the noise.
#[test]
fn a_hidden_slope_is_named_and_the_locked_runs_confirm_it() {
    let (bench, names) = field(&["--effect", "grade=0.02:along=travel"]);
    let report = gap(&bench, &names, &["--coeffs", "base.toml"]);
    assert_eq!(keys(&report), KEYS);
    assert_eq!(report["verdict"], "named", "{report:#}");
    assert_eq!(report["effects"].as_array().unwrap().len(), 1);
    let effect = &report["effects"][0];
    assert_eq!(
        keys(effect),
        ["id", "coefficient", "unit", "std_err", "physical", "detail", "meaning", "sign"]
    );
    assert_eq!(effect["id"], "grade");
    // The drive folds its efficiency in: the base's inertia gain, 1.34 here, multiplies the weight
    // as it does the mass.
    let slope = number(&effect["coefficient"]) / 1.34;
    assert!((slope / 0.02 - 1.0).abs() < 0.1, "{slope}");
    let [before, after, floor] =
        ["gap_before_w", "gap_after_w", "noise_floor_w"].map(|key| number(&report[key]));
    assert!(before > after && after >= floor && floor > 0.0, "{before} {after} {floor}");
    let closed = (before * before - after * after) / (before * before - floor * floor);
    assert!((closed - number(&report["gap_closed"])).abs() < 1e-9 && closed > 0.9, "{closed}");
    // Locked runs are a third of them: they confirm what the others named.
    assert_eq!(report["confirm_runs"].as_array().unwrap().len(), 3);
    let cell = &report["localisation"][0];
    assert_eq!(keys(cell)[..5], ["axis", "from", "to", "mean_residual_w", "band_w"]);
    // Driving backwards is downhill: the slowest cell of speed has less power than the fastest.
    let speed: Vec<f64> = report["localisation"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|cell| cell["axis"] == "speed")
        .map(|cell| number(&cell["mean_residual_w"]))
        .collect();
    assert!(speed[0] < 0.0 && *speed.last().unwrap() > 0.0, "{speed:?}");
    let summary = bench.done(&[
        "gap",
        "--coeffs",
        "base.toml",
        "field_1.csv",
        "field_2.csv",
        "field_3.csv",
        "field_4.csv",
    ]);
    assert!(summary.stdout.lines().count() < 24, "{}", summary.stdout);
}

/// What the base gets wrong is as late as the rest of the power. Taken for being in time, as in
/// clean runs, it would move this delay by 5 ms.
#[test]
fn a_delay_is_as_long_as_the_one_that_was_hidden() {
    let (bench, names) = field(&["--effect", "sensor-delay=0.17"]);
    let report = gap(&bench, &names, &["--coeffs", "base.toml"]);
    assert_eq!((&report["verdict"], &report["effects"][0]["id"]), (&"named".into(), &"sensor-delay".into()));
    let effect = &report["effects"][0];
    let [delay, error] = ["coefficient", "std_err"].map(|key| number(&effect[key]));
    assert!((delay - 0.17).abs() < 0.0015, "{delay}");
    // The samples are 50 ms apart: a twenty-fifth of that comes on top.
    assert!(error > 0.002 && error < 0.004, "{error}");
}

/// Coefficients without the delay that their own clean runs have: a drag is there to be named, but
/// the base comes first.
#[test]
fn a_base_that_lacks_what_its_clean_runs_ask_for_names_nothing() {
    let bench = Bench::new();
    let late = ["--effect", "sensor-delay=0.2"];
    let clean: Vec<String> = (1..=6).map(|k| format!("base_{k}.csv")).collect();
    for (k, name) in clean.iter().enumerate() {
        simulate(&bench, name, k, &(k + 1).to_string(), 500 + k, &late);
    }
    let names: Vec<String> = (1..=6).map(|k| format!("field_{k}.csv")).collect();
    for (k, name) in names.iter().enumerate() {
        simulate(
            &bench,
            name,
            k,
            FIELD[k],
            600 + k,
            &[&late[..], &["--effect", "wheel-drag=0.03:wheel=1"]].concat(),
        );
    }
    let clean: Vec<&str> = clean.iter().map(String::as_str).collect();
    bench.done(&[&["fit", "--out", "base.toml"], &clean[..]].concat());
    let report = gap(&bench, &names, &["--coeffs", "base.toml"]);
    assert_eq!(
        (&report["verdict"], &report["effects"][0]["id"]),
        (&"named".into(), &"wheel-drag".into()),
        "{report:#}"
    );
    assert!(report["refit"].as_array().unwrap().is_empty());
    let old: Vec<String> = bench
        .text("base.toml")
        .lines()
        .map(|line| {
            if line.starts_with("power_delay_s") { "power_delay_s = 0.0".to_owned() } else { line.to_owned() }
        })
        .collect();
    bench.put("old.toml", old.join("\n") + "\n");
    let report = gap(&bench, &names, &["--coeffs", "old.toml"]);
    assert_eq!(report["verdict"], "unexplained", "{report:#}");
    assert!(report["effects"].as_array().unwrap().is_empty());
    assert_eq!(report["refit"][0]["term"], "delay");
    assert!(report["next_steps"][0].as_str().unwrap().starts_with("refit"), "{report:#}");
}

/// A floor that slopes another way in every run, clean or not: runs disagree far beyond the noise,
/// but the field's no more than the clean ones.
#[test]
fn what_clean_runs_show_of_each_other_is_no_alarm() {
    let bench = Bench::new();
    let sloping = |name: &str, place: usize, mass: &str| {
        let heading = (2.1 * place as f64) % std::f64::consts::TAU - std::f64::consts::PI;
        let effect = format!("grade=0.02:heading={heading}");
        simulate(&bench, name, place, mass, 300 + place, &["--effect", &effect]);
    };
    let clean: Vec<String> = (1..=6).map(|k| format!("base_{k}.csv")).collect();
    for (k, name) in clean.iter().enumerate() {
        sloping(name, k, &(k + 1).to_string());
    }
    let names: Vec<String> = (1..=6).map(|k| format!("field_{k}.csv")).collect();
    for (k, name) in names.iter().enumerate() {
        sloping(name, 6 + k, FIELD[k]);
    }
    let clean: Vec<&str> = clean.iter().map(String::as_str).collect();
    bench.done(&[&["fit", "--out", "base.toml"], &clean[..]].concat());
    let report = gap(&bench, &names, &["--coeffs", "base.toml"]);
    let round = &report["rounds"][0];
    assert!(number(&round["structure"]) > 5.3, "noise does not explain it: {round:#}");
    assert!((number(&round["allowed"]) / number(&report["clean_structure"]) - 1.0).abs() < 1e-9, "{round:#}");
    assert_eq!(report["verdict"], "none", "{report:#}");
    let next = report["next_steps"][0].as_str().unwrap();
    assert!(next.contains("disagree with each other"), "{next}");
}

/// What the world has, not what the motors make of it: the plant's own sizes, the drive's
/// efficiency of 0.75 taken out again. A moment of scrub is friction times weight times the plant's
/// lever of half a wheelbase, 80 mm.
#[test]
fn sizes_are_those_of_the_world() {
    for (effect, id, truth, unit) in [
        ("grade=0.03:along=travel", "grade", 0.03, "rad"),
        ("wheel-drag=0.035:wheel=1", "wheel-drag", 0.035, "N·m"),
        ("turning-scrub=0.04", "turning-scrub", 0.04 * 9.806_65 * 0.08, "N·m/kg"),
        ("rolling-resistance-change=0.012", "rolling-resistance-change", 0.012, "1"),
    ] {
        let (bench, names) = field(&["--effect", effect]);
        let report = gap(&bench, &names, &["--coeffs", "base.toml"]);
        let named = report["effects"].as_array().unwrap().iter().find(|named| named["id"] == id);
        let named = named.unwrap_or_else(|| panic!("{effect}: {report:#}"));
        let physical = &named["physical"];
        assert_eq!(
            (keys(physical), &physical["unit"]),
            (vec!["value", "unit", "std_err"], &Value::from(unit))
        );
        let (value, std_err) = (number(&physical["value"]), number(&physical["std_err"]));
        // 99 %.
        assert!((value - truth).abs() < 2.58 * std_err, "{effect}: {physical}");
        assert!(std_err < 0.1 * truth, "{effect}: {physical}");
    }
}

/// Of the plant's gear.
const EFFICIENCY: f64 = 0.7598;

/// e of such a gear.
const LOSS: f64 = (1.0 - EFFICIENCY * EFFICIENCY) / (1.0 + EFFICIENCY * EFFICIENCY);

/// The plant's gear passes η = 0.76 of what drives the wheel, and η of what drives the motor back:
/// e = (1 − η²)/(1 + η²), and a load costs g₄ (1 + e) = 1/η of itself.
#[test]
fn the_loss_of_the_gear_is_that_of_the_plant() {
    let bench = clean();
    let names = bench.files().into_iter().filter(|name| name.starts_with("base_")).collect::<Vec<_>>();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let fitted = Bench::new();
    for name in &names {
        fitted.put(name, std::fs::read(bench.path(name)).unwrap());
    }
    let fitted = fitted.json(&[&["fit", "--out", "gear.toml"], &names[..]].concat());
    let parameter = |name: &str| {
        let all = fitted["parameters"].as_array().unwrap();
        let one = all.iter().find(|one| one["name"] == name).unwrap_or_else(|| panic!("{name}: {fitted:#}"));
        (number(&one["value"]), number(&one["std_err"]))
    };
    let (loss, std_err) = parameter("gear_loss");
    // 99 %.
    assert!((loss - LOSS).abs() < 2.58 * std_err && std_err < 0.2 * LOSS, "{loss} ± {std_err}: {LOSS}");
    let (gain, _) = parameter("inertia_gain");
    assert!((gain * (1.0 + loss) * EFFICIENCY - 1.0).abs() < 0.05, "{gain} {loss}");
}

/// On a smooth floor, with drives that give power back: friction of the motors does not pass the
/// gear; brakes that rub and grease in the bearings of the wheels, in the place of it, do.
#[test]
fn friction_of_the_wheels_passes_the_gear() {
    let burger = include_str!("../../robots/burger.toml");
    for at_wheels in [false, true] {
        let bench = Bench::new();
        bench.put("robot.toml", burger.replace("regeneration = false", "regeneration = true"));
        let logs: Vec<String> = (1..=6).map(|k| format!("{k}.csv")).collect();
        for (k, log) in (1..).zip(&logs) {
            let kind = if k % 2 == 0 { ProfileKind::Training } else { ProfileKind::Test };
            let mut scenario = Scenario::new(PlantSet::Gearmotor, Kinematics::Differential, kind, 60.0, k);
            (scenario.payload, scenario.rate_hz) = (PayloadSchedule::constant(k as f64), 20.0);
            scenario.sensors.power_noise_w = 0.05;
            scenario.drive.regeneration = true;
            for (place, wheel) in (1..=2).zip(&mut scenario.robot.wheels) {
                wheel.rolling_resistance = 0.005;
                let (Gear { ratio, efficiency }, motor) = (wheel.gear, &mut wheel.motor);
                if at_wheels {
                    let drag = format!("wheel-drag={}:wheel={place}", ratio * efficiency * motor.coulomb);
                    scenario.effects.push(Effect::parse(&drag).unwrap());
                    wheel.viscous = ratio.powi(2) * efficiency * motor.viscous;
                    (motor.coulomb, motor.viscous) = (0.0, 0.0);
                }
            }
            plant::log::write(&bench.path(log), &scenario, &Columns::default()).unwrap();
        }
        let logs: Vec<&str> = logs.iter().map(String::as_str).collect();
        let fitted =
            bench.json(&[&["fit", "--robot", "robot.toml", "--out", "gear.toml"], &logs[..]].concat());
        assert_eq!(fitted["wheel_friction_share"], f64::from(u8::from(at_wheels)), "{fitted:#}");
        let parameter = |name: &str| {
            let all = fitted["parameters"].as_array().unwrap();
            number(&all.iter().find(|one| one["name"] == name).unwrap()["value"])
        };
        // Friction that always drives hides a part of the loss, but not of what a load costs.
        let loss = parameter("gear_loss");
        assert!((loss / LOSS - 1.0).abs() < if at_wheels { 0.5 } else { 0.1 }, "{loss}: {LOSS}");
        let gain = parameter("inertia_gain") * (1.0 + loss);
        assert!((gain * EFFICIENCY - 1.0).abs() < 0.02, "{gain}");
        // Only a file with such friction names it; read and written again it is what it was.
        let text = bench.text("gear.toml");
        assert_eq!(text.contains("wheel_friction_share"), at_wheels, "{text}");
        let (file, robot) = (bench.path("gear.toml"), Robot::parse(&bench.text("robot.toml")).unwrap());
        let read = CoefficientsFile::read(&file, &robot).unwrap();
        assert_eq!(read.text(&file).unwrap(), text);
    }
}

/// A slope that the pitch shows, while the clean runs were level and did not measure it.
#[test]
fn a_slope_that_only_the_field_runs_measure_is_named_by_its_pitch() {
    let (bench, names) = field(&["--effect", "grade=0.02:heading=0.4", "--columns", "pitch"]);
    let report = gap(&bench, &names, &["--coeffs", "base.toml"]);
    assert_eq!(report["verdict"], "named", "{report:#}");
    assert_eq!(report["effects"][0]["id"], "grade");
    assert_eq!(report["effects"][0]["detail"]["by"], "pitch_rad");
    assert!(number(&report["gap_closed"]) > 0.9, "{report:#}");
}

#[test]
fn nothing_is_named_where_nothing_hides() {
    let (bench, names) = field(&[]);
    let report = gap(&bench, &names, &["--coeffs", "base.toml"]);
    assert_eq!(keys(&report), KEYS);
    assert_eq!(report["verdict"], "none", "{report:#}");
    assert_eq!(report["effects"], Value::Array(Vec::new()));
    assert!(report["gap_closed"].is_null() && report["suggested_profile"].is_null());
    // What needs a column that no log has is said to be so.
    let missing = report["not_testable"].as_array().unwrap();
    let load = missing.iter().find(|entry| entry["id"] == "compute-load").unwrap();
    assert_eq!(load["reason"], "needs cpu_percent");
}

/// Without the runs that the coefficients were fitted to, what the model gets wrong of its own
/// looks like effects: said in a line, and only large ones are named.
#[test]
fn clean_runs_that_are_gone_are_missed() {
    let (bench, names) = field(&[]);
    for k in 1..=6 {
        std::fs::remove_file(bench.path(&format!("base_{k}.csv"))).unwrap();
    }
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let ran = bench.done(&[&["gap", "--coeffs", "base.toml", "--json"], &names[..]].concat());
    assert!(ran.stderr.contains("the clean runs of these coefficients are not there"), "{}", ran.stderr);
    let report: Value = serde_json::from_str(&ran.stdout).unwrap();
    assert_ne!(report["verdict"], "named", "{report:#}");
}

/// The line that a refused command says, and nothing on standard output.
fn refusal(bench: &Bench, arguments: &[&str]) -> String {
    let ran = bench.gmr(arguments);
    assert_eq!(ran.code, Some(1), "{arguments:?}: {}", ran.stderr);
    assert_eq!(ran.stdout, "");
    assert_eq!(ran.stderr.lines().count(), 1, "{}", ran.stderr);
    ran.stderr.trim_end().to_owned()
}

#[test]
fn what_cannot_be_worked_with_is_said_in_one_line() {
    let (bench, _) = field(&[]);
    let few = refusal(&bench, &["gap", "--coeffs", "base.toml", "field_1.csv", "field_2.csv"]);
    assert_eq!(
        few,
        "gmr: 2 runs; expected at least 4: 3 to name an effect and 1 to confirm it. Record 2 more"
    );
    bench.simulate("fast.csv", &["--duration", "30", "--rate", "50"]);
    let all = ["field_1.csv", "field_2.csv", "field_3.csv", "fast.csv"];
    let rates = refusal(&bench, &[&["gap", "--coeffs", "base.toml"], &all[..]].concat());
    assert_eq!(
        rates,
        "gmr: fast.csv: sampled at 50.00 Hz, but field_1.csv at 20.00 Hz; expected runs of one sample rate"
    );
    let robot = refusal(&bench, &["gap", "--robot", "warthog", "--coeffs", "base.toml", "field_1.csv"]);
    assert!(robot.contains("base.toml") && robot.contains("another robot"), "{robot}");
    let text = bench.text("field_1.csv").replacen("\n0.1", "\nx0.1", 1);
    bench.put("broken.csv", text);
    let broken = refusal(&bench, &["gap", "--coeffs", "base.toml", "broken.csv"]);
    assert!(broken.starts_with("gmr: broken.csv:") && broken.contains("is not a number"), "{broken}");
    let eq18 = ["fit", "--model", "eq18", "--out", "eq18.toml", "base_1.csv", "base_6.csv"];
    bench.done(&eq18);
    let model = refusal(&bench, &["gap", "--coeffs", "eq18.toml", "field_1.csv"]);
    assert!(model.starts_with("gmr: eq18.toml:model:") && model.contains("expected signed"), "{model}");
}

/// Fields that hold no number are left out, and counted.
#[test]
fn rows_that_are_not_finite_are_left_out_and_counted() {
    let (bench, names) = field(&[]);
    let text = bench.text("field_1.csv");
    let lines = text.lines().enumerate().map(|(k, line)| {
        let mut fields: Vec<&str> = line.split(',').collect();
        if k > 0 && k % 200 == 0 {
            fields[3] = "nan";
        }
        fields.join(",") + "\n"
    });
    bench.put("field_1.csv", lines.collect::<String>());
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let ran = bench.done(&[&["gap", "--coeffs", "base.toml"], &names[..]].concat());
    assert!(ran.stderr.contains("field_1.csv") && ran.stderr.contains('6'), "{}", ran.stderr);
}
