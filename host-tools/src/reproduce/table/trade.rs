//! Tables of what the paper only mentions: recalibration, price, print.

use super::{Mark, Row, Table, error, figure, number, plain, share, spread, with_unit};
use crate::reproduce::price::Price;
use crate::reproduce::print::Difference;
use crate::reproduce::study::Recalibration;

pub(super) fn recalibration(policies: &[Recalibration]) -> Table {
    let rows = policies.iter().map(|row| {
        plain(vec![
            row.policy.clone(),
            row.method.clone(),
            error(&row.delay_s, 1),
            format!("{} of {}", row.never.0, row.never.1),
            error(&row.false_restarts_per_hour, 1),
            error(&row.energy_error_percent, 2),
            error(&row.absolute_energy_error_percent, 2),
            share(&row.unknown_percent, 1),
        ])
    });
    Table {
        name: "recalibration",
        title: "Fig. 4: policies of recalibration, and the change detector".to_owned(),
        head: vec![
            "policy",
            "estimator",
            "#delay s",
            "#never",
            "#needless restarts 1/h",
            "#energy error %",
            "#absolute %",
            "#unknown %",
        ],
        rows: rows.collect(),
        note: "delay: from a change until the mass is within 10 % for good, mean over the changes after which it ever is; never: changes \
               after which it is not; needless restarts: those that no change asked for, of the periodic policy its rounds without one; energy error: of the total, absolute: errors of both signs added up"
            .to_owned(),
    }
}

pub(super) fn price(price: &Price) -> Table {
    let rows = price.best.iter().map(|best| {
        let window = format!("{}{}", number(best.window_s, 1), if best.at_end { " (end)" } else { "" });
        let parts = [
            best.split.sensors_j,
            best.split.shunt_j,
            best.split.computing_j,
            best.split.before_j,
            best.split.after_j,
            best.total_j,
        ];
        let mut cells = vec![number(best.task_s, 0), best.method.clone(), window];
        cells.extend(parts.map(|part| number(part, 4)));
        cells.push(best.dominant.to_owned());
        cells.push(number(best.break_even, 4));
        plain(cells)
    });
    Table {
        name: "price",
        title: "Price of sensing and computing: the window that costs least".to_owned(),
        head: vec![
            "#task s",
            "method",
            "#window s",
            "#sensors J",
            "#shunt J",
            "#computing J",
            "#error before J",
            "#error behind J",
            "#total J",
            "greatest part",
            "#break-even",
        ],
        rows: rows.collect(),
        note: format!(
            "a sensor draws {} mW, an instruction takes {} nJ; a mispredicted joule counts as one spent; break-even: the worth of a \
             mispredicted joule below which sensors and computing weigh more; (end): the shortest or longest window tried",
            number(1e3 * price.sensors_w, 2),
            number(1e9 * price.instruction_j, 3)
        ),
    }
}

pub(super) fn print(differences: &[Difference]) -> Table {
    let mut rows: Vec<Row> = Vec::new();
    for difference in differences {
        if difference.cost.is_empty() {
            let none = "–".to_owned();
            rows.push(plain(vec![
                difference.what.to_owned(),
                "notation or choice: no cost".to_owned(),
                none.clone(),
                none.clone(),
                none,
            ]));
        }
        for (place, cost) in difference.cost.iter().enumerate() {
            let what = if place == 0 { difference.what } else { "" };
            let digits = if cost.unit.is_empty() { 5 } else { 2 };
            let worse =
                if cost.unit.is_empty() { cost.difference.high < 0.0 } else { cost.difference.low > 0.0 };
            rows.push(Row {
                cells: vec![
                    what.to_owned(),
                    format!("{}, {}", cost.plant, with_unit(cost.figure.to_owned(), cost.unit)),
                    figure(&cost.derivation, cost.unit, digits),
                    figure(&cost.print, cost.unit, digits),
                    spread(&cost.difference, digits),
                ],
                mark: if worse { Mark::Against } else { Mark::None },
            });
        }
    }
    Table {
        name: "print",
        title: "Eq. 18: what the print costs against the derivation".to_owned(),
        head: vec!["difference", "figure", "#as derived", "#as printed", "#print less derivation"],
        rows,
        note: "coefficients fitted exactly; marked where the print is worse on average, interval and all"
            .to_owned(),
    }
}
