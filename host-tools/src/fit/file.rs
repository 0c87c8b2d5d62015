//! coefficients.toml: what `gmr fit` writes and every other command reads.

use std::path::{Path, PathBuf};

use model_core::coefficients::{Coefficients, Name, Robot as CoreRobot};
use model_core::conditioning::Conditioning;
use model_core::effects::Columns;
use model_core::eq18::REGRESSORS;
use model_core::kinematics::Kinematics;
use model_core::model::{MassRange, Model};
use model_core::payload::Noise;
use model_core::torque::{Drive, TorqueModel};
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use super::{Fit, Method, ModelKind, fingerprint, verdict};
use crate::effects::written::{self, Written, Wrong};
use crate::error::{Error, Result};
use crate::output::write_whole;
use crate::robot::Robot;

/// Version of the file's layout.
const FORMAT: u32 = 1;

#[derive(Debug, Serialize, Deserialize)]
struct Document {
    format: u32,
    model: ModelKind,
    method: Method,
    robot: RobotSection,
    parameters: toml::Table,
    noise: NoiseSection,
    fit: FitSection,
    /// What `gmr gap --out` added.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    effects: Vec<Written>,
}

#[derive(Debug, Serialize, Deserialize)]
struct RobotSection {
    name: String,
    /// Rows vx, vy (m) and ω of R, one column a wheel.
    kinematics: Vec<Vec<f64>>,
    gyration_radius_m: f64,
    mass_no_load_kg: f64,
    mass_full_load_kg: f64,
    speed_dead_band_rad_s: f64,
    filter_cutoff_hz: f64,
    static_power_w: f64,
    regeneration: bool,
    /// Whether the wheels are dragged sideways in turns.
    scrubs: bool,
}

#[derive(Debug, Serialize, Deserialize)]
struct NoiseSection {
    density_w2_s: f64,
    model_std_w: f64,
    power_scale_w: f64,
    tail: f64,
}

#[derive(Debug, Serialize, Deserialize)]
struct FitSection {
    rows: u64,
    /// The logs, from the folder of this file: `gmr gap` asks them what the model gets wrong without any effect.
    #[serde(default)]
    logs: Vec<PathBuf>,
    /// Size and checksum of each, empty where it was no file: whether they are still what was fitted.
    #[serde(default)]
    fingerprints: Vec<String>,
    masses_kg: Vec<f64>,
    r2: f64,
    rmse_w: f64,
    /// Covariance of the parameters in the order above.
    covariance: Vec<Vec<f64>>,
}

/// Writes a fit, whole or not at all.
///
/// # Errors
/// What the operating system refuses.
pub fn write<const N: usize>(file: &Path, fit: &Fit<N>) -> Result<()> {
    let robot = &fit.coefficients.robot;
    let drive = match &fit.coefficients.model {
        Model::Signed { drive, .. } => *drive,
        Model::Eq18 { .. } => Drive::Dissipative,
    };
    let document = Document {
        format: FORMAT,
        model: fit.kind,
        method: fit.method,
        robot: RobotSection {
            name: robot.name.as_str().to_owned(),
            kinematics: robot.kinematics.rows().iter().map(|row| row.to_vec()).collect(),
            gyration_radius_m: robot.gyration_radius,
            mass_no_load_kg: robot.range.no_load(),
            mass_full_load_kg: robot.range.full_load(),
            speed_dead_band_rad_s: robot.dead_band,
            filter_cutoff_hz: robot.cutoff_hz,
            static_power_w: robot.static_power,
            regeneration: drive == Drive::Regenerative,
            scrubs: robot.kinematics.scrubs(),
        },
        parameters: fit.parameters.iter().map(|p| (p.name.clone(), toml::Value::Float(p.value))).collect(),
        noise: NoiseSection {
            density_w2_s: fit.coefficients.noise.density,
            model_std_w: fit.coefficients.noise.model_std,
            power_scale_w: fit.coefficients.noise.power_scale,
            tail: fit.coefficients.noise.tail,
        },
        fit: FitSection {
            rows: fit.rows,
            logs: fit.files.iter().map(|log| seen_from(file, log)).collect(),
            fingerprints: fit
                .files
                .iter()
                .map(|log| {
                    let found = fingerprint::of(log).map_err(|error| Error::io(log, &error))?;
                    Ok(found.unwrap_or_default())
                })
                .collect::<Result<_>>()?,
            masses_kg: fit.masses.clone(),
            r2: fit.quality.r2.unwrap_or(f64::NAN),
            rmse_w: fit.quality.rmse_w,
            covariance: fit
                .uncertainty
                .covariance
                .row_iter()
                .map(|row| row.iter().copied().collect())
                .collect(),
        },
        effects: Vec::new(),
    };
    write_document(file, &document)
}

