//! `gmr watch`: what a board measures and estimates, live.

use std::fmt::Write as _;
use std::io::{ErrorKind, IsTerminal as _};
use std::net::UdpSocket;
use std::path::PathBuf;
use std::time::Duration;

use board::client::{Board, Client};
use board::serial::Serial;
use board::status::{BatteryStatus, Status};
use support::error::{Error, Result};

/// Arguments of `gmr watch`.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  gmr watch --port /dev/ttyACM1\n  gmr watch --port /dev/ttyACM1 --every 0.05 --udp localhost:9870"
)]
pub(crate) struct Arguments {
    /// The board's serial port, for example /dev/ttyACM1
    #[arg(long)]
    port: PathBuf,
    /// Time between two looks, s
    #[arg(long, value_name = "S", default_value_t = 0.5, allow_negative_numbers = true)]
    every: f64,
    /// Look once and end
    #[arg(long)]
    once: bool,
    /// One line of JSON a look, on standard output
    #[arg(long)]
    json: bool,
    /// Send each look as a datagram of JSON as well: PlotJuggler's UDP Server takes it, message
    /// protocol json, timestamp uptime_s
    #[arg(long, value_name = "HOST:PORT")]
    udp: Option<String>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let every = match Duration::try_from_secs_f64(arguments.every) {
        Ok(every) if !every.is_zero() => every,
        _ => return Err(Error::usage(format!("--every {}: expected a time above 0 s", arguments.every))),
    };
    let feed = arguments.udp.as_deref().map(Feed::open).transpose()?;
    let at_port = |error: Error| error.in_file(&arguments.port);
    let (mut client, board) = Client::connect(Serial::open(&arguments.port)?).map_err(at_port)?;
    let is_redrawn = std::io::stdout().is_terminal() && !arguments.json;
    let mut drawn = 0;
    loop {
        let status = Status::read(&mut client).map_err(at_port)?;
        let line = support::output::json_line(&status)?;
        if let Some(feed) = &feed {
            feed.send(&line)?;
        }
        if arguments.json {
            println!("{line}");
        } else {
            let text = text(&board, &status);
            // Over what was drawn before.
            if is_redrawn && drawn > 0 {
                support::output::redraw(drawn);
            }
            drawn = text.lines().count();
            println!("{}", text.trim_end());
        }
        // Whoever reads this may have left.
        support::output::finish()?;
        if arguments.once {
            return Ok(());
        }
        client.wait(every).map_err(at_port)?;
    }
}

/// Where looks are sent.
struct Feed {
    socket: UdpSocket,
    to: String,
}

impl Feed {
    fn open(to: &str) -> Result<Self> {
        let wrong = |error: std::io::Error| {
            Error::usage(format!("--udp {to}: {error}; expected HOST:PORT, as localhost:9870"))
        };
        let socket = UdpSocket::bind("0.0.0.0:0").map_err(wrong)?;
        socket.connect(to).map_err(wrong)?;
        Ok(Self { socket, to: to.to_owned() })
    }

    /// Nobody listening is no error: whoever does may come later.
    fn send(&self, line: &str) -> Result<()> {
        match self.socket.send(line.as_bytes()) {
            Err(error) if error.kind() != ErrorKind::ConnectionRefused => {
                Err(Error::failed(format!("--udp {}: {error}", self.to)))
            }
            _ => Ok(()),
        }
    }
}

