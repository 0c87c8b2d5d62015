//! Columns of a log as what they are made of.

/// How a column follows from the numbers of a bag's row, by their places.
#[derive(Debug, Clone, PartialEq)]
pub enum Expression {
    /// A number times a factor.
    Number(usize, f64),
    /// The mean of some: the wheels of one side.
    Mean(Vec<usize>),
    /// Voltage times current times a factor.
    Product(usize, usize, f64),
    /// Factors of some numbers, added: a wheel's speed from the body's motion.
    Sum(Vec<(usize, f64)>),
}

impl Expression {
    /// The column's number; NaN where one that it needs is missing.
    pub fn of(&self, numbers: &[f64]) -> f64 {
        match self {
            Self::Number(place, scale) if *scale == 1.0 => numbers[*place],
            Self::Number(place, scale) => numbers[*place] * scale,
            Self::Mean(places) => {
                places.iter().map(|place| numbers[*place]).sum::<f64>() / places.len() as f64
            }
            Self::Product(voltage, current, scale) => numbers[*voltage] * numbers[*current] * scale,
            Self::Sum(terms) => terms.iter().map(|(place, factor)| numbers[*place] * factor).sum(),
        }
    }
}

/// A column of the log, what it is made of, and that in words.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// As in the header.
    pub name: String,
    /// From the numbers.
    pub expression: Expression,
    /// For people.
    pub source: String,
}
