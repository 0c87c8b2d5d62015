//! Figs. 5, 6 and 7.

use crate::report::Page;

use super::courses::{masses, powers, speeds, validation};
use super::{Colours, Figure};
use crate::reproduce::study::Simulation;
use crate::reproduce::table::number;

pub(super) fn fig05(simulation: &Simulation, colours: &Colours) -> Figure {
    const HEIGHT: u32 = 280;
    let (training, test) = (&simulation.training, &simulation.test);
    let panels = [
        speeds("(a) Wheel speeds, training", &training.trace, HEIGHT).into(),
        powers("(b) Power, training, payload known", training, colours, 2, HEIGHT).into(),
        speeds("(c) Wheel speeds, test", &test.trace, HEIGHT).into(),
        powers("(d) Power, test, payload from 10 s", test, colours, 2, HEIGHT).into(),
    ];
    Figure {
        name: "fig05",
        title: "Fig. 5: speeds and power of the simulation".to_owned(),
        caption: "The paper: wheel speeds and power of training (no load, from 100 s on 5 kg) and of the test (2 kg, from 50 s on 3 kg), \
                  its estimate over the latter. Here: the same payloads on profiles drawn anew, as the paper's are not given. Before a \
                  task's first 10 s are over there is no estimate of the mass, and no line."
            .to_owned(),
        page: Page::new(panels).with_panels_of(1000, HEIGHT),
    }
}

pub(super) fn fig06(simulation: &Simulation, colours: &Colours) -> Figure {
    const HEIGHT: u32 = 380;
    let worst: Vec<String> = simulation
        .rows
        .iter()
        .map(|row| format!("{} {} %", row.method, number(row.worst_start_percent.mean, 1)))
        .collect();
    Figure {
        name: "fig06",
        title: "Fig. 6: mass over a moving window of 10 s, simulation".to_owned(),
        caption: format!(
            "The paper: its estimate stays within 22 % of the truth, worst where the wheels are slow. Here: the first seed; at the worst \
             moment, over all seeds, {}. The window still holds the old payload for 10 s behind the change at 50 s.",
            worst.join(", ")
        ),
        page: Page::new([masses("Estimated mass", &simulation.moving, colours, HEIGHT).into()])
            .with_panels_of(1000, HEIGHT),
    }
}

pub(super) fn fig07(simulation: &Simulation, colours: &Colours) -> Figure {
    let r2: Vec<String> =
        simulation.rows.iter().map(|row| format!("{} R² {}", row.method, number(row.r2.mean, 4))).collect();
    Figure {
        name: "fig07",
        title: "Fig. 7: validation of the predicted power, simulation".to_owned(),
        caption: format!(
            "The paper: predictions about the diagonal with bounded residuals, R² 0.973. Here, over all seeds: {}; drawn is the first seed.",
            r2.join(", ")
        ),
        page: Page::new([validation(&simulation.test, colours).into()]).with_panels_of(1000, 440),
    }
}
