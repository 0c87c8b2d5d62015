//! From figures to words: what is wrong or missing in a log, and what to do about it.

use std::path::Path;

use logs::MIN_GAP_FACTOR;
use logs::robot::Robot;
use logs::standing::Stuck;
use logs::suspicion::{Kind, Suspicion};

use super::finding::{Finding, Severity};
use super::report::Report;
use super::scan::Scan;
use super::static_power::{Moving, StaticPower};
use super::verdict::Verdict;

/// Noise alone makes the power of slow drives negative now and then: up to this share of the moving
/// rows.
const NEGATIVE: f64 = 0.05;

/// Up to this share of the rows, outliers are the starts and stops of a robot with play in its
/// gears: 3 % in measured logs of a Husky.
const MANY_OUTLIERS: f64 = 0.05;

/// Wheels that are held at a speed may keep a register's value for a while: below this share of the
/// log it is no reason to refuse it. Chosen: of some 4,000 right logs of the second judge one kept a
/// value for 9 %.
const STUCK_SHARE: f64 = 0.2;

/// An offset at standstill below this share of the greatest power does no harm to a fit.
const OFFSET: f64 = 0.01;

/// Faster than any robot with these tools in mind, m/s: a unit is wrong then.
const FASTEST_M_S: f64 = 20.0;
/// Sample rates below these say little about accelerations; see the measured comparison in the
/// model's description.
const LOW_RATE_HZ: f64 = 15.0;
const GOOD_RATE_HZ: f64 = 50.0;

pub(super) fn report(path: &Path, robot: &Robot, scan: Scan) -> Report {
    let has_wheels = scan.excitation.is_some();
    let power = StaticPower::of(&scan.blocks, has_wheels);
    let mut findings = Findings(Vec::new());
    findings.sampling(&scan);
    findings.suspicions(&scan);
    findings.sensors(&scan);
    findings.drive(robot, &scan);
    findings.payload(&scan);
    findings.static_power(robot, &scan, &power);
    findings.0.sort_by_key(|finding| finding.severity);
    let verdict = Verdict::of(&scan, &findings.0);
    Report {
        verdict,
        log: path.display().to_string(),
        robot: robot.name().to_owned(),
        rows: scan.rows,
        duration_s: scan.duration_s,
        rate_hz: Some(1.0 / scan.period_s).filter(|rate| rate.is_finite()),
        timing: scan.timing,
        exclusions: scan.exclusions,
        outliers: scan.outliers,
        stuck: scan.stuck,
        excitation: scan.excitation,
        static_states: power.standing,
        moving_levels: power.moving,
        standstill_from: if has_wheels { "wheel speeds" } else { "power" },
        other_columns: scan.other_columns,
        findings: findings.0,
        blocks: scan.blocks,
    }
}

struct Findings(Vec<Finding>);

impl Findings {
    fn add(&mut self, severity: Severity, text: impl Into<String>, advice: impl Into<String>) {
        self.0.push(Finding { severity, text: text.into(), advice: advice.into(), is_misread: false });
    }

    fn sampling(&mut self, scan: &Scan) {
        use Severity::{Note, Problem, Warning};
        let rate = 1.0 / scan.period_s;
        if !rate.is_finite() {
            let text = "no row continues the one before: nothing is known of the sample rate";
            self.add(Problem, text, "give the rows of one drive one value of run");
        } else if scan.period_s > 10.0 {
            let text = format!(
                "the median step of time is {:.0} s: time_s does not seem to be in seconds",
                scan.period_s
            );
            self.add(Problem, text, "convert time to seconds");
        } else if rate < LOW_RATE_HZ {
            let text = format!(
                "sample rate {rate:.1} Hz is low for accelerations: inertia and payload will be uncertain"
            );
            self.add(Warning, text, "record at 50 Hz or more; servo bus and power sensor allow 200 Hz");
        } else if rate < GOOD_RATE_HZ {
            let text = format!("sample rate {rate:.1} Hz is usable; payload estimates gain from more");
            self.add(Note, text, "record at 50 Hz or more where the robot can");
        }
        if scan.timing.jitter.std_s > 0.2 * scan.period_s {
            let share = 100.0 * scan.timing.jitter.std_s / scan.period_s;
            let text = format!("steps of time vary by {share:.0} % of the period (standard deviation)");
            self.add(Warning, text, "write the time of the measurement, not of its arrival");
        }
        if scan.timing.gap_count > 0 {
            let count = scan.timing.gap_count;
            let text = format!("{count} gap{} of more than {MIN_GAP_FACTOR} periods", plural(count));
            self.add(Note, text, "nothing: filters start afresh behind every gap");
        }
        if scan.exclusions.total() > 0 {
            self.add(Warning, scan.exclusions.to_string(), "look at the first such line");
        }
    }

