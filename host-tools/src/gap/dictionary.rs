//! The candidates that some runs can show: with which range, and in which shapes.
//!
//! The ids are the public interface. One entry may stand for several [`Candidate`]s: other shapes, wheels or sides.

use model_core::effects::Term;
use model_core::torque::TorqueModel;
use serde_json::{Map, Value, json};

use crate::effects::{Candidate, NotTestable, PITCH, PROCESSOR, Regressor, find};
use crate::log::runs::Runs;

/// Sizes that make a coefficient plausible.
#[derive(Debug, Clone, Copy)]
struct Scale {
    /// Wheel speed that is rarely exceeded, rad/s.
    speed: f64,
    /// Torque of the base at that speed and the middle mass, N·m.
    torque: f64,
    /// Middle mass, kg.
    mass: f64,
    /// Length of the longest run, s.
    duration: f64,
    /// Usual power in motion, W.
    power: f64,
}

impl Scale {
    fn of<const N: usize>(runs: &Runs<N>, base: &TorqueModel<f64>) -> Self {
        let rows = || runs.runs.iter().flat_map(|run| &run.rows);
        let mut speeds: Vec<f64> = rows()
            .flat_map(|row| row.motion.wheels.iter().map(|wheel| wheel.speed.abs()))
            .filter(|speed| *speed > 0.0)
            .collect();
        let rank = speeds.len() * 95 / 100;
        let speed = match speeds.len() {
            0 => 1.0,
            _ => *speeds.select_nth_unstable_by(rank, f64::total_cmp).1,
        };
        let count = rows().count().max(1) as f64;
        let mass = rows().map(|row| row.mass).sum::<f64>() / count;
        let moving: Vec<f64> =
            rows().filter(|row| row.motion.is_moving()).map(|row| row.power.abs()).collect();
        let torque = (base.coulomb + base.rolling * mass + base.viscous * speed) * (1.0 + f64::EPSILON);
        Self {
            speed,
            torque: torque.max(1e-6),
            mass,
            duration: runs
                .runs
                .iter()
                .filter_map(|run| run.rows.last())
                .map(|row| row.time)
                .fold(1.0, f64::max),
            power: moving.iter().sum::<f64>() / moving.len().max(1) as f64,
        }
    }
}

/// Shape parameters that may be searched, as `detail` calls them.
pub const SHAPES: [&str; 4] = ["speed_rad_s", "time_constant_s", "hold_s", "at_s"];

/// What the choice among a few shapes costs, in χ².
pub const SHAPE: f64 = 2.0;

