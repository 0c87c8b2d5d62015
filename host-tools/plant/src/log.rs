//! A run as a CSV log, row by row: what `gmr simulate` writes.

use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::Path;

use support::error::{Error, Result};
use support::output::write_whole;

use super::kinematics::Geometry;
use super::scenario::Scenario;
use super::simulation::{Sample, Simulation};

/// Columns that a log need not have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
#[value(rename_all = "snake_case")]
pub enum Column {
    /// Slope under the robot, nose up, rad
    Pitch,
    /// Heading on the slope, counter-clockwise from straight uphill, rad
    Slope,
    /// Commanded motion of the body, m/s and rad/s
    Command,
    /// Accelerations at an IMU, gravity and the floor's roughness included, m/s²
    Imu,
    /// Coefficients of rolling friction and of static friction (0 where tyres do not scrub)
    Friction,
    /// Temperatures of the windings, °C
    Temps,
    /// Voltage at the drives, V
    BusV,
    /// Load of the computer, percent
    Cpu,
}

/// What a log has beside time, wheel speeds and power.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Columns {
    /// The mass as it is noted.
    pub mass: bool,
    /// The supply power before sensors and noise.
    pub truth: bool,
    /// These, in this order.
    pub further: Vec<Column>,
}

impl Default for Columns {
    /// Those of a log that one fits: the mass, and nothing that real sensors do not show.
    fn default() -> Self {
        Self { mass: true, truth: false, further: Vec::new() }
    }
}

/// Sums over the rows of a log.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Totals {
    /// Rows written.
    pub rows: u64,
    /// Highest true power, W.
    pub peak_w: f64,
    /// Sum of the true power, W.
    sum_w: f64,
}

impl Totals {
    /// Mean true power, W.
    pub fn mean_w(&self) -> f64 {
        self.sum_w / self.rows.max(1) as f64
    }

    fn add(&mut self, sample: &Sample) {
        self.rows += 1;
        self.sum_w += sample.true_power_w;
        self.peak_w = self.peak_w.max(sample.true_power_w);
    }
}

/// Simulates a scenario into a file, which takes its name only when it is complete.
///
/// # Errors
/// What [`Scenario::check`] finds, or the operating system.
pub fn write(file: &Path, scenario: &Scenario, columns: &Columns) -> Result<Totals> {
    let simulation = Simulation::new(scenario)?;
    let failed = |error: io::Error| Error::io(file, &error);
    write_whole(file, |log| write_rows(log, failed, simulation, columns, |_| ()))
}

/// Writes header and rows; `at` gets the number of rows so far after every one.
///
/// # Errors
/// `failed` of what the writer refuses.
pub fn write_rows(
    log: &mut dyn Write,
    failed: impl Fn(io::Error) -> Error,
    run: Simulation<'_>,
    columns: &Columns,
    mut at: impl FnMut(u64),
) -> Result<Totals> {
    let mut totals = Totals::default();
    let geometry = run.geometry();
    let mut line = header(&geometry, columns);
    for sample in run {
        line.push('\n');
        log.write_all(line.as_bytes()).map_err(&failed)?;
        line.clear();
        Row { line: &mut line, sample: &sample, geometry: &geometry }.push(columns);
        totals.add(&sample);
        at(totals.rows);
    }
    line.push('\n');
    log.write_all(line.as_bytes()).map_err(failed)?;
    Ok(totals)
}

fn header(geometry: &Geometry, columns: &Columns) -> String {
    let wheels = 1..=geometry.wheels();
    let mut names = vec!["time_s".to_owned()];
    names.extend(wheels.clone().map(|i| format!("wheel{i}_rad_s")));
    names.push("power_w".to_owned());
    names.extend(columns.mass.then(|| "mass_kg".to_owned()));
    names.extend(columns.truth.then(|| "true_power_w".to_owned()));
    for column in &columns.further {
        let fixed: &[&str] = match column {
            Column::Pitch => &["pitch_rad"],
            Column::Slope => &["slope_heading_rad"],
            Column::Command if geometry.holonomic() => &["cmd_vx_m_s", "cmd_vy_m_s", "cmd_omega_rad_s"],
            Column::Command => &["cmd_v_m_s", "cmd_omega_rad_s"],
            Column::Imu => &["accel_x_m_s2", "accel_y_m_s2", "accel_z_m_s2"],
            Column::Friction => &["rolling_friction", "static_friction"],
            Column::Temps => &[],
            Column::BusV => &["bus_v"],
            Column::Cpu => &["cpu_percent"],
        };
        names.extend(fixed.iter().map(|name| (*name).to_owned()));
        if *column == Column::Temps {
            names.extend(wheels.clone().map(|i| format!("motor{i}_temp_c")));
        }
    }
    names.join(",")
}

/// One row in the making.
struct Row<'a> {
    line: &'a mut String,
    sample: &'a Sample,
    geometry: &'a Geometry,
}

impl Row<'_> {
    /// Time to a microsecond, speeds to 1e-7 rad/s, power to a microwatt; mass as short as it is
    /// exact.
    fn push(&mut self, columns: &Columns) {
        let Self { sample, geometry, .. } = *self;
        let wheels = geometry.wheels();
        // Writing to a String cannot fail.
        let _ = write!(self.line, "{:.6}", sample.time_s);
        self.fields(&sample.wheel_rad_s[..wheels], 7);
        self.fields(&[sample.power_w], 6);
        if columns.mass {
            let _ = write!(self.line, ",{}", sample.mass_kg);
        }
        if columns.truth {
            self.fields(&[sample.true_power_w], 6);
        }
        let [vx, vy, omega] = sample.command;
        for column in &columns.further {
            match column {
                Column::Pitch => self.fields(&[sample.pitch_rad], 6),
                Column::Slope => self.fields(&[sample.slope_heading_rad], 6),
                Column::Command if geometry.holonomic() => self.fields(&[vx, vy, omega], 6),
                Column::Command => self.fields(&[vx, omega], 6),
                Column::Imu => self.fields(&sample.imu_m_s2, 4),
                Column::Friction => self.fields(&[sample.rolling_friction, sample.static_friction], 6),
                Column::Temps => self.fields(&sample.motor_temp_c[..wheels], 2),
                Column::BusV => self.fields(&[sample.bus_v], 3),
                Column::Cpu => self.fields(&[sample.cpu_percent], 1),
            }
        }
    }

    /// So many digits each, and zero instead of what would be written as `-0.000000`.
    fn fields(&mut self, values: &[f64], digits: usize) {
        let half = 0.5 * 10_f64.powi(-(digits as i32));
        for value in values {
            let value = if value.abs() <= half { 0.0 } else { *value };
            let _ = write!(self.line, ",{value:.digits$}");
        }
    }
}