fn write_document(file: &Path, document: &Document) -> Result<()> {
    let text = toml::to_string(document).map_err(|error| Error::failed(error.to_string()).in_file(file))?;
    write_whole(file, |out| out.write_all(text.as_bytes()).map_err(|error| Error::io(file, &error)))
}

/// Writes coefficients that [`read`] has accepted anew, whole or not at all: with the torque model as it moved, and effects.
///
/// # Errors
/// What the operating system refuses; more effects than coefficients can hold.
pub fn extend(base: &Path, torque: &TorqueModel<f64>, effects: &[Written], file: &Path) -> Result<()> {
    let mut document = parse(base, &read_text(base)?)?;
    let wheels = document.robot.kinematics.first().map_or(0, Vec::len);
    written::columns(effects, wheels).map_err(|wrong| Error::failed(wrong.message).in_file(file))?;
    for (description, value) in verdict::TORQUE.iter().zip(torque.to_array()) {
        if let Some(place) = document.parameters.get_mut(description.name) {
            // A little below nought is nought: no robot has less (Eq. 20).
            *place = toml::Value::Float(value.max(0.0));
        }
    }
    let logs = document.fit.logs.iter().map(|log| seen_from(file, &folder_of(base).join(log)));
    document.fit.logs = logs.collect();
    document.effects = effects.to_vec();
    write_document(file, &document)
}

fn read_text(file: &Path) -> Result<String> {
    std::fs::read_to_string(file).map_err(|error| Error::io(file, &error))
}

/// Reads coefficients and checks that they are for this robot.
///
/// # Errors
/// The file cannot be read, is of another format, is for another robot, or holds what no model can have.
pub fn read<const N: usize>(file: &Path, robot: &Robot) -> Result<Coefficients<f64, N>> {
    let text = read_text(file)?;
    let wrong = |message: String| Error::failed(message).in_file(file);
    let document = parse(file, &text)?;
    if document.format != FORMAT {
        return Err(wrong(format!("format {}; expected {FORMAT}", document.format)).in_column("format"));
    }
    let found = core_robot::<N>(&document.robot).map_err(|message| wrong(message).in_column("robot"))?;
    let expected = robot.core::<N>(found.cutoff_hz)?;
    if let Some(difference) = difference(&found, &expected) {
        return Err(wrong(format!(
            "these coefficients are for another robot: {difference} of {} (fitted for {}) differ",
            robot.name(),
            found.name.as_str()
        ))
        .in_column("robot"));
    }
    check_numbers(&document).map_err(|(name, message)| {
        let wrong = wrong(message).in_column(name);
        match line_of(&text, name) {
            Some(line) => wrong.at_line(line),
            None => wrong,
        }
    })?;
    let model = model(&document).map_err(|message| wrong(message).in_column("parameters"))?;
    let noise = Noise {
        density: document.noise.density_w2_s,
        model_std: document.noise.model_std_w,
        power_scale: document.noise.power_scale_w,
        tail: document.noise.tail,
    };
    // The file's static power is what the fit took off; the robot's file says what is to be taken off now.
    let coefficients = Coefficients { robot: expected, model, noise, columns: Columns::NONE };
    with_effects(coefficients, &document.effects).map_err(|Wrong { place, key, message }| {
        let wrong = wrong(message).in_column(key);
        match line_of_effect(&text, place, key) {
            Some(line) => wrong.at_line(line),
            None => wrong,
        }
    })
}

fn parse(file: &Path, text: &str) -> Result<Document> {
    toml::from_str(text).map_err(|error| {
        let message =
            format!("{}; expected coefficients as gmr fit writes them", error.message().replace('\n', " "));
        let wrong = Error::failed(message).in_file(file);
        match error.span() {
            Some(span) => wrong.at_line(1 + text[..span.start].matches('\n').count() as u64),
            None => wrong,
        }
    })
}

/// The effects that coefficients hold beyond the fitted model, for coefficients that [`read`] has accepted.
///
/// # Errors
/// The file cannot be read.
pub fn read_effects(file: &Path) -> Result<Vec<Written>> {
    Ok(parse(file, &read_text(file)?)?.effects)
}

