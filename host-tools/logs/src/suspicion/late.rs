//! Power that was logged later, or earlier, than the speeds that it belongs to.
//!
//! Power is regressed on speeds and accelerations, each mass on its own, with the power moved by so
//! much. Where another time fits much better than none, the clocks of the two sensors differ.

use nalgebra::{SMatrix, SVector};

use super::doubt::{Kind, Suspicion};

/// Time that rows are averaged over, s: what is looked for is a few of them.
const CELL_S: f64 = 0.05;

/// Most of them: ten minutes.
const MOST_CELLS: usize = 12_000;

/// Fewest that say anything.
const LEAST_CELLS: usize = 200;

/// Farthest that the power is moved, s.
const FARTHEST_S: f64 = 2.5;

/// Less is for the fit to find: a filter in the power sensor, a bus that is read in turns.
const LATE_S: f64 = 0.3;

// The four shares below were set so that every right log of tests/suite/suspicion.rs passes
// (simulated drives of four robots, excerpts of measured ones) and every one whose power was moved
// by a second is named; what lies between was not looked at.

/// Least R² at the best time: below, nothing is known of the power.
const LEAST_R2: f64 = 0.5;

/// The residual at the best time is at most this share of the one without.
const BETTER: f64 = 0.6;

/// The same of each half of the log, with less to go by.
const LEAST_R2_OF_HALF: f64 = 0.3;
const BETTER_IN_HALF: f64 = 0.8;

/// Regressors: 1, Σ|w|, Σw², Σw·dw/dt, and the mass times the second and the last.
const REGRESSORS: usize = 6;

/// The mean of some rows.
#[derive(Debug, Clone, Default)]
struct Cell {
    time_s: f64,
    wheels: Vec<f64>,
    power_w: f64,
    mass_kg: f64,
    rows: f64,
    segment: usize,
}

/// The first minutes of a log, in cells of equal time.
#[derive(Debug, Default)]
pub(super) struct Cells {
    cells: Vec<Cell>,
    open: Option<Cell>,
    began_s: f64,
    segment: usize,
}

impl Cells {
    pub(super) fn add(&mut self, time_s: f64, fresh: bool, wheels: &[f64], power_w: f64, mass_kg: f64) {
        if self.cells.len() >= MOST_CELLS {
            return;
        }
        if fresh {
            self.close();
            self.segment += 1;
        } else if self.open.is_some() && time_s - self.began_s >= CELL_S * (1.0 - 1e-6) {
            self.close();
        }
        let segment = self.segment;
        if self.open.is_none() {
            self.began_s = time_s;
        }
        let cell = self.open.get_or_insert_with(|| Cell {
            wheels: vec![0.0; wheels.len()],
            segment,
            ..Cell::default()
        });
        cell.rows += 1.0;
        cell.time_s += time_s;
        cell.power_w += power_w;
        cell.mass_kg += if mass_kg.is_finite() { mass_kg } else { 1.0 };
        for (sum, speed) in cell.wheels.iter_mut().zip(wheels) {
            *sum += speed;
        }
    }

    fn close(&mut self) {
        let Some(mut cell) = self.open.take() else { return };
        let rows = cell.rows;
        for value in cell.wheels.iter_mut().chain([&mut cell.time_s, &mut cell.power_w, &mut cell.mass_kg]) {
            *value /= rows;
        }
        self.cells.push(cell);
    }