    fn sensors(&mut self, scan: &Scan) {
        for outliers in scan.outliers.iter().filter(|outliers| outliers.count > 0) {
            let share = outliers.count as f64 / scan.rows as f64;
            let severity = if share > MANY_OUTLIERS { Severity::Warning } else { Severity::Note };
            let text = format!(
                "{} outlier{} of {} (greatest {:.3} from its neighbours in line {})",
                outliers.count,
                plural(outliers.count),
                outliers.quantity,
                outliers.greatest,
                outliers.greatest_line
            );
            self.add(severity, text, "look at that line; few of them do no harm to a fit");
        }
        for stuck in &scan.stuck {
            self.add(
                if is_short(stuck, scan) { Severity::Warning } else { Severity::Problem },
                stuck.to_string(),
                "check the sensor and its cable; leave this stretch out",
            );
        }
    }

    fn suspicions(&mut self, scan: &Scan) {
        for Suspicion { kind, text, remedy } in &scan.suspicions {
            // A wheel whose sensor stands still drives no curves.
            if *kind == Kind::SpeedSign && scan.stuck.iter().any(|stuck| !is_short(stuck, scan)) {
                continue;
            }
            let severity = match kind {
                Kind::Clipped | Kind::Unlabelled | Kind::SpeedDear => Severity::Warning,
                _ => Severity::Problem,
            };
            let (text, advice) = (text.clone(), remedy.clone());
            self.0.push(Finding { severity, text, advice, is_misread: kind.is_misread() });
        }
    }

    fn drive(&mut self, robot: &Robot, scan: &Scan) {
        use Severity::{Note, Problem, Warning};
        let Some(drive) = &scan.excitation else {
            let text = "no wheel speeds: standstill is inferred from power, and nothing can be fitted";
            self.add(Warning, text, "log wheel1_rad_s … of all wheels");
            return;
        };
        let (low, high) = drive.wheel_speed_range_rad_s;
        let fastest = high.max(-low);
        // What the usual speed says is said already.
        let is_doubted = scan.suspicions.iter().any(|suspicion| suspicion.kind == Kind::SpeedUnit);
        if let Some(radius) = robot.wheel_radius_m()
            && !is_doubted
            && fastest * radius > FASTEST_M_S
        {
            let text = format!("a wheel at {fastest:.0} rad/s would drive at {:.0} m/s", fastest * radius);
            self.add(Problem, text, "check the unit (rev/min or degrees?) and wheel_radius_m");
        }
        if drive.share_moving == 0.0 {
            self.add(Warning, "the robot never moves: only static power can be found", "record a drive");
            return;
        }
        let [slow, _, fast] = drive.speed_quantiles_rad_s;
        if drive.share_accelerating < 0.02 || fast < 1.25 * slow {
            let (what, advice) = if fast < 1.25 * slow {
                (
                    "constant speed only: friction (a0, a1), viscous friction (g2) and winding loss (κ) cannot be told \
                  apart, nor inertia (g3, g4) found",
                    "drive at three speeds and more, with ramps up and down",
                )
            } else {
                (
                    "hardly any acceleration: inertia (g3, g4) cannot be found, nor payload told by it",
                    "drive with ramps up and down, some of them steep",
                )
            };
            self.add(Warning, what, advice);
        }
        if drive.share_turning < 0.02 {
            let text = "hardly any turning: rotational inertia and turning friction cannot be found";
            self.add(Warning, text, "add turns on the spot and curves");
        }
        if drive.share_straight < 0.02 && drive.share_turning > 0.5 {
            self.add(Warning, "hardly any straight driving", "add straight drives with ramps");
        }
        // Six standard deviations of the sensor's noise: what is within them says nothing about
        // signs.
        let noise = scan.outliers.first().map_or(0.0, |power| power.limit);
        let is_turned = scan.suspicions.iter().any(|suspicion| suspicion.kind == Kind::PowerSign);
        if !is_turned
            && drive.share_power_negative > NEGATIVE
            && drive.power_high_w > 1.5 * noise
            && !robot.regeneration()
        {
            let text = format!(
                "{:.0} % of moving rows have negative power, but {} does not feed power back",
                100.0 * drive.share_power_negative,
                robot.name()
            );
            self.add(
                Warning,
                text,
                "check the sign and the zero of the power sensor, or set regeneration = true",
            );
        }
        if drive.share_power_near_zero > 0.2 && !robot.regeneration() {
            let text = format!(
                "power is near 0 in {:.0} % of moving rows: there the model is clamped and learns nothing",
                100.0 * drive.share_power_near_zero
            );
            self.add(Note, text, "brake less, or drive level ground");
        }
    }