fn text(board: &Board, status: &Status) -> String {
    let number = |value: Option<f32>, unit: &str| match value {
        Some(value) => format!("{value:>9.3} {unit}"),
        None => format!("{:>9} {unit}", "–"),
    };
    let mut text = format!("{}, {:.1} s\n", board.robot, status.uptime_s);
    // Writing to a String cannot fail.
    for rail in &status.rails {
        let _ = writeln!(
            text,
            "{:>9} {} {} {} {}  {}",
            rail.name,
            number(rail.power_w, "W"),
            number(rail.voltage_v, "V"),
            number(rail.current_a, "A"),
            number(rail.energy_j, "J"),
            rail.health
        );
    }
    text.push_str(&totals(status));
    text.push_str(&battery(&status.battery));
    let wheels: Vec<String> = status.wheel_rad_s.iter().map(|speed| number(*speed, "rad/s")).collect();
    let standing = if status.is_standing { "  standing" } else { "" };
    let _ = writeln!(text, "{:>9} {}{standing}", "wheels", wheels.join(" "));
    let _ = match (status.no_coefficients, status.mass_kg, status.low_kg, status.high_kg) {
        (Some(why), ..) => writeln!(text, "{:>9} unknown: no coefficients ({why})", "mass"),
        (None, Some(mass), Some(low), Some(high)) => {
            let end = status.out_of_range.map_or(String::new(), |end| format!(", {end}"));
            writeln!(text, "{:>9} {mass:>9.3} kg  (95 %: {low:.3} … {high:.3}){end}", "mass")
        }
        _ => writeln!(text, "{:>9} unknown: {}", "mass", status.unknown.unwrap_or("no reason")),
    };
    let (measured, predicted) = (number(status.measured_w, "W"), number(status.predicted_w, "W"));
    let _ = writeln!(
        text,
        "{:>9} {measured} measured, {predicted} by the model, {} payload changes",
        "actuation", status.changes
    );
    let driven = if status.is_driven { ", driven by a node" } else { "" };
    let _ = writeln!(
        text,
        "{:>9} {}{driven}, goals {:?}; started by: {}",
        "drive", status.drive, status.goals, status.reset
    );
    let _ = writeln!(text, "{:>9} {:>9.1} ° {}", "heading", status.yaw_deg, status.inertial);
    let faults: Vec<String> = status.faults.iter().map(|(what, count)| format!("{what} {count}")).collect();
    if !faults.is_empty() {
        let _ = writeln!(text, "{:>9} {}", "faults", faults.join(", "));
    }
    text
}

/// Of the board's whole life.
fn totals(status: &Status) -> String {
    let hours = |seconds: u32| f64::from(seconds) / 3600.0;
    let rails = status.rails.iter().map(|rail| format!("{} {:.3}", rail.name, rail.total_j / 3600.0));
    let (rails, totals) = (rails.collect::<Vec<_>>().join(", "), &status.totals);
    let mut text = format!(
        "{:>9} {rails} Wh; {:.1} m in {:.2} of {:.2} h",
        "ever",
        totals.distance_m,
        hours(totals.driving_s),
        hours(totals.on_s)
    );
    if let Some(why) = totals.unkept {
        let _ = write!(text, " (not kept: {why})");
    }
    text.push('\n');
    text
}

/// A line, or two where it is known how long the battery lasts.
fn battery(battery: &BatteryStatus) -> String {
    let (Some(charge), Some(std)) = (battery.charge_percent, battery.charge_std_percent) else {
        return format!("{:>9} unknown\n", "charge");
    };
    let mut text = format!("{:>9} {charge:>9.1} % ± {std:.1}", "charge");
    if let (Some(ohm), Some(std)) = (battery.resistance_ohm, battery.resistance_std_ohm) {
        let _ = write!(text, ", resistance {ohm:.3} ± {std:.3} Ω");
    }
    text.push('\n');
    if let (Some(remaining), Some(low), Some(high), Some(load)) =
        (battery.remaining_wh, battery.remaining_low_wh, battery.remaining_high_wh, battery.load_w)
    {
        let _ = write!(text, "{:>9} {remaining:>9.2} Wh (95 %: {low:.2} … {high:.2})", "left");
        if let Some(seconds) = battery.remaining_s {
            let _ = write!(text, ", {:.0} min at {load:.1} W", seconds / 60.0);
        }
        text.push('\n');
    }
    text
}
