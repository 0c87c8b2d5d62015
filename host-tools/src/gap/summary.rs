//! The answer on one screen.

use std::fmt::Write as _;

use super::investigate::{Report, Verdict};

/// Cells with the greatest mean residual that are shown.
const CELLS: usize = 3;

/// Candidates of a round that are shown.
const SHOWN: usize = 6;

/// The summary.
pub fn text(report: &Report) -> String {
    let mut out = String::new();
    // Writing to a String cannot fail.
    let _ = write(&mut out, report);
    out
}

fn write(out: &mut String, report: &Report) -> std::fmt::Result {
    let confirmed = &report.confirmed;
    let verdict = match report.verdict {
        Verdict::None => "no gap beyond the noise",
        Verdict::Named => "named",
        Verdict::Ambiguous => "ambiguous",
        Verdict::Unexplained => "unexplained",
    };
    writeln!(out, "verdict: {verdict}")?;
    for effect in &report.effects {
        for (value, error) in effect.coefficients.iter().zip(&effect.std_errs) {
            let detail: Vec<String> =
                effect.candidate.detail.iter().map(|(key, value)| format!("{key} {value}")).collect();
            let (id, unit) = (&effect.candidate.id, &effect.candidate.unit);
            writeln!(out, "  {id} {value:.4e} ± {error:.1e} {unit}  {}", detail.join(", "))?;
        }
    }
    if !report.ambiguous_with.is_empty() {
        writeln!(out, "  cannot be told from: {}", report.ambiguous_with.join(", "))?;
    }
    writeln!(
        out,
        "gap on {} locked runs: {:.4} W before, {:.4} W after; noise floor {:.4} W{}",
        confirmed.runs.len(),
        confirmed.before_w,
        confirmed.after_w,
        confirmed.floor_w,
        confirmed.closed.map_or(String::new(), |closed| format!("; {:.0} % closed", 100.0 * closed))
    )?;
    let mut cells: Vec<_> =
        report.localisation.iter().filter(|cell| cell.mean_residual_w.abs() > cell.band_w).collect();
    cells.sort_by(|a, b| b.mean_residual_w.abs().total_cmp(&a.mean_residual_w.abs()));
    for cell in cells.iter().take(CELLS).filter(|_| report.verdict != Verdict::None) {
        let (axis, from, to) = (&cell.axis, cell.from, cell.to);
        let (mean, band) = (cell.mean_residual_w, cell.band_w);
        writeln!(out, "  {axis} {from:.3} to {to:.3}: {mean:+.3} ± {band:.3} W")?;
    }
    for (number, round) in (1..).zip(&report.rounds) {
        let (structure, allowed) = (round.structure, round.allowed);
        writeln!(out, "round {number}: structure {structure:.1} (allowed {allowed:.1}): {}", round.outcome)?;
        for scored in round.candidates.iter().take(SHOWN) {
            let values: Vec<String> = scored.coefficients.iter().map(|c| format!("{c:.3e}")).collect();
            writeln!(
                out,
                "    {:<26} {:>9.1}  {} {} {}",
                scored.id,
                scored.gain,
                values.join(" "),
                scored.detail,
                scored.status
            )?;
        }
    }
    Ok(())
}
