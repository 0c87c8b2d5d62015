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
    /// Products of some numbers, each times its factor, added: the power of several motor drivers.
    Products(Vec<(Vec<usize>, f64)>),
    /// Pitch, nose up, rad, of an orientation x, y, z, w (its z axis up), and the first entry of
    /// its covariance if it has one.
    NoseUp([usize; 4], Option<usize>),
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
            Self::Products(terms) => {
                let product = |places: &[usize]| places.iter().map(|place| numbers[*place]).product::<f64>();
                terms.iter().map(|(places, factor)| product(places) * factor).sum()
            }
            Self::NoseUp(places, covariance) => {
                nose_up(places.map(|place| numbers[place]), covariance.map(|place| numbers[place]))
            }
        }
    }
}

/// ROS turns about y, which points left, with the nose down (REP 103).
pub(super) fn nose_up([x, y, z, w]: [f64; 4], covariance: Option<f64>) -> f64 {
    let square = x * x + y * y + z * z + w * w;
    // A covariance of -1, or an orientation of nothing but zeros, says that there is none
    // (sensor_msgs/Imu). Between two that are the same with opposite signs, as at half a turn,
    // there is none either.
    if covariance == Some(-1.0) || square < 0.5 {
        return f64::NAN;
    }
    -(2.0 * (w * y - z * x) / square).clamp(-1.0, 1.0).asin()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_that_climbs_has_its_nose_up() {
        // Turned by -0.1 rad about y and then by 2 rad about z: the quaternions of both,
        // multiplied.
        let ((s, c), (u, v)) = ((-0.05_f64).sin_cos(), 1.0_f64.sin_cos());
        let turned = [-u * s, v * s, u * c, v * c];
        let pitch = |[x, y, z, w]: [f64; 4], covariance| {
            Expression::NoseUp([0, 1, 2, 3], Some(4)).of(&[x, y, z, w, covariance])
        };
        assert!((pitch(turned, 0.0) - 0.1).abs() < 1e-12);
        assert!(pitch(turned, -1.0).is_nan() && pitch([0.0; 4], 0.0).is_nan());
        assert!(pitch(turned.map(|axis| 0.6 * axis), 0.0).is_nan(), "between two of opposite signs");
    }

    #[test]
    fn a_sum_lacks_what_one_of_its_products_lacks() {
        let sum = Expression::Products(vec![(vec![0, 1], 2.0), (vec![2], -1.0)]);
        assert_eq!(sum.of(&[3.0, 4.0, 5.0]), 19.0);
        assert!(sum.of(&[3.0, f64::NAN, 5.0]).is_nan());
    }
}