/// # Errors
/// The effect that is unknown, lacks something, or makes powers that no robot draws.
fn with_effects<const N: usize>(
    coefficients: Coefficients<f64, N>,
    effects: &[Written],
) -> std::result::Result<Coefficients<f64, N>, Wrong> {
    let columns = written::columns(effects, N)?;
    let has_torques = matches!(coefficients.model, Model::Signed { .. });
    for (place, effect) in effects.iter().enumerate() {
        let wrong = |key, message| Wrong { place, key, message };
        if !has_torques {
            let message =
                format!("{} beside model eq18; expected model signed: effects act on its torques", effect.id);
            return Err(wrong("id", message));
        }
        let alone =
            Coefficients { columns: written::columns(std::slice::from_ref(effect), N)?, ..coefficients };
        if !alone.is_plausible() {
            let message = format!(
                "{} with coefficient {} makes powers that no robot draws",
                effect.id, effect.coefficient
            );
            return Err(wrong("coefficient", message));
        }
    }
    Ok(Coefficients { columns, ..coefficients })
}

/// The path of a log as seen from the folder of the coefficients, so that both can move together; absolute where they share none.
fn seen_from(coefficients: &Path, log: &Path) -> PathBuf {
    let folder = folder_of(coefficients);
    match (std::fs::canonicalize(log), std::fs::canonicalize(folder)) {
        (Ok(log), Ok(folder)) => log.strip_prefix(&folder).map(Path::to_owned).unwrap_or(log),
        _ => log.to_owned(),
    }
}