    pub(super) fn suspicion(mut self) -> Option<Suspicion> {
        self.close();
        if self.cells.len() < LEAST_CELLS {
            return None;
        }
        let mut steps: Vec<f64> = self.cells.windows(2).map(|pair| pair[1].time_s - pair[0].time_s).collect();
        let middle = steps.len() / 2;
        let step = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
        if step <= 0.0 {
            return None;
        }
        let regressors = self.regressors();
        let most = (FARTHEST_S / step).round() as i64;
        let all = most as usize..self.cells.len().saturating_sub(most as usize);
        let r2 = |shift: i64| self.r2(&regressors, shift, all.clone());
        let now = r2(0)?;
        // Every tenth of a second is close enough to tell a second.
        let stride = (0.1 / step).round().max(1.0) as i64;
        let (best, shift) = (-most..=most)
            .filter(|shift| shift % stride == 0)
            .filter_map(|shift| Some((r2(shift)?, shift)))
            .max_by(|a, b| a.0.total_cmp(&b.0))?;
        let late = shift as f64 * step;
        if late.abs() < LATE_S || best < LEAST_R2 || 1.0 - best > BETTER * (1.0 - now) {
            return None;
        }
        // What one start says is chance: both halves have to say it.
        let middle = all.start + all.len() / 2;
        for half in [all.start..middle, middle..all.end] {
            let (now, then) = (self.r2(&regressors, 0, half.clone())?, self.r2(&regressors, shift, half)?);
            if then < LEAST_R2_OF_HALF || 1.0 - then > BETTER_IN_HALF * (1.0 - now) {
                return None;
            }
        }
        let (when, mend) = if late > 0.0 { ("later", "earlier") } else { ("earlier", "later") };
        let text = format!(
            "power comes about {:.1} s {when} than the speeds that explain it (R² {best:.2}, as logged {now:.2}): two clocks?",
            late.abs()
        );
        let remedy = format!("log both with one clock, or move the power {:.1} s {mend}", late.abs());
        Some(Suspicion { kind: Kind::PowerLate, text, remedy })
    }

    fn regressors(&self) -> Vec<Option<SVector<f64, REGRESSORS>>> {
        let cells = &self.cells;
        (0..cells.len())
            .map(|place| {
                let before = cells.get(place.checked_sub(1)?)?;
                let (now, after) = (&cells[place], cells.get(place + 1)?);
                if before.segment != now.segment || after.segment != now.segment {
                    return None;
                }
                let span = after.time_s - before.time_s;
                let gained = now.wheels.iter().zip(after.wheels.iter().zip(&before.wheels));
                let gained =
                    gained.map(|(speed, (after, before))| speed * (after - before) / span).sum::<f64>();
                let sum = now.wheels.iter().map(|speed| speed.abs()).sum::<f64>();
                let squares = now.wheels.iter().map(|speed| speed * speed).sum::<f64>();
                let mass = now.mass_kg;
                Some(SVector::from([1.0, sum, squares, gained, mass * sum, mass * gained]))
            })
            .collect()
    }

    /// Of the power of so many cells later, over these cells.
    fn r2(
        &self,
        regressors: &[Option<SVector<f64, REGRESSORS>>],
        shift: i64,
        cells: std::ops::Range<usize>,
    ) -> Option<f64> {
        let mut gram = SMatrix::<f64, REGRESSORS, REGRESSORS>::zeros();
        let mut products = SVector::<f64, REGRESSORS>::zeros();
        let (mut count, mut sum, mut squares) = (0.0, 0.0, 0.0);
        for place in cells {
            let other = &self.cells[place.checked_add_signed(shift as isize)?];
            let Some(x) = regressors[place].as_ref().filter(|_| other.segment == self.cells[place].segment)
            else {
                continue;
            };
            gram.ger(1.0, x, x, 1.0);
            products.axpy(other.power_w, x, 1.0);
            count += 1.0;
            sum += other.power_w;
            squares += other.power_w * other.power_w;
        }
        let total = squares - sum * sum / count;
        if count < LEAST_CELLS as f64 / 4.0 || total <= 0.0 {
            return None;
        }
        // Columns that repeat others (one mass) take nothing away from the fit: a little of their
        // own size keeps it solvable.
        for place in 0..REGRESSORS {
            gram[(place, place)] *= 1.0 + 1e-9;
        }
        let solution = gram.cholesky()?.solve(&products);
        let explained = solution.dot(&products);
        Some(1.0 - (squares - explained) / total)
    }
}
