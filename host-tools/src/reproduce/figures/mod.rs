//! The paper's figures, drawn from a study: the same for the page and for files.

mod courses;
mod experiment;
mod simulation;
mod trade;

use crate::report::{Colour, Page, palette};

use super::study::Study;

/// One figure of the paper, or one that it lacks.
pub struct Figure {
    /// Name of its files.
    pub name: &'static str,
    /// Its title.
    pub title: String,
    /// What the paper's figure shows, and what is seen here.
    pub caption: String,
    /// The panels.
    pub page: Page,
}

/// Names of all figures, in the paper's order.
pub const NAMES: [&str; 12] = [
    "fig05", "fig06", "fig07", "fig09", "fig10", "fig11", "fig12", "fig13", "fig14", "fig15", "models",
    "price",
];

/// Every figure, in the order of [`NAMES`].
pub fn all(study: &Study) -> Vec<Figure> {
    let colours = Colours::of(study);
    let (section6, section7) = (&study.simulation, &study.experiment);
    vec![
        simulation::fig05(section6, &colours),
        simulation::fig06(section6, &colours),
        simulation::fig07(section6, &colours),
        experiment::fig09(&section7.rails),
        experiment::fig10(section7, &colours),
        experiment::fig11(section7, &colours),
        experiment::fig12(section7, &colours),
        experiment::fig13(section7, &colours),
        experiment::fig14(section7, &colours),
        experiment::fig15(section7, &colours),
        experiment::models(section7),
        trade::price(&study.price, &colours),
    ]
}

/// A method's colour: the same in every figure.
pub(super) struct Colours {
    methods: Vec<String>,
}

/// The palette's black is for what was measured.
const METHODS: usize = 6;

impl Colours {
    fn of(study: &Study) -> Self {
        let mut methods: Vec<String> = Vec::new();
        let models = study.experiment.test.methods.iter().map(|method| &method.method);
        let rows = study.simulation.rows.iter().map(|row| &row.method);
        let published =
            study.experiment.models.iter().filter(|row| row.published.is_some()).map(|row| &row.name);
        let courses = [&study.simulation.test, &study.simulation.moving];
        let courses =
            courses.into_iter().flat_map(|course| course.methods.iter().map(|method| &method.method));
        for method in rows.chain(published).chain(courses).chain(models) {
            if !methods.contains(method) {
                methods.push(method.clone());
            }
        }
        Self { methods }
    }

    fn get(&self, method: &str) -> Colour {
        let place = self.methods.iter().position(|known| known == method);
        palette(place.unwrap_or(METHODS - 1) % METHODS)
    }
}

/// What was measured, and truths.
fn black() -> Colour {
    palette(METHODS)
}