fn folder_of(file: &Path) -> &Path {
    file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// The logs that coefficients were fitted to, as far as they are still there, for coefficients that [`read`] has accepted.
///
/// # Errors
/// The file cannot be read; a log is no longer what was fitted.
pub fn read_logs(file: &Path) -> Result<Vec<PathBuf>> {
    let document = parse(file, &read_text(file)?)?;
    let all = document.fit.logs.len();
    let mut logs = Vec::new();
    for (place, log) in document.fit.logs.into_iter().enumerate() {
        let log = folder_of(file).join(log);
        if !log.exists() {
            continue;
        }
        let then = document.fit.fingerprints.get(place).filter(|fingerprint| !fingerprint.is_empty());
        let now = fingerprint::of(&log).map_err(|error| Error::io(&log, &error))?;
        if let (Some(then), Some(now)) = (then, now)
            && *then != now
        {
            let message = format!(
                "has changed since the coefficients of {} were fitted to it; expected the log as it was, or the clean runs \
                 with --base",
                file.display()
            );
            return Err(Error::failed(message).in_file(log));
        }
        logs.push(log);
    }
    if !logs.is_empty() && logs.len() < all {
        eprintln!(
            "gmr: {}: {} of the {all} clean runs are no longer where they were, and are done without",
            file.display(),
            all - logs.len()
        );
    }
    Ok(logs)
}

/// The covariance of the parameters as the fit stated it, for coefficients that [`read`] has accepted.
///
/// # Errors
/// The file cannot be read, or its covariance is no square matrix of finite numbers.
pub fn read_covariance(file: &Path) -> Result<DMatrix<f64>> {
    let wrong = |message: &str| Error::failed(message).in_file(file).in_column("covariance");
    let document = parse(file, &read_text(file)?)?;
    let rows = document.fit.covariance;
    let size = document.parameters.len();
    if rows.len() != size || rows.iter().any(|row| row.len() != size || row.iter().any(|x| !x.is_finite())) {
        return Err(wrong(&format!("expected {size} rows of {size} finite numbers, one a parameter")));
    }
    Ok(DMatrix::from_fn(size, size, |i, j| rows[i][j]))
}

/// # Errors
/// Names a number that no fit can give, and says what was expected (Eq. 20 for the coefficients).
fn check_numbers(document: &Document) -> std::result::Result<(), (&str, String)> {
    let parameters = document.parameters.iter().filter_map(|(name, value)| {
        let number = value.as_float().or_else(|| Some(value.as_integer()? as f64))?;
        Some((name.as_str(), number))
    });
    let noise = [
        ("density_w2_s", document.noise.density_w2_s),
        ("model_std_w", document.noise.model_std_w),
        ("power_scale_w", document.noise.power_scale_w),
        ("tail", document.noise.tail),
        ("filter_cutoff_hz", document.robot.filter_cutoff_hz),
    ];
    match parameters.chain(noise).find(|(_, value)| !(value.is_finite() && *value >= 0.0)) {
        Some((name, value)) => Err((name, format!("found {value}; expected a finite number not below 0"))),
        None => Ok(()),
    }
}

/// The line on which a key stands, counted from 1.
fn line_of(text: &str, key: &str) -> Option<u64> {
    let holds = |line: &str| line.split_once('=').is_some_and(|(name, _)| name.trim() == key);
    text.lines().position(holds).map(|index| index as u64 + 1)
}

/// The line of a key within the effect at this place, or of the effect where it has no such key; counted from 1.
fn line_of_effect(text: &str, place: usize, key: &str) -> Option<u64> {
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    let mut starts = lines.iter().enumerate().filter(|(_, line)| **line == "[[effects]]").map(|(at, _)| at);
    let start = starts.nth(place)?;
    let end = starts.next().unwrap_or(lines.len());
    let holds = |line: &&str| line.split_once('=').is_some_and(|(name, _)| name.trim() == key);
    let within = lines[start..end].iter().position(holds).unwrap_or(0);
    Some((start + within) as u64 + 1)
}

fn core_robot<const N: usize>(section: &RobotSection) -> std::result::Result<CoreRobot<f64, N>, String> {
    let rows = section.kinematics.iter().map(|row| <[f64; N]>::try_from(row.as_slice()));
    let rows: Vec<[f64; N]> = rows.collect::<std::result::Result<_, _>>().map_err(|_| {
        let found = section.kinematics.first().map_or(0, Vec::len);
        format!("fitted for a robot with {found} wheels; expected {N}: wrong robot?")
    })?;
    let rows: [[f64; N]; 3] = rows.try_into().map_err(|_| "kinematics: expected three rows".to_owned())?;
    let kinematics = Kinematics::from_rows(rows)
        .map_err(|error| format!("{} is not finite", error.name))?
        .with_scrub(section.scrubs);
    let mass_matrix = kinematics
        .mass_matrix(section.gyration_radius_m)
        .map_err(|error| format!("{} is wrong", error.name))?;
    let range = MassRange::new(section.mass_no_load_kg, section.mass_full_load_kg)
        .ok_or_else(|| "expected 0 < mass_no_load_kg < mass_full_load_kg".to_owned())?;
    Ok(CoreRobot {
        name: Name::new(&section.name),
        kinematics,
        gyration_radius: section.gyration_radius_m,
        mass_matrix,
        dead_band: section.speed_dead_band_rad_s,
        cutoff_hz: section.filter_cutoff_hz,
        conditioning: Conditioning::PLAIN,
        range,
        static_power: section.static_power_w,
    })
}

/// What makes two robots different, if anything does.
fn difference<const N: usize>(left: &CoreRobot<f64, N>, right: &CoreRobot<f64, N>) -> Option<&'static str> {
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-6 * a.abs().max(b.abs());
    let entries = left.kinematics.rows().iter().flatten().zip(right.kinematics.rows().iter().flatten());
    if left.kinematics.scrubs() != right.kinematics.scrubs() {
        Some("the kind of steering")
    } else if left.name != right.name {
        Some("the name")
    } else if !entries.into_iter().all(|(a, b)| close(*a, *b)) {
        Some("the wheels' geometry")
    } else if !close(left.gyration_radius, right.gyration_radius) {
        Some("the gyration radius")
    } else if !close(left.range.no_load(), right.range.no_load())
        || !close(left.range.full_load(), right.range.full_load())
    {
        Some("the masses")
    } else {
        None
    }
}

fn model(document: &Document) -> std::result::Result<Model<f64>, String> {
    let value = |name: &str| match document.parameters.get(name) {
        Some(toml::Value::Float(value)) => Ok(*value),
        Some(toml::Value::Integer(value)) => Ok(*value as f64),
        _ => Err(format!("{name} is missing or not a number")),
    };
    match document.model {
        ModelKind::Signed => {
            let mut parameters = [0.0; verdict::TORQUE.len()];
            for (place, description) in parameters.iter_mut().zip(&verdict::TORQUE) {
                // A robot without scrub has no such entry.
                *place = match description.name {
                    "scrub" if !document.robot.scrubs => 0.0,
                    name => value(name)?,
                };
            }
            let drive = if document.robot.regeneration { Drive::Regenerative } else { Drive::Dissipative };
            Ok(Model::Signed { torque: TorqueModel::from_array(parameters), drive })
        }
        ModelKind::Eq18 | ModelKind::Eq18Published => {
            let mut beta = [0.0; REGRESSORS];
            for (place, description) in beta.iter_mut().zip(&verdict::EQ18) {
                *place = value(description.name)?;
            }
            Ok(Model::Eq18 { gate: document.model.gate(), beta })
        }
    }
}