/// Every candidate that these runs can show, and the effects that they cannot.
pub fn candidates<const N: usize>(
    runs: &Runs<N>,
    base: &TorqueModel<f64>,
    regenerative: bool,
) -> (Vec<Candidate>, Vec<NotTestable>) {
    let scale = Scale::of(runs, base);
    let mut found = Vec::new();
    let mut missing = Vec::new();
    let mut skip = |id: &str, reason: &str| {
        missing.push(NotTestable { id: id.to_owned(), reason: reason.to_owned() });
    };
    let mut add = |id: &str, regressors: Vec<Regressor>, range: (f64, f64), shapes: u32, detail: Value| {
        let unit = find(id).map_or("", |entry| entry.unit).to_owned();
        let detail = match detail {
            Value::Object(map) => map,
            _ => Map::new(),
        };
        let shape = SHAPES.into_iter().find(|key| detail.contains_key(*key));
        found.push(Candidate {
            id: id.to_owned(),
            regressors,
            unit,
            range,
            detail,
            search: f64::from(shapes) * SHAPE,
            shape,
        });
    };
    let term = |term| vec![Regressor::Term(term)];
    let none = Value::Null;
    let torque = scale.torque;

    // A slope of 0.35 rad is a steep ramp; drives pass a third of the torque at worst.
    let steep = 0.35 * 3.0;
    if runs.column(PITCH).is_some() {
        add("grade", term(Term::GradeByPitch), (0.2, 5.0), 0, json!({"by": PITCH}));
    } else {
        add("grade", term(Term::GradeAhead), (-steep, steep), 0, json!({"along": "the way ahead"}));
        let along = vec![
            Regressor::Term(Term::GradeAlong([1.0, 0.0])),
            Regressor::Term(Term::GradeAlong([0.0, 1.0])),
        ];
        add("grade", along, (-steep, steep), 0, json!({"along": "a direction of the world"}));
    }
    let temperatures: Option<Vec<usize>> =
        (1..=N).map(|wheel| runs.column(&format!("motor{wheel}_temp_c"))).collect();
    match temperatures {
        Some(places) if places.windows(2).all(|pair| pair[1] == pair[0] + 1) => {
            let coldest = runs
                .runs
                .iter()
                .flat_map(|run| places.iter().flat_map(|&place| run.extra(place).iter().copied()))
                .fold(f64::INFINITY, f64::min);
            add(
                "winding-temperature",
                vec![Regressor::Temperature(places[0], coldest)],
                (0.0, 0.02),
                0,
                json!({"by": "motor temperatures", "from_c": coldest}),
            );
        }
        _ => {
            add("winding-temperature", vec![Regressor::Hot], (0.0, 1.0), 1, json!({"from": "the start"}));
            for share in [0.15, 0.5, 1.5] {
                let time = share * scale.duration;
                add(
                    "winding-temperature",
                    vec![Regressor::Heat(time)],
                    (0.0, f64::INFINITY),
                    1,
                    json!({"time_constant_s": time}),
                );
            }
        }
    }
    let much = 20.0 * torque;
    add("windage", term(Term::Windage), (0.0, much / scale.speed.powi(2)), 0, none.clone());
    for share in [0.05, 0.1, 0.2, 0.35] {
        let speed = share * scale.speed;
        add("stribeck", term(Term::Stribeck(speed)), (0.0, much), 1, json!({"speed_rad_s": speed}));
    }
    add("viscous-change", term(Term::Viscous), (-base.viscous, much / scale.speed), 0, none.clone());
    for share in [0.25, 0.75, 2.0] {
        let time = share * scale.duration;
        add(
            "lubricant-warm-up",
            term(Term::WarmUp(time)),
            (0.0, much / scale.speed),
            1,
            json!({"time_constant_s": time}),
        );
    }
    let per_kg = much / scale.mass;
    add("rolling-resistance-change", term(Term::Rolling), (-base.rolling, per_kg), 0, none.clone());
    let right = (0..N).any(|wheel| runs.layout.side[wheel] > 0.0);
    let left = (0..N).any(|wheel| runs.layout.side[wheel] < 0.0);
    let sides = right && left;
    if sides {
        add("payload-offset", term(Term::Offset), (-per_kg, per_kg), 0, none.clone());
    } else {
        skip("payload-offset", "needs wheels on two sides");
    }
    for wheel in 0..N {
        let side = match runs.layout.side[wheel] {
            side if side < 0.0 => "left",
            side if side > 0.0 => "right",
            _ => "centre",
        };
        add(
            "wheel-drag",
            term(Term::Drag(wheel as u8)),
            (0.0, much),
            0,
            json!({"wheel": wheel + 1, "side": side}),
        );
    }
    if runs.robot.kinematics.scrubs() {
        add("turning-scrub", term(Term::Scrub), (0.0, much), 0, json!({"depends_on_mass": false}));
    } else {
        add("turning-scrub", term(Term::Scrub), (0.0, much), 1, json!({"depends_on_mass": false}));
        add("turning-scrub", term(Term::ScrubPerKg), (0.0, per_kg), 1, json!({"depends_on_mass": true}));
    }
    add("gear-load-loss", term(Term::GearLoad), (0.0, 20.0 / torque), 0, none.clone());
    // Leads and sensor see the whole power, the part that was calibrated away as static included: unless it was calibrated anew.
    let with_static: Vec<f64> = match runs.robot.static_power {
        with if with > 0.0 => vec![with, 0.0],
        _ => vec![0.0],
    };
    for &with in &with_static {
        let most = 2.0 / (scale.power + with).max(1e-9);
        let detail = if with > 0.0 { json!({"with_static_w": with}) } else { Value::Null };
        add("supply-sag", term(Term::Sag(with)), (0.0, most), with_static.len() as u32 - 1, detail);
    }
    if regenerative {
        skip("regeneration", "the robot's file says that the drives feed back already");
    } else {
        add("regeneration", term(Term::Return), (0.0, 1.0), 0, none.clone());
    }
    // With the command the power goes before the wheel stands: a negative hold.
    for hold in [-0.3, 0.0, 1.0, 4.0, f64::INFINITY] {
        let with = if hold.is_finite() {
            json!({"with": "motion", "hold_s": hold})
        } else {
            json!({"from": "the first motion on"})
        };
        add("static-step", term(Term::WithMotion(hold)), (-f64::INFINITY, f64::INFINITY), 1, with);
    }
    let light = runs.runs.iter().flat_map(|run| &run.rows).map(|row| row.mass).fold(f64::INFINITY, f64::min);
    add("payload-mislabel", vec![Regressor::Masses], (-light, 20.0 * scale.mass), 0, json!({"runs": "all"}));
    match runs.column(PROCESSOR) {
        Some(column) => {
            add("compute-load", vec![Regressor::Column(column)], (0.0, f64::INFINITY), 0, none.clone())
        }
        None => skip("compute-load", "needs cpu_percent"),
    }
    for &with in &with_static {
        let detail = if with > 0.0 { json!({"with_static_w": with}) } else { Value::Null };
        add("sensor-gain", term(Term::Gain(with)), (-0.9, 4.0), with_static.len() as u32 - 1, detail);
    }
    add("sensor-offset", term(Term::Constant), (-f64::INFINITY, f64::INFINITY), 0, none.clone());
    add("sensor-delay", vec![Regressor::Delay], (-1.0, 1.0), 0, none);
    let both = if sides { vec![("left", -1.0), ("right", 1.0), ("both", 0.0)] } else { vec![("both", 0.0)] };
    for (name, side) in both {
        add("speed-scale", vec![Regressor::Scale(side)], (-0.5, 1.0), 0, json!({"side": name}));
    }
    (found, missing)
}