    fn payload(&mut self, scan: &Scan) {
        use Severity::{Note, Warning};
        let Some(drive) = &scan.excitation else { return };
        match drive.payloads.len() {
            0 if scan.has_mass => self.add(Warning, "mass_kg holds no number", "write the total mass into every row"),
            0 => self.add(
                Note,
                "no mass_kg column: fine for estimating, not enough for fitting",
                "add a column mass_kg with the total mass for training runs",
            ),
            1 => self.add(
                Warning,
                "one payload only: a0 (Coulomb torque) and a1 (rolling resistance per kg) cannot be told apart",
                "record a second drive with another payload",
            ),
            2 => self.add(
                Note,
                "two payloads: the signed torque model is determined; β0, β1 and β2 of Eq. 18 are not",
                "add a drive with a third payload if Eq. 18 is wanted",
            ),
            _ => {}
        }
    }

    fn static_power(&mut self, robot: &Robot, scan: &Scan, power: &StaticPower) {
        use Severity::{Note, Problem, Warning};
        let Some(lowest) = power.standing.first() else {
            let text = "no standstill longer than a second: static power cannot be found";
            self.add(Note, text, "let the robot stand for ten seconds and more, motors on and off");
            return;
        };
        if power.standing.len() > 1 {
            let levels: Vec<_> = power.standing.iter().map(|state| format!("{:.2}", state.mean_w)).collect();
            let text = format!("static power has {} states: {} W", levels.len(), levels.join(", "));
            let advice = "use the state that holds while the robot drives (motor torque on, same sensors)";
            self.add(Note, text, advice);
        }
        if power.standing.iter().any(|state| state.moving == Moving::Unknown) {
            let text =
                "levels above the lowest may be motion at constant speed: without wheel speeds nothing tells";
            self.add(Note, text, "log wheel speeds, or compare with what the robot did at those times");
        }
        if scan.excitation.is_none() {
            return;
        }
        let high = scan.excitation.as_ref().map_or(0.0, |drive| drive.power_high_w);
        if lowest.is_offset() && -lowest.mean_w > OFFSET * high {
            let text = format!(
                "power_w is {:.2} W at standstill: the power sensor has an offset, as no robot draws less than nothing",
                lowest.mean_w
            );
            self.add(Warning, text, format!("add {:.2} W to power_w, or zero the sensor", -lowest.mean_w));
        }
        match robot.static_power_w() {
            None if lowest.mean_w > 3.0 * lowest.std_w && lowest.mean_w > 0.1 * high => {
                let state =
                    power.standing.iter().max_by(|a, b| a.share.total_cmp(&b.share)).unwrap_or(lowest);
                let text = format!("power_w is total power ({:.2} W standing)", state.mean_w);
                self.add(Problem, text, format!("add static_power_w = {:.2} to robot.toml", state.mean_w));
            }
            Some(set) => {
                let near = power
                    .standing
                    .iter()
                    .any(|state| (state.mean_w - set).abs() < state.std_w.max(0.05 * set));
                if !near {
                    let text = format!(
                        "static_power_w = {set} in robot.toml, but the robot draws {:.2} W at standstill",
                        lowest.mean_w
                    );
                    self.add(
                        Warning,
                        text,
                        "correct static_power_w, or leave it out if power_w is actuation power",
                    );
                }
            }
            None => {}
        }
    }
}

fn is_short(stuck: &Stuck, scan: &Scan) -> bool {
    stuck.total_s < STUCK_SHARE * scan.duration_s
}

fn plural(count: u64) -> &'static str {
    if count == 1 { "" } else { "s" }
}
