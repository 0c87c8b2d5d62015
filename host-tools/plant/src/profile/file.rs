//! A profile from a CSV file.

use std::path::Path;

use support::error::{Error, Result};
use support::input::{MOST_PROFILE, read_text};

use super::super::kinematics::{Geometry, MAX_WHEELS};
use super::Profile;

/// Reads a profile: `time_s` and either `v_m_s, omega_rad_s` (`vx_m_s, vy_m_s, omega_rad_s` for
/// robots that move sideways) or `wheel1_rad_s … wheelN_rad_s`. Times ascend; motion is linear
/// between rows.
///
/// # Errors
/// Names file, line and column, and what was expected there.
pub fn read(file: &Path, geometry: &Geometry) -> Result<Profile> {
    let text = read_text(file, MOST_PROFILE)?;
    parse(&text, geometry).map_err(|error| error.in_file(file))
}

fn parse(text: &str, geometry: &Geometry) -> Result<Profile> {
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let Some((_, header)) = lines.next() else {
        return Err(Error::failed("the file is empty; expected a header such as `time_s,v_m_s,omega_rad_s`"));
    };
    let names: Vec<&str> = header.split(',').map(str::trim).collect();
    let place = |name: &str| names.iter().position(|n| *n == name);
    let need = |name: &str| {
        place(name).ok_or_else(|| Error::failed("column missing from the header").at_line(1).in_column(name))
    };
    let time = need("time_s")?;
    let wheels = place("wheel1_rad_s").is_some();
    let columns: Vec<Option<usize>> = if wheels {
        (1..=geometry.wheels()).map(|i| need(&format!("wheel{i}_rad_s")).map(Some)).collect::<Result<_>>()?
    } else if geometry.holonomic() && place("v_m_s").is_none() {
        vec![Some(need("vx_m_s")?), Some(need("vy_m_s")?), Some(need("omega_rad_s")?)]
    } else {
        vec![Some(need("v_m_s")?), None, Some(need("omega_rad_s")?)]
    };
    let mut rows: Vec<(f64, [f64; MAX_WHEELS])> = Vec::new();
    for (index, line) in lines {
        let line_number = index as u64 + 1;
        let cells: Vec<&str> = line.split(',').map(str::trim).collect();
        let number = |column: usize| {
            let wrong = |cell: &str| {
                Error::failed(format!("found {cell}; expected a number"))
                    .at_line(line_number)
                    .in_column(names[column])
            };
            let cell = cells.get(column).ok_or_else(|| wrong("the end of the line"))?;
            let value = cell.parse::<f64>().ok().filter(|x| x.is_finite());
            value.ok_or_else(|| wrong(&format!("`{cell}`")))
        };
        let at = number(time)?;
        if rows.last().map_or(at < 0.0, |&(last, _)| at <= last) {
            let expected = "expected times from 0, ascending";
            return Err(Error::failed(format!("time {at} s; {expected}"))
                .at_line(line_number)
                .in_column("time_s"));
        }
        let mut command = [0.0; MAX_WHEELS];
        for (value, column) in command.iter_mut().zip(&columns) {
            *value = column.map_or(Ok(0.0), number)?;
        }
        rows.push((at, command));
    }
    if rows.is_empty() {
        return Err(Error::failed("only a header; expected at least one row"));
    }
    Ok(if wheels {
        Profile::from_wheel_speeds(rows)
    } else {
        Profile::from_twists(rows.into_iter().map(|(at, [x, y, turn, _])| (at, [x, y, turn])))
    })
}

#[cfg(test)]
mod tests {
    use super::super::super::kinematics::Kinematics;
    use super::super::tests::geometry;
    use super::*;

    #[test]
    fn every_accepted_header_is_read() {
        let speeds = |text: &str, kinematics| {
            let geometry = geometry(kinematics);
            parse(text, &geometry).unwrap().wheel_speeds_at(&geometry, 1.0, &mut 0)
        };
        let [left, right, ..] =
            speeds("time_s,v_m_s,omega_rad_s\n0,0,0\n1,0.1,0.5\n", Kinematics::Differential);
        assert!((left * 0.033 - 0.06).abs() < 1e-12 && (right * 0.033 - 0.14).abs() < 1e-12);
        let wheels = speeds("wheel2_rad_s,time_s,wheel1_rad_s\n2,0,1\n", Kinematics::Differential);
        assert_eq!(wheels[..2], [1.0, 2.0]);
        let sideways = speeds("time_s,vx_m_s,vy_m_s,omega_rad_s\r\n0,0,0.033,0\r\n", Kinematics::Mecanum);
        assert_eq!(sideways.map(|w| (w * 1e9).round() / 1e9), [-1.0, 1.0, 1.0, -1.0]);
    }

    #[test]
    fn errors_name_line_and_column() {
        for (text, expected) in [
            ("", "file is empty"),
            ("time_s,v_m_s,omega_rad_s\n", "only a header"),
            ("time_s,v_m_s\n0,1\n", ":1:omega_rad_s: column missing"),
            ("time_s,v_m_s,omega_rad_s\n0,0,0\n1,x,0\n", ":3:v_m_s: found `x`"),
            ("time_s,v_m_s,omega_rad_s\n0,0,0\n1,0\n", ":3:omega_rad_s: found the end of the line"),
            ("time_s,v_m_s,omega_rad_s\n0,0,NaN\n", ":2:omega_rad_s: found `NaN`"),
            ("time_s,v_m_s,omega_rad_s\n0,0,0\n0,0,0\n", ":3:time_s: time 0 s"),
            ("time_s,wheel1_rad_s\n0,0\n", ":1:wheel2_rad_s: column missing"),
        ] {
            let error = parse(text, &geometry(Kinematics::Differential)).unwrap_err().in_file("p.csv");
            assert!(error.to_string().contains(expected), "{text:?}: {error}");
        }
    }
}
