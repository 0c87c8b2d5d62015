//! What came of it.

use std::fmt::Write;
use std::ops::AddAssign;

/// Least share of windows whose interval contains the mass, for each kind of drive and each chain.
const GOAL: f64 = 0.90;

/// Windows of a few drives.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Cell {
    pub(crate) known: usize,
    pub(crate) inside: usize,
    pub(crate) unknown: usize,
    pub(crate) changes: usize,
}

impl AddAssign for Cell {
    fn add_assign(&mut self, other: Self) {
        self.known += other.known;
        self.inside += other.inside;
        self.unknown += other.unknown;
        self.changes += other.changes;
    }
}

impl Cell {
    /// Share of the windows with a mass; `None` where there are none.
    fn share(&self) -> Option<f64> {
        (self.known > 0).then(|| self.inside as f64 / self.known as f64)
    }

    fn percent(&self) -> String {
        self.share().map_or("–".to_owned(), |share| format!("{:.0} %", 100.0 * share))
    }

    fn reaches(&self) -> bool {
        self.share().is_none_or(|share| share >= GOAL)
    }
}

/// Cells by chain and kind.
#[derive(Debug, Default)]
pub(crate) struct Table {
    cells: Vec<(usize, &'static str, Cell)>,
    /// With five times the noise, a chain each.
    pub(crate) noise: [Cell; 7],
    /// Masses beyond the range, a chain each.
    pub(crate) beyond: [Cell; 7],
}

impl Table {
    pub(crate) fn add(&mut self, chain: usize, kind: &'static str, cell: Cell) {
        match self.cells.iter_mut().find(|(of, name, _)| (*of, *name) == (chain, kind)) {
            Some((.., there)) => *there += cell,
            None => self.cells.push((chain, kind, cell)),
        }
    }

    fn kinds(&self) -> Vec<&'static str> {
        let mut kinds = Vec::new();
        for (_, kind, _) in &self.cells {
            if !kinds.contains(kind) {
                kinds.push(*kind);
            }
        }
        kinds
    }

    fn sum(&self, wanted: impl Fn(usize, &str) -> bool) -> Cell {
        let mut sum = Cell::default();
        for (_, _, cell) in self.cells.iter().filter(|(chain, kind, _)| wanted(*chain, kind)) {
            sum += *cell;
        }
        sum
    }

    /// Every kind and every chain reaches its share.
    pub(crate) fn is_reached(&self) -> bool {
        self.kinds().iter().all(|kind| self.sum(|_, name| name == *kind).reaches())
            && (0..self.noise.len()).all(|chain| self.sum(|of, _| of == chain).reaches())
            && self.noise.iter().all(|cell| cell.changes == 0)
    }

    /// As markdown.
    pub(crate) fn text(&self, chains: &[&str]) -> String {
        let mut text = "Share of 25 s windows whose 95 % interval contains the mass (of those with a mass; in brackets the share of \
                        windows without one).\nOwn plant, whose power is the model's formula.\n\n"
            .to_owned();
        let row = |head: &str, cells: &[String]| format!("| {head} | {} |\n", cells.join(" | "));
        let mut names: Vec<String> = chains.iter().map(|name| (*name).to_owned()).collect();
        names.push("all".to_owned());
        text += &row("", &names);
        text += &row("---", &vec!["---".to_owned(); names.len()]);
        let show = |cell: Cell| {
            let unknown = 100.0 * cell.unknown as f64 / (cell.known + cell.unknown).max(1) as f64;
            format!("{} ({unknown:.0} %)", cell.percent())
        };
        for kind in self.kinds() {
            let mut cells: Vec<String> = (0..chains.len())
                .map(|chain| show(self.sum(|of, name| of == chain && name == kind)))
                .collect();
            cells.push(show(self.sum(|_, name| name == kind)));
            text += &row(kind, &cells);
        }
        let mut all: Vec<String> =
            (0..chains.len()).map(|chain| show(self.sum(|of, _| of == chain))).collect();
        all.push(show(self.sum(|_, _| true)));
        text += &row("all", &all);
        let changes: Vec<String> = (0..=chains.len())
            .map(|chain| self.sum(|of, _| of == chain || chain == chains.len()).changes.to_string())
            .collect();
        text += &row("changes noticed that are none", &changes);
        let with_sum = |cells: &[Cell], text: &dyn Fn(&Cell) -> String| {
            let mut sum = Cell::default();
            for cell in cells {
                sum += *cell;
            }
            cells.iter().chain([&sum]).map(text).collect::<Vec<_>>()
        };
        text += &row("five times the noise: inside", &with_sum(&self.noise, &Cell::percent));
        let drives = |cell: &Cell| cell.changes.to_string();
        text += &row("… drives with a change that is none", &with_sum(&self.noise, &drives));
        text += &row("beyond the range: told", &with_sum(&self.beyond, &Cell::percent));
        text += &row("… drives with a change that is none", &with_sum(&self.beyond, &drives));
        let mut short = String::new();
        for kind in self.kinds() {
            let cell = self.sum(|_, name| name == kind);
            if !cell.reaches() {
                let _ = writeln!(short, "not reached: {kind} {}", cell.percent());
            }
        }
        for (chain, name) in chains.iter().enumerate() {
            let cell = self.sum(|of, _| of == chain);
            if !cell.reaches() {
                let _ = writeln!(short, "not reached: {name} {}", cell.percent());
            }
            if self.noise[chain].changes > 0 {
                let _ = writeln!(short, "not reached: {name}, changes noticed with five times the noise");
            }
        }
        if !short.is_empty() {
            text = format!("{text}\n{short}");
        }
        text
    }
}
