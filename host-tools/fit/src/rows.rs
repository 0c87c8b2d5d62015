//! Rows after the filter, each with as much room as the robot has wheels: a row of two with room
//! for six would take nearly three times as much.

use logs::robot::chassis::{Together, Wheels};
use logs::{Now, RawRow, with_motion};
use model_core::eq18::{self, Gate, REGRESSORS};
use model_core::model::{MassRange, Model, Response};
use model_core::motion::{Motion, Wheel};
use rayon::prelude::*;

/// One conditioned row, with its wheels or without.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row<W = Wheels> {
    /// Speeds and accelerations after the filter.
    pub wheels: W,
    /// Actuation power after the filter, W.
    pub power: f64,
    /// Total mass, kg.
    pub mass: f64,
    /// Which run: files and values of their `run` column are counted through.
    pub run: u32,
    /// Time within its log, s.
    pub time: f64,
}

/// A row whose wheels are kept elsewhere.
pub type Kept<'a> = Row<&'a [Wheel<f64>]>;

/// Rows of one robot: what is per wheel lies in one piece.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Rows {
    /// As many of every row.
    wheels: Vec<Wheel<f64>>,
    others: Vec<Row<()>>,
}

/// Consecutive rows.
#[derive(Debug, Clone, Copy)]
pub struct Stretch<'a> {
    wheels: &'a [Wheel<f64>],
    others: &'a [Row<()>],
}

impl<W> Row<W> {
    fn with<V>(&self, wheels: V) -> Row<V> {
        Row { wheels, power: self.power, mass: self.mass, run: self.run, time: self.time }
    }
}

impl Row {
    /// As models take it.
    pub fn view(&self) -> Kept<'_> {
        self.with(&self.wheels)
    }
}

impl<'a> Kept<'a> {
    /// Of a row and what it is after the filter. A log without masses is at `mass_kg`.
    pub(super) fn of(now: &'a Now, raw: &RawRow, mass_kg: f64) -> Self {
        let mass = raw.mass.unwrap_or(mass_kg);
        Self { wheels: &now.wheels, power: now.power, mass, run: raw.run, time: raw.time }
    }

    /// The same with its wheels.
    pub fn owned(&self) -> Row {
        self.with(Wheels::new(self.wheels.len(), |wheel| self.wheels[wheel]))
    }

    /// Power by a model, W; `None` where it is not finite.
    pub fn predicted(&self, model: &Model<f64>) -> Option<f64> {
        with_motion!(self.wheels, motion => model.power(motion, self.mass))
    }

    /// Power by a model at any mass.
    pub fn response(&self, model: &Model<f64>, range: &MassRange<f64>) -> Response<f64> {
        with_motion!(self.wheels, motion => model.response(motion, range))
    }

    /// Products of Eq. 18, summed over the wheels.
    #[inline(always)]
    pub fn products(&self, gate: Gate) -> [f64; REGRESSORS] {
        let mut sums = [0.0; REGRESSORS];
        for wheel in self.wheels {
            let products = eq18::products(gate, &Motion { wheels: [*wheel] });
            sums.iter_mut().zip(products).for_each(|(sum, product)| *sum += product);
        }
        sums
    }
}

impl Rows {
    /// None yet, with room for so many of a robot with so many wheels.
    pub(super) fn with_capacity(rows: usize, wheels: usize) -> Self {
        Self { wheels: Vec::with_capacity(rows * wheels), others: Vec::with_capacity(rows) }
    }

    /// Another one of the same robot.
    pub fn push(&mut self, row: Kept<'_>) {
        self.wheels.extend_from_slice(row.wheels);
        self.others.push(row.with(()));
    }

    /// Keeps the rows that `stays` accepts; it sees them without their wheels.
    pub fn retain(&mut self, mut stays: impl FnMut(&Row<()>) -> bool) {
        let wheels = self.all().wheels_a_row();
        let mut kept = 0;
        for place in 0..self.others.len() {
            if stays(&self.others[place]) {
                self.others[kept] = self.others[place];
                self.wheels.copy_within(place * wheels..(place + 1) * wheels, kept * wheels);
                kept += 1;
            }
        }
        self.others.truncate(kept);
        self.wheels.truncate(kept * wheels);
    }

    /// Leaves none.
    pub fn clear(&mut self) {
        self.wheels.clear();
        self.others.clear();
    }

    /// All of them.
    pub fn all(&self) -> Stretch<'_> {
        Stretch { wheels: &self.wheels, others: &self.others }
    }

    /// One by one.
    pub fn iter(&self) -> impl Iterator<Item = Kept<'_>> + Clone {
        self.all().iter()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.others.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.others.is_empty()
    }
}

impl<'a> FromIterator<Kept<'a>> for Rows {
    fn from_iter<I: IntoIterator<Item = Kept<'a>>>(rows: I) -> Self {
        let mut all = Self::default();
        rows.into_iter().for_each(|row| all.push(row));
        all
    }
}

impl<'a> Stretch<'a> {
    /// What rows hold besides their wheels.
    pub fn others(self) -> &'a [Row<()>] {
        self.others
    }

    /// The wheels of the first row, of the second, …, and how many are of one row.
    pub(super) fn wheels(self) -> (&'a [Wheel<f64>], usize) {
        (self.wheels, self.wheels_a_row())
    }

    fn wheels_a_row(self) -> usize {
        // One, not none, where there is no row: what is cut into pieces of it has none.
        (self.wheels.len() / self.others.len().max(1)).max(1)
    }

    /// One by one.
    pub fn iter(self) -> impl Iterator<Item = Kept<'a>> + Clone {
        let wheels = self.wheels.chunks_exact(self.wheels_a_row());
        self.others.iter().zip(wheels).map(|(row, wheels)| row.with(wheels))
    }

    /// Cut where two neighbours differ in this.
    pub fn chunk_by(self, alike: impl FnMut(&Row<()>, &Row<()>) -> bool) -> impl Iterator<Item = Self> {
        let (wheels_a_row, mut behind) = (self.wheels_a_row(), self.wheels);
        self.others.chunk_by(alike).map(move |others| {
            let wheels;
            (wheels, behind) = behind.split_at(others.len() * wheels_a_row);
            Self { wheels, others }
        })
    }

    /// Cut into stretches of so many rows.
    pub(super) fn blocks(self, rows: usize) -> impl Iterator<Item = Self> {
        let wheels = self.wheels.chunks(rows * self.wheels_a_row());
        self.others.chunks(rows).zip(wheels).map(|(others, wheels)| Self { wheels, others })
    }

    /// The same for any core.
    pub(super) fn par_chunks(self, rows: usize) -> impl IndexedParallelIterator<Item = Self> {
        let wheels = self.wheels.par_chunks(rows * self.wheels_a_row());
        self.others.par_chunks(rows).zip(wheels).map(|(others, wheels)| Self { wheels, others })
    }
}
