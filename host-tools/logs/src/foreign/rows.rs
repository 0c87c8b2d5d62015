//! Rows of other formats.

use std::path::Path;

use log_formats::merge::merge;
use log_formats::table::{self, Cell, Taker};
use log_formats::{Bag, Ending};
use support::error::{Error, Result};

use super::choose::choose;
use super::columns::Expression;
use super::spool::Writer;
use super::wrong::wrong;
use crate::robot::Robot;
use crate::{POWER, TIME};

/// Of a Parquet file.
pub(super) fn of_parquet(path: &Path, writer: &mut Writer) -> Result<Vec<String>> {
    table::parquet(path, writer).map_err(wrong)?;
    Ok(Vec::new())
}

/// Of a bag that is a table. Gives what is to be said.
pub(super) fn of_table(bag: &Bag, topic: usize, writer: &mut Writer) -> Result<Vec<String>> {
    let ending = table::json_topic(bag, topic, writer).map_err(wrong)?;
    Ok(cut(&ending).into_iter().collect())
}

fn cut(ending: &Ending) -> Option<String> {
    match ending {
        Ending::Whole => None,
        Ending::Cut(why) => {
            Some(format!("{}: what comes before is used", why.split(';').next().unwrap_or(why)))
        }
    }
}

/// What the power's current is like, over all rows.
#[derive(Default)]
struct Current {
    rows: u64,
    not_zero: u64,
    negative: u64,
}

/// Of a bag. Gives what is to be said: where the columns come from, and what is missing.
pub(super) fn of_bag(
    bag: &Bag,
    robot: &Robot,
    says_sources: bool,
    writer: &mut Writer,
) -> Result<Vec<String>> {
    let chosen = choose(bag, robot)?;
    let names: Vec<String> = std::iter::once(TIME.to_owned())
        .chain(chosen.columns.iter().map(|column| column.name.clone()))
        .collect();
    writer.columns(&names).map_err(wrong)?;
    let power = chosen.columns.iter().find(|column| column.name == POWER).map(|column| &column.expression);
    let mut current = Current::default();
    let mut cells = Vec::with_capacity(names.len());
    let merged = merge(bag, &chosen.request, &mut |time, numbers| {
        cells.clear();
        cells.push(Cell::Number(time));
        cells.extend(chosen.columns.iter().map(|column| Cell::Number(column.expression.of(numbers))));
        let drawn = match power {
            Some(Expression::Product(_, place, scale)) => Some(numbers[*place] * scale.signum()),
            Some(sum @ Expression::Products(_)) => Some(sum.of(numbers)),
            _ => None,
        };
        if let Some(drawn) = drawn {
            current.rows += 1;
            current.not_zero += u64::from(drawn.abs() > 0.0);
            current.negative += u64::from(drawn < 0.0);
        }
        writer.row(&cells)
    })
    .map_err(wrong)?;
    let base = &chosen.request.base;
    if merged.rows == 0 {
        let fields: Vec<String> = base.iter().map(|field| field.path.clone()).collect();
        return Err(Error::failed(format!(
            "no message of {} has numbers in {}; expected one at least",
            base[0].topic,
            fields.join(", ")
        )));
    }
    if let Some(battery) = &chosen.battery
        && current.rows > 0
        && current.not_zero == 0
    {
        return Err(Error::failed(format!(
            "the current of {battery} is 0 or missing in all its messages: this robot does not measure it; expected power, or voltage and current, from \
             another topic ([topics] of robot.toml), or a power sensor"
        )));
    }
    let is_sum = matches!(power, Some(Expression::Products(_)));
    if is_sum && current.rows > 0 && current.not_zero == 0 {
        let source =
            chosen.columns.iter().find(|column| column.name == POWER).map_or("", |column| &*column.source);
        return Err(Error::failed(format!(
            "power, {source}, is 0 or missing in all rows; expected drivers that measure it, or other sources as power in [topics] of robot.toml"
        )));
    }
    let mut said = Vec::new();
    if says_sources {
        let sources = chosen.columns.iter().map(|column| format!("{} from {}", column.name, column.source));
        let sources = sources.collect::<Vec<_>>().join("; ");
        said.push(format!("{} rows on the clock of {}: {sources}", merged.rows, base[0].topic));
    }
    said.extend(cut(&merged.ending));
    if merged.out_of_order > 0 {
        said.push(format!(
            "{} messages were not later than the one before them, and left out",
            merged.out_of_order
        ));
    }
    if is_sum && current.negative * 2 > current.rows {
        said.push("power is negative in most rows: turn its sign with scale = -1 where power is named in [topics] of robot.toml".to_owned());
    } else if current.negative * 2 > current.rows {
        said.push(
            "power is negative in most rows: this robot's driver counts a discharging current positive; read it with --flip-power"
                .to_owned(),
        );
    }
    if !chosen.lacking.is_empty() {
        let lacks = format!("has no {}", chosen.lacking.join(", no "));
        said.push(lacks.clone());
        writer.lacks = Some(lacks);
    }
    Ok(said)
}
